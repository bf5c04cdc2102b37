//! Figure 7.7: the models.

use crate::measure::chart;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::thesis::hierarchy::Variant;
use rapunzel_collision::thesis::scenes::{self, MovingFibers};
use rapunzel_repro::plot::{Drawing, Picture, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// How large models are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Size {
    Scaled,
    /// As in the thesis.
    Full,
}

pub(crate) struct Model {
    pub(crate) name: &'static str,
    pub(crate) scene: MovingFibers,
}

/// What a model is made by, its fibers and segments, scaled and full, and the pairs that the thesis
/// found in its own of this name.
struct Recipe {
    name: &'static str,
    make: fn(usize, usize) -> MovingFibers,
    scaled: [usize; 2],
    full: [usize; 2],
    thesis: f64,
}

const RECIPES: [Recipe; 6] = [
    Recipe {
        name: "cloth",
        make: scenes::cloth,
        scaled: [60, 150],
        full: [500, 2600],
        thesis: 17e6,
    },
    Recipe { name: "ball", make: scenes::ball, scaled: [200, 37], full: [700, 37], thesis: 1.5e6 },
    Recipe {
        name: "locke",
        make: scenes::lock,
        scaled: [300, 100],
        full: [2500, 100],
        thesis: 24e3,
    },
    Recipe {
        name: "tress I",
        make: scenes::bundle,
        scaled: [100, 200],
        full: [100, 2000],
        thesis: 1750.0,
    },
    Recipe {
        name: "tress II",
        make: scenes::bundle,
        scaled: [500, 80],
        full: [500, 2000],
        thesis: 23e3,
    },
    Recipe {
        name: "soup",
        make: scenes::soup,
        scaled: [800, 50],
        full: [10_000, 100],
        thesis: 70e3,
    },
];

pub(crate) fn models(size: Size) -> Vec<Model> {
    let model = |recipe: &Recipe| {
        let [fibers, segments] = if size == Size::Full { recipe.full } else { recipe.scaled };
        Model { name: recipe.name, scene: (recipe.make)(fibers, segments) }
    };
    RECIPES.iter().map(model).collect()
}

/// The model of that name.
pub(crate) fn model(name: &str, size: Size) -> Fallible<Model> {
    models(size).into_iter().find(|m| m.name == name).ok_or_else(|| format!("no {name}").into())
}

/// Moved to the origin and shrunk or grown to one size: the drawing has one scale for all.
fn centered(mut fibers: Vec<Vec<Point3<f64>>>) -> Vec<Vec<Point3<f64>>> {
    let points = || fibers.iter().flatten();
    let start = points().fold(Point3::from([f64::MAX; 3]), |a, p| a.inf(p));
    let end = points().fold(Point3::from([f64::MIN; 3]), |a, p| a.sup(p));
    let (middle, size) = (nalgebra::center(&start, &end), (end - start).amax());
    for p in fibers.iter_mut().flatten() {
        *p = Point3::from((*p - middle) / size);
    }
    fibers
}

pub(crate) fn all(size: Size) -> Fallible<Figure> {
    let mut pictures = Vec::new();
    let (mut pairs, mut differences) = (Vec::new(), 0.0);
    for Model { name, scene } in models(size) {
        let capsules = scene.capsules()?;
        let count = |variant: Variant| variant.build(&capsules).all(&capsules);
        let [spatial, layered] = [count(Variant::As)?, count(Variant::Al)?].map(|f| f.pairs.len());
        differences += spatial.abs_diff(layered) as f64;
        pairs.push(layered as f64 / capsules.len() as f64);
        let spread = (0..scene.layout.fibers()).step_by(scene.layout.fibers().div_ceil(40));
        let line = |fiber: usize| scene.positions[scene.layout.node_range(fiber)].to_vec();
        let fibers = centered(spread.map(line).collect());
        let caption = format!("{name}: {} fibers, {} pairs", scene.layout.fibers(), layered);
        pictures.push(Picture { caption, fibers });
    }
    let pictures = Pictures {
        title: "7.7 The models (40 fibers of each, each to its own scale)".into(),
        view: "seen along a diagonal; sizes are relative",
        axes: [Vector3::new(0.8, 0.6, 0.0), Vector3::new(-0.3, 0.4, 0.866)],
        columns: 3,
        pictures,
    };
    let numbers: Vec<f64> = (1..=RECIPES.len()).map(|i| i as f64).collect();
    let thesis = RECIPES.iter().map(|r| r.thesis / (r.full[0] * r.full[1]) as f64).collect();
    let series = [("ours".to_owned(), pairs), ("thesis".to_owned(), thesis)];
    let labels = ["1 cloth, 2 ball, 3 locke, 4 tress I, 5 tress II, 6 soup", "pairs per segment"];
    Ok(Figure {
        scene: "scenes::cloth, ball, lock, bundle, bundle, soup",
        parameters: "the thesis shows pictures and counts only; shapes and radii are ours",
        drawings: vec![
            Drawing::Pictures(pictures),
            chart("7.7 Touching pairs per segment", labels, Some(1e-4), &numbers, series),
        ],
        checks: vec![check(
            "pairs that only one of AS and AL finds, all models",
            differences,
            "",
            Criterion::AtMost(0.0),
            "all trees find the same",
        )],
    })
}
