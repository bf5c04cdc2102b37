//! Sliding on a polygon: friction is at a vertex, or slides along an edge while the slip is at a
//! right angle to it. All are tried; one of them obeys the law.
use crate::limit_curve::Polygon;
use nalgebra::{Matrix3, Vector2, Vector3};

pub(super) fn slide(w: &Matrix3<f64>, free: &Vector3<f64>, curve: &Polygon) -> Vector3<f64> {
    let mut best = Vector3::new(-free.x / w.m11, 0.0, 0.0);
    let mut least = f64::INFINITY;
    let mut try_out = |impulse: Vector3<f64>, outside: f64| {
        if impulse.x <= 0.0 || !impulse.iter().all(|x| x.is_finite()) {
            return;
        }
        let slip = (w * impulse + free).yz();
        let violation = outside.max(reluctance(&slip, &(impulse.yz() / impulse.x), curve));
        if violation < least {
            (best, least) = (impulse, violation);
        }
    };
    for (start, end) in curve.edges() {
        let along = Vector3::new(1.0, start.x, start.y);
        let normal = -free.x / (w * along).x;
        try_out(along * normal, 0.0);
        let edge = Vector3::new(0.0, end.x - start.x, end.y - start.y);
        // Nothing along the normal, nothing along the edge.
        let (push, slide) = (w * along, w * edge);
        let (a, b, c, d) = (push.x, slide.x, edge.dot(&push), edge.dot(&slide));
        let (e, f) = (-free.x, -edge.dot(free));
        let determinant = a * d - b * c;
        let normal = (e * d - b * f) / determinant;
        let share = (a * f - c * e) / (determinant * normal);
        let inside = share.clamp(0.0, 1.0);
        try_out((along + edge * inside) * normal, (share - inside).abs());
    }
    best
}

/// How much more, of the slip times the curve's size, another friction would dissipate.
fn reluctance(slip: &Vector2<f64>, friction: &Vector2<f64>, curve: &Polygon) -> f64 {
    let speed = slip.norm();
    let size = curve.vertices().iter().map(Vector2::amax).fold(0.0, f64::max);
    if speed * size > 0.0 {
        curve.vertices().iter().map(|v| (friction - v).dot(slip)).fold(0.0, f64::max)
            / (speed * size)
    } else {
        0.0
    }
}
