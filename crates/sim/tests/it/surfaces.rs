//! Contacts act where surfaces touch, beside the axes of fibres.

use crate::common::Run;
use nalgebra::Vector3;
use rapunzel_sim::BodyRef;
use std::f64::consts::PI;

/// A stiff fibre presses on a drum; its clamp and the drum turn together as one body. Nothing
/// slips, whichever way they turn: friction does no work, and stays as it was when the press had
/// been put on. The fibre is 1e-7 m deep in the drum: two places as far apart would slip past each
/// other by 1.6e-7 m/s.
#[test]
fn what_turns_together_does_not_slip() {
    let press = 1.3e-2;
    let mut along = Vec::new();
    for rate in [90.0, -90.0] {
        // From the root, at (-0.02, 0, 0.0105), the axis of the drum is in this direction.
        let root = [-0.02_f64, 0.010_500_1];
        let far = root[0].hypot(root[1]);
        let mut run = Run::read(&format!(
            "(format: 1, duration: 1.0, fibers: [(length: 0.04, segments: 9,
                section: Circle(radius: 0.0005), damping_time: 1e-3,
                material: Elastic(density: 1000, youngs_modulus: 2e9, shear_modulus: 7e8),
                root: (position: ({:?}, 0, {:?}), orientation: Along(direction: (1, 0, 0))),
                motion: Swing(angle: {rate:?}, radius: {far:?}, period: 2.0, axis: (0, 1, 0),
                    center: ({:?}, 0, {:?}), pace: Constant),
                tip: Loaded(force: (value: (5e-3, 0, 0), frame: Follower,
                    profile: Ramp(until: 0.1))))],
            objects: [(shape: Capsule(length: 0.06, radius: 0.01), turn: (90, 0, 0),
                motion: Rotate(axis: (0, 1, 0), rate: {rate:?}, until: 1.0))],
            environment: (gravity: (0, 0, 0)),
            contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3))",
            root[0],
            root[1],
            -root[0] / far,
            -root[1] / far
        ));
        run.steps(200);
        let (before, start) = (run.world.contact_work().friction, run.world.time());
        run.steps(400);
        let force = run.world.force_on(0).norm();
        assert!(force > 0.5 * press && force < 2.0 * press, "{force} N");
        let work = run.world.contact_work().friction - before;
        let allowed = 1e-9 * (run.world.time() - start) * 2.0 * press;
        assert!(work.abs() < allowed, "{work:e} J of {allowed:e} J, at {rate}");
        // In the frame that turns with both.
        let angle = f64::to_radians(rate) * run.world.time();
        let force = run.world.force_on(0);
        along.push(angle.cos() * force.x - angle.sin() * force.z);
    }
    assert!((along[0] - along[1]).abs() < 0.01 * press && along[0] < -0.2 * press, "{along:?}");
}

/// A bar below a fibre that is drawn along itself, across the fibre, rolls and bends it: the force
/// is that of two springs in series, the cantilever of its bending and the torsion of what is
/// between clamp and contact at the lever of its radius. The torsion gives way six times as much.
#[test]
fn a_contact_twists_a_clamped_fiber() {
    let (radius, length, segments) = (2e-3_f64, 20e-3, 40_u32);
    let (young, shear) = (1e8, 2.5e5);
    let middle = length * (1.0 - 0.5 / f64::from(segments));
    let drawn = 1e-5;
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [(length: {length:?}, segments: {segments},
            section: Circle(radius: {radius:?}), damping_time: 1e-3,
            material: Elastic(density: 1000, youngs_modulus: {young:?}, shear_modulus: {shear:?}),
            root: (position: (0, 0, {radius:?}), orientation: Along(direction: (1, 0, 0))),
            tip: Loaded(force: (value: (0, 0, -0.02))))],
        objects: [(shape: Capsule(length: 0.06, radius: 0.02), turn: (90, 0, 0),
            position: ({middle:?}, 0, -0.02),
            motion: Translate(velocity: (0, {:?}, 0), until: 0.1))],
        contact: (friction: Isotropic(0.5), residual: 1e-8, slip: 1e-9),
        environment: (gravity: (0, 0, 0), viscosity: 1e-3), stepper: (dt: 1e-3))",
        drawn / 0.1
    ));
    run.steps(400);
    let inertia = PI / 4.0 * radius.powi(4);
    let (bending, torsion) = (young * inertia, shear * 2.0 * inertia);
    let gives = [middle.powi(3) / (3.0 * bending), radius * radius * middle / torsion];
    let expected = drawn / (gives[0] + gives[1]);
    let found = run.world.force_on(0).y;
    // It twists up to the middle of its last segment, and bends by the cube of where on that it is
    // touched, which is half a segment from there at most.
    let open = 1.5 / f64::from(segments) * gives[0] / (gives[0] + gives[1]);
    let error = (found + expected).abs() / expected;
    assert!(gives[1] > 5.0 * gives[0], "{gives:?}");
    assert!(error < open, "{found} N, {expected} N");
}

