//! An ellipse on the coordinate axes; a semi-axis may be zero.
use nalgebra::Vector2;

/// Component along a semi-axis of zero that counts as rounding, relative to the vector.
const AXIS_ROUNDING: f64 = 1e-14;

/// The point inside the ellipse that is nearest to `p`.
///
/// Outside it is `e_i^2 p_i / (t + e_i^2)` with the `t > 0` for which that lies on the ellipse.
/// The reciprocal of its gauge is a concave function of `t`, so that Newton's iteration from the
/// left never passes the root (Moré and Sorensen 1983 for the same equation).
pub(super) fn project(p: &Vector2<f64>, semi: [f64; 2]) -> Vector2<f64> {
    let [a, b] = semi;
    if a <= 0.0 || b <= 0.0 {
        return Vector2::new(p.x.min(a).max(-a), p.y.min(b).max(-b));
    }
    if (p.x / a).powi(2) + (p.y / b).powi(2) <= 1.0 {
        return *p;
    }
    let size = a.max(b);
    let q = p / size;
    if !q.norm_squared().is_finite() {
        return support(p, semi);
    }
    let e = Vector2::new(a / size, b / size);
    let squares = e.component_mul(&e);
    let scaled = e.component_mul(&q);
    // Every one of these is at most the root.
    let mut t = (scaled.norm() - 1.0)
        .max(scaled.x.abs() - squares.x)
        .max(scaled.y.abs() - squares.y)
        .max(0.0);
    for _ in 0..50 {
        let shifted = squares.add_scalar(t);
        let z = scaled.component_div(&shifted);
        let norm_squared = z.norm_squared();
        let norm = norm_squared.sqrt();
        let slope = z.component_mul(&z).component_div(&shifted).sum();
        let step = (norm - 1.0) * norm_squared / slope;
        t = (t + step).max(t);
        // The next step would be of the order of this one's square.
        if step <= 1e-9 * shifted.min() {
            break;
        }
    }
    let weights = squares.component_div(&squares.add_scalar(t));
    weights.component_mul(&q) * size
}

/// The point of the ellipse farthest along `direction`; zero if that is zero.
pub(super) fn support(direction: &Vector2<f64>, [a, b]: [f64; 2]) -> Vector2<f64> {
    let size = direction.amax();
    if size <= 0.0 {
        return Vector2::zeros();
    }
    let d = direction / size;
    let scaled = Vector2::new(a * d.x, b * d.y);
    let norm = scaled.norm();
    if norm > 0.0 { Vector2::new(a * scaled.x, b * scaled.y) / norm } else { Vector2::zeros() }
}

/// Factor by which the ellipse must be scaled to pass through `p`; infinite where none does.
pub(super) fn gauge(p: &Vector2<f64>, [a, b]: [f64; 2]) -> f64 {
    let negligible = AXIS_ROUNDING * p.amax();
    let ratio = |x: f64, semi: f64| {
        if semi > 0.0 {
            x / semi
        } else if x.abs() <= negligible {
            0.0
        } else {
            f64::INFINITY
        }
    };
    ratio(p.x, a).hypot(ratio(p.y, b))
}
