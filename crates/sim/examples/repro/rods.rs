//! Figures of single fibers.

use crate::film::{Film, play, scene};
use nalgebra::{Point3, Vector3};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Pictures};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_sim::scene::{Arrangement, RodMethod, StepperSettings, Weights};
use rapunzel_sim::{Scene, World};
use std::f64::consts::TAU;

/// The first fiber's tip: position (m) and velocity (m/s).
pub(crate) fn tip(world: &World) -> (Point3<f64>, Vector3<f64>) {
    let state = world.state(0);
    let last = state.positions.len() - 1;
    (state.positions[last], state.velocities[last])
}

/// Sets the integrator to the box scheme and the largest time step to `dt`, s; the step taken is
/// that one if a multiple of it is `1 / frame_rate`.
pub(crate) fn with_box(scene: &mut Scene, weights: Weights, dt: f64) {
    let residual = rapunzel_rod_dynamic::BoxOptions::default().tolerance;
    scene.stepper =
        StepperSettings { dt, method: Some(RodMethod::Box { weights, residual }), tolerance: None };
}

/// Figure 3.15: a sine that is clamped level and let go.
pub(crate) fn wavy() -> Fallible<Figure> {
    let scene = scene("sine-under-gravity")?;
    let mut film = Film::at(&[0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6]);
    let (mut torsion, mut kept) = (0.0_f64, f64::MAX);
    play(&scene, |world| {
        film.observe(world);
        let state = world.state(0);
        let natural = world.assembly().fibers()[0].nodes();
        let most = natural.iter().map(|node| node.natural_curvature.norm()).fold(0.0, f64::max);
        torsion = state.curvatures.iter().map(|k| k.z.abs() / most).fold(torsion, f64::max);
        // What the curvature has of the natural one beyond the first wave, where the whole weight
        // hangs: on whole waves the smooth bend under the weight has no part.
        let pairs = || state.curvatures.iter().zip(natural).skip(natural.len() / 5);
        let both: f64 = pairs().map(|(k, n)| k.dot(&n.natural_curvature)).sum();
        let own: f64 = pairs().map(|(_, n)| n.natural_curvature.norm_squared()).sum();
        // Until it hangs; what follows is a whip.
        if world.time() < 0.25 {
            kept = kept.min(both / own);
        }
    })?;
    let pictures = Pictures {
        title: "3.15 A wavy rod falls and keeps its waves".into(),
        view: "seen along y, x to the right",
        axes: [Vector3::x(), Vector3::z()],
        columns: 4,
        pictures: film.pictures,
    };
    Ok(Figure {
        scene: "sine-under-gravity",
        parameters: "the thesis gives no size; undamped: box scheme, rho_inf 1, steps of 1 ms",
        drawings: vec![Drawing::Pictures(pictures)],
        checks: vec![
            ClaimCheck {
                compared: "torsion, in parts of the largest natural curvature".into(),
                obtained: torsion,
                unit: "",
                criterion: Criterion::AtMost(1e-9),
                thesis: "only bending, kappa_3 = 0",
            },
            ClaimCheck {
                compared: "part of the natural waves in the curvature while it falls, at least"
                    .into(),
                obtained: kept,
                unit: "",
                // Most of them: the weight bends each of them more or less.
                criterion: Criterion::AtLeast(0.5),
                thesis: "the natural curvature stays in the deformed shape",
            },
        ],
    })
}

