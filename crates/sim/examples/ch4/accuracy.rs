//! Figure 4.10: time and error of the multipole method over the number of terms; and time over the
//! number of points.

use crate::Size;
use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::{Accuracy, Direct, Method, Multipole, units};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::World;
use std::time::Instant;

/// Numbers of terms.
const TERMS: [usize; 7] = [2, 4, 8, 12, 16, 20, 30];
/// Particles whose forces are compared with the direct sum.
const SAMPLES: usize = 500;

/// Time and angle between the force and that of the direct sum, over the degree of expansions.
pub(crate) fn terms(size: Size) -> Fallible<Figure> {
    let scene = size.scene("tress")?;
    let world = World::build(&scene)?;
    // The thesis has 330 a centimeter: 99 on each segment.
    let each = if size == Size::Full { 99 } else { 10 };
    let mut points: Vec<Point3<f64>> = Vec::new();
    for fiber in 0..world.assembly().fibers().len() {
        for ends in world.state(fiber).positions.windows(2) {
            let place =
                |k: i32| ends[0] + (f64::from(k) + 0.5) / f64::from(each) * (ends[1] - ends[0]);
            points.extend((0..each).map(place));
        }
    }
    let count = world.assembly().fibers().len() as f64;
    let charge = units::THESIS_LINE_DENSITY * 0.3 * count / points.len() as f64;
    let charges = vec![charge; points.len()];
    let every = points.len() / SAMPLES;
    let samples: Vec<_> = points.iter().copied().step_by(every).collect();
    let exact = Direct.fields(&points, &charges, &samples)?.fields;
    let (mut times, mut angles) = (Vec::new(), Vec::new());
    for terms in TERMS {
        let start = Instant::now();
        let method = Multipole { accuracy: Accuracy::Order(terms) };
        let fields = method.fields(&points, &charges, &points)?.fields;
        times.push([terms as f64, start.elapsed().as_secs_f64()]);
        let angle = |(a, b): (&Vector3<f64>, &Vector3<f64>)| a.cross(b).norm().atan2(a.dot(b));
        let found = fields.iter().step_by(every).zip(&exact).map(angle);
        angles.push([terms as f64, found.sum::<f64>() / exact.len() as f64]);
    }
    let last = TERMS.len() - 1;
    let checks = vec![
        check(
            "mean angle with 2 terms",
            angles[0][1],
            "rad",
            Criterion::AtMost(0.1),
            "1e-2 rad, with cells that are farther apart",
        ),
        check(
            "mean angle with 30 terms",
            angles[last][1],
            "rad",
            Criterion::AtMost(1e-7),
            "1e-9 rad",
        ),
        check(
            "time with 30 terms over that with 2",
            times[last][1] / times[0][1],
            "",
            Criterion::Told,
            "it grows about as the square",
        ),
    ];
    let chart = |title: &str, y, log_from, curves| {
        Drawing::Chart(Chart { title: title.into(), x: "terms", y, log_from, curves })
    };
    let curve = |name: &str, points| Curve { name: name.into(), points };
    // In words; of the times it says none.
    let thesis = curve("the thesis", vec![[2.0, 1e-2], [30.0, 1e-9]]);
    let ours = curve("mean angle to direct sum", angles);
    Ok(Figure {
        scene: "scenes/charge/tress.ron, at rest without charge",
        parameters: "10 points on each segment of 60 fibers; --full takes 99 on each of 300, the thesis's",
        drawings: vec![
            chart("4.10 Time", "time (s)", None, vec![curve("all fields", times)]),
            chart("4.10 Error", "angle (rad)", Some(1e-12), vec![ours, thesis]),
        ],
        checks,
    })
}

/// The error that is asked for where times are compared.
const ASKED: f64 = 1e-4;

/// Time of all fields of uniform points over their number, which the method says is linear.
pub(crate) fn growth(size: Size) -> Fallible<Figure> {
    let most = if size == Size::Full { 7 } else { 6 };
    let mut times = Vec::new();
    for half_decade in 8..=2 * most {
        let count = 10_f64.powf(0.5 * f64::from(half_decade)).round();
        let points = uniform(count);
        let charges = vec![1e-12; points.len()];
        let start = Instant::now();
        let method = Multipole { accuracy: Accuracy::Tolerance(ASKED) };
        method.fields(&points, &charges, &points)?;
        times.push([0.5 * f64::from(half_decade), 1e6 * start.elapsed().as_secs_f64() / count]);
    }
    let of_last = times[times.len() - 1][1];
    Ok(Figure {
        scene: "points in a cube",
        parameters: "tolerance 1e-4; a million points at most, --full ten million",
        drawings: vec![Drawing::Chart(Chart {
            title: "Time of a point".into(),
            x: "log10 of the number of points",
            y: "time of a point (us)",
            log_from: None,
            curves: vec![Curve { name: "all fields".into(), points: times.clone() }],
        })],
        checks: vec![check(
            "time of a point with the most points over that with 10,000",
            of_last / times[0][1],
            "",
            Criterion::Told,
            "one, for the method is linear",
        )],
    })
}

/// Points that fill a cube evenly: multiples of the inverse powers of the root of `x^4 = x + 1`.
fn uniform(count: f64) -> Vec<Point3<f64>> {
    let root: f64 = 1.220_744_084_605_759_6;
    let place = |i: u32| [1, 2, 3].map(|k| (f64::from(i) * root.powi(-k)).fract());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    (0..count as u32).map(|i| Point3::from(place(i))).collect()
}
