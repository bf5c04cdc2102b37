//! Ends that are loaded at the root and led at the tip.

use crate::common::Run;
use crate::common::books::Books;
use nalgebra::Vector3;
use rapunzel_sim::Scene;
use std::f64::consts::PI;

const LENGTH: f64 = 0.1;
const RADIUS: f64 = 5e-4;
const MATTER: &str = "length: 0.1, segments: 10, section: Circle(radius: 5e-4),
    material: Elastic(density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6)";

/// A force on the root of a fibre that floats gives it the momentum `F t`, whatever it does inside.
#[test]
fn a_force_on_the_root_moves_the_whole() {
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [({MATTER},
            root_joint: Loaded(force: (value: (1e-4, 0, 2e-4))))],
        environment: (gravity: (0, 0, 0)), stepper: (dt: 1e-3))"
    ));
    run.steps(100);
    let found = run.world.momentum().expect("told").linear;
    let right = Vector3::new(1e-4, 0.0, 2e-4) * 0.1;
    // Newton's method stops at residuals of rounding.
    assert!((found - right).norm() < 1e-9 * right.norm(), "{found:?} for {right:?}");
}

/// Two forces that pull at both ends stretch it with the same tension everywhere, and two couples
/// twist it by `M / G J`.
#[test]
fn loads_on_both_ends_balance() {
    let rigidity = 4e6 * PI / 2.0 * RADIUS.powi(4);
    let moment = 0.3 * rigidity / LENGTH;
    let mut run = Run::read(&format!(
        "(format: 1, duration: 100.0, fibers: [({MATTER}, damping_time: 0.01,
            root: (orientation: Along(direction: (0, 0, 1))),
            root_joint: Loaded(force: (value: (0, 0, -0.01)), moment: (value: (0, 0, {:?}))),
            tip: Loaded(force: (value: (0, 0, 0.01)), moment: (value: (0, 0, {moment:?}))))],
        environment: (gravity: (0, 0, 0)), stepper: (dt: 0.05, method: BackwardEuler))",
        -moment
    ));
    run.steps(400);
    let state = run.world.state(0);
    let pull = Vector3::new(0.0, 0.0, 0.01);
    for force in &state.forces {
        assert!((force - pull).norm() < 1e-9, "{force:?}");
    }
    for curvature in &state.curvatures[1..10] {
        assert!((curvature.z - 3.0).abs() < 1e-6, "{curvature:?}");
    }
}

/// A tip that is led goes and turns as its motion says. The ledger closes: what the supports do is
/// what the fibre has gained, and what damping and the integrator have taken. At rest again, the
/// ends bear opposite forces, and moments that these balance.
#[test]
fn a_led_tip_goes_where_it_is_led_and_its_work_closes() {
    let mut books = Books::new(Run::read(&format!(
        "(format: 1, duration: 20.0, fibers: [({MATTER}, damping_time: 0.05,
            shape: Curved(curvature: (8, 0, 3)), root: (orientation: Along(direction: (0, 0, 1))),
            tip: Led(motion: Keyframes(points: [
                (time: 0),
                (time: 0.5, translation: (0.01, 0.02, -0.005), rotation: (0, 0, 60))])))],
        environment: (gravity: (0, 0, 0)), stepper: (dt: 2e-3), output: (ledger: true))"
    )));
    let start = books.run.world.state(0);
    for _ in 0..2000 {
        books.step();
    }
    assert!(books.whole() < 1e-10, "{:e}", books.whole());
    let world = &books.run.world;
    let state = world.state(0);
    let way = state.positions[10] - start.positions[10];
    assert!((way - Vector3::new(0.01, 0.02, -0.005)).norm() < 1e-12, "{way:?}");
    let fibers = world.stepper().fibers().expect("fibres");
    let [root, tip] =
        [false, true].map(|at_tip| fibers.reaction(0, at_tip, world.time()).expect("told"));
    let arm = state.positions[10] - state.positions[0];
    let (force, moment) = (root[0] + tip[0], root[1] + tip[1] + arm.cross(&tip[0]));
    let size = [tip[0].norm(), tip[1].norm()];
    println!("{size:?}, left {force:?} {moment:?}");
    // What still moves decays with the damping.
    assert!(size[0] > 1e-6 && force.norm() < 1e-6 * size[0], "{force:?} of {size:?}");
    assert!(moment.norm() < 1e-6 * size[1], "{moment:?} of {size:?}");
}

#[test]
fn ends_that_are_led_and_free_are_refused() {
    let refused = |fields: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({MATTER}, {fields})], stepper: (dt: 1e-3))"
        );
        Scene::from_ron(&text).expect_err("nonsense").to_string()
    };
    let error = refused("root_joint: Loaded(), motion: Shake(amplitude: (1, 0, 0), frequency: 1)");
    assert!(error.contains("fibers[0].motion") && error.contains("leave one out"), "{error}");
    let error = refused("tip: Led(motion: Fixed, joint: Loaded())");
    assert!(error.contains("fibers[0].tip.joint") && error.contains("drives nothing"), "{error}");
    let error = refused("tip: Led(motion: Keyframes(points: []))");
    assert!(error.contains("fibers[0].tip.motion"), "{error}");
}