/// Two fibres cross, and the upper one is drawn along both: each drags the other across itself,
/// rolls and bends it. Both forces are those of two springs in series, bending and torsion.
#[test]
fn crossed_fibers_twist_each_other() {
    let (radius, length, segments) = (2e-3_f64, 20e-3, 40_u32);
    let (young, shear) = (1e8, 2.5e5);
    let middle = length * (1.0 - 0.5 / f64::from(segments));
    let drawn = 1e-5;
    let fiber = |position: [f64; 3], direction: [f64; 3], more: &str| {
        format!(
            "(length: {length:?}, segments: {segments}, section: Circle(radius: {radius:?}),
                material: Elastic(density: 1000, youngs_modulus: {young:?},
                    shear_modulus: {shear:?}), damping_time: 1e-2, {more}
                root: (position: {}, orientation: Along(direction: {})))",
            format!("{position:?}").replace('[', "(").replace(']', ")"),
            format!("{direction:?}").replace('[', "(").replace(']', ")"),
        )
    };
    let force = |rate: f64| {
        let upper = format!(
            "motion: Translate(velocity: ({rate:?}, {rate:?}, 0), ramp: 0.2, until: 0.2),
         tip: Loaded(force: (value: (0, 0, -0.02))),"
        );
        let mut run = Run::read(&format!(
            "(format: 1, duration: 1.0, fibers: [{}, {}],
        contact: (friction: Isotropic(0.5), residual: 1e-8, slip: 1e-9),
        environment: (gravity: (0, 0, 0), viscosity: 1e-3), stepper: (dt: 1e-3))",
            fiber([0.0; 3], [1.0, 0.0, 0.0], ""),
            fiber([middle, -middle, 2.0 * radius], [0.0, 1.0, 0.0], &upper),
        ));
        run.steps(600);
        run.world.contacts().map(|contact| contact.force).sum::<Vector3<f64>>()
    };
    let inertia = PI / 4.0 * radius.powi(4);
    let (bending, torsion) = (young * inertia, shear * 2.0 * inertia);
    let gives = [middle.powi(3) / (3.0 * bending), radius * radius * middle / torsion];
    let expected = drawn / (gives[0] + gives[1]);
    // To press them on each other bends them, and moves their surfaces too.
    let force = force(drawn / 0.1) - force(0.0);
    println!("{:.4e} and {:.4e} N for {expected:.4e} N", force.x, force.y);
    // As above; and that each is bent down by the other tilts it by less than that.
    let open = 1.5 / f64::from(segments) * gives[0] / (gives[0] + gives[1]);
    for found in [force.x, force.y] {
        assert!((found - expected).abs() < open * expected, "{force} N, {expected} N");
    }
}

/// Bonds hold places on surfaces: a moment about the axis of a fibre between two that are clamped
/// is borne by two bonds, by their forces at twice the radius. Without them it would spin.
#[test]
fn bonds_carry_a_torque() {
    let radius = 1e-3;
    let moment = 1e-6;
    let fiber = |x: f64, y: f64, more: &str| {
        format!(
            "(length: 0.01, segments: 4, section: Circle(radius: {radius:?}), damping_time: 1e-3,
                {more}
                root: (position: ({x:?}, {y:?}, 0), orientation: Along(direction: (0, 1, 0))))"
        )
    };
    let turned = format!("root_joint: Free, tip: Loaded(moment: (value: (0, {moment:?}, 0))),");
    let run = |gap: f64, laws: &str| {
        let apart = 2.0 * radius + gap;
        let mut run = Run::read(&format!(
            "(format: 1, duration: 1.0, fibers: [{}, {}, {}],
            contact: (friction: Isotropic(0.5), residual: 1e-8, slip: 1e-9 {laws}),
            environment: (gravity: (0, 0, 0), viscosity: 1e-3), stepper: (dt: 1e-3))",
            // The bonds and the root must not lie on a line, about which the fibre would swing.
            fiber(-apart, 2e-3, ""),
            fiber(0.0, 0.0, &turned),
            fiber(apart, 6e-3, ""),
        ));
        run.steps(200);
        run
    };
    let spin = |run: &Run| run.world.state(1).angular_velocities[1].z;
    let free = run(1e-7, "");
    assert!(spin(&free) > 1.0, "{}", spin(&free));
    let bonded = run(0.0, ", adhesion: Bonds(strength: 1.0, range: 1e-6)");
    assert!(spin(&bonded).abs() < 1e-9 * spin(&free), "{}", spin(&bonded));
    // What acts on the middle one, about the origin: at rest it balances the moment.
    let mut torque = Vector3::zeros();
    for contact in bonded.world.contacts() {
        let [BodyRef::Fiber(first), BodyRef::Fiber(second)] = contact.sides else {
            unreachable!("fibres only");
        };
        let nodes = bonded.world.state(first as usize).positions;
        #[expect(clippy::cast_possible_truncation, reason = "there are few segments")]
        let segment = (contact.at[0] as usize).min(nodes.len() - 2);
        let axis = nodes[segment].lerp(&nodes[segment + 1], contact.at[0] - segment as f64);
        let sense = f64::from(first == 1) - f64::from(second == 1);
        torque += sense * (axis + contact.lever).coords.cross(&contact.force);
    }
    let rest = torque + Vector3::new(0.0, moment, 0.0);
    assert!(rest.norm() < 1e-4 * moment, "{torque} Nm of {moment} Nm");
}
