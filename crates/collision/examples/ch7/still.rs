//! Figures 7.9, 7.13 and 7.14: models at rest.

use crate::measure::{chart, least};
use crate::models::{Size, model, models};
use rapunzel_collision::thesis::hierarchy::{Counts, Variant};
use rapunzel_collision::thesis::scenes::{self, MovingFibers};
use rapunzel_collision::thesis::volume::Directions;
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// What the tests of section 7.4 measure, ms and counts.
struct Cost {
    build: f64,
    update: f64,
    all: f64,
    first: f64,
    counts: Counts,
    pairs: usize,
}

fn cost(variant: &Variant, scene: &MovingFibers, runs: usize) -> Fallible<Cost> {
    let capsules = scene.capsules()?;
    let (build, mut tree) = least(runs, || variant.build(&capsules));
    let (update, updated) = least(runs, || tree.update(&capsules));
    updated?;
    let (all, found) = least(runs, || tree.all(&capsules));
    let found = found?;
    let (first, one) = least(runs, || tree.first(&capsules));
    one?;
    Ok(Cost { build, update, all, first, counts: found.counts, pairs: found.pairs.len() })
}

/// Figure 7.9: AL and SW on bundles of more and more fibers.
pub(crate) fn bundle(_: Size) -> Fallible<Figure> {
    let fibers = [50, 100, 200, 400, 600, 800, 1000];
    let mut costs = [Vec::new(), Vec::new()];
    for count in fibers {
        let scene = scenes::bundle(count, 100);
        for (variant, costs) in [Variant::Al, Variant::Sw].iter().zip(&mut costs) {
            costs.push(cost(variant, &scene, 2)?);
        }
    }
    let segments = fibers.map(|f| 100.0 * f as f64);
    let [al, sw] = &costs;
    let ratio = |a: f64, b: f64| a / b;
    // Time per segment where there are the most and the fewest, the latter large enough to time.
    let linear =
        |value: fn(&Cost) -> f64| ratio(value(&al[6]) / segments[6], value(&al[2]) / segments[2]);
    let per_segment: Vec<f64> = sw.iter().zip(&segments).map(|(c, s)| c.update / s).collect();
    let mut ordered = per_segment.clone();
    ordered.sort_by(f64::total_cmp);
    let peak = ratio(ordered[6], ordered[3]);
    let faster = ratio(sw.iter().map(|c| c.all).sum(), al.iter().map(|c| c.all).sum());
    let series = |value: fn(&Cost) -> f64| {
        ["AL", "SW"].into_iter().zip(&costs).map(move |(name, costs)| {
            (name.to_owned(), costs.iter().map(value).collect::<Vec<_>>())
        })
    };
    let drawing = |title: &str, value: fn(&Cost) -> f64| {
        chart(title, ["segments", "time (ms)"], Some(1e-3), &segments, series(value))
    };
    Ok(Figure {
        scene: "scenes::bundle(50..1000, 100)",
        parameters: "least of 2 runs",
        drawings: vec![
            drawing("7.9 Build", |c| c.build),
            drawing("7.9 Update", |c| c.update),
            drawing("7.9 Find all pairs", |c| c.all),
        ],
        checks: vec![
            check(
                "AL: update of a segment, 100 000 segments over 20 000",
                linear(|c| c.update),
                "",
                Criterion::Within(0.25, 4.0),
                "update is linear in the number of segments",
            ),
            check(
                "AL: build of a segment, 100 000 segments over 20 000",
                linear(|c| c.build),
                "",
                Criterion::Within(0.25, 4.0),
                "build is linear in the number of segments",
            ),
            check(
                "AL: update of a segment",
                1e6 * al[6].update / segments[6],
                "ns",
                Criterion::AtMost(150.0),
                "150 ns (2 M segments in 300 ms, Pentium IV)",
            ),
            check(
                "find all: time of SW over AL, all bundles",
                faster,
                "",
                Criterion::AtLeast(1.0),
                "AL is clearly faster",
            ),
            check(
                "SW: slowest update of a segment over the median",
                peak,
                "",
                Criterion::AtMost(3.0),
                "extreme peaks, from Welzl's algorithm; ours pivots and has none",
            ),
        ],
    })
}

