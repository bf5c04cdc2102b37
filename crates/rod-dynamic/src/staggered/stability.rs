//! Stability of an equilibrium under dead loads, without a solve.

use crate::joint::Joint;
use crate::{End, Instant, Load, RodState};
use nalgebra::{Isometry3, Matrix3, Vector3};
use rapunzel_fiber::{Fiber, so3};

/// Whether the potential energy of a fibre with a clamped root and a loaded or free tip has a
/// strict minimum at `state`, an equilibrium under `conditions` and `node_forces` (N, world, one
/// per node, or none).
///
/// `false` also where the loads have no potential: a moment or a force that follows the tip, and
/// air. The second variation is block tridiagonal in the rotations of the segments, and it is
/// positive definite exactly if all pivots of an elimination from the tip to the root are; the
/// first that is not is a conjugate point. Cost: one pass over the segments.
pub(super) fn is_minimum(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
) -> bool {
    let (End::Held(clamp), None) = (conditions.root, conditions.air) else { return false };
    let End::Loaded { force: Load::World(force), moment } = conditions.tip else { return false };
    if *moment.components() != Vector3::zeros() {
        return false;
    }
    let h = fiber.segment_lengths();
    // Force that all beyond the segment exerts on it, world.
    let mut beyond = force;
    // Joint at the end of the segment, and what elimination of all beyond leaves of it.
    let mut after = None;
    for e in (0..fiber.segments()).rev() {
        beyond += conditions.node_load(fiber, node_forces, e + 1);
        let before = JointVariation::new(fiber, state, &clamp, e);
        // Second variation of `-h n d3`: `(p d3) E - sym(p d3^T)` with `p = h n`.
        let d3 = state.frames[e] * Vector3::z();
        let pull = beyond * h[e];
        let outer = pull * d3.transpose();
        let mut pivot = before.own + Matrix3::from_diagonal_element(pull.dot(&d3))
            - 0.5 * (outer + outer.transpose());
        if let Some(complement) = after {
            pivot += complement;
        }
        let Some(factor) = pivot.cholesky() else { return false };
        // Schur complement: what is left of the joint for the segment before.
        let mixed = before.mixed;
        after = Some(before.own - mixed * factor.solve(&mixed.transpose()));
    }
    true
}

/// Second variation of the energy of the joint between two segments, by rotation vectors of both in
/// the world.
struct JointVariation {
    /// By the rotation of either segment twice, N m.
    own: Matrix3<f64>,
    /// By the rotations of the segment before (rows) and of the one after (columns), N m.
    mixed: Matrix3<f64>,
}

impl JointVariation {
    /// The joint before segment `e`.
    fn new(fiber: &Fiber, state: &RodState, clamp: &Isometry3<f64>, e: usize) -> Self {
        let frame = &state.frames[e];
        let before = if e > 0 { state.frames[e - 1] } else { clamp.rotation.to_rotation_matrix() };
        let phi = so3::log(&(before.inverse() * frame));
        let joint = Joint::new(fiber, e);
        let m = joint.stiffness.component_mul(&(phi - joint.rest));
        // Both segments see the rotation vector and its moment in the world alike.
        let (world_phi, world_m) = (frame * phi, frame * m);
        let slope = so3::right_jacobian_inverse(&phi) * frame.matrix().transpose();
        let stiff = Matrix3::from_fn(|i, j| joint.stiffness[i] * slope[(i, j)]);
        let own = slope.tr_mul(&stiff) + log_variation(&world_phi, &world_m);
        // Moment on the segment before, `J^-T m`: rotations do not commute, which leaves half.
        let moment = slope.tr_mul(&m);
        Self { own, mixed: 0.5 * so3::hat(&moment) - own }
    }
}

