//! Figures 7.11 and 7.12: a bundle that bends to a loop.

use crate::measure::{chart, correlation, least};
use crate::models::Size;
use nalgebra::Vector3;
use rapunzel_collision::thesis::hierarchy::Variant;
use rapunzel_collision::thesis::scenes::{self, MovingFibers};
use rapunzel_repro::plot::{Drawing, Picture, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

const STEPS: usize = 100;

fn at(step: usize, spread: f64) -> MovingFibers {
    scenes::looping(150, 100, step as f64 / STEPS as f64, spread)
}

/// A way to keep a tree valid.
struct Strategy {
    name: &'static str,
    variant: Variant,
    /// Rebuilds when the last search needed so many times the tests after the last rebuild.
    rebuild_from: f64,
}

fn strategies() -> [Strategy; 4] {
    [
        Strategy { name: "AS refit", variant: Variant::As, rebuild_from: f64::INFINITY },
        Strategy { name: "AS rebuilt", variant: Variant::As, rebuild_from: 0.0 },
        Strategy { name: "AS rebuilt in need", variant: Variant::As, rebuild_from: 1.5 },
        Strategy { name: "AL", variant: Variant::Al, rebuild_from: f64::INFINITY },
    ]
}

/// Series over the steps.
#[derive(Default)]
struct Run {
    update: Vec<f64>,
    find: Vec<f64>,
    tests: Vec<f64>,
    pairs: Vec<f64>,
}

/// Updates and searches at every step, both timed as the least of `runs`.
fn run(strategy: &Strategy, spread: f64, runs: usize) -> Fallible<Run> {
    let mut tree = strategy.variant.build(&at(0, spread).capsules()?);
    let mut series = Run::default();
    let (mut last, mut fresh) = (0.0, f64::INFINITY);
    for step in 0..=STEPS {
        let scene = at(step, spread);
        let capsules = scene.capsules()?;
        let rebuilds = step > 0 && last >= strategy.rebuild_from * fresh;
        let (update, updated) = least(runs, || {
            if rebuilds {
                tree.rebuild(&capsules);
                Ok(())
            } else {
                tree.update(&capsules)
            }
        });
        updated?;
        let (find, found) = least(runs, || tree.all(&capsules));
        let found = found?;
        last = found.counts.volume_tests as f64;
        if rebuilds || step == 0 {
            fresh = last;
        }
        series.update.push(update);
        series.find.push(find);
        series.tests.push(last);
        series.pairs.push(found.pairs.len() as f64);
    }
    Ok(series)
}

fn steps() -> Vec<f64> {
    (0..=STEPS).map(|step| step as f64).collect()
}

/// Figure 7.11: AL over the motion.
pub(crate) fn looping(_: Size) -> Fallible<Figure> {
    let [.., layered] = strategies();
    let run = run(&layered, 0.05, 3)?;
    let film = [0, 33, 66, 100].map(|step| {
        let scene = at(step, 0.05);
        let line = |fiber: usize| scene.positions[scene.layout.node_range(fiber)].to_vec();
        let fibers = (0..scene.layout.fibers()).step_by(5).map(line).collect();
        Picture { caption: format!("step {step}"), fibers }
    });
    let pictures = Pictures {
        title: "7.11 The bundle bends to a loop".into(),
        view: "every fifth fiber, seen along y",
        axes: [Vector3::x(), Vector3::z()],
        columns: 4,
        pictures: film.into(),
    };
    let agreement = correlation(&run.pairs, &run.tests);
    let timed = correlation(&run.pairs, &run.find);
    let steady = run.update.iter().fold(0.0_f64, |a, &b| a.max(b))
        / (run.update.iter().sum::<f64>() / run.update.len() as f64);
    let times = [("update".to_owned(), run.update), ("find all".to_owned(), run.find)];
    let counts = [("pairs".to_owned(), run.pairs), ("volume tests".to_owned(), run.tests)];
    Ok(Figure {
        scene: "scenes::looping(150, 100, 0..1, 0.05)",
        parameters: "arcs of constant curvature, where the thesis solves static rods under recorded \
                     loads; least of 3 runs",
        drawings: vec![
            Drawing::Pictures(pictures),
            chart("7.11 Time of AL", ["step", "time (ms)"], None, &steps(), times),
            chart("7.11 Pairs and tests", ["step", "count"], Some(1.0), &steps(), counts),
        ],
        checks: vec![
            check(
                "correlation of the volume tests with the number of pairs",
                agreement,
                "",
                Criterion::Told,
                "strong, of times and pairs; the search is output-sensitive",
            ),
            check(
                "correlation of the search's time with the number of pairs",
                timed,
                "",
                Criterion::Told,
                "strong",
            ),
            check(
                "largest update over the mean",
                steady,
                "",
                Criterion::AtMost(3.0),
                "updates are a constant base line",
            ),
        ],
    })
}

/// Figure 7.12: ways to keep a tree, for a bundle that stays one and for one that bursts.
pub(crate) fn updates(_: Size) -> Fallible<Figure> {
    let mut drawings = Vec::new();
    let mut checks = Vec::new();
    let scenes = [("together", 0.05), ("bursting", std::f64::consts::PI)];
    for (name, spread) in scenes {
        let names = strategies().map(|s| s.name.to_owned());
        let mut runs = Vec::new();
        for strategy in &strategies() {
            runs.push(run(strategy, spread, 2)?);
        }
        let sum = |series: &[f64]| series.iter().sum::<f64>();
        let total = |run: &Run| sum(&run.update) + sum(&run.find);
        let [refit, rebuilt, in_need, layered] = [0, 1, 2, 3].map(|i| &runs[i]);
        let worse = refit.tests.iter().zip(&rebuilt.tests).map(|(a, b)| a / b).fold(0.0, f64::max);
        let mut claim = |compared: &str, obtained, criterion, thesis| {
            checks.push(check(format!("{name}: {compared}"), obtained, "", criterion, thesis));
        };
        claim(
            "update, AS rebuilt over AS refit",
            sum(&rebuilt.update) / sum(&refit.update),
            Criterion::AtLeast(4.0),
            "12",
        );
        claim(
            "volume tests, AS refit over AS rebuilt, at worst",
            worse,
            Criterion::Told,
            "detection gets up to 4 times slower",
        );
        claim(
            "update and search, AS rebuilt over AL",
            total(rebuilt) / total(layered),
            Criterion::AtLeast(1.0),
            "2 to 2.5: topological trees win under motion",
        );
        claim(
            "update and search, AS refit over AL",
            total(refit) / total(layered),
            Criterion::Told,
            "AL wins by the end of the motion",
        );
        claim(
            "update and search, AS rebuilt in need over AS rebuilt",
            total(in_need) / total(rebuilt),
            Criterion::Told,
            "occasional rebuilds should help",
        );
        claim(
            "update and search, AS rebuilt in need over AL",
            total(in_need) / total(layered),
            Criterion::Told,
            "not measured; below 1 the spatial tree wins",
        );
        let series =
            |value: fn(&Run) -> Vec<f64>| names.iter().cloned().zip(runs.iter().map(value));
        let title = |what: &str| format!("7.12 {what}, {name}");
        let labels = ["step", "time (ms)"];
        let both = |r: &Run| r.update.iter().zip(&r.find).map(|(a, b)| a + b).collect();
        drawings.push(chart(
            &title("Find all"),
            labels,
            None,
            &steps(),
            series(|r| r.find.clone()),
        ));
        drawings.push(chart(&title("Update and find all"), labels, None, &steps(), series(both)));
        let tests = series(|r| r.tests.clone());
        drawings.push(chart(&title("Volume tests"), ["step", "count"], None, &steps(), tests));
    }
    Ok(Figure {
        scene: "scenes::looping(150, 100, 0..1, 0.05 and pi)",
        parameters: "the thesis's second experiment, an arrangement that falls, is not described \
                     well enough to be repeated; least of 2 runs",
        drawings,
        checks,
    })
}
