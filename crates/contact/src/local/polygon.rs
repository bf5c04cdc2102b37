//! Sliding on a polygon: friction is at a vertex, or slides along an edge while the slip is at a
//! right angle to it. All are tried; one of them obeys the law.
use crate::limit_curve::Polygon;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Impulse of a contact that slides, N s, from the cone's tip, with the response `w`, 1/kg, and the
/// velocity `free`, m/s, in the contact's frame.
pub(super) fn slide(w: &Matrix3<f64>, free: &Vector3<f64>, curve: &Polygon) -> Vector3<f64> {
    let vertices = curve.vertices();
    let count = vertices.len();
    let mut best = Vector3::new(-free.x / w.m11, 0.0, 0.0);
    let mut least = f64::INFINITY;
    let speed = free.norm();
    // What is wrong with a candidate: how far it is outside of its edge, and how much of its slip,
    // compared to the free velocity, friction would resist more elsewhere.
    let mut consider = |impulse: Vector3<f64>, outside: f64, better: [Vector2<f64>; 2]| {
        if impulse.x <= 0.0 || !impulse.iter().all(|x| x.is_finite()) {
            return;
        }
        let slip = (w * impulse + free).yz();
        let gain = |toward: &Vector2<f64>| {
            let most = toward.norm() * speed;
            if most > 0.0 { -toward.dot(&slip) / most } else { 0.0 }
        };
        let wrong = outside.max(gain(&better[0])).max(gain(&better[1]));
        if wrong < least {
            (best, least) = (impulse, wrong);
        }
    };
    for i in 0..count {
        let (start, end) = (vertices[i], vertices[(i + 1) % count]);
        let edge = end - start;
        let along = Vector3::new(1.0, start.x, start.y);
        let normal = -free.x / (w * along).x;
        consider(along * normal, 0.0, [edge, vertices[(i + count - 1) % count] - start]);
        // Nothing along the normal, nothing along the edge.
        let across = Vector3::new(0.0, edge.x, edge.y);
        let (push, slide) = (w * along, w * across);
        let (a, b, c, d) = (push.x, slide.x, across.dot(&push), across.dot(&slide));
        let (e, f) = (-free.x, -across.dot(free));
        let determinant = a * d - b * c;
        let normal = (e * d - b * f) / determinant;
        let share = (a * f - c * e) / (determinant * normal);
        let inside = share.clamp(0.0, 1.0);
        let inward = Vector2::new(-edge.y, edge.x);
        // From the place on the edge, so that the normal velocity is zero to rounding.
        let place = along + across * inside;
        consider(place * (-free.x / (w * place).x), (share - inside).abs(), [inward; 2]);
    }
    best
}
