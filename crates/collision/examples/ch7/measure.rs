//! Times and statistics.

use rapunzel_repro::plot::{Chart, Curve, Drawing};
use std::time::Instant;

/// The least time of some runs, ms, and what the last gave.
pub(crate) fn least<T>(runs: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let start = Instant::now();
        let result = run();
        (1e3 * start.elapsed().as_secs_f64(), result)
    };
    let mut best = timed();
    for _ in 1..runs {
        let (time, result) = timed();
        best = (best.0.min(time), result);
    }
    best
}

/// The correlation of two series, in -1..=1.
pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let product = |x: &[f64], mx: f64, y: &[f64], my: f64| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum()
    };
    product(a, ma, b, mb) / (product(a, ma, a, ma) * product(b, mb, b, mb)).sqrt()
}

/// A chart of named series over common abscissas.
pub(crate) fn chart(
    title: &str,
    [x, y]: [&'static str; 2],
    log_from: Option<f64>,
    abscissas: &[f64],
    series: impl IntoIterator<Item = (String, Vec<f64>)>,
) -> Drawing {
    let curves = series.into_iter().map(|(name, values)| {
        let points = abscissas.iter().zip(values).map(|(&x, y)| [x, y]).collect();
        Curve { name, points }
    });
    Drawing::Chart(Chart { title: title.into(), x, y, log_from, curves: curves.collect() })
}
