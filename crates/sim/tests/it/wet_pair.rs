//! Two wet hairs stick together as far as their stiffness lets them (Bico et al. 2004).

use crate::common::Run;
use std::f64::consts::PI;

const RADIUS: f64 = 3.5e-5;
const WATER: f64 = 0.0728;
/// How far the surfaces of the roots are drawn apart, m.
const APART: f64 = 0.707e-3;
const LENGTH: f64 = 0.012;
const SEGMENTS: usize = 60;

/// The length along which two hairs that lie together stay apart, m, after their roots have been
/// drawn apart. Friction, which does no work where they open face to face, keeps them in their
/// plane: without it they slide to each other's side and coil, which shortens it by 2 %.
fn dry(adhesion: &str) -> f64 {
    let hair = |y: f64, motion: &str| {
        format!(
            "(length: {LENGTH:?}, segments: {SEGMENTS}, section: Circle(radius: {RADIUS:?}),
            material: Elastic(density: 1320.0, youngs_modulus: 4e9, shear_modulus: 1.5e9),
            damping_time: 2e-3, motion: {motion},
            root: (position: (0.0, {y:?}, 0.0), orientation: Along(direction: (1.0, 0.0, 0.0))))"
        )
    };
    let led = "Translate(velocity: (0.0, 0.01414, 0.0), until: 0.05)";
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [{}, {}],
        contact: (friction: Isotropic(0.3), adhesion: {adhesion}),
        environment: (gravity: (0.0, 0.0, 0.0), viscosity: 1e-3), stepper: (dt: 1e-4))",
        hair(0.0, "Fixed"),
        hair(2.0 * RADIUS, led)
    ));
    run.steps(1500);
    let gap = |node: usize| {
        let [a, b] = [0, 1].map(|i| run.world.state(i).positions[node]);
        (b - a).norm() - 2.0 * RADIUS
    };
    assert!((gap(0) / APART - 1.0).abs() < 1e-3);
    assert!(gap(SEGMENTS).abs() < 2e-6, "they stick at their tips");
    // Between a clamp and straight hairs the gap is d (1 - 3 x^2 + 2 x^3): half in the middle.
    let half = (0..SEGMENTS).find(|&node| gap(node) < 0.5 * APART).expect("they close");
    let (before, behind) = (gap(half - 1), gap(half));
    let middle = half as f64 - (0.5 * APART - behind) / (before - behind);
    2.0 * middle * LENGTH / SEGMENTS as f64
}

#[test]
fn the_dry_length_balances_film_and_stiffness() {
    let bending = 4e9 * PI * RADIUS.powi(4) / 4.0;
    let energy = (2.0 * PI - 4.0) * WATER * RADIUS;
    let expected = (9.0 * bending * APART.powi(2) / energy).powf(0.25);
    let range = 5e-6;
    let found = dry(&format!("Line(force: {:?}, range: {range:?})", energy / range));
    println!("dry {:.3} mm for {:.3} mm", 1e3 * found, 1e3 * expected);
    // The film ends within 2.7 segments: a beam of such segments opens to a length 0.2 % shorter.
    assert!((found / expected - 1.0).abs() < 1e-2, "{found} for {expected}");
}