/// Figure 3.16: a helix under a moment and under a force at its end.
pub(crate) fn helix() -> Fallible<Figure> {
    let scene = scene("helix-with-end-load")?;
    let mut film = Film::at(&[0.0, 0.5, 1.5, 2.0, 2.5, 3.5]);
    let (mut radius, mut height) = (Vec::new(), Vec::new());
    let mut torsion = [0.0_f64; 2];
    play(&scene, |world| {
        film.observe(world);
        let (time, state) = (world.time(), world.state(0));
        // The coil's inner turns; the first and last feel the ends.
        let turns = &state.positions[20..=80];
        let mean = turns.iter().map(|p| p.coords).sum::<Vector3<f64>>() / turns.len() as f64;
        let across = |p: &Point3<f64>| (p.x - mean.x).hypot(p.y - mean.y);
        let size = turns.iter().map(across).sum::<f64>() / turns.len() as f64;
        radius.push([time, 1e3 * size]);
        height.push([time, -1e3 * tip(world).0.z]);
        let natural = world.assembly().fibers()[0].nodes();
        let strain = state.curvatures.iter().zip(natural).map(|(k, n)| (k - n.natural_curvature).z);
        let most = strain.fold(0.0, |most: f64, k| most.max(k.abs()));
        let phase = usize::from(time > 2.0);
        torsion[phase] = torsion[phase].max(most);
    })?;
    let at = |curve: &[[f64; 2]], time: f64| {
        curve.iter().find(|p| p[0] > time - 1e-9).map_or(f64::NAN, |p| p[1])
    };
    let checks = [
        (
            "radius at 0.5 s over that at rest",
            at(&radius, 0.5) / radius[0][1],
            true,
            "the moment narrows it",
        ),
        (
            "radius at 1.5 s over that at rest",
            at(&radius, 1.5) / radius[0][1],
            false,
            "the other way it widens it",
        ),
        (
            "length at 3.5 s over that at rest",
            at(&height, 3.5) / height[0][1],
            true,
            "the force compresses it",
        ),
        (
            "length at 2.5 s over that at rest",
            at(&height, 2.5) / height[0][1],
            false,
            "the other way it stretches it",
        ),
    ];
    let mut checks: Vec<ClaimCheck> = checks
        .into_iter()
        .map(|(compared, obtained, less, thesis)| ClaimCheck {
            compared: compared.into(),
            obtained,
            unit: "",
            criterion: if less { Criterion::AtMost(0.98) } else { Criterion::AtLeast(1.02) },
            thesis,
        })
        .collect();
    for (load, most) in ["moment", "force"].into_iter().zip(torsion) {
        checks.push(ClaimCheck {
            compared: format!("largest torsion under the {load}"),
            obtained: most,
            unit: "1/m",
            criterion: Criterion::AtLeast(1.0),
            thesis: "kappa_3 is not 0 in both cases",
        });
    }
    let chart = |title: &str, y, name: &str, points| {
        Drawing::Chart(Chart {
            title: title.into(),
            x: "time (s)",
            y,
            log_from: None,
            curves: vec![Curve { name: name.into(), points }],
        })
    };
    Ok(Figure {
        scene: "helix-with-end-load",
        parameters: "30 cm; alpha 0.4, beta 0, gamma 1, steps of 1/30 s as in the thesis; the coil \
                     and the loads are ours",
        drawings: vec![
            Drawing::Pictures(Pictures {
                title:
                    "3.16 A helix under a moment (0.5 and 1.5 s) and a force (2.5 and 3.5 s) at \
                        its end"
                        .into(),
                view: "seen along y, x to the right",
                axes: [Vector3::x(), Vector3::z()],
                columns: 6,
                pictures: film.pictures,
            }),
            chart("Mean radius of the inner turns", "radius (mm)", "radius", radius),
            chart("Depth of the tip below the root", "depth (mm)", "depth", height),
        ],
        checks,
    })
}

/// Figure 3.17: a straight rod with a moment at its end.
pub(crate) fn torque() -> Fallible<Figure> {
    let scene = scene("straight-rod-with-torque")?;
    let mut film = Film::at(&[0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 2.0, 3.0]);
    let mut turn = Vec::new();
    let mut crossings = 0;
    play(&scene, |world| {
        film.observe(world);
        let state = world.state(0);
        let h = world.assembly().fibers()[0].segment_lengths()[0];
        let angle: f64 = state.curvatures.iter().map(|k| k.norm() * h).sum();
        turn.push([world.time(), angle / TAU]);
        crossings = crossings.max(self_crossings(&state.positions));
    })?;
    let most = turn.iter().map(|p| p[1]).fold(0.0, f64::max);
    Ok(Figure {
        scene: "straight-rod-with-torque",
        parameters: "45 cm; alpha 0.3, beta 0, gamma 0.7, steps of 1/30 s as in the thesis; the \
                     moment goes up to 4 pi E I / L",
        drawings: vec![
            Drawing::Pictures(Pictures {
                title: "3.17 A straight rod with a moment at its end".into(),
                view: "seen along y, x to the right",
                axes: [Vector3::x(), Vector3::z()],
                columns: 4,
                pictures: film.pictures,
            }),
            Drawing::Chart(Chart {
                title: "How far the rod is wound".into(),
                x: "time (s)",
                y: "turns",
                log_from: None,
                curves: vec![Curve { name: "turns of the tangent".into(), points: turn }],
            }),
        ],
        checks: vec![
            check("turns at most", most, "", Criterion::AtLeast(1.9), "a moment makes loops"),
            check(
                "crossings of the fiber with itself at most",
                f64::from(crossings),
                "",
                Criterion::AtLeast(1.0),
                "a moment makes loops",
            ),
        ],
    })
}

