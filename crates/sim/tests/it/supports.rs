//! Ends whose freedoms are held, sprung and loaded one by one, from scenes.

use crate::common::Run;
use crate::common::books::Books;
use nalgebra::Vector3;
use rapunzel_sim::Scene;
use std::f64::consts::{PI, TAU};

const LENGTH: f64 = 0.1;
const RADIUS: f64 = 5e-4;
const UP: &str = "length: 0.1, segments: 10, section: Circle(radius: 5e-4),
    material: Elastic(density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6),
    root: (orientation: Along(direction: (0, 0, 1)))";

/// The machine that twists: the tip is turned at a rate under constant tension. Before the fibre
/// leaves its axis the torque is `GJ angle / L` at both ends, and the tension is the load.
#[test]
fn a_tip_is_turned_at_a_rate_under_tension() {
    let mut books = Books::new(Run::read(&format!(
        "(format: 1, duration: 20.0, fibers: [({UP}, damping_time: 0.02,
            tip: Led(motion: Rotate(axis: (0, 0, 1), rate: 60, until: 2.0),
                joint: Supported(translations: (Held, Held, Free), rotations: (Held, Held, Held),
                    force: (value: (0, 0, 0.02)))))],
        environment: (gravity: (0, 0, 0)), stepper: (dt: 2e-3), output: (ledger: true))"
    )));
    for _ in 0..1500 {
        books.step();
    }
    assert!(books.whole() < 1e-10, "{:e}", books.whole());
    let world = &books.run.world;
    let torque = 4e6 * PI / 2.0 * RADIUS.powi(4) * 120_f64.to_radians() / LENGTH;
    let fibers = world.stepper().fibers().expect("fibres");
    for (at_tip, sign) in [(false, -1.0), (true, 1.0)] {
        let [force, moment] = fibers.reaction(0, at_tip, world.time()).expect("told");
        let right = Vector3::new(0.0, 0.0, sign * torque);
        assert!((moment - right).norm() < 1e-8 * torque, "{moment:?} for {right:?}");
        // At the tip the load is what pulls, and no reaction.
        let pull = Vector3::new(0.0, 0.0, if at_tip { 0.0 } else { -0.02 });
        assert!((force - pull).norm() < 2e-11, "{force:?}");
    }
    let pull = Vector3::new(0.0, 0.0, 0.02);
    for force in &world.state(0).forces {
        assert!((force - pull).norm() < 2e-11, "{force:?}");
    }
}

/// A fibre whose root slides on a spring along its axis swings as a mass on a spring, and its books
/// close.
#[test]
fn a_sprung_root_swings_at_its_frequency() {
    let mass = 1000.0 * PI * RADIUS * RADIUS * LENGTH;
    let stiffness = 0.5;
    let (period, steps) = (TAU * (mass / stiffness).sqrt(), 400);
    let dt = period / f64::from(steps);
    let weight = 1.0;
    let mut books = Books::new(Run::read(&format!(
        "(format: 1, duration: 20.0, fibers: [({UP}, root_joint: Supported(axes: End,
            translations: (Held, Held, Sprung(stiffness: {stiffness:?})),
            rotations: (Held, Held, Held)))],
        environment: (gravity: (0, 0, {weight:?})), output: (ledger: true),
        stepper: (dt: {dt:?}, method: Staggered(rho_infinity: 0.4)))"
    )));
    // It swings about its rest: there and twice as far after half a period.
    let rest = mass * weight / stiffness;
    let mut seen = Vec::new();
    for _ in 0..steps {
        books.step();
        seen.push(books.run.world.state(0).positions[0].z / rest);
    }
    assert!(books.whole() < 1e-10, "{:e}", books.whole());
    for (k, x) in (1..).zip(&seen) {
        let right = 1.0 - (TAU * f64::from(k) / f64::from(steps)).cos();
        // The phase error of the method is (omega dt)^2 / 12 a radian, and it is damped less.
        assert!((x - right).abs() < 1e-3, "step {k}: {x} for {right}");
    }
}

#[test]
fn supports_that_contradict_themselves_are_refused() {
    let refused = |fields: &str, stepper: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({UP}, {fields})], stepper: (dt: 1e-3{stepper}))"
        );
        Scene::from_ron(&text).expect_err("nonsense").to_string()
    };
    let error = refused(
        "tip: Led(joint: Supported(translations: (Held, Free, Free), force: (value: (1, 0, 0))))",
        "",
    );
    assert!(error.contains("fibers[0].tip.joint.force.value[0]"), "{error}");
    assert!(error.contains("leave one out"), "{error}");
    let error = refused("root_joint: Supported(rotations: (Free, Sprung(stiffness: 0), Held))", "");
    assert!(error.contains("root_joint.rotations[1].stiffness"), "{error}");
    let error = refused("root_joint: Supported()", ", method: Box()");
    assert!(error.contains("fibers[0].root_joint") && error.contains("Staggered"), "{error}");
}
