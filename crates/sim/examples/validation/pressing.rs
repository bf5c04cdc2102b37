//! A heavy strip that is pressed onto a plane.

use crate::discrete::{Convergence, errors};
use crate::pressed::{DT, HANGING, PRESSING, Strip, slid};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{Scene, World};

/// Weights, in `B / L^2`, and parts of the length by which the clamp comes down.
const WEIGHTS: [f64; 3] = [1.0, 10.0, 40.0];
const WAYS: [f64; 2] = [0.1, 0.2];
const MESHES: [usize; 3] = [15, 30, 60];
/// Part by which friction is above and below the threshold: some times what 60 segments leave.
const BESIDE: f64 = 0.01;
/// How far a tip that sticks goes at most, in its ten seconds, and one that slips at least.
const STUCK: f64 = 1e-5;
const SLIPPED: f64 = 1e-4;
/// Friction that nothing slips against.
const ROUGH: f64 = 10.0;

/// A strip whose clamp is level with the plane, curved a little by nature: a straight one would
/// bear Euler's load before it goes to either side.
fn strip(weight: f64) -> Strip {
    Strip { lean: 0.0, curvature: 0.3, weight }
}

/// A run to its end: how far the tip has slid, and the forces of the plane on it along the plane
/// and along the normal.
fn run(strip: &Strip, segments: usize, way: f64, mu: f64) -> Fallible<[f64; 3]> {
    let mut world = World::build(&Scene::from_ron(&strip.scene(segments, way, mu))?)?;
    for _ in 0..HANGING {
        world.step(DT)?;
    }
    let hung = world.state(0).positions;
    for _ in 0..PRESSING {
        world.step(DT)?;
    }
    let state = world.state(0);
    let last = state.forces[segments - 1];
    // Half of the last segment's weight hangs on the tip.
    let weight = 0.5 * strip.weight / segments as f64;
    Ok([slid(&hung, &state.positions), last.x, last.z + weight])
}

/// The threshold of friction below which it slips, once it is pressed so far.
fn threshold(weight: f64, way: f64) -> Fallible<f64> {
    let path = strip(weight).pressed(way).ok_or("a strip does not stand on its tip")?;
    Ok(path[path.len() - 1].critical())
}

/// Romero et al. 2021, protocol "stick-slip".
pub(crate) fn pressed_strip() -> Fallible<Figure> {
    let mut all = Vec::new();
    let mut beside = Vec::new();
    for weight in WEIGHTS {
        let strip = strip(weight);
        for way in WAYS {
            let right = threshold(weight, way)?;
            let name = format!("weight {weight}, pressed by {way}");
            // What holds a tip that no force lets slip. Of the heaviest strip the errors of second
            // order nearly cancel, and no order is seen above what contacts leave, some 1e-6.
            if way == WAYS[1] && weight < WEIGHTS[2] {
                all.push(Convergence::of(format!("{name}, ratio"), &MESHES, right, |n| {
                    let [_, along, normal] = run(&strip, n, way, ROUGH)?;
                    Ok(-along / normal)
                })?);
            }
            for (part, word, criterion) in [
                (1.0 + BESIDE, "more", Criterion::AtMost(STUCK)),
                (1.0 - BESIDE, "less", Criterion::AtLeast(SLIPPED)),
            ] {
                let [slid, ..] = run(&strip, MESHES[2], way, part * right)?;
                let name = format!("{name}, slid with 1 % {word} friction");
                beside.push(check(name, slid.abs(), "L", criterion, "the heavy elastica"));
            }
        }
    }
    let mut checks: Vec<_> =
        all.iter().flat_map(|one| one.checks("", "the heavy elastica")).collect();
    checks.append(&mut beside);
    let curve = |way: f64| -> Fallible<Curve> {
        let points = (0..=16).map(|i| {
            let length = 0.25 * f64::from(i);
            Ok([length, threshold(length.powi(3), way)?])
        });
        Ok(Curve {
            name: format!("pressed by {way} of its length"),
            points: points.collect::<Fallible<_>>()?,
        })
    };
    let chart = Chart {
        title: "Friction below which a pressed strip slips".into(),
        x: "length, in (B / w)^(1/3)",
        y: "coefficient of friction",
        log_from: None,
        curves: [0.05, 0.1, 0.2].into_iter().map(curve).collect::<Fallible<_>>()?,
    };
    Ok(Figure {
        scene: "a strip hangs from a clamp above a plane, and is pressed onto it",
        parameters: "natural curvature 0.3 / L; B = L = 1; 60 segments",
        checks,
        drawings: vec![Drawing::Chart(chart), errors(&all)],
    })
}
