//! Distances written apart from the library.

use nalgebra::Point3;

/// Distance of a point to a triangle, by clamping to its sides; it may have no area.
pub(crate) fn to_triangle(p: &Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> f64 {
    let n = (b - a).cross(&(c - a));
    let flat = n.norm() <= 1e-9 * (b - a).norm() * (c - a).norm();
    let within = |(u, v): (Point3<f64>, Point3<f64>)| n.cross(&(v - u)).dot(&(p - u)) >= 0.0;
    if !flat && [(a, b), (b, c), (c, a)].into_iter().all(within) {
        return n.dot(&(p - a)).abs() / n.norm();
    }
    let to_side = |u: Point3<f64>, v: Point3<f64>| {
        let length = (v - u).norm_squared();
        let t = if length > 0.0 { (v - u).dot(&(p - u)) / length } else { 0.0 };
        (p - (u + t.clamp(0.0, 1.0) * (v - u))).norm()
    };
    to_side(a, b).min(to_side(b, c)).min(to_side(c, a))
}
