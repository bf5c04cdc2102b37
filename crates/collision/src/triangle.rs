//! The nearest point of a triangle.

use nalgebra::Vector3;

/// Weights of the corners at the point of a triangle that is nearest to the origin; a weight is
/// exactly zero where that point lies on the opposite side.
///
/// The squared distance is convex, so that its least value lies inside, at the foot of the
/// perpendicular, or on one of the sides; all four are tried. Corners may coincide.
#[must_use]
pub(crate) fn nearest_weights(corners: &[Vector3<f64>; 3]) -> [f64; 3] {
    let mut best = [1.0, 0.0, 0.0];
    let mut least = f64::INFINITY;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let side = corners[j] - corners[i];
        let length = side.norm_squared();
        let t = if length > 0.0 { (-side.dot(&corners[i]) / length).clamp(0.0, 1.0) } else { 0.0 };
        let squared = (corners[i] + t * side).norm_squared();
        if squared < least {
            least = squared;
            (best[i], best[j], best[k]) = (1.0 - t, t, 0.0);
        }
    }
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let area = normal.norm_squared();
    let inside = [b.cross(c), c.cross(a), a.cross(b)].map(|part| part.dot(&normal) / area);
    if area > 0.0 && inside.iter().all(|&weight| weight > 0.0) {
        let foot = inside[0] * a + inside[1] * b + inside[2] * c;
        if foot.norm_squared() < least {
            return inside;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = Vector3<f64>> {
        let x = prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64];
        prop::array::uniform3(x).prop_map(Vector3::from)
    }

    proptest! {
        /// A point of a convex body is the nearest if no corner lies before its plane.
        #[test]
        fn nothing_is_nearer(corners in prop::array::uniform3(corner())) {
            let weights = nearest_weights(&corners);
            prop_assert!(weights.iter().all(|&w| (0.0..=1.0 + 1e-12).contains(&w)));
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() <= 1e-9);
            let nearest: Vector3<f64> = (0..3).map(|k| weights[k] * corners[k]).sum();
            for corner in &corners {
                prop_assert!(nearest.dot(&(corner - nearest)) >= -1e-9);
            }
        }
    }
}
