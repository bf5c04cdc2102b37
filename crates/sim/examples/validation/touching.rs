//! Rods that lie on things and rub.

use nalgebra::Vector3;
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{Scene, World};
use std::f64::consts::{FRAC_PI_2, PI};

/// Of the drum with the fibre, up to its axis, m; of a segment, m; stiffness is 1 N m^2.
const DRUM: f64 = 0.1;
const SEGMENT: f64 = 0.005;

/// A rod at rest over a drum that turns toward its tip.
struct Wound {
    /// Of the force on its root to the load on its tip.
    ratio: f64,
    /// Angle between the forces at its ends, rad.
    turn: f64,
    /// Angles between rod and force at tip and root, rad.
    ends: [f64; 2],
}

/// A level rod on a drum, thin and a ribbon, so that it stays in its plane; its root is in a ball
/// joint, its tip bears loads, one after the other, in parts of `B / 2 R^2`.
fn wound(mu: f64, loads: &[f64]) -> Fallible<Vec<Wound>> {
    let thin = 1e-5_f64;
    let bending = 0.5 / (DRUM * DRUM);
    let flat = [thin / 3.0, 3.0 * thin];
    let modulus = 4.0 / (PI * flat[0].powi(3) * flat[1]);
    let density = 0.01 / (PI * thin * thin);
    // The middles of chords are on the drum, the axis on average at its radius.
    let drum = DRUM / (1.0 + (SEGMENT / DRUM).powi(2) / 12.0) - thin;
    let [behind, before] = [3.0 * DRUM, 9.0 * DRUM];
    let (dt, steps) = (0.02, 100_u32);
    let hold = dt * f64::from(steps);
    let mut points = vec![(0.0, 0.0)];
    for (i, load) in (0_u32..).zip(loads) {
        points.extend([0.5, 1.0].map(|part| (hold * (f64::from(i) + part), load * bending)));
    }
    let scene = Scene::from_ron(&format!(
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
        drum + thin + 1e-6,
    ))?;
    let mut world = World::build(&scene)?;
    let down = -Vector3::z();
    let mut rests = Vec::new();
    for load in loads {
        let [mut pull, mut tip, mut root] = [Vector3::zeros(); 3];
        for step in 0..steps {
            world.step(dt)?;
            if step < 60 {
                continue;
            }
            // Within the depth that is allowed the place of a single contact goes to and fro.
            let state = world.state(0);
            pull += state.forces[0] / f64::from(steps - 60);
            root += state.frames[0] * Vector3::z();
            tip += state.frames[state.frames.len() - 1] * Vector3::z();
        }
        let ends = [tip.angle(&down), root.angle(&pull)];
        rests.push(Wound { ratio: pull.norm() / (load * bending), turn: pull.angle(&down), ends });
    }
    Ok(rests)
}

/// The ratio that an elastic rod has: along what does not touch `T + B kappa^2 / 2` stays what it
/// is; a leg that has turned by an angle leaves the drum with the drum's curvature, where its shear
/// ends in a point force that rubs too, and in between tension grows as Euler's formula says.
fn elastic(rest: &Wound, load: f64, mu: f64) -> f64 {
    let [low, high] = rest.ends;
    let wound = (low.cos() - 1.0 / load).max(-1.0).acos();
    let legs = |turned: f64| {
        let other = wound.min(rest.turn - turned);
        let bent = load * (low.cos() - other.cos());
        (other, bent / (high.cos() - turned.cos()))
    };
    let excess = |turned: f64| {
        let (other, force) = legs(turned);
        let held = load * (other.cos() + mu * other.sin());
        force * (turned.cos() - mu * turned.sin())
            - held * (mu * (rest.turn - turned - other)).exp()
    };
    let [mut least, mut most] = [high, rest.turn - low];
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        *(if excess(middle) > 0.0 { &mut least } else { &mut most }) = middle;
    }
    legs(least).1 / load
}

/// The capstan, of a rope and of rods that resist their bending.
pub(crate) fn capstan() -> Fallible<Figure> {
    let mu = 0.3;
    let loads = [10.0, 30.0];
    let rests = wound(mu, &loads)?;
    let euler = (mu * FRAC_PI_2).exp();
    let mut checks = Vec::new();
    let mut curves = [Vec::new(), Vec::new()];
    for (rest, load) in rests.iter().zip(loads) {
        let right = elastic(rest, load, mu);
        // The formula of chords in place of Euler's is off by mu angle / 12 of the squared turn of
        // a segment, and lengths of legs and radii by as much.
        let room = 0.25 * (SEGMENT / DRUM).powi(2) * right;
        let criterion = Criterion::Within(right - room, right + room);
        let name = format!("ratio of forces, load {load}");
        checks.push(check(
            name,
            rest.ratio,
            "",
            criterion,
            "material forces, with Euler's formula",
        ));
        curves[0].push([load, rest.ratio]);
        curves[1].push([load, right]);
    }
    let last = rests[rests.len() - 1].ratio;
    let rope = Criterion::Within(0.98 * euler, 1.02 * euler);
    checks.push(check("the same, beside a rope's", last, "", rope, "exp(mu angle)"));
    let [found, theory] = curves;
    let chart = Chart {
        title: "Forces at the ends of a rod over a drum".into(),
        x: "load, in B / 2 R^2",
        y: "ratio of forces",
        log_from: None,
        curves: vec![
            Curve { name: "240 segments".into(), points: found },
            Curve { name: "theory".into(), points: theory },
        ],
    };
    Ok(Figure {
        scene: "a rod over a drum that turns toward the loaded end",
        parameters: "mu = 0.3, a quarter of the drum, segments of 0.05 of its radius",
        checks,
        drawings: vec![Drawing::Chart(chart)],
    })
}

