//! What a rod bears inside, from its state.

use crate::RodState;
use crate::joint::Joint;
use nalgebra::Vector3;
use rapunzel_fiber::{Fiber, so3};

/// Elastic moments of the part beyond on the part before at the `n + 1` nodes of a fibre with the
/// linear law, N m, world frame, without internal damping; zero at ends that are not clamped.
///
/// A joint of the staggered rod turns the segments about a node by `phi` against each other, and
/// its energy `m . dphi` is the work of the moment `R J(phi)^-1 m`, with the frame `R` before it
/// and the right Jacobian `J` of rotations. Where the rod rests, these are the moments about the
/// node of all forces beyond it, to rounding.
///
/// # Panics
/// If the state is not one of this fibre.
#[must_use]
pub fn elastic_moments(fiber: &Fiber, state: &RodState) -> Vec<Vector3<f64>> {
    let at = |j: usize| {
        let joint = Joint::new(fiber, j);
        let strain = (state.curvatures[j] - fiber.nodes()[j].natural_curvature) * joint.length;
        let (turn, own) = (joint.rest + strain, joint.stiffness.component_mul(&strain));
        match j {
            // The frame before the first joint is that of the clamp.
            0 => state.frames[0] * (so3::right_jacobian_inverse(&-turn) * own),
            j => state.frames[j - 1] * (so3::right_jacobian_inverse(&turn) * own),
        }
    };
    (0..=fiber.segments()).map(at).collect()
}
