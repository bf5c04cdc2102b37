//! For any rod, any conditions and either integrator a step gives a finite state or a typed error;
//! the frames are rotations, and the fibre is as long as it is.

use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, Material, NodeProperties, Section};
use rapunzel_rod_dynamic::{
    Air, BoxIntegrator, BoxOptions, Conditions, Drag, End, Instant, Load, Rod, RodIntegrator,
    RodState, Staggered,
};

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn power(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|x| 10f64.powf(x))
}

/// Rods of 2 to 12 segments of unequal length, tapered and curled, thin to thick.
fn rod() -> impl Strategy<Value = Rod> {
    let parts = (
        prop::collection::vec(0.2..1.0_f64, 2..=12),
        power(-6.0, -1.0),
        0.3..3.0_f64,
        vector(20.0),
        prop_oneof![Just(0.0), power(-5.0, 0.0)],
        vector(3.0),
    );
    parts.prop_map(|(lengths, radius, taper, curl, damping_time, turn)| {
        let total: f64 = lengths.iter().sum();
        let nodes = (0..=lengths.len())
            .map(|j| {
                let s = j as f64 / lengths.len() as f64;
                let a = radius * (1.0 + (taper - 1.0) * s);
                let section = Section::Ellipse { a, b: 0.7 * a };
                let node = NodeProperties::new(section, &Material::HAIR);
                NodeProperties { natural_curvature: curl * (1.0 - s), ..node }
            })
            .collect();
        let root = Isometry3::new(Vector3::zeros(), turn);
        let lengths = lengths.iter().map(|l| 0.3 * l / total).collect();
        let fiber = Fiber::new(root, lengths, nodes).expect("valid parts");
        Rod::damped(fiber, damping_time)
    })
}

#[derive(Debug, Clone)]
enum Kind {
    Held,
    Pinned,
    World,
    Follower,
}

fn kind() -> impl Strategy<Value = Kind> {
    prop_oneof![Just(Kind::Held), Just(Kind::Pinned), Just(Kind::World), Just(Kind::Follower)]
}

/// An end that starts at `pose` and moves, or is loaded by up to a few weights of the rod; what is
/// pinned has this part of its moment.
fn end(
    kind: &Kind,
    pose: Isometry3<f64>,
    velocity: Vector3<f64>,
    [weight, pinned]: [f64; 2],
    t: f64,
) -> End {
    let point = pose.translation.vector + velocity * t;
    let turn = UnitQuaternion::from_scaled_axis(velocity * t);
    let (force, moment) = (weight * velocity, 0.1 * weight * velocity.yzx());
    match kind {
        Kind::Held => End::Held(Isometry3::from_parts(point.into(), turn * pose.rotation)),
        Kind::Pinned => {
            let moment = Load::World(pinned * moment);
            End::Pinned { position: Point3::from(point), moment }
        }
        Kind::World => End::Loaded { force: Load::World(force), moment: Load::World(moment) },
        Kind::Follower => {
            End::Loaded { force: Load::Follower(force), moment: Load::Follower(moment) }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]
    #[test]
    fn a_step_is_finite_or_a_typed_error(
        rod in rod(),
        ends in (kind(), kind()),
        velocities in (vector(1.0), vector(1.0)),
        gravity in prop_oneof![Just(Vector3::zeros()), vector(20.0)],
        drag in prop_oneof![Just(None), power(-8.0, 0.0).prop_map(Some)],
        rho in 0.0..=1.0_f64,
        dt in power(-6.0, 0.0),
    ) {
        let weight = 9.81 * rod.fiber.mass();
        let (positions, frames) = rod.fiber.rest_shape();
        let last = positions.len() - 1;
        let tip = Isometry3::from_parts(
            positions[last].into(),
            UnitQuaternion::from_rotation_matrix(&frames[last]),
        );
        let root = *rod.fiber.root();
        let air = drag.map(|d| Air {
            wind: velocities.1,
            drag: Drag { normal: d, tangential: 0.5 * d },
        });
        let ends = &ends;
        let conditions = |pinned: f64| move |t: f64| Instant {
            gravity,
            distributed: 0.2 * weight * velocities.0,
            root: end(&ends.0, root, velocities.0, [weight, pinned], t),
            tip: end(&ends.1, tip, velocities.1, [weight, pinned], t),
            air,
            inside: 0.0,
        };
        let options = BoxOptions::with_damping(rho).expect("in range");
        let scheme = BoxIntegrator::new(rod.clone(), options).expect("valid");
        steps_are_sound(scheme, dt, &conditions(1.0))?;
        // The moment of a pinned end is not one of its conditions.
        let staggered = Staggered::with_rho_inf(rod, rho).expect("valid");
        steps_are_sound(staggered, dt, &conditions(0.0))?;
    }
}

/// A frame is a product of rotations, each of them orthogonal to rounding: after a step of Newton's
/// method with at most some hundred of them, to some hundred roundings. A segment is as long as the
/// place of its nodes can tell: to a rounding of their distance from the origin over its length,
/// here 1e-10 with room for a held end that has gone far.
fn steps_are_sound<I: RodIntegrator>(
    mut integrator: I,
    dt: f64,
    conditions: &dyn Conditions,
) -> Result<(), TestCaseError> {
    for _ in 0..4 {
        let before = integrator.state();
        let result = integrator.step(dt, conditions);
        let state = integrator.state();
        if let Err(error) = result {
            // Forces of staggered rods are a result of the last solve, not a part of where they
            // are.
            let state = RodState { forces: before.forces.clone(), ..state };
            prop_assert!(before == state, "changed by a failed step: {error}");
            break;
        }
        let vectors = state.velocities.iter().chain(&state.forces);
        let vectors = vectors.chain(&state.curvatures).chain(&state.angular_velocities);
        prop_assert!(vectors.flat_map(|v| v.iter()).all(|x| x.is_finite()));
        for (i, h) in integrator.rod().fiber.segment_lengths().iter().enumerate() {
            let chord = state.positions[i + 1] - state.positions[i];
            prop_assert!((chord.norm() / h - 1.0).abs() < 1e-10, "length {} of {h}", chord.norm());
            let frame = state.frames[i].matrix();
            let off = (frame.transpose() * frame - Matrix3::identity()).amax();
            prop_assert!(off < 100.0 * f64::EPSILON, "frame {i} is off SO(3) by {off:e}");
            prop_assert!(frame.determinant() > 0.0, "frame {i} is a reflection");
            let aside = (chord / *h - frame.column(2)).norm();
            prop_assert!(aside < 1e-10, "tangent {i} is off d3 by {aside:e}");
        }
    }
    Ok(())
}