/// Stick and slip of a hair on a belt: an oscillator of one degree of freedom.
pub(crate) fn stick_slip() -> Fallible<Figure> {
    const RADIUS: f64 = 3.5e-5;
    let (length, segments, g) = (0.01, 4_u32, 9.81);
    let (rest, slide, frequency) = (0.4, 0.3, 200.0);
    let mass = 1300.0 * PI * RADIUS * RADIUS * length;
    // Moments of the masses of the nodes about the pin.
    let sum = |power: i32| -> f64 {
        let one = |a: u32| {
            let share = if a == 0 || a == segments { 0.5 } else { 1.0 };
            let at = length * f64::from(a) / f64::from(segments);
            share * mass / f64::from(segments) * at.powi(power)
        };
        (0..=segments).map(one).sum()
    };
    let force = frequency * frequency * sum(2) / length;
    let pressure = g * sum(1) / length;
    let swing = (rest - slide) * pressure / force;
    let pace = frequency * swing / 3.1;
    let right = 2.0 * swing / pace + 2.0 / frequency * (PI - (frequency * swing / pace).atan());
    let dt = 1e-3 / frequency;
    let scene = Scene::from_ron(&format!(
        "(format: 1, duration: 10.0, fibers: [(
            length: {length:?}, segments: {segments}, section: Circle(radius: {RADIUS:?}),
            material: Elastic(density: 1300.0, youngs_modulus: 3.8e13, shear_modulus: 1.3e13),
            root: (position: (0, 0, {RADIUS:?}), orientation: Along(direction: (1, 0, 0))),
            root_joint: Ball(), tip: Loaded(force: (value: ({force:?}, 0.0, 0.0))),
        )],
        objects: [(shape: Plane(normal: (0, 0, 1)),
            motion: Rotate(axis: (0, 0, 1), rate: {:?}, until: 10.0))],
        contact: (friction: Resting(resting: {rest:?}, sliding: {slide:?}),
            slip: {:?}, residual: 1e-5, depth: 5e-3),
        environment: (gravity: (0.0, 0.0, -{g:?})), stepper: (dt: {dt:?}))",
        pace.to_degrees(),
        1e-4 * pace * length
    ))?;
    let mut world = World::build(&scene)?;
    // When it is carried through the middle of what it swings about.
    let middle = slide * pressure / force;
    let (mut before, mut times, mut points) = (0.0, Vec::new(), Vec::new());
    let mut step = 0_u32;
    while f64::from(step) * dt < 2.7 * right {
        world.step(dt)?;
        step += 1;
        let tip = world.node(0, None).0;
        let angle = tip.y.atan2(tip.x);
        let part = (middle - before) / (angle - before);
        if before < middle && angle >= middle {
            times.push(dt * (f64::from(step - 1) + part));
        }
        if step.is_multiple_of(100) {
            points.push([dt * f64::from(step), angle]);
        }
        before = angle;
    }
    let [first, second] = times[..] else {
        return Err("it does not stick and slip twice".into());
    };
    // The crossing of the middle is found within a step; what slips less than the belt moves by
    // 1e-4 counts as sticking, for a part of the period that goes with its root.
    let room = 5e-3 * right;
    let criterion = Criterion::Within(right - room, right + room);
    let chart = Chart {
        title: "A hair on a belt sticks and slips".into(),
        x: "time (s)",
        y: "angle, rad",
        log_from: None,
        curves: vec![Curve { name: "4 segments".into(), points }],
    };
    Ok(Figure {
        scene: "a stiff hair, pinned at its root, on a belt that turns about the pin; a force on its \
                tip draws it back",
        parameters: "coefficients 0.4 at rest and 0.3 in sliding, steps of a thousandth of the \
                     frequency's radian",
        checks: vec![check(
            "period",
            second - first,
            "s",
            criterion,
            "2 D / V + (2 / w) (pi - atan(w D / V))",
        )],
        drawings: vec![Drawing::Chart(chart)],
    })
}