/// Figure 7.13: update, search for all, and search for the first.
pub(crate) fn table(size: Size) -> Fallible<Figure> {
    let variants = Variant::all(&Directions::new(18)?);
    let models = models(size);
    let of_all = |variant: &Variant| models.iter().map(|m| cost(variant, &m.scene, 2)).collect();
    let costs: Vec<Vec<Cost>> = variants.iter().map(of_all).collect::<Fallible<_>>()?;
    let numbers: Vec<f64> = (1..=models.len()).map(|i| i as f64).collect();
    let drawing = |title: &str, y, value: fn(&Cost) -> f64| {
        let rows = variants.iter().zip(&costs);
        let series = rows.map(|(v, row)| (v.name().to_owned(), row.iter().map(value).collect()));
        let x = "1 cloth, 2 ball, 3 locke, 4 tress I, 5 tress II, 6 soup";
        chart(title, [x, y], Some(1e-3), &numbers, series)
    };
    let row = |name: &str| variants.iter().position(|v| v.name() == name).unwrap_or_default();
    let column = |name: &str| models.iter().position(|m| m.name == name).unwrap_or_default();
    let [al, ass, ol, os, dl, ds, sl, ss] =
        ["AL", "AS", "OL", "OS", "DL", "DS", "SL", "SS"].map(|name| &costs[row(name)]);
    let sum = |row: &[Cost], value: fn(&Cost) -> f64| row.iter().map(value).sum::<f64>();
    let over = |a: &[Cost], b: &[Cost], value: fn(&Cost) -> f64| sum(a, value) / sum(b, value);
    let tests = |c: &Cost| c.counts.volume_tests as f64;
    let at = |row: &[Cost], name: &str| tests(&row[column(name)]);
    let disagree = costs.iter().flat_map(|row| row.iter().zip(&costs[0]));
    let differences: usize = disagree.map(|(a, b)| a.pairs.abs_diff(b.pairs)).sum();
    let slower = [(al, ass), (dl, ds), (ol, os), (sl, ss)]
        .map(|(l, s)| over(s, l, |c| c.build) / over(l, l, |c| c.update))
        .into_iter()
        .fold(f64::MAX, f64::min);
    Ok(Figure {
        scene: "all of figure 7.7",
        parameters: "k-DOPs with 18 faces; build is shown for all, because that is the update of a \
                     spatial tree; least of 2 runs",
        drawings: vec![
            drawing("7.13 Build", "time (ms)", |c| c.build),
            drawing("7.13 Update (refit; cascade for OW, SW)", "time (ms)", |c| c.update),
            drawing("7.13 Find all pairs", "time (ms)", |c| c.all),
            drawing("7.13 Find the first pair", "time (ms)", |c| c.first),
            drawing("7.14 Tests of volumes", "tests", |c| c.counts.volume_tests as f64),
        ],
        checks: vec![
            check(
                "pairs in which any of the 10 trees differs from AS, all models",
                differences as f64,
                "",
                Criterion::AtMost(0.0),
                "all find the same",
            ),
            check(
                "build of the spatial over build of the layered, least of A, D, O, S",
                slower,
                "",
                Criterion::AtLeast(1.0),
                "larger throughout",
            ),
            check(
                "soup: volume tests of AL over AS",
                at(al, "soup") / at(ass, "soup"),
                "",
                Criterion::AtLeast(5.0),
                "time AS:AL = 1:43",
            ),
            check(
                "tress I: volume tests of AL over AS",
                at(al, "tress I") / at(ass, "tress I"),
                "",
                Criterion::AtMost(5.0),
                "time AS:AL = 1:1.7",
            ),
            check(
                "tress I: volume tests of DL over DS",
                at(dl, "tress I") / at(ds, "tress I"),
                "",
                Criterion::AtMost(5.0),
                "time DS:DL = 1:1",
            ),
            check(
                "find all: time of OS over AS, largest of all models",
                os.iter().zip(ass).map(|(o, a)| o.all / a.all).fold(0.0, f64::max),
                "",
                Criterion::Told,
                "up to 10",
            ),
            check(
                "find all: tests of segments, AL over AS, all models",
                over(al, ass, |c| c.counts.segment_tests as f64),
                "",
                Criterion::Within(0.999, 1.001),
                "almost the same for both",
            ),
        ],
    })
}

/// Figure 7.14: tests on Tress I, and volumes by level on Locke.
pub(crate) fn counts(size: Size) -> Fallible<Figure> {
    let variants = Variant::all(&Directions::new(18)?);
    let tress = model("tress I", size)?.scene;
    let lock = model("locke", size)?.scene;
    let capsules = lock.capsules()?;
    let mut counts = [Vec::new(), Vec::new(), Vec::new()];
    let mut levels = Vec::new();
    for variant in &variants {
        let Counts { volume_tests, overlaps, segment_tests } = cost(variant, &tress, 1)?.counts;
        for (list, count) in counts.iter_mut().zip([volume_tests, overlaps, segment_tests]) {
            list.push(count as f64);
        }
        levels.push((variant.name().to_owned(), variant.build(&capsules).mean_volumes()));
    }
    let root = |name: &str| levels.iter().find(|l| l.0 == name).map_or(f64::NAN, |l| l.1[0]);
    let growth = root("OL") / root("SL");
    let layered = root("SL") / root("SW");
    // The same levels for all: the spatial trees are deeper.
    let shown = levels.iter().map(|l| l.1.len()).min().unwrap_or_default();
    let depth: Vec<f64> = (0..shown).map(|i| i as f64).collect();
    let numbers: Vec<f64> = (1..=variants.len()).map(|i| i as f64).collect();
    let names = ["volume tests", "overlaps", "segment tests"].map(str::to_owned);
    let labels = ["1 AS, 2 DS, 3 OS, 4 SS, 5 OW, 6 SW, 7 AL, 8 DL, 9 OL, 10 SL", "count"];
    let volumes = ["level from the root", "mean volume (m^3)"];
    Ok(Figure {
        scene: "tress I and locke of figure 7.7",
        parameters: "k-DOPs with 18 faces; their volume is that of a ball of the same mean width",
        drawings: vec![
            chart(
                "7.14 Tests, tress I",
                labels,
                Some(1.0),
                &numbers,
                names.into_iter().zip(counts),
            ),
            chart(
                "7.14 Volume by level, locke",
                volumes,
                Some(1e-14),
                &depth,
                levels.iter().cloned(),
            ),
        ],
        checks: vec![
            check(
                "locke, root: volume of OL over SL",
                growth,
                "",
                Criterion::Told,
                "five orders of magnitude; boxes from corners grow exponentially with the level",
            ),
            check(
                "locke, root: volume of SL over SW",
                layered,
                "",
                Criterion::Within(1.0, 8.0),
                "layered ones are slightly larger",
            ),
        ],
    })
}
