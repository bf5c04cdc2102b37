//! An elastic rod over a drum. H. Singh, Planar equilibria of an elastic rod wrapped around a
//! circular capstan, J. Elast. 151 (2022): its loads differ without friction too, and with friction
//! their ratio is not Euler's.

use crate::common::Run;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Of the drum with the fibre, up to its axis, m; of a segment, m; stiffness is 1 N m^2.
const RADIUS: f64 = 0.1;
const SEGMENT: f64 = 0.005;
/// What bends a rod about the drum, N: `B / 2 R^2`. Loads are in parts of it.
const BENDING: f64 = 0.5 / (RADIUS * RADIUS);

/// How a rod rests whose tip bears a load.
struct Rest {
    load: f64,
    /// Of the force on its root to the load.
    ratio: f64,
    /// Angle between the forces at its ends.
    turn: f64,
    /// Angles between rod and force at tip and root.
    ends: [f64; 2],
}

/// A straight rod that lies level on a drum which turns toward its tip. Its root is held in a ball
/// joint, three radii beside the axis, its tip bears loads downward, one after the other, nine
/// radii on the other side: lightly loaded it is a seesaw, else it goes about a quarter of the
/// drum.
///
/// A thin rod: the place where it touches is known only to where gaps differ by a thousandth of its
/// radius.
fn rest(mu: f64, loads: &[f64]) -> Vec<Rest> {
    let thin = 1e-5_f64;
    // A ribbon, bent about its weak axis: free to spin, a round rod is free to leave the plane.
    let flat = [thin / 3.0, 3.0 * thin];
    let modulus = 4.0 / (PI * flat[0].powi(3) * flat[1]);
    let density = 0.01 / (PI * thin * thin);
    // The middles of chords are on the drum, the axis on average at its radius.
    let drum = RADIUS / (1.0 + (SEGMENT / RADIUS).powi(2) / 12.0) - flat[0];
    let [behind, before] = [3.0 * RADIUS, 9.0 * RADIUS];
    let (dt, steps) = (0.02, 100_u32);
    let hold = dt * f64::from(steps);
    let mut points = vec![(0.0, 0.0)];
    for (i, load) in (0_u32..).zip(loads) {
        points.extend([0.5, 1.0].map(|part| (hold * (f64::from(i) + part), load * BENDING)));
    }
    let mut run = Run::read(&format!(
        "(format: 1, duration: 100.0, fibers: [(length: {:?}, segments: {},
            section: Ellipse(a: {:?}, b: {:?}), material: Elastic(density: {density:?},
            youngs_modulus: {modulus:?}, shear_modulus: {modulus:?}),
            root: (position: ({:?}, 0, {:?}), orientation: Along(direction: (1, 0, 0))),
            root_joint: Ball(),
            tip: Loaded(force: (value: (0, 0, -1), profile: Linear(points: {points:?}))))],
        objects: [(shape: Capsule(length: 1.0, radius: {drum:?}), turn: (90, 0, 0),
            motion: Rotate(axis: (0, 1, 0), rate: 5.0, until: 100.0))],
        contact: (friction: Isotropic({mu:?}), residual: 1e-6, slip: 1e-6),
        environment: (gravity: (0, 0, 0), viscosity: 0.1), stepper: (dt: {dt:?}))",
        before + behind,
        ((before + behind) / SEGMENT).round(),
        flat[0],
        flat[1],
        -behind,
        drum + flat[0] + 1e-6,
    ));
    let down = -Vector3::z();
    let rests = loads.iter().map(|&load| {
        run.steps(60);
        // Within the depth that is allowed the place of a single contact goes to and fro.
        let [mut pull, mut tip, mut root] = [Vector3::zeros(); 3];
        for _ in 60..steps {
            run.step();
            let state = run.world.state(0);
            pull += state.forces[0] / f64::from(steps - 60);
            root += state.frames[0] * Vector3::z();
            tip += state.frames[state.frames.len() - 1] * Vector3::z();
        }
        let ends = [tip.angle(&down), root.angle(&pull)];
        Rest { load, ratio: pull.norm() / (load * BENDING), turn: pull.angle(&down), ends }
    });
    rests.collect()
}

/// The ratio that a rod at rest has by the balance of material forces: along what does not touch,
/// and where contacts push but do not rub, `T + B kappa^2 / 2` stays what it is, with the tension
/// `T`. Of a leg with force `F` it is `F cos` of the angle between force and rod at its end, and if
/// it leaves the drum with `kappa` it has turned from the force's direction by the angle with `F
/// (cos end - cos angle) = B kappa^2 / 2`.
///
/// Either the legs turn by all of the angle between the forces, and the rod touches at a point; or
/// by less, with the drum's curvature, and between them it lies on the drum. Where a leg leaves it,
/// shear `F sin angle` ends in a point force that rubs too, and in between tension grows as Euler's
/// formula says.
///
/// Returns the ratio, and the curvature on the drum in parts of the drum's.
fn expected(rest: &Rest, mu: f64) -> [f64; 2] {
    let [low, high] = rest.ends;
    let wound = (low.cos() - 1.0 / rest.load).max(-1.0).acos();
    let legs = |turned: f64| {
        let other = wound.min(rest.turn - turned);
        let bent = rest.load * (low.cos() - other.cos());
        (other, bent, bent / (high.cos() - turned.cos()))
    };
    // How much more the root pulls than friction holds when its leg turns by an angle.
    let excess = |turned: f64| {
        let (other, _, force) = legs(turned);
        let held = rest.load * (other.cos() + mu * other.sin());
        force * (turned.cos() - mu * turned.sin())
            - held * (mu * (rest.turn - turned - other)).exp()
    };
    let [mut least, mut most] = [high, rest.turn - low];
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        *(if excess(middle) > 0.0 { &mut least } else { &mut most }) = middle;
    }
    let (_, bent, force) = legs(least);
    [force / rest.load, bent.sqrt()]
}

/// Ratios at loads, each as it is expected.
fn ratios(mu: f64, loads: &[f64]) -> Vec<f64> {
    let rests = rest(mu, loads);
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
