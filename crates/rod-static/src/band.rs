use crate::chain::TipHold;
use crate::segment::Blocks;
use nalgebra::{Matrix3, Vector3};
use rapunzel_fiber::so3::hat;

/// The Jacobian of the nodes' balance, block-tridiagonal, eliminated from the tip.
///
/// Each node's variation follows from the variation of the node before. Forces that follow the
/// frames beyond a node act on it too; they are carried along as one sum, so the cost stays that of
/// tridiagonal blocks.
#[derive(Debug, Default)]
pub(crate) struct BandFactor {
    /// Inverse pivots of the nodes behind the clamp.
    inverse: Vec<Matrix3<f64>>,
    /// Matrix that takes the variation of the node before to that of each node behind the clamp.
    carry: Vec<Matrix3<f64>>,
    /// Change of the forces from each node on by that node's variation; empty without followers.
    beyond: Vec<Matrix3<f64>>,
    /// Number of negative eigenvalues of the pivots.
    pub(crate) negative: usize,
    /// The first eliminated node whose pivot has negative eigenvalues, and their directions.
    falling: Option<(usize, Vec<Vector3<f64>>)>,
}

/// Derivatives of the following loads and of the nodes they act on.
pub(crate) struct Follow {
    /// Couple on the last node, N m, in the node's own axes.
    pub(crate) couple: Vector3<f64>,
    /// Derivative of each node's force by the variation of its frame, world frame.
    pub(crate) turned: Vec<Matrix3<f64>>,
    /// Derivatives of the end of each segment by the variations of its frames, world frame.
    pub(crate) motions: Vec<[Matrix3<f64>; 2]>,
}

impl BandFactor {
    /// Eliminates the blocks with `shift` times their own shifts added, from tip to clamp. `None`
    /// if a pivot is singular.
    pub(crate) fn of(
        blocks: &[Blocks],
        shift: f64,
        follow: Option<&Follow>,
        tip: TipHold,
    ) -> Option<Self> {
        let count = blocks.len();
        let mut factor = Self {
            inverse: vec![Matrix3::zeros(); count],
            carry: vec![Matrix3::zeros(); count],
            ..Self::default()
        };
        if follow.is_some() {
            factor.beyond = vec![Matrix3::zeros(); count];
        }
        // Derivative of the force beyond by the variation of the node at hand.
        let mut beyond = Matrix3::zeros();
        for i in (0..count).rev() {
            let mut pivot = blocks[i].behind;
            let mut own = shift * blocks[i].shift;
            if let Some(next) = blocks.get(i + 1) {
                pivot += next.before + next.mixed.tr_mul(&factor.carry[i + 1]);
                own += shift * next.shift;
            }
            for j in 0..3 {
                pivot[(j, j)] += own;
            }
            if let Some(follow) = follow {
                factor.beyond[i] = beyond + follow.turned[i + 1];
                pivot -= follow.motions[i][1].tr_mul(&factor.beyond[i]);
                if let Some(motion) = follow.motions.get(i + 1) {
                    pivot -= motion[0].tr_mul(&beyond);
                } else {
                    // The balance is one of moments in the node's own axes, which turn with it:
                    // half of the moment times the turn, beside the Hessian along geodesics.
                    pivot += hat(&(0.5 * follow.couple));
                }
            }
            let held = if i + 1 == count { tip } else { TipHold::Free };
            factor.inverse[i] = match held {
                TipHold::Held => Matrix3::zeros(),
                TipHold::Aligned => {
                    // Only the rotation about the tangent is free.
                    let (along, spin) = (pivot[(2, 2)], Vector3::z());
                    if along < 0.0 {
                        factor.note(i, vec![spin]);
                    }
                    spin * spin.transpose() * along.recip()
                }
                TipHold::Free => {
                    if follow.is_none() && !definite(&pivot) {
                        factor.note(i, falling(&pivot));
                    }
                    pivot.try_inverse()?
                }
            };
            factor.carry[i] = -(factor.inverse[i] * blocks[i].mixed);
            if follow.is_some() {
                beyond = factor.beyond[i] * factor.carry[i];
            }
        }
        Some(factor)
    }

    fn note(&mut self, node: usize, falling: Vec<Vector3<f64>>) {
        self.negative += falling.len();
        if self.falling.is_none() && !falling.is_empty() {
            self.falling = Some((node, falling));
        }
    }

    /// The variations of the nodes behind the clamp for the given moments on them.
    pub(crate) fn solve(
        &self,
        blocks: &[Blocks],
        follow: Option<&Follow>,
        moments: &[Vector3<f64>],
    ) -> Vec<Vector3<f64>> {
        let mut parts = vec![Vector3::zeros(); moments.len()];
        let mut force = Vector3::zeros();
        for i in (0..moments.len()).rev() {
            let mut moment = moments[i];
            if let Some(next) = blocks.get(i + 1) {
                moment -= next.mixed.tr_mul(&parts[i + 1]);
            }
            if let Some(follow) = follow {
                moment += follow.motions[i][1].tr_mul(&force);
                if let Some(motion) = follow.motions.get(i + 1) {
                    moment += motion[0].tr_mul(&force);
                }
            }
            parts[i] = self.inverse[i] * moment;
            if follow.is_some() {
                force += self.beyond[i] * parts[i];
            }
        }
        self.propagate(&mut parts, 0);
        parts
    }

    /// A variation along which the energy falls to second order; of several, the one to which the
    /// moments drive.
    pub(crate) fn falling(&self, moments: &[Vector3<f64>]) -> Option<Vec<Vector3<f64>>> {
        let (node, directions) = self.falling.as_ref()?;
        let along = |direction: &Vector3<f64>| {
            let mut parts = vec![Vector3::zeros(); self.carry.len()];
            parts[*node] = *direction;
            self.propagate(&mut parts, *node);
            parts
        };
        let driven = |direction: &Vector3<f64>| {
            let work =
                along(direction).into_iter().zip(moments).map(|(part, moment)| part.dot(moment));
            direction * work.sum::<f64>()
        };
        let driven: Vector3<f64> = directions.iter().map(driven).sum();
        Some(along(&driven.try_normalize(0.0).or_else(|| directions.first().copied())?))
    }

    fn propagate(&self, parts: &mut [Vector3<f64>], from: usize) {
        for i in from + 1..parts.len() {
            let before = parts[i - 1];
            parts[i] += self.carry[i] * before;
        }
    }
}

/// The directions in which a pivot has negative eigenvalues.
fn falling(pivot: &Matrix3<f64>) -> Vec<Vector3<f64>> {
    let eigen = pivot.symmetric_eigen();
    let all = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    all.filter(|(value, _)| **value < 0.0).map(|(_, vector)| vector.into_owned()).collect()
}

/// Whether a symmetric matrix is positive definite.
fn definite(m: &Matrix3<f64>) -> bool {
    m[(0, 0)] > 0.0 && m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(0, 1)] > 0.0 && m.determinant() > 0.0
}
