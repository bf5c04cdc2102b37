//! Two cords that are twisted about each other.

use crate::common::Run;
use std::f64::consts::TAU;

/// Radius of the cords, m, of the helix on which they start, and its pitch.
const RADIUS: f64 = 1e-3;
const START: f64 = 1.02e-3;
const PITCH: f64 = 0.04;
const LENGTH: f64 = 0.125;
const SEGMENTS: usize = 60;

/// A cord of the braid, whose tip is pulled, N, and may only follow.
fn cord(side: f64, pull: f64) -> String {
    let roll = if side < 0.0 { 180.0 } else { 0.0 };
    format!(
        "(length: {LENGTH:?}, segments: {SEGMENTS}, section: Circle(radius: {RADIUS:?}),
          material: Elastic(density: 1200.0, youngs_modulus: 1e7, shear_modulus: 3.4e6),
          damping_time: 2e-3, initial: Helix(radius: {START:?}, pitch: {PITCH:?}),
          root: (position: ({:?}, 0, 0), orientation: Along(direction: (0, 0, 1), roll: {roll:?})),
          tip: Led(joint: Supported(translations: (Held, Held, Free),
            rotations: (Held, Held, Held),
            force: (value: (0, 0, {pull:?}), profile: Ramp(until: 0.05)))))",
        side * START
    )
}

/// Two cords that are twisted about each other and stretched keep their turns, touch all along, and
/// are as long as the geometry of two helices that touch says.
#[test]
fn a_braid_under_tension_keeps_its_pitch() {
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [{}, {}], contact: (friction: Isotropic(0.2)),
          environment: (gravity: (0, 0, 0)), stepper: (dt: 1e-3))",
        cord(1.0, 1.0),
        cord(-1.0, 1.0)
    ));
    run.steps(200);
    let (a, b) = (run.positions(0), run.positions(1));
    // Helices of nodes whose chords touch in their middles, with the turns that they start with.
    let turn = TAU * (LENGTH / SEGMENTS as f64) / (TAU * START).hypot(PITCH);
    let height = |radius: f64| {
        let (length, across) = (LENGTH / SEGMENTS as f64, 2.0 * radius * (0.5 * turn).sin());
        SEGMENTS as f64 * (length * length - across * across).sqrt()
    };
    let radius = RADIUS / (0.5 * turn).cos();
    let (expected, before) = (height(radius), height(START));
    let found = a[SEGMENTS].z;
    println!("height {found} for {expected}, {before} before");
    // At both ends, over some three lengths sqrt(E I / T) = 3 mm, cords are held apart as before.
    assert!((found - expected).abs() < 0.15 * (expected - before), "{found} for {expected}");
    let angle = |i: usize| (a[i].y - b[i].y).atan2(a[i].x - b[i].x);
    for i in 10..SEGMENTS - 10 {
        let apart = (a[i] - b[i]).norm();
        assert!((apart / (2.0 * radius) - 1.0).abs() < 1e-3, "{apart} at {i}");
        let own = (angle(i + 1) - angle(i)).rem_euclid(TAU);
        assert!((own / turn - 1.0).abs() < 1e-2, "turns by {own} for {turn} at {i}");
    }
}
