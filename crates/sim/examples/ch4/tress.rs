//! Figures 4.7 and 4.8: the tress before it is charged, charged, and wet; and without gravity.

use crate::Size;
use crate::film::{Film, play};
use nalgebra::{Point3, Vector3};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Pictures};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_sim::scene::Dealing;
use rapunzel_sim::{Scene, World};

/// A run of a scene: pictures at `times` (s), and at every step how wide the tips are spread and
/// how strong the mean field is.
struct Run {
    film: Film,
    /// Time and spread, s and mm.
    spread: Vec<[f64; 2]>,
    /// Time and mean field, s and kV/m.
    field: Vec<[f64; 2]>,
    /// Mean curvature of the fibers, 1/m.
    curvature: Vec<f64>,
    unsettled: usize,
    equilibria: usize,
}

fn run(scene: &Scene, times: &[f64]) -> Fallible<Run> {
    let mut run = Run {
        film: Film::at(times),
        spread: Vec::new(),
        field: Vec::new(),
        curvature: Vec::new(),
        unsettled: 0,
        equilibria: 0,
    };
    play(scene, |world| {
        run.film.observe(world);
        run.spread.push([world.time(), 1e3 * spread(world)]);
        run.curvature.push(curvature(world));
        let Some(report) = world.charge_report().filter(|_| world.steps() > 0) else { return };
        run.field.push([world.time(), 1e-3 * report.mean_field]);
        run.unsettled += report.unsettled;
        run.equilibria = run.equilibria.max(report.equilibria);
    })?;
    Ok(run)
}

/// Root mean square distance of the tips from their mean, m.
fn spread(world: &World) -> f64 {
    let count = world.assembly().fibers().len();
    let tips: Vec<Point3<f64>> = (0..count).map(|i| world.node(i, None).0).collect();
    let mean = tips.iter().map(|tip| tip.coords).sum::<Vector3<f64>>() / count as f64;
    (tips.iter().map(|tip| (tip.coords - mean).norm_squared()).sum::<f64>() / count as f64).sqrt()
}

/// Mean curvature of all fibers, 1/m.
fn curvature(world: &World) -> f64 {
    let count = world.assembly().fibers().len();
    let of = |i: usize| {
        let curvatures = world.state(i).curvatures;
        curvatures.iter().map(Vector3::norm).sum::<f64>() / curvatures.len() as f64
    };
    (0..count).map(of).sum::<f64>() / count as f64
}

fn at(series: &[[f64; 2]], time: f64) -> f64 {
    series.iter().find(|[t, _]| (t - time).abs() < 1e-9).map_or(f64::NAN, |[_, value]| *value)
}

fn drawings(number: &str, run: Run) -> Vec<Drawing> {
    let chart = |what: &str, y, points| {
        Drawing::Chart(Chart {
            title: format!("{number} {what}"),
            x: "portion",
            y,
            log_from: None,
            curves: vec![Curve { name: what.into(), points }],
        })
    };
    vec![
        Drawing::Pictures(Pictures {
            title: format!("{number} The tress, before its charge first"),
            view: "seen along y, x to the right",
            axes: [Vector3::x(), Vector3::z()],
            columns: 3,
            pictures: run.film.pictures,
        }),
        chart("Spread of the tips", "spread (mm)", run.spread),
        chart("Mean field on the charges", "field (kV/m)", run.field),
    ]
}

fn settled(run: &Run) -> ClaimCheck {
    check(
        "portions that did not come to rest",
        run.unsettled as f64,
        "",
        Criterion::AtMost(0.0),
        "not told",
    )
}

/// Figure 4.7: uncharged, charged at 65 %, and at 100 % humidity.
pub(crate) fn humidity(size: Size) -> Fallible<Figure> {
    let run = run(&size.scene("tress")?, &[0.0, 8.0, 10.0])?;
    let spreads = [0.0, 8.0, 10.0].map(|t| at(&run.spread, t));
    let [natural, dry, wet] = [0, 8, 10].map(|step| run.curvature[step]);
    let mut checks = vec![
        check("spread of the tips before", spreads[0], "mm", Criterion::Told, "a picture"),
        check(
            "spread charged over before",
            spreads[1] / spreads[0],
            "",
            Criterion::AtLeast(1.1),
            "the tress opens",
        ),
        check(
            "gain of the spread at 100 % over that at 65 %",
            (spreads[2] - spreads[0]) / (spreads[1] - spreads[0]),
            "",
            Criterion::AtMost(1.0),
            "clearly less at 100 %",
        ),
        check(
            "mean curvature at 100 % over that at 65 %",
            wet / dry,
            "",
            Criterion::AtMost(1.0),
            "the fibers lose their shape",
        ),
        check("mean curvature before", natural, "1/m", Criterion::Told, "not told"),
        settled(&run),
    ];
    if size == Size::Full {
        checks.push(check(
            "mean field on the charges",
            at(&run.field, 8.0),
            "kV/m",
            Criterion::Within(9.0, 14.0),
            "about 13 kV/m; it opens",
        ));
    }
    Ok(Figure {
        scene: "scenes/charge/tress.ron",
        parameters: "7.7e-4 statC/cm, of which the thesis gives no unit; type of hair and curvature are ours",
        drawings: drawings("4.7", run),
        checks,
    })
}

/// Figure 4.8: the same charge without gravity; and what the thesis says of dealing it in portions.
pub(crate) fn weightless(size: Size) -> Fallible<Figure> {
    let mut scene = size.scene("tress-without-gravity")?;
    if let Some(charging) = &mut scene.charging {
        charging.grid = None;
        if size == Size::Reduced {
            charging.compared = vec![Dealing::Once];
        }
    }
    let run = run(&scene, &[0.0, 1.0, 8.0])?;
    let heavy = self::run(&size.scene("tress")?, &[])?;
    let gain = |run: &Run| at(&run.spread, 8.0) - at(&run.spread, 0.0);
    let mut checks = vec![
        check(
            "gain of the spread over that with gravity",
            gain(&run) / gain(&heavy),
            "",
            Criterion::AtLeast(3.0),
            "a picture that is far wider; our estimate is 30",
        ),
        settled(&run),
    ];
    if size == Size::Reduced {
        checks.push(check(
            "equilibria by dealing in eight portions and at once",
            run.equilibria as f64,
            "",
            Criterion::Told,
            "they are said to differ; equilibria that are converged do not have to",
        ));
    }
    Ok(Figure {
        scene: "scenes/charge/tress-without-gravity.ron",
        parameters: "as 4.7",
        drawings: drawings("4.8", run),
        checks,
    })
}
