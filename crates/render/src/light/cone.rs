use nalgebra::Vector3;
use std::f64::consts::TAU;

/// A direction drawn evenly from a cone around `axis`, of unit length, whose half angle has a
/// cosine that falls short of 1 by `gap`; 2 is the whole sphere.
pub(super) fn in_cone(axis: &Vector3<f64>, gap: f64, numbers: [f64; 2]) -> Vector3<f64> {
    let short = numbers[0] * gap;
    let sine = (short * (2.0 - short)).max(0.0).sqrt();
    let (sin, cos) = (TAU * numbers[1]).sin_cos();
    let [a, b] = across(axis);
    (a * (sine * cos) + b * (sine * sin) + axis * (1.0 - short)).normalize()
}

/// Two unit vectors that make a right-handed frame with `axis`, of unit length (Duff et al. 2017,
/// "Building an orthonormal basis, revisited").
fn across(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let sign = 1.0_f64.copysign(axis.z);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    [
        Vector3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        Vector3::new(b, sign + axis.y * axis.y * a, -axis.y),
    ]
}
