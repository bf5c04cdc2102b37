use crate::band::{BandFactor, Follow};
use crate::chain::Chain;
use crate::segment::Blocks;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A Newton step of a [`Chain`].
pub(crate) struct NewtonStep {
    /// Rotation increments of the nodes behind the clamp, rad, in the nodes' own axes.
    pub(crate) step: Vec<Vector3<f64>>,
    /// Changes of the targets' forces on their nodes, N.
    pub(crate) pulls: Vec<Vector3<f64>>,
    /// Multiple of the blocks' shifts that makes the matrix definite; zero at and near stable
    /// equilibria.
    pub(crate) shift: f64,
    /// A variation along which the energy falls, where the matrix is not definite.
    pub(crate) falling: Option<Vec<Vector3<f64>>>,
}

/// Multiples of the blocks' shifts that are tried in turn.
const SHIFTS: [f64; 6] = [0.0, 0.1, 1.0, 4.0, 16.0, 64.0];

impl NewtonStep {
    /// Largest rotation of a node, rad; infinite if one is NaN.
    pub(crate) fn size(&self) -> f64 {
        let squares = self.step.iter().map(Vector3::norm_squared);
        let largest = |a: f64, b: f64| if b.is_nan() { f64::INFINITY } else { a.max(b) };
        squares.fold(0.0, largest).sqrt()
    }

    /// The Newton step at a shape in which the targets' nodes are off their places by `gaps` (m).
    /// With following forces the matrix is not symmetric, and no shift is tried. `None` if it is
    /// singular.
    pub(crate) fn of(
        chain: &Chain,
        blocks: &[Blocks],
        gaps: &[Vector3<f64>],
        motions: &[[Matrix3<f64>; 2]],
        follow: Option<&Follow>,
    ) -> Option<Self> {
        // Residual moments on the nodes behind the clamp.
        let mut moments: Vec<Vector3<f64>> = (0..blocks.len())
            .map(|i| {
                let next = blocks.get(i + 1).map_or_else(Vector3::zeros, |b| b.gradient[0]);
                -(blocks[i].gradient[1] + next)
            })
            .collect();
        if let (Some(follow), Some(last)) = (follow, moments.last_mut()) {
            *last += follow.couple;
        }
        let mut falling = None;
        // Raise the shift until the matrix is definite on the variations that the targets allow.
        for shift in SHIFTS {
            let factor = BandFactor::of(blocks, shift, follow, chain.tip)?;
            let mut newton = Self {
                step: factor.solve(blocks, follow, &moments),
                pulls: Vec::new(),
                shift,
                falling: None,
            };
            let taken = newton.bind(chain, blocks, gaps, motions, follow, &factor)?;
            if factor.negative == taken || follow.is_some() {
                newton.falling = falling;
                return newton.size().is_finite().then_some(newton);
            }
            if let (None, Some(step)) = (&falling, factor.falling(&moments)) {
                // Along the direction of falling energy, held nodes stay in place.
                let mut way = Self { step, pulls: Vec::new(), shift, falling: None };
                let met = vec![Vector3::zeros(); gaps.len()];
                way.bind(chain, blocks, &met, motions, follow, &factor)?;
                falling = Some(way.step);
            }
        }
        None
    }

    /// Corrects the step for the forces of the targets, by the Schur complement of these forces.
    /// Returns how many directions of falling energy the targets take away.
    pub(crate) fn bind(
        &mut self,
        chain: &Chain,
        blocks: &[Blocks],
        gaps: &[Vector3<f64>],
        motions: &[[Matrix3<f64>; 2]],
        follow: Option<&Follow>,
        factor: &BandFactor,
    ) -> Option<usize> {
        let count = chain.targets.len();
        if count == 0 {
            return Some(0);
        }
        let mut compliance = DMatrix::zeros(3 * count, 3 * count);
        let mut off = DVector::zeros(3 * count);
        let mut responses = Vec::with_capacity(3 * count);
        // Responses to unit forces on the targets' nodes, and the residuals of the targets.
        for (i, target) in chain.targets.iter().enumerate() {
            let held = target.is_held();
            for axis in 0..3 {
                let mut moments = vec![Vector3::zeros(); blocks.len()];
                for (s, motion) in motions[..target.node].iter().enumerate() {
                    moments[s] += motion[1].row(axis).transpose();
                    if s > 0 {
                        moments[s - 1] += motion[0].row(axis).transpose();
                    }
                }
                responses.push(factor.solve(blocks, follow, &moments));
                if !held {
                    compliance[(3 * i + axis, 3 * i + axis)] = 1.0 / target.stiffness;
                }
            }
            let wanted = if held { gaps[i] } else { Vector3::zeros() };
            off.fixed_rows_mut::<3>(3 * i)
                .copy_from(&(moved(&motions[..target.node], &self.step) + wanted));
        }
        // Compliance of the targets' nodes: their motions by these responses.
        for (i, target) in chain.targets.iter().enumerate() {
            for (column, response) in responses.iter().enumerate() {
                let by = moved(&motions[..target.node], response);
                let mut entry = compliance.fixed_view_mut::<3, 1>(3 * i, column);
                entry += by;
            }
        }
        // Forces of the targets, and the step that they correct.
        let pulls = -compliance.clone().lu().solve(&off)?;
        for (response, pull) in responses.iter().zip(pulls.iter()) {
            for (variation, part) in self.step.iter_mut().zip(response) {
                *variation += part * *pull;
            }
        }
        self.pulls = (0..count).map(|i| pulls.fixed_rows::<3>(3 * i).into_owned()).collect();
        // A negative eigenvalue of the compliance takes away a direction of falling energy.
        let symmetric = 0.5 * (&compliance + compliance.transpose());
        Some(symmetric.symmetric_eigenvalues().iter().filter(|e| **e < 0.0).count())
    }
}

/// Displacement of the end of consecutive segments from the clamp on, by the variations `step` of
/// the frames behind the clamp.
pub(crate) fn moved(motions: &[[Matrix3<f64>; 2]], step: &[Vector3<f64>]) -> Vector3<f64> {
    motions.iter().enumerate().fold(Vector3::zeros(), |sum, (s, motion)| {
        let before = if s > 0 { motion[0] * step[s - 1] } else { Vector3::zeros() };
        sum + before + motion[1] * step[s]
    })
}
