use crate::longitudinal::Inclination;
use nalgebra::{Vector2, Vector3};

/// Cosine of the inclination; of a unit vector, whose squares neither overflow nor vanish.
fn width(w: &Vector3<f64>) -> f64 {
    (w.x * w.x + w.y * w.y).sqrt()
}

/// Inclination of a direction of unit length.
pub(crate) fn inclination(w: &Vector3<f64>) -> Inclination {
    Inclination { sin: w.z.clamp(-1.0, 1.0), cos: width(w).min(1.0) }
}

/// The direction of the azimuth; one along the axis has none: any will do.
pub(crate) fn flat(w: &Vector3<f64>) -> Vector2<f64> {
    let length = width(w);
    if length == 0.0 { Vector2::x() } else { w.xy() / length }
}

/// Change of azimuth from one direction to another, rad, in `[-pi, pi]`.
pub(crate) fn azimuth_change(from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    (from.x * to.y - from.y * to.x).atan2(from.x * to.x + from.y * to.y)
}

/// The direction of an inclination whose azimuth is `change`, rad, from that of another.
pub(crate) fn turned(from: &Vector3<f64>, change: f64, inclination: &Inclination) -> Vector3<f64> {
    let (sin, cos) = change.sin_cos();
    let flat = flat(from);
    let (x, y) = (flat.x, flat.y);
    let Inclination { sin: z, cos: width } = *inclination;
    Vector3::new(width * (x * cos - y * sin), width * (x * sin + y * cos), z)
}
