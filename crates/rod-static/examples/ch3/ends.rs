//! Boundary values by the thesis's annealing and by multiple shooting.

use crate::annealing::{CYCLES, Found, LENGTH, TARGET, TORSION, clamp, end, search};
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rapunzel_repro::Criterion::{AtMost, Told};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Picture, Pictures};
use rapunzel_repro::{ClaimCheck, Fallible, Figure, check};
use rapunzel_rod_static::{EndCondition, Equilibrium, Lagrange, Piece, Problem, Properties, State};
use std::time::Instant;

const SCENE: &str = "n = 1, m3 = 2, mz = 1.1, theta' = 1";
const PARAMETERS: &str = "length 2.5, clamp at 1 rad to the force, GJ/EI = 0.75; annealing from \
                          perturbations up to 1, temperatures 1 to 1e-8";
/// Starts of the annealing.
const SEEDS: u64 = 5;

pub(crate) fn position() -> Fallible<Figure> {
    let target = end(TARGET)?;
    let cost = |x| Ok((end(x)?.position - target.position).norm_squared());
    let ours = solve(EndCondition::Position(target.position))?;
    let thesis = "0.03 cm of 25 cm after about 1,300 cycles";
    figure(&target, cost, ours, "for the position", thesis)
}

pub(crate) fn tangent() -> Fallible<Figure> {
    let target = end(TARGET)?;
    let along = target.frame * Vector3::z();
    let cost = |x| {
        let found = end(x)?;
        let turned = found.frame * Vector3::z() - along;
        Ok((found.position - target.position).norm_squared() + turned.norm_squared())
    };
    let ours = solve(EndCondition::Tangent(target.position, Unit::new_normalize(along)))?;
    figure(&target, cost, ours, "for position and tangent", "0.3 cm of 25 cm and 0.3 rad")
}

fn solve(to: EndCondition) -> Fallible<(Equilibrium, f64)> {
    let properties = Properties {
        stiffness: Vector3::new(1.0, 1.0, TORSION),
        natural_curvature: Vector3::zeros(),
        load: Vector3::zeros(),
    };
    let from = Isometry3::from_parts(
        Translation3::identity(),
        UnitQuaternion::from_rotation_matrix(&clamp()),
    );
    let problem = Problem::new(&from, vec![Piece::uniform(LENGTH, properties)], to)?;
    let start = Instant::now();
    let found = problem.solve()?;
    Ok((found, start.elapsed().as_secs_f64()))
}

/// Distance in parts of the length, and angle of the tangents.
fn missed(found: &State, target: &State) -> [f64; 2] {
    let [a, b] = [found, target].map(|state| state.frame * Vector3::z());
    [(found.position - target.position).norm() / LENGTH, a.cross(&b).norm().atan2(a.dot(&b))]
}

fn figure(
    target: &State,
    cost: impl Fn([f64; 4]) -> Result<f64, rapunzel_rod_static::StaticError>,
    (ours, took): (Equilibrium, f64),
    what: &str,
    thesis: &'static str,
) -> Fallible<Figure> {
    let start = Instant::now();
    let found: Vec<Found> = (0..SEEDS).map(|seed| search(seed, &cost)).collect::<Result<_, _>>()?;
    let annealed = start.elapsed().as_secs_f64() / SEEDS as f64;
    let mut checks = Vec::new();
    let (mut worst, mut best) = ([0.0_f64; 2], [f64::MAX; 2]);
    for one in &found {
        let missed = missed(&end(one.parameters)?, target);
        for i in 0..2 {
            worst[i] = worst[i].max(missed[i]);
            best[i] = best[i].min(missed[i]);
        }
    }
    // The closed form from what is found for the clamp judges it, not its own end.
    let own = missed(&Lagrange::new(1.0, TORSION, 0.0, &ours.root())?.at(LENGTH), target);
    let mut line = |text: &str, x, unit, criterion| -> () {
        checks.push(check(format!("{text}, {what}"), x, unit, criterion, thesis));
    };
    line("best distance by annealing", best[0], "L", Told);
    line("worst distance by annealing", worst[0], "L", Told);
    line("distance by shooting", own[0], "L", AtMost(1e-9));
    if what.contains("tangent") {
        line("best angle by annealing", best[1], "rad", Told);
        line("worst angle by annealing", worst[1], "rad", Told);
        line("angle by shooting", own[1], "rad", AtMost(1e-8));
    }
    line("time of annealing", annealed, "s", Told);
    line("time of shooting", took, "s", Told);
    let checks: Vec<ClaimCheck> = checks;
    let curve = |(seed, one): (usize, &Found)| Curve {
        name: format!("start {seed}"),
        points: (0..CYCLES).map(f64::from).zip(&one.history).map(|(x, y)| [x, y.sqrt()]).collect(),
    };
    let chart = Chart {
        title: format!("Annealing {what}"),
        x: "cycle",
        y: "root of the cost",
        log_from: Some(1e-8),
        curves: found.iter().enumerate().map(curve).collect(),
    };
    let line = |at: &dyn Fn(f64) -> Point3<f64>| -> Vec<Point3<f64>> {
        (0..=100).map(|i| at(LENGTH * f64::from(i) / 100.0)).collect()
    };
    let picture = Picture {
        caption: format!("shooting, {} conjugate points", ours.conjugate_points()),
        fibers: vec![line(&|s| ours.at(s).position)],
    };
    let pictures = Pictures {
        title: "The equilibrium that is found without a random start".into(),
        view: "from the side",
        axes: [Vector3::x(), Vector3::z()],
        columns: 1,
        pictures: vec![picture],
    };
    let drawings = vec![Drawing::Chart(chart), Drawing::Pictures(pictures)];
    Ok(Figure { scene: SCENE, parameters: PARAMETERS, drawings, checks })
}
