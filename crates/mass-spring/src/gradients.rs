//! Conjugate gradients: loops over columns in SIMD lanes, few passes over memory.

use crate::NodeVectors;
use crate::tangent::Tangent;
use pulp::{Arch, Simd, WithSimd};

/// Largest number of iterations.
const MOST: usize = 20_000;

/// Solves `A x = forces` on the motions that the supports allow, preconditioned by the diagonal,
/// down to a residual of `tolerance` times the residual of `x = 0`.
///
/// # Errors
/// A direction along which the matrix is not positive definite, if one is met.
pub(crate) fn solve<const D: usize>(
    tangent: &Tangent<D>,
    forces: &NodeVectors<D>,
    tolerance: f64,
) -> Result<NodeVectors<D>, NodeVectors<D>> {
    Arch::new().dispatch(GradientSolve { tangent, forces, tolerance })
}

struct GradientSolve<'a, const D: usize> {
    tangent: &'a Tangent<'a, D>,
    forces: &'a NodeVectors<D>,
    tolerance: f64,
}

impl<const D: usize> WithSimd for GradientSolve<'_, D> {
    type Output = Result<NodeVectors<D>, NodeVectors<D>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { tangent, forces, tolerance } = self;
        let supports = &tangent.system().supports;
        let inverse = tangent.inverse_diagonal();
        let mut residual = forces.clone();
        let mut x = NodeVectors::zeros(forces.len());
        let mut direction = NodeVectors::zeros(forces.len());
        let mut image = NodeVectors::zeros(forces.len());
        let mut product = residual.dot_weighted(&inverse);
        let enough = product * tolerance * tolerance;
        let mut turn = 0.0;
        for _ in 0..MOST {
            if product <= enough || product <= f64::MIN_POSITIVE {
                break;
            }
            for axis in 0..D {
                turn_column(&mut direction.0[axis], turn, &residual.0[axis], &inverse.0[axis]);
            }
            supports.project(&mut direction);
            tangent.apply_inline(&direction, &mut image);
            supports.project(&mut image);
            let curvature = direction.dot(&image);
            if curvature.is_nan() || curvature <= 0.0 {
                return Err(direction);
            }
            let along = product / curvature;
            let mut next = 0.0;
            for axis in 0..D {
                next += advance_column(
                    along,
                    [&direction.0[axis], &image.0[axis], &inverse.0[axis]],
                    &mut x.0[axis],
                    &mut residual.0[axis],
                );
            }
            turn = next / product;
            product = next;
        }
        Ok(x)
    }
}

/// `direction = turn * direction + inverse * residual`.
#[inline(always)]
fn turn_column(direction: &mut [f64], turn: f64, residual: &[f64], inverse: &[f64]) {
    let count = direction.len();
    let (residual, inverse) = (&residual[..count], &inverse[..count]);
    for n in 0..count {
        direction[n] = turn * direction[n] + inverse[n] * residual[n];
    }
}

/// `x += along * direction`, `residual -= along * image`, and the sum of `inverse * residual^2`, in
/// a fixed order.
#[inline(always)]
fn advance_column(
    along: f64,
    [direction, image, inverse]: [&[f64]; 3],
    x: &mut [f64],
    residual: &mut [f64],
) -> f64 {
    const LANES: usize = 16;
    let count = x.len();
    let (direction, image) = (&direction[..count], &image[..count]);
    let (inverse, residual) = (&inverse[..count], &mut residual[..count]);
    let mut sums = [0.0; LANES];
    let whole = count - count % LANES;
    for start in (0..whole).step_by(LANES) {
        let part = start..start + LANES;
        let (x, residual) = (&mut x[part.clone()], &mut residual[part.clone()]);
        let (direction, image) = (&direction[part.clone()], &image[part.clone()]);
        let inverse = &inverse[part];
        for lane in 0..LANES {
            x[lane] += along * direction[lane];
            residual[lane] -= along * image[lane];
            sums[lane] += residual[lane] * residual[lane] * inverse[lane];
        }
    }
    for (sum, n) in sums.iter_mut().zip(whole..count) {
        x[n] += along * direction[n];
        residual[n] -= along * image[n];
        *sum += residual[n] * residual[n] * inverse[n];
    }
    sums.iter().sum()
}
