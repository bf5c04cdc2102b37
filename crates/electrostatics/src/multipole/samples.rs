//! Bodies at which expansions are compared with the direct sum.

/// Usual number of samples.
pub(crate) const SAMPLES: usize = 48;

/// Indices of at most `wanted` samples, evenly spread over `count` bodies.
pub(crate) fn samples(count: usize, wanted: usize) -> Vec<usize> {
    let samples = count.min(wanted);
    (0..samples).map(|k| (2 * k + 1) * count / (2 * samples)).collect()
}

/// Relative error at `samples`, by root sums of squares, of all numbers but the first, which is an
/// energy or a potential.
pub(crate) fn error<const N: usize>(
    samples: &[usize],
    found: &[[f64; N]],
    exact: &[[f64; N]],
) -> f64 {
    let [mut errors, mut squares] = [0.0; 2];
    for (&sample, exact) in samples.iter().zip(exact) {
        for c in 1..N {
            errors += (found[sample][c] - exact[c]).powi(2);
            squares += exact[c].powi(2);
        }
    }
    if errors > 0.0 { (errors / squares).sqrt() } else { 0.0 }
}
