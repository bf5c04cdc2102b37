//! Projection onto the cone `K` of all impulses whose friction is within the curve.
use super::LimitCurve;
use nalgebra::Vector3;

/// The nearest point has the normal part `s` at which `s - q_n` equals what the curve's growth
/// saves, the support function of `q_t` minus its projection onto the curve scaled by `s`. That
/// difference grows with `s` at least as fast as `s` does.
pub(super) fn project(curve: &LimitCurve, q: &Vector3<f64>) -> Vector3<f64> {
    let (normal, tangential) = (q.x, q.yz());
    let reach = curve.dissipation(&-tangential);
    if normal + reach <= 0.0 {
        return Vector3::zeros();
    }
    if normal >= 0.0 && curve.contains(&tangential, normal) {
        return *q;
    }
    let at = |s: f64| {
        let friction = curve.project(&tangential, s);
        (s - normal - curve.dissipation(&(friction - tangential)), friction)
    };
    let s = match curve {
        LimitCurve::Circle { mu } => (normal + mu * tangential.norm()) / (1.0 + mu * mu),
        _ => root(|s| at(s).0, normal.max(0.0), normal + reach),
    };
    let friction = at(s).1;
    Vector3::new(s, friction.x, friction.y)
}

/// Root of an increasing function between `low` and `high`: regula falsi with the Illinois rule.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (f(low), f(high));
    let tolerance = 4.0 * f64::EPSILON * high;
    let mut side = 0;
    for _ in 0..100 {
        if at_low >= 0.0 {
            return low;
        }
        if at_high <= 0.0 || high - low <= tolerance {
            return high;
        }
        let middle = (low - at_low * (high - low) / (at_high - at_low)).clamp(low, high);
        let value = f(middle);
        if value.abs() <= tolerance {
            return middle;
        }
        if value > 0.0 {
            (high, at_high) = (middle, value);
            at_low *= if side == 1 { 0.5 } else { 1.0 };
            side = 1;
        } else {
            (low, at_low) = (middle, value);
            at_high *= if side == -1 { 0.5 } else { 1.0 };
            side = -1;
        }
    }
    0.5 * (low + high)
}
