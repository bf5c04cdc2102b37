use nalgebra::Point3;

/// Weight of the trapezoidal rule on [0, 1] at a node of `segments` equal segments.
pub(crate) fn trapezoid(node: usize, segments: usize) -> f64 {
    let whole = (segments as f64).recip();
    if node == 0 || node == segments { 0.5 * whole } else { whole }
}

/// Length of the straight ways between points, m.
pub(crate) fn length(points: &[Point3<f64>]) -> f64 {
    points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
}