/// The symmetric second derivative of `m log(exp(phi) exp(x))` by `x` at zero, for a constant `m`:
/// `sym(phi g^T) + beta E`, from `J^-1 = E + hat(phi)/2 + c hat(phi)^2`.
fn log_variation(phi: &Vector3<f64>, m: &Vector3<f64>) -> Matrix3<f64> {
    let squared = phi.norm_squared();
    let (c, slope) = (so3::inverse_coefficient(squared), so3::inverse_coefficient_slope(squared));
    let (turned, along) = (phi.cross(m), phi.dot(m));
    let g = m * (0.25 - c) - turned * c
        + phi.cross(&turned) * (2.0 * slope + c * c)
        + phi * (c * c * along);
    let outer = phi * g.transpose();
    let beta = along * (c - 0.25 - c * c * squared);
    0.5 * (outer + outer.transpose()) + Matrix3::from_diagonal_element(beta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::staggered::natural_curvatures;
    use crate::{Rod, RodIntegrator, Staggered};
    use nalgebra::{DMatrix, Rotation3, UnitQuaternion};
    use proptest::prelude::*;
    use rapunzel_fiber::{Material, Section};

    /// Potential energy, J, of a fibre with the frames `frames` under dead loads.
    fn energy(
        fiber: &Fiber,
        frames: &[Rotation3<f64>],
        conditions: &Instant,
        forces: &[Vector3<f64>],
    ) -> f64 {
        let (mut at, mut energy) = (Vector3::zeros(), 0.0);
        let mut before = fiber.root().rotation.to_rotation_matrix();
        for (e, frame) in frames.iter().enumerate() {
            let joint = Joint::new(fiber, e);
            let strain = so3::log(&(before.inverse() * frame)) - joint.rest;
            energy += 0.5 * joint.stiffness.component_mul(&strain).dot(&strain);
            at += frame * Vector3::z() * fiber.segment_lengths()[e];
            energy -= conditions.node_load(fiber, forces, e + 1).dot(&at);
            before = *frame;
        }
        let End::Loaded { force, .. } = conditions.tip else { panic!("a loaded tip") };
        energy - force.components().dot(&at)
    }

    /// Least eigenvalue of the second differences of the energy, relative to the largest.
    fn least_eigenvalue(
        fiber: &Fiber,
        state: &RodState,
        conditions: &Instant,
        forces: &[Vector3<f64>],
    ) -> f64 {
        const STEP: f64 = 1e-4;
        let count = 3 * state.frames.len();
        let at = |moves: &[(usize, f64)]| {
            let mut turns = vec![Vector3::zeros(); state.frames.len()];
            moves.iter().for_each(|&(i, x): &(usize, f64)| turns[i / 3][i % 3] += x * STEP);
            let turned =
                turns.iter().zip(&state.frames).map(|(turn, frame)| so3::exp(turn) * frame);
            energy(fiber, &turned.collect::<Vec<_>>(), conditions, forces)
        };
        let differences = DMatrix::from_fn(count, count, |i, j| {
            at(&[(i, 1.0), (j, 1.0)]) + at(&[(i, -1.0), (j, -1.0)])
                - at(&[(i, 1.0), (j, -1.0)])
                - at(&[(i, -1.0), (j, 1.0)])
        });
        let values = differences.symmetric_eigenvalues();
        values.min() / values.amax()
    }

    proptest! {
        /// The pivots tell what the eigenvalues of second differences of the energy tell.
        #[test]
        fn pivots_agree_with_eigenvalues(
            segments in 2..6_usize,
            turns in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 6),
            pull in prop::array::uniform3(-1.0..1.0_f64),
            strength in -1.0..2.5_f64,
            torsion in 0.3..2.0_f64,
        ) {
            let material = Material { shear_modulus: torsion * 1e9, ..Material::HAIR };
            let section = Section::Ellipse { a: 40e-6, b: 30e-6 };
            let fiber = Fiber::uniform(0.05, segments, section, &material).expect("a hair");
            let root = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.7);
            let fiber = fiber.with_root(Isometry3::from_parts(Vector3::zeros().into(), root));
            let mut state = Staggered::new(Rod::new(fiber.clone())).expect("a rod").state();
            let mut frame = root.to_rotation_matrix();
            for (e, turn) in turns.iter().take(segments).enumerate() {
                frame *= so3::exp(&Vector3::from(*turn));
                state.frames[e] = frame;
            }
            let bending = fiber.nodes()[0].stiffness.x / fiber.length().powi(2);
            let force = Vector3::from(pull) * (bending * 10.0_f64.powf(strength));
            let mut conditions = Instant::clamped(*fiber.root(), Vector3::new(0.0, 0.0, -9.81));
            conditions.tip = End::Loaded { force: Load::World(force), moment: Load::ZERO };
            let forces = vec![Vector3::new(0.2, 0.1, -0.3) * bending; segments + 1];
            let natural = natural_curvatures(&fiber, &state, &conditions, &forces).expect("held");
            let fiber = fiber.with_node_curvatures(&natural).expect("finite");
            let least = least_eigenvalue(&fiber, &state, &conditions, &forces);
            // Differences of energies have their rounding over the square of the step.
            prop_assume!(least.abs() > 1e-5);
            prop_assert_eq!(is_minimum(&fiber, &state, &conditions, &forces), least > 0.0, "{}", least);
        }
    }

    /// An upright hair is stable up to Greenhill's length, `(7.8373 E I / w)^(1/3)`.
    #[test]
    fn an_upright_hair_stands_up_to_greenhills_length() {
        let stands = |length: f64| {
            let section = Section::Circle { radius: 35e-6 };
            let fiber = Fiber::uniform(length, 200, section, &Material::HAIR).expect("a hair");
            let state = Staggered::new(Rod::new(fiber.clone())).expect("a rod").state();
            let conditions = Instant::clamped(*fiber.root(), Vector3::new(0.0, 0.0, -9.81));
            is_minimum(&fiber, &state, &conditions, &[])
        };
        let node = Fiber::uniform(1.0, 1, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .expect("a hair")
            .nodes()[0];
        let greenhill = (7.837_347 * node.stiffness.x / (node.linear_density * 9.81)).cbrt();
        // Second order in the length of the segments.
        assert!(stands(greenhill * (1.0 - 1e-4)) && !stands(greenhill * (1.0 + 1e-4)));
    }

    /// What has no potential is not called stable.
    #[test]
    fn loads_that_follow_are_left_out() {
        let fiber = Fiber::uniform(0.01, 10, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .expect("a hair");
        let state = Staggered::new(Rod::new(fiber.clone())).expect("a rod").state();
        let mut conditions = Instant::clamped(*fiber.root(), Vector3::zeros());
        assert!(is_minimum(&fiber, &state, &conditions, &[]));
        let moment = Load::Follower(Vector3::new(0.0, 0.0, 1e-12));
        conditions.tip = End::Loaded { force: Load::ZERO, moment };
        assert!(!is_minimum(&fiber, &state, &conditions, &[]));
    }
}
