//! A bundle that falls onto another or on its tips, and a jerk: no hair passes through any other.

use crate::common::Run;
use crate::common::topology::crossed;
use rapunzel_sim::{ActiveContact, BodyRef};

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

/// Between no two states do the axes of any two segments come nearer than half a diameter, and
/// after every step no two are nearer than 0.98 diameters but for the segments of one bend. Returns
/// most contacts of a step, and the fastest node at the end of one, m/s.
fn stays_apart(run: &mut Run, steps: usize) -> (usize, f64) {
    let mut before = run.all_positions();
    let (mut active, mut depth, mut fastest) = (0, 0.0_f64, 0.0_f64);
    for step in 0..steps {
        let report = run.step().contact;
        (active, depth) = (active.max(report.active), depth.max(report.depth));
        let after = run.all_positions();
        assert_eq!(crossed(&before, &after, 0.5 * DIAMETER), None, "step {step}");
        assert_eq!(crossed(&after, &after, 0.98 * DIAMETER), None, "step {step}");
        before = after;
        let velocities = (0..run.fibers()).flat_map(|i| run.world.state(i).velocities);
        fastest = velocities.map(|v| v.norm()).fold(fastest, f64::max);
    }
    println!(
        "{active} contacts at most, {:.4} diameters deep, {fastest:.3} m/s at most",
        depth / DIAMETER
    );
    (active, fastest)
}

fn falls(mut run: Run) {
    let (active, _) = stays_apart(&mut run, 60);
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

/// So many hairs of 50 mm, level, within a millimetre upon a ball.
fn over_a_ball(count: usize, tip: &str, dt: f64) -> Run {
    Run::read(&format!(
        "(format: 1, seed: 5, duration: 1.0,
        fibers: [(length: 0.05, segments: 40, section: Circle(radius: 3.5e-5),
            shape: Sine(amplitude: 0.0003, wavelength: 0.015),
            root: (position: (-0.015, 0.0, 0.0115), orientation: Along(direction: (1, 0, 0))),
            arrangement: Ellipse(semi_axes: (0.001, 0.001), count: {count}), tip: {tip})],
        objects: [(shape: Ball(radius: 0.01))],
        contact: (friction: Isotropic(0.3)),
        environment: (viscosity: 1.8e-5), stepper: (dt: {dt:?}))"
    ))
}

/// A weight of 1 g, some thousands of that of the hair, draws each hair down over a ball and taut,
/// at once and slowly. It is a force alone, which no mass holds back: they come faster than with
/// the mass of 1 g, at some 1 m/s.
#[test]
fn a_gram_at_each_tip_draws_a_bundle_over_a_ball() {
    for (profile, dt) in [("Constant", 1e-3), ("Ramp(until: 0.02)", 1e-3), ("Constant", 1e-4)] {
        let weight = format!("Loaded(force: (value: (0, 0, -9.81e-3), profile: {profile}))");
        let mut run = over_a_ball(12, &weight, dt);
        let (active, fastest) = stays_apart(&mut run, 20);
        assert!(active > 100 && fastest > 1.0, "{profile}, {dt} s: {active}, {fastest} m/s");
        // Taut: level to the top, a quarter of the ball, and the rest down, but for what is off the
        // plane.
        let lowest = 0.05 - 0.015 - 0.5 * std::f64::consts::PI * 0.01;
        let tips = (0..run.fibers()).map(|i| run.positions(i)[40].z + lowest);
        assert!(tips.clone().all(|z| z.abs() < 1e-3), "{profile}: {:?}", tips.collect::<Vec<_>>());
    }
}

/// A block of 1 g is glued to all tips of a bundle that lies level upon a ball: it falls with some
/// 0.7 m/s and swings under the ball.
#[test]
fn a_block_of_a_gram_swings_on_a_bundle() {
    let (side, gap) = (0.004, 5e-7);
    let mut run = Run::read(&format!(
        "(format: 1, seed: 5, duration: 1.0,
        fibers: [(length: 0.05, segments: 40, section: Circle(radius: 3.5e-5),
            root: (position: (-0.015, 0.0, 0.0115), orientation: Along(direction: (1, 0, 0))),
            arrangement: Ellipse(semi_axes: (0.001, 0.001), count: 12))],
        objects: [(shape: Ball(radius: 0.01)),
            (shape: Cuboid(sides: ({side:?}, {side:?}, {side:?})),
            position: ({:?}, 0.0, 0.0115), moves: Free(mass: Mass(0.001)))],
        contact: (friction: Isotropic(0.3), adhesion: Bonds(strength: 1.0, range: 1e-6)),
        environment: (viscosity: 1.8e-5), stepper: (dt: 1e-3))",
        0.035 + 0.5 * DIAMETER + gap + 0.5 * side
    ));
    let (active, fastest) = stays_apart(&mut run, 120);
    assert!(active > 80 && fastest > 0.5, "{active} contacts, {fastest} m/s");
    assert_eq!(run.world.contacts().filter(|bearing| bearing.bonded).count(), run.fibers());
}

/// Hairs that have come to lie over a ball and on each other stay apart in steps of 4 ms too.
#[test]
fn what_lies_still_stays_apart_in_long_steps() {
    let mut run = over_a_ball(40, "Free", 1e-3);
    run.steps(300);
    run.dt = 4e-3;
    let (_, fastest) = stays_apart(&mut run, 50);
    // A few diameters a step at first.
    assert!(fastest < 0.1, "{fastest} m/s");
    let of_fibers =
        |bearing: &ActiveContact| bearing.sides.iter().all(|s| matches!(s, BodyRef::Fiber(_)));
    let touches = run.world.contacts().filter(of_fibers).count();
    // Or there would be nothing to keep apart: of forty hairs half touch another.
    assert!(touches >= 20, "{touches} contacts of hairs");
}
