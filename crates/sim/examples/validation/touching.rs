//! Rods that lie on things and rub.

use crate::belt::{Belt, angle};
use crate::drum::{DT, RADIUS, SEGMENT, expected, rests, scene};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{Scene, SimError, World};
use std::f64::consts::FRAC_PI_2;

/// The capstan, of a rope and of rods that resist their bending.
pub(crate) fn capstan() -> Fallible<Figure> {
    let mu = 0.3;
    let loads = [10.0, 30.0];
    let mut world = World::build(&Scene::from_ron(&scene(mu, &loads))?)?;
    let rests = rests(&loads, || {
        world.step(DT)?;
        Ok::<_, SimError>(world.state(0))
    })?;
    let euler = (mu * FRAC_PI_2).exp();
    let mut checks = Vec::new();
    let mut curves = [Vec::new(), Vec::new()];
    for (rest, load) in rests.iter().zip(loads) {
        let [right, _] = expected(rest, mu);
        // The formula of chords in place of Euler's is off by mu angle / 12 of the squared turn of
        // a segment, and lengths of legs and radii by as much.
        let room = 0.25 * (SEGMENT / RADIUS).powi(2) * right;
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
    let belt = Belt::new();
    let start = World::build(&Scene::from_ron(&belt.scene(0.0))?)?;
    let aside = angle(&start.node(0, None).0);
    let mut world = World::build(&Scene::from_ron(&belt.scene(aside))?)?;
    let mut all = Vec::new();
    let next = || {
        world.step(belt.dt)?;
        Ok::<_, SimError>(world.node(0, None).0)
    };
    let times = belt.crossings(next, |time, angle| all.push([time, angle]))?;
    let points = all.into_iter().step_by(100).collect();
    let right = belt.period;
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
        scene: "a stiff arc of hair, pinned at its root, on a belt that turns about the pin; a force on its \
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
