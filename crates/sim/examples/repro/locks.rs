//! Figures of locks of 1 + 180 fibers.

use crate::film::{Film, play, scene};
use nalgebra::{Point3, Vector3};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Pictures};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_sim::World;
use rapunzel_sim::scene::Tip;

/// Seen along y.
fn pictures(title: &str, columns: usize, film: Film) -> Drawing {
    Drawing::Pictures(Pictures {
        title: title.into(),
        view: "seen along y, x to the right",
        axes: [Vector3::x(), Vector3::z()],
        columns,
        pictures: film.pictures,
    })
}

fn chart(title: &str, y: &'static str, name: &str, points: Vec<[f64; 2]>) -> Drawing {
    Drawing::Chart(Chart {
        title: title.into(),
        x: "time (s)",
        y,
        log_from: None,
        curves: vec![Curve { name: name.into(), points }],
    })
}

/// The mean position of all tips, m.
fn mean_tip(world: &World) -> Point3<f64> {
    let count = world.assembly().fibers().len();
    let tips = (0..count).filter_map(|i| world.state(i).positions.last().map(|p| p.coords));
    Point3::from(tips.sum::<Vector3<f64>>() / count as f64)
}

/// Extremes of a curve later than `from`, in their order: where it stops rising or falling.
fn turning_points(points: &[[f64; 2]], from: f64) -> Vec<[f64; 2]> {
    let turns = points.windows(3).filter(|w| w[1][0] > from);
    turns.filter(|w| (w[1][1] - w[0][1]) * (w[2][1] - w[1][1]) < 0.0).map(|w| w[1]).collect()
}

fn last_over_first(swings: &[f64]) -> f64 {
    swings.first().zip(swings.last()).map_or(f64::NAN, |(first, last)| last / first)
}

/// Figure 3.21: a lock is pulled by 30 % of its length and let go.
pub(crate) fn pulled() -> Fallible<Figure> {
    let scene = scene("lock-pulled")?;
    let Tip::Pulled { until, .. } = scene.fibers[0].tip else {
        return Err("the lock of lock-pulled.ron is not pulled".into());
    };
    let mut film = Film::at(&[0.0, 0.25, until, 0.52, 0.54, 0.56, 0.6, 1.5]);
    let mut height = Vec::new();
    play(&scene, |world| {
        film.observe(world);
        height.push([world.time(), 1e3 * mean_tip(world).z]);
    })?;
    let at = |time: f64| height.iter().find(|p| p[0] > time - 1e-9).map_or(f64::NAN, |p| p[1]);
    let pull = (at(0.0) - at(until)) / (1e3 * scene.fibers[0].length);
    let rest = height.last().map_or(f64::NAN, |p| p[1]);
    let after = height.iter().filter(|p| p[0] > until).map(|p| p[1]);
    let over = after.fold(f64::MIN, f64::max);
    let swings: Vec<f64> =
        turning_points(&height, until).iter().map(|p| (p[1] - rest).abs()).collect();
    Ok(Figure {
        scene: "lock-pulled",
        parameters: "25 cm, 1 + 180 fibers, each integrated by itself, pulled in 0.5 s; gravity \
                     and the air act too",
        drawings: vec![
            pictures("3.21 A lock is pulled by 30 % and let go at 0.5 s", 8, film),
            chart("Mean height of the tips", "height (mm)", "tips", height),
        ],
        checks: vec![
            check("pull, in parts of the length", pull, "", Criterion::Within(0.29, 0.31), "30 %"),
            check(
                "height after release above that at the end",
                over - rest,
                "mm",
                Criterion::AtLeast(1.0),
                "it snaps back beyond its rest",
            ),
            check(
                "turns of the motion after release",
                swings.len() as f64,
                "",
                Criterion::AtLeast(2.0),
                "it comes to rest in a finite number of swings",
            ),
            check(
                "last swing over the first",
                last_over_first(&swings),
                "",
                Criterion::AtMost(0.2),
                "it comes to rest",
            ),
        ],
    })
}

