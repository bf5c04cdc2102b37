//! Figure 7.15: k-DOPs of 6 to 200 faces.

use crate::measure::{chart, least};
use crate::models::{Size, model, models};
use rapunzel_collision::thesis::hierarchy::{Counts, Variant};
use rapunzel_collision::thesis::scenes::MovingFibers;
use rapunzel_collision::thesis::volume::Directions;
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// Times in ms, and counts.
struct Cost {
    update: f64,
    find: f64,
    counts: Counts,
}

fn cost(directions: &Directions, scene: &MovingFibers, runs: usize) -> Fallible<Cost> {
    let capsules = scene.capsules()?;
    let mut tree = Variant::Dl(directions.clone()).build(&capsules);
    let (update, updated) = least(runs, || tree.update(&capsules));
    updated?;
    let (find, found) = least(runs, || tree.all(&capsules));
    Ok(Cost { update, find, counts: found?.counts })
}

/// Where the least of `values` is.
fn best(values: &[f64]) -> usize {
    (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or_default()
}

pub(crate) fn faces(size: Size) -> Fallible<Figure> {
    let few = [6, 8, 10, 12, 14, 16, 18, 20, 24, 30, 40, 50, 60];
    let many = [80, 100, 130, 160, 200];
    let all: Vec<Directions> =
        few.into_iter().chain(many).map(Directions::new).collect::<Result<_, _>>()?;
    let k: Vec<f64> = all.iter().map(|d| d.k() as f64).collect();
    let lock = model("locke", size)?.scene;
    let costs: Vec<Cost> = all.iter().map(|d| cost(d, &lock, 2)).collect::<Fallible<_>>()?;
    let list = |value: fn(&Cost) -> f64| costs.iter().map(value).collect::<Vec<_>>();
    let (find, update) = (list(|c| c.find), list(|c| c.update));
    let tests = list(|c| c.counts.volume_tests as f64);
    let optimum = k[best(&find)];
    let fewer = tests[0] / tests[tests.len() - 1];
    let slower = update[update.len() - 1] / update[0];
    let mut others = Vec::new();
    for model in models(size) {
        let costs: Vec<Cost> =
            all[..few.len()].iter().map(|d| cost(d, &model.scene, 1)).collect::<Fallible<_>>()?;
        let find: Vec<f64> = costs.iter().map(|c| c.find).collect();
        // Relative to 6 faces, so that models of all sizes fit.
        others.push((model.name.to_owned(), find.iter().map(|f| f / find[0]).collect::<Vec<_>>()));
    }
    let soup = others.iter().find(|o| o.0 == "soup").map_or(0, |o| best(&o.1));
    let named = |pairs: [(&str, Vec<f64>); 3]| pairs.map(|(name, list)| (name.to_owned(), list));
    let times = [("find all".to_owned(), find), ("update".to_owned(), update)];
    let counts = named([
        ("volume tests", tests),
        ("overlaps", list(|c| c.counts.overlaps as f64)),
        ("segment tests", list(|c| c.counts.segment_tests as f64)),
    ]);
    Ok(Figure {
        scene: "locke, then all of figure 7.7",
        parameters: "DL; directions by packing::lines; least of 2 runs for locke, 1 for all",
        drawings: vec![
            chart("7.15 Times, locke", ["k", "time (ms)"], None, &k, times),
            chart("7.15 Tests, locke", ["k", "count"], Some(1.0), &k, counts),
            chart(
                "7.15 Find all, all models",
                ["k", "time relative to k = 6"],
                None,
                &k[..few.len()],
                others,
            ),
        ],
        checks: vec![
            check("locke: fastest k", optimum, "", Criterion::Within(8.0, 60.0), "20"),
            check(
                "locke: volume tests with 6 faces over 200",
                fewer,
                "",
                Criterion::AtLeast(1.0),
                "fewer with each k",
            ),
            check(
                "locke: update with 200 faces over 6",
                slower,
                "",
                Criterion::AtLeast(4.0),
                "grows with k",
            ),
            check(
                "soup: fastest k up to 60",
                k[soup],
                "",
                Criterion::AtLeast(10.0),
                "times still fall at 60",
            ),
        ],
    })
}
