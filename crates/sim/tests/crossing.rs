//! A bundle that falls onto another or on its tips, and a jerk: no hair passes through any other.

#![expect(clippy::print_stdout, reason = "a test tells what it measured")]

mod common;

use common::Run;
use common::topology::crossed;

const DIAMETER: f64 = 7e-5;

/// Hairs of 30 mm, on average half a millimetre apart, of random curl.
fn bundle(seed: u64, tip: &str) -> Run {
    let hairs = |rest: &str| {
        format!(
            "(length: 0.03, segments: 20, section: Circle(radius: 3.5e-5),
            arrangement: Ellipse(semi_axes: (0.001, 0.001), count: 12), {rest})"
        )
    };
    let lying = hairs(&format!(
        "shape: Helix(radius: 0.001, pitch: 0.012),
        root: (position: (-0.015, 0.0, 0.0), orientation: Along(direction: (1, 0, 0))), tip: {tip}"
    ));
    let falling = hairs(
        "shape: Sine(amplitude: 0.0005, wavelength: 0.015), root_joint: Free,
        velocity: (0.0, 0.0, -1.2),
        root: (position: (0.0, -0.015, 0.006), orientation: Along(direction: (0.1, 1.0, 0.05)))",
    );
    Run::read(&format!(
        "(format: 1, seed: {seed}, duration: 1.0, fibers: [{lying}, {falling}],
        contact: (friction: Isotropic(0.3)),
        environment: (viscosity: 1.8e-5), stepper: (dt: 1e-3))"
    ))
}

/// Between no two states do the axes of any two segments come nearer than half a diameter, and after
/// every step no two are nearer than 0.98 diameters but for the segments of one bend.
fn falls(mut run: Run) {
    let mut before = run.all_positions();
    let (mut active, mut depth) = (0, 0.0_f64);
    for step in 0..60 {
        let report = run.step().contact;
        (active, depth) = (active.max(report.active), depth.max(report.depth));
        let after = run.all_positions();
        assert_eq!(crossed(&before, &after, 0.5 * DIAMETER), None, "step {step}");
        assert_eq!(crossed(&after, &after, 0.98 * DIAMETER), None, "step {step}");
        before = after;
    }
    println!("{active} contacts at most, {:.4} diameters deep", depth / DIAMETER);
    assert!(active > 40, "they meet: {active}");
}

#[test]
fn a_bundle_falls_onto_a_bundle() {
    for seed in [1, 2] {
        falls(bundle(seed, "Held"));
    }
}

/// The tips of the lower bundle are jerked upward with 1 g.
#[test]
fn a_jerked_bundle_meets_one_that_falls() {
    falls(bundle(3, "Driven(velocity: (0.0, 0.0, 0.1962), ramp: 0.02, until: 0.04)"));
}

/// It comes with 1.2 m/s, buckles and collapses; its roots stop when it is half as high.
#[test]
fn a_bundle_falls_on_its_tips() {
    falls(Run::read(
        "(format: 1, seed: 4, duration: 1.0,
        fibers: [(length: 0.05, segments: 30, section: Circle(radius: 3.5e-5),
            shape: Sine(amplitude: 0.0005, wavelength: 0.015), velocity: (0.0, 0.0, -1.2),
            motion: Translate(velocity: (0.0, 0.0, -1.2), until: 0.02),
            root: (position: (0.0, 0.0, 0.051)),
            arrangement: Ellipse(semi_axes: (0.001, 0.001), count: 36))],
        objects: [(shape: Plane(normal: (0, 0, 1)))],
        contact: (friction: Isotropic(0.3)),
        environment: (viscosity: 1.8e-5), stepper: (dt: 1e-3))",
    ));
}