/// Figure 3.23: a lock that is let go in its natural shape.
pub(crate) fn falling() -> Fallible<Figure> {
    let scene = scene("lock-falling")?;
    let mut film = Film::at(&[0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 2.0]);
    let mut height = Vec::new();
    play(&scene, |world| {
        film.observe(world);
        height.push([world.time(), 1e3 * mean_tip(world).z]);
    })?;
    let start = height.first().map_or(f64::NAN, |p| p[1]);
    let rest = height.last().map_or(f64::NAN, |p| p[1]);
    let swings: Vec<f64> =
        turning_points(&height, 0.0).iter().map(|p| (p[1] - rest).abs()).collect();
    Ok(Figure {
        scene: "lock-falling",
        parameters: "25 cm, 1 + 180 fibers, each integrated by itself, without contacts",
        drawings: vec![
            pictures("3.23 A lock stretches under gravity", 8, film),
            chart("Mean height of the tips", "height (mm)", "tips", height),
        ],
        checks: vec![
            ClaimCheck {
                compared: "stretch at rest".into(),
                obtained: start - rest,
                unit: "mm",
                criterion: Criterion::AtLeast(5.0),
                thesis: "it stretches under gravity",
            },
            ClaimCheck {
                compared: "turns of the motion".into(),
                obtained: swings.len() as f64,
                unit: "",
                criterion: Criterion::AtLeast(4.0),
                thesis: "several damped swings",
            },
            ClaimCheck {
                compared: "last swing over the first".into(),
                obtained: last_over_first(&swings),
                unit: "",
                criterion: Criterion::AtMost(0.5),
                thesis: "several damped swings",
            },
        ],
    })
}

/// Figure 3.24: a lock whose root goes up and down an arc.
pub(crate) fn moving_root() -> Fallible<Figure> {
    let scene = scene("lock-on-moving-root")?;
    let mut film = Film::at(&[0.0, 0.5, 1.0, 1.25, 1.5, 2.0, 3.0, 4.0]);
    let (mut speeds, mut energies, mut path) = (Vec::new(), Vec::new(), Vec::new());
    let root = |world: &World| world.state(0).positions[0];
    let mut before: Option<(f64, Point3<f64>)> = None;
    play(&scene, |world| {
        film.observe(world);
        let (time, here) = (world.time(), root(world));
        if let Some((t, there)) = before {
            speeds.push((here - there).norm() / (time - t));
        }
        before = Some((time, here));
        energies.push([time, 1e6 * world.energy().kinetic]);
        path.push(here);
    })?;
    speeds.sort_by(f64::total_cmp);
    let (low, high) = (speeds[speeds.len() / 20], speeds[speeds.len() * 19 / 20]);
    let chord = path.iter().map(|p| (p - path[0]).norm()).fold(0.0, f64::max);
    let angle = 2.0 * (0.5 * chord / 0.3).asin().to_degrees();
    let most = 1e-6 * energies.iter().map(|p| p[1]).fold(0.0, f64::max);
    let mass: f64 = 181.0 * World::build(&scene)?.assembly().fibers()[0].mass();
    let speed = (2.0 * most / mass).sqrt();
    Ok(Figure {
        scene: "lock-on-moving-root",
        parameters: "25 cm, 1 + 180 fibers, each integrated by itself; an arc of 45 degrees and \
                     30 cm up and down in 2 s",
        drawings: vec![
            pictures("3.24 The root goes up and down an arc of 45 degrees", 4, film),
            chart("Kinetic energy of the lock", "kinetic energy (uJ)", "181 fibers", energies),
        ],
        checks: vec![
            ClaimCheck {
                compared: "angle of the arc that the root covers".into(),
                obtained: angle,
                unit: "degrees",
                criterion: Criterion::Within(44.5, 45.5),
                thesis: "45 degrees, 30 cm",
            },
            ClaimCheck {
                compared: "speed of the root, 95th over 5th percentile".into(),
                obtained: high / low,
                unit: "",
                criterion: Criterion::AtMost(1.01),
                thesis: "constant speed",
            },
            ClaimCheck {
                compared: "largest root mean square speed of the lock over that of its root".into(),
                obtained: speed / high,
                unit: "",
                criterion: Criterion::AtMost(6.0),
                thesis: "the model stays stable",
            },
        ],
    })
}