/// Figure 3.20: two ends that come together under a moment.
pub(crate) fn buckling() -> Fallible<Figure> {
    let scene = scene("buckling")?;
    let mut film = Film::at(&[0.0, 1.5, 2.5, 2.9, 3.05, 3.2, 3.4, 4.0]);
    let mut kinetic = Vec::new();
    let mut crossings = 0;
    play(&scene, |world| {
        film.observe(world);
        kinetic.push([world.time(), world.energy().kinetic]);
        if world.steps() % 10 == 0 {
            crossings = crossings.max(self_crossings(&world.state(0).positions));
        }
    })?;
    let peak = kinetic.iter().copied().fold([0.0, 0.0], |a, b| if b[1] > a[1] { b } else { a });
    let driven = kinetic
        .iter()
        .filter(|p| (0.5..0.5 * peak[0]).contains(&p[0]))
        .map(|p| p[1])
        .fold(0.0, f64::max);
    Ok(Figure {
        scene: "buckling",
        parameters: "the thesis gives no numbers; ball joints under a constant axial moment, driven \
                     together at 4 cm/s each, a short force in the middle",
        drawings: vec![
            Drawing::Pictures(Pictures {
                title: "3.20 Buckling: the ends are driven together under a moment".into(),
                view: "seen along y, x to the right",
                axes: [Vector3::x(), Vector3::z()],
                columns: 4,
                pictures: film.pictures,
            }),
            Drawing::Chart(Chart {
                title: "Kinetic energy".into(),
                x: "time (s)",
                y: "kinetic energy (J)",
                log_from: Some(1e-10),
                curves: vec![Curve { name: "kinetic energy".into(), points: kinetic }],
            }),
        ],
        checks: vec![
            ClaimCheck {
                compared: "kinetic energy at the collapse over that of the driven motion".into(),
                obtained: peak[1] / driven,
                unit: "",
                criterion: Criterion::AtLeast(10.0),
                thesis: "the motion gets faster toward the bifurcation",
            },
            ClaimCheck {
                compared: "crossings of the fiber with itself at most, seen along y".into(),
                obtained: f64::from(crossings),
                unit: "",
                criterion: Criterion::AtLeast(1.0),
                thesis: "it turns into a loop",
            },
        ],
    })
}

/// How often a line crosses itself, seen along y.
fn self_crossings(points: &[Point3<f64>]) -> u32 {
    let side = |a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>| {
        (b.x - a.x) * (c.z - a.z) - (b.z - a.z) * (c.x - a.x)
    };
    let mut count = 0;
    for i in 0..points.len() - 1 {
        for j in i + 2..points.len() - 1 {
            let ([a, b], [c, d]) = ([&points[i], &points[i + 1]], [&points[j], &points[j + 1]]);
            let apart = side(a, b, c) * side(a, b, d) < 0.0;
            count += u32::from(apart && side(c, d, a) * side(c, d, b) < 0.0);
        }
    }
    count
}

/// Figure 3.22: how fast a fiber comes to rest, by the coefficients.
pub(crate) fn damping() -> Fallible<Figure> {
    const SETS: [(f64, f64); 6] =
        [(0.0, 0.5), (0.1, 0.6), (0.2, 0.7), (0.3, 0.7), (0.4, 0.8), (0.4, 1.0)];
    let mut curves = Vec::new();
    let mut rest = Vec::new();
    for (alpha, gamma) in SETS {
        let mut scene = scene("lock-falling")?;
        let bundle = &mut scene.fibers[0];
        bundle.arrangement = Arrangement::Single;
        bundle.damping_time = 0.0;
        scene.output.frame_rate = 200.0;
        with_box(&mut scene, Weights::Given { alpha, beta: 0.0, gamma }, 5e-3);
        let mut points = Vec::new();
        play(&scene, |world| points.push([world.time(), world.energy().kinetic]))?;
        // What moves in the last fifth of the time.
        let late = points.iter().filter(|p| p[0] > 0.8 * scene.duration).map(|p| p[1]);
        rest.push(late.fold(0.0, f64::max));
        curves.push(Curve { name: format!("alpha {alpha}, gamma {gamma}"), points });
    }
    let thesis = "how soon it rests depends on the coefficients";
    let check = |compared, obtained, criterion| check(compared, obtained, "", criterion, thesis);
    let mut checks = Vec::new();
    for i in 1..SETS.len() {
        checks.push(check(
            format!(
                "late kinetic energy of {} over that of {}",
                curves[i].name,
                curves[i - 1].name
            ),
            rest[i] / rest[i - 1],
            Criterion::AtMost(1.0),
        ));
    }
    Ok(Figure {
        scene: "lock-falling",
        parameters: "the guide alone, no other damping, beta 0, steps of 5 ms; the thesis's pairs of \
                     alpha and gamma are not in its text. Pairs of one sum damp alike: the method \
                     is of second order where the sum is 1/2",
        drawings: vec![Drawing::Chart(Chart {
            title: "3.22 Kinetic energy of a fiber that falls, by the coefficients".into(),
            x: "time (s)",
            y: "kinetic energy (J)",
            log_from: Some(1e-10),
            curves,
        })],
        checks,
    })
}
