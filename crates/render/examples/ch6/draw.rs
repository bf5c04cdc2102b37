//! Curves, charts and numbers in a row.

use rapunzel_repro::plot::{Chart, Curve, Drawing};

/// The ends of `count` even parts of an interval.
pub(crate) fn samples(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> + Clone {
    (0..=count).map(move |k| low + f64::from(k) / f64::from(count) * (high - low))
}

/// The middles of `count` even parts of an interval.
pub(crate) fn midpoints(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> + Clone {
    (0..count).map(move |k| low + (f64::from(k) + 0.5) / f64::from(count) * (high - low))
}

pub(crate) fn curve(name: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Curve {
    Curve { name: name.into(), points: points.into_iter().collect() }
}

/// Curves with the labels of the abscissa and the ordinate.
pub(crate) fn chart(title: &str, [x, y]: [&'static str; 2], curves: Vec<Curve>) -> Drawing {
    Drawing::Chart(Chart { title: title.into(), x, y, log_from: None, curves })
}

/// Where a curve has its local maxima, highest first.
pub(crate) fn peaks(curve: &Curve) -> Vec<[f64; 2]> {
    let all = curve.points.windows(3);
    let mut found: Vec<[f64; 2]> =
        all.filter(|p| p[1][1] > p[0][1] && p[1][1] >= p[2][1]).map(|p| p[1]).collect();
    found.sort_by(|a, b| b[1].total_cmp(&a[1]));
    found
}
