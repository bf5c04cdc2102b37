//! A rod that is fed onto a floor coils.

use crate::coil::{Coil, Rod, coils};
use nalgebra::{Point3, Vector2};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{Scene, World};
use std::f64::consts::{PI, TAU};

/// Length at which gravity bends the rod, `(B / rho A g)^(1/3)`, m; the lengths below are in it.
const UNIT: f64 = 0.0165;
/// Mass per length, kg/m, and gravity, m/s^2.
const LINEAR_DENSITY: f64 = 6e-4;
const G: f64 = 9.81;
/// Heights of the mouth: a decade.
const HEIGHTS: [f64; 3] = [2.0, 6.0, 20.0];
/// The rod. So fast that inertia hardly counts; so soft against torsion that what the first coils
/// have not been twisted yet hardly does: the twist of a steady coil comes with some turns.
const ROD: Rod = Rod { torsion: 0.1, inertia: 0.01 };
/// Radius of the section: so thin that the coils before it hardly lift a coil.
const SECTION: f64 = 0.005;
/// Length of a segment, and of what is fed in a step.
const SEGMENT: f64 = 0.125;
const FED: f64 = 0.04;
/// Turns that are laid down, and the last ones, of which the frequency is taken.
const TURNS: f64 = 3.5;
const LAST_TURNS: f64 = 2.0;
/// Height under which the rod lies, and that at which it is watched where it turns to.
const LAID: f64 = 0.1;
const WATCHED: f64 = 0.5;
/// What the radius and the frequency may be off, as the scaling law of coils is known.
const ROOM: f64 = 0.05;

fn speed() -> f64 {
    (ROD.inertia * G * UNIT).sqrt()
}

/// The scene, its step (s) and the number of steps.
fn scene(coil: &Coil) -> (String, f64, u32) {
    let height = coil.height;
    let fed = height + 1.0 + TAU * coil.radius * TURNS;
    let segments = (fed / SEGMENT).ceil();
    let (length, outside) = (segments * SEGMENT * UNIT, 0.5 * height);
    let bending = LINEAR_DENSITY * G * UNIT.powi(3);
    let (speed, dt) = (speed(), FED * UNIT / speed());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let steps = ((fed - outside) / FED).floor() as u32;
    let duration = f64::from(steps) * dt;
    let text = format!(
        "(format: 1, duration: {duration:?}, fibers: [(length: {length:?}, segments: {segments},
            section: Circle(radius: {:?}),
            material: Measured(bending: ({bending:?}, {bending:?}), torsion: {:?},
                linear_density: {LINEAR_DENSITY:?}),
            damping_time: {:?},
            root: (position: (0, 0, {:?}), orientation: Along(direction: (0.02, 0.01, -1))),
            feed: Some((inside: {:?}, rate: {speed:?})))],
        objects: [(shape: Plane(normal: (0, 0, 1)))], contact: (friction: Isotropic(0.8)),
        stepper: (dt: {dt:?}), output: (frame_rate: {:?}))",
        SECTION * UNIT,
        ROD.torsion * bending,
        0.02 * (UNIT / G).sqrt(),
        (height + SECTION) * UNIT,
        length - outside * UNIT,
        1.0 / dt,
    );
    (text, dt, steps)
}

/// The angle from a direction in the plane of the floor to another one, within half a turn.
fn turned(from: f64, to: f64) -> f64 {
    (to - from + PI).rem_euclid(TAU) - PI
}

/// Direction along which the segment before a node goes over the floor, rad.
fn course(nodes: &[Point3<f64>], node: usize) -> f64 {
    let along = nodes[node] - nodes[node - 1];
    along.y.atan2(along.x)
}

/// The first node that is lower than a height.
fn below(nodes: &[Point3<f64>], height: f64) -> Option<usize> {
    (1..nodes.len()).find(|&node| nodes[node].z < height * UNIT)
}

/// Mean distance of the turn that was laid down last from its middle.
fn radius(nodes: &[Point3<f64>]) -> Option<f64> {
    let first = below(nodes, LAID)?;
    let (mut angle, mut last) = (0.0_f64, first);
    while angle.abs() < TAU {
        last += 1;
        nodes.get(last)?;
        angle += turned(course(nodes, last - 1), course(nodes, last));
    }
    let turn = &nodes[first..last];
    let count = turn.len() as f64;
    let middle = turn.iter().map(|node| node.coords.xy()).sum::<Vector2<f64>>() / count;
    Some(turn.iter().map(|node| (node.coords.xy() - middle).norm()).sum::<f64>() / count / UNIT)
}

/// What is laid down in a radian, the speed over the frequency of the last turns, and the radius.
fn laid(coil: &Coil) -> Fallible<[f64; 2]> {
    let (text, dt, steps) = scene(coil);
    let mut world = World::build(&Scene::from_ron(&text)?)?;
    let (mut angle, mut before, mut angles) = (0.0, None, Vec::new());
    for _ in 0..steps {
        world.step(dt)?;
        let nodes = world.state(0).positions;
        let Some(node) = below(&nodes, WATCHED) else { continue };
        let now = course(&nodes, node);
        angle += turned(before.unwrap_or(now), now);
        before = Some(now);
        angles.push(angle);
    }
    let turns = LAST_TURNS * TAU;
    let back = angles.iter().rev().position(|one| (one - angle).abs() >= turns);
    let back = back.ok_or("it has not turned often enough")?;
    let found = radius(&world.state(0).positions).ok_or("no turn has been laid down")?;
    Ok([back as f64 * FED / turns, found])
}

/// Radius and frequency against height.
pub(crate) fn coiling() -> Fallible<Figure> {
    let theory = coils(ROD, &HEIGHTS)?;
    let mut checks = Vec::new();
    let mut points = [Vec::new(), Vec::new()];
    for coil in &theory {
        let found = laid(coil)?;
        let within = Criterion::Within((1.0 - ROOM) * coil.radius, (1.0 + ROOM) * coil.radius);
        for ((found, what), points) in
            found.into_iter().zip(["speed over frequency", "radius"]).zip(&mut points)
        {
            let name = format!("{what}, height {}", coil.height);
            checks.push(check(name, found, "", within, "the steady coil"));
            points.push([coil.height.log10(), found]);
        }
    }
    let right = theory.iter().map(|coil| [coil.height.log10(), coil.radius]).collect();
    let growth = theory[theory.len() - 1].radius / theory[0].radius;
    let name = "growth of the radius over the decade, by theory";
    checks.push(check(name, growth, "", Criterion::Told, "one, but for a logarithm of the height"));
    let [by_rate, by_place] = points;
    let chart = Chart {
        title: "Coils of a rod on a floor".into(),
        x: "decimal logarithm of the height, in (B / rho A g)^(1/3)",
        y: "radius, in the same",
        log_from: None,
        curves: vec![
            Curve { name: "speed over frequency".into(), points: by_rate },
            Curve { name: "radius".into(), points: by_place },
            Curve { name: "theory".into(), points: right },
        ],
    };
    Ok(Figure {
        scene: "a rod that is fed downward onto a floor, in the regime of gravity",
        parameters: "lengths in (B / rho A g)^(1/3): segments of 0.125, radius 0.005; U^2 / g = \
                     0.01, C / B = 0.1, friction 0.8",
        checks,
        drawings: vec![Drawing::Chart(chart)],
    })
}
