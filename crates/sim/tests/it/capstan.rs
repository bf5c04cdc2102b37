//! An elastic rod over a drum.

use crate::common::Run;
use crate::drum::{RADIUS, SEGMENT, expected, rests, scene};
use nalgebra::Vector3;
use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_2, PI};

/// Ratios at loads, each as it is expected.
fn ratios(mu: f64, loads: &[f64]) -> Vec<f64> {
    let mut run = Run::read(&scene(mu, loads));
    let next = || {
        run.step();
        Ok::<_, Infallible>(run.world.state(0))
    };
    let rests = rests(loads, next).expect("steps");
    for rest in &rests {
        let [ratio, bent] = expected(rest, mu);
        println!(
            "mu {mu}, load {:4}: ratio {:.5} for {ratio:.5}, curvature {bent:.3}",
            rest.load, rest.ratio
        );
        let step = SEGMENT / RADIUS;
        // The formula of chords in place of Euler's is off by mu angle / 12 of the squared turn of
        // a segment, and lengths of legs and radii by as much.
        let mut bounds =
            [1.0 - 0.25 * step * step, 1.0 + 0.25 * step * step].map(|part| part * ratio);
        if bent < 0.999 {
            // At a point the normal may be that of any place of the segment that touches.
            let tilt = 0.5 * bent * step;
            bounds = [-tilt, tilt].map(|tilt| expected(rest, (mu.atan() + tilt).tan())[0]);
        }
        assert!(
            bounds[0] < rest.ratio && rest.ratio < bounds[1],
            "{} not in {bounds:?}",
            rest.ratio
        );
    }
    rests.iter().map(|rest| rest.ratio).collect()
}

/// Lightly loaded the rod is a seesaw, and the shorter arm bears more; a load that winds it about
/// the drum makes it a rope. In between the ratio is less than either: bending takes more of the
/// tension where it is small.
#[test]
fn the_ratio_of_loads_has_a_minimum() {
    let mu = 0.3;
    let ratios = ratios(mu, &[0.1, 0.3, 1.0, 3.0, 10.0, 30.0]);
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let euler = (mu * FRAC_PI_2).exp();
    let falls = ratios.windows(2).map(|pair| pair[1] < pair[0]).collect::<Vec<_>>();
    assert_eq!(falls, [true, true, true, false, false], "{ratios:?}");
    assert!(ratios[0] > 1.3 * euler && least < 0.98 * euler, "{ratios:?} {euler}");
    assert!((ratios[5] / euler - 1.0).abs() < 0.02, "{ratios:?} {euler}");
}

/// Without friction it is the cosine of the angle between force and rod at the tip over that at the
/// root.
#[test]
fn loads_differ_without_friction() {
    let ratios = ratios(0.0, &[0.1, 0.3, 30.0]);
    assert!(ratios[0] > 1.1 && (ratios[2] - 1.0).abs() < 1e-3, "{ratios:?}");
}

/// A cord is wound half round a drum that stands still, by a root that is clamped at its surface:
/// lower than the ends of chords that lie on it. Its first segment is not pried off by that, and
/// friction misses at most the turn of that one.
#[test]
fn a_root_at_the_drum_draws_a_cord_over_it() {
    let (mu, load, radius, drum) = (0.3_f64, 0.05, 2e-4_f64, 0.01);
    let (length, segments, young, density) = (0.25, 125, 2e8, 1200.0);
    let axis = drum + radius;
    let place = axis + 1e-6;
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [(length: {length:?}, segments: {segments},
            section: Circle(radius: {radius:?}), damping_time: 1e-3,
            material: Elastic(density: {density:?}, youngs_modulus: {young:?},
                shear_modulus: 7e7),
            root: (position: ({place:?}, 0, 0), orientation: Along(direction: (0, 0, -1))),
            motion: Swing(angle: -360, radius: {place:?}, period: 4.0, axis: (0, 1, 0),
                center: (-1, 0, 0), pace: Constant),
            tip: Loaded(force: (value: (0, 0, {:?}))))],
        objects: [(shape: Capsule(length: 0.06, radius: {drum:?}), turn: (90, 0, 0))],
        contact: (friction: Isotropic({mu:?})), environment: (viscosity: 1e-3),
        stepper: (dt: 1e-3))",
        -load
    ));
    run.steps(1000);
    let state = run.world.state(0);
    let pull = state.forces[0].dot(&(state.frames[0] * Vector3::z()));
    // The leg that hangs leaves the drum with its curvature, which takes an angle of the turn; the
    // shear there rubs as a point force.
    let section = PI * radius * radius;
    let hangs = load + density * section * 9.81 * (length - PI * axis);
    let bent = 0.5 * young * section * radius * radius / 4.0 / (axis * axis);
    let leg = (1.0 - bent / hangs).acos();
    let held = hangs * (leg.cos() + mu * leg.sin());
    let [least, most] = [length / f64::from(segments), 0.0]
        .map(|missed| held * (mu * (PI - leg - missed / axis)).exp());
    println!("{pull:.4} N in {least:.4}..{most:.4}");
    assert!(least < pull && pull < most, "{pull} N in {least}..{most}");
}
