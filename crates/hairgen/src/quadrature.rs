/// Weight of the trapezoidal rule on [0, 1] at a node of `segments` equal segments.
pub(crate) fn trapezoid(node: usize, segments: usize) -> f64 {
    let whole = (segments as f64).recip();
    if node == 0 || node == segments { 0.5 * whole } else { whole }
}
