use crate::longitudinal::Inclination;
use nalgebra::Vector3;

/// Cosine of the inclination; of a unit vector, whose squares neither overflow nor vanish.
fn width(w: &Vector3<f64>) -> f64 {
    (w.x * w.x + w.y * w.y).sqrt()
}

/// Inclination of a direction of unit length.
pub(crate) fn inclination(w: &Vector3<f64>) -> Inclination {
    Inclination { sin: w.z.clamp(-1.0, 1.0), cos: width(w).min(1.0) }
}

/// Azimuth of a direction, rad, from d1 towards d2.
pub(crate) fn azimuth(w: &Vector3<f64>) -> f64 {
    w.y.atan2(w.x)
}

/// Change of azimuth from one direction to another, rad, in `[-pi, pi]`.
pub(crate) fn azimuth_change(from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    (from.x * to.y - from.y * to.x).atan2(from.x * to.x + from.y * to.y)
}

/// The direction of an inclination whose azimuth is `change`, rad, from that of another.
pub(crate) fn turned(from: &Vector3<f64>, change: f64, inclination: &Inclination) -> Vector3<f64> {
    let (sin, cos) = change.sin_cos();
    let flat = width(from);
    // A direction along the axis has no azimuth: any will do.
    let (x, y) = if flat > 0.0 { (from.x / flat, from.y / flat) } else { (1.0, 0.0) };
    let Inclination { sin: z, cos: width } = *inclination;
    Vector3::new(width * (x * cos - y * sin), width * (x * sin + y * cos), z)
}
