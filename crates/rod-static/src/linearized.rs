//! The balance of moments of a chain, linearized at an equilibrium.

use crate::StaticError;
use crate::band::{BandFactor, Follow};
use crate::chain::Chain;
use crate::newton::NewtonStep;
use crate::relax::Rest;
use crate::segment::Blocks;
use crate::trial::TrialShape;
use nalgebra::{Matrix3, Vector3};

/// The Jacobian of the balance of moments at an equilibrium, factorized.
pub(crate) struct LinearizedBalance {
    blocks: Vec<Blocks>,
    follow: Follow,
    factor: BandFactor,
}

impl LinearizedBalance {
    /// Linearizes the balance of `chain` at `rest`, with a following `couple`, N m, in place of its
    /// own.
    ///
    /// # Errors
    /// A shape of another number of nodes, and [`StaticError::NoDerivative`] for a chain with
    /// following forces, or at a limit of stability.
    pub(crate) fn new(
        chain: &Chain,
        rest: &Rest,
        couple: Vector3<f64>,
    ) -> Result<Self, StaticError> {
        let frames = &rest.shape.frames;
        chain.check(&rest.shape)?;
        if chain.followers.iter().any(|force| *force != Vector3::zeros()) {
            let reason = "forces act that follow the nodes";
            return Err(StaticError::NoDerivative { reason });
        }
        let carried = chain.carried(frames, 0.0, &rest.pulls);
        let trial = TrialShape::new(chain, frames.clone(), &carried);
        let (blocks, motions) = (trial.blocks(chain, &carried), trial.motions(chain));
        let turned = vec![Matrix3::zeros(); frames.len()];
        let follow = Follow { couple, turned, motions };
        let factor = BandFactor::of(&blocks, 0.0, Some(&follow), chain.tip);
        Ok(Self { blocks, follow, factor: factor.ok_or(LIMIT)? })
    }

    /// How the nodes move by the rotations of the two nodes of each segment.
    pub(crate) fn motions(&self) -> &[[Matrix3<f64>; 2]] {
        &self.follow.motions
    }

    /// Rotations of the nodes behind the clamp, in their own axes, by small `moments` on them.
    ///
    /// # Errors
    /// [`StaticError::NoDerivative`] at a limit of stability.
    pub(crate) fn turns(
        &self,
        chain: &Chain,
        moments: &[Vector3<f64>],
    ) -> Result<Vec<Vector3<f64>>, StaticError> {
        let Self { blocks, follow, factor } = self;
        let step = factor.solve(blocks, Some(follow), moments);
        let mut turns = NewtonStep { step, pulls: Vec::new(), shift: 0.0, falling: None };
        let met = vec![Vector3::zeros(); chain.targets.len()];
        turns.bind(chain, blocks, &met, &follow.motions, Some(follow), factor).ok_or(LIMIT)?;
        if turns.size().is_finite() { Ok(turns.step) } else { Err(LIMIT) }
    }
}

/// Why there is no derivative where the Jacobian is singular.
const LIMIT: StaticError = StaticError::NoDerivative { reason: "it is at a limit of stability" };
