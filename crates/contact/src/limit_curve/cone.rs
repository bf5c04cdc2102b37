//! Projection onto the cone `K` of all impulses whose friction is within the curve.
use super::{LimitCurve, quarter};
use nalgebra::{Vector2, Vector3};

impl LimitCurve {
    /// Impulse nearest to `q`, N s, whose friction is within its limit: the projection onto the
    /// cone over the curve.
    ///
    /// Closed form for a circle, three to five steps of a monotone Newton iteration for ellipses, a
    /// bracketed root with some ten calls of [`Self::project`] for a polygon. Of a joint it is all
    /// there is.
    #[must_use]
    pub fn project_cone(&self, q: &Vector3<f64>) -> Vector3<f64> {
        if let Self::Circle { mu } = self {
            return circular(q, *mu);
        }
        if *self == Self::Joint {
            return *q;
        }
        let (normal, tangential) = (q.x, q.yz());
        // What is in the polar cone goes to the tip.
        if normal + self.dissipation(&-tangential) <= 0.0 {
            return Vector3::zeros();
        }
        // What is inside stays.
        if normal >= 0.0 && self.contains(&tangential, normal) {
            return *q;
        }
        match self.semi_axes() {
            Some(mu) => elliptic(q, quarter(&mu, &tangential)),
            None => convex(self, q),
        }
    }
}

/// Projection onto a circular cone, in the closed form that most contacts take in every iteration
/// of a solver.
fn circular(q: &Vector3<f64>, mu: f64) -> Vector3<f64> {
    let (normal, size) = (q.x, q.yz().norm());
    if normal + mu * size <= 0.0 {
        return Vector3::zeros();
    }
    if size <= mu * normal {
        return *q;
    }
    let s = (normal + mu * size) / (1.0 + mu * mu);
    let share = mu * s / size;
    Vector3::new(s, q.y * share, q.z * share)
}

/// Projection onto an elliptic cone.
///
/// With the Lagrange multiplier `tau` the friction is `m_i^2 q_i / (m_i^2 + tau)` and the normal
/// part `q_n / (1 - tau)`. On the cone `1 - tau = q_n / |z|`, `z_i = m_i q_i / (m_i^2 + tau)`; for
/// a normal part that is not negative this difference is convex in `tau` and falls, so that
/// Newton's iteration from zero never passes the root. Else the same holds in the polar cone, with
/// `1 / m_i` and `1 / tau`.
fn elliptic(q: &Vector3<f64>, mu: [f64; 2]) -> Vector3<f64> {
    let semi = Vector2::from(mu);
    let squares = semi.component_mul(&semi);
    let tangential = q.yz();
    let polar = q.x < 0.0;
    let normal = q.x.abs();
    // z and the relative rates at which its components fall.
    let at = |tau: f64| {
        let denominator =
            if polar { (squares * tau).add_scalar(1.0) } else { squares.add_scalar(tau) };
        let component = |i: usize| {
            if squares[i] > 0.0 { semi[i] * tangential[i] / denominator[i] } else { 0.0 }
        };
        let rate = |i: usize| (if polar { squares[i] } else { 1.0 }) / denominator[i];
        (Vector2::new(component(0), component(1)), [rate(0), rate(1)])
    };
    // Newton's iteration for tau, monotone from zero.
    let mut tau = 0.0;
    for _ in 0..50 {
        let (z, rate) = at(tau);
        let norm = z.norm();
        let excess = 1.0 - tau - normal / norm;
        if norm <= 0.0 || excess <= 0.0 {
            break;
        }
        let fall: f64 = (0..2).filter(|&i| z[i] != 0.0).map(|i| z[i] * z[i] * rate[i]).sum();
        let step = excess / (1.0 + normal * fall / (norm * norm * norm));
        tau += step;
        // The next step would be of the order of this one's square.
        if step <= 1e-9 * tau {
            break;
        }
    }
    let scale = if polar { tau } else { 1.0 };
    let z = at(tau).0 * scale;
    let friction = semi.component_mul(&z);
    // Where an axis of length zero leaves the rest inside.
    let s = if tau > 0.0 { z.norm() } else { normal };
    Vector3::new(s, friction.x, friction.y)
}

/// Projection onto the cone over any convex curve.
///
/// The nearest point has the normal part `s` at which `s - q_n` equals what the curve's growth
/// saves, the support function of `q_t` minus its projection onto the curve scaled by `s`. That
/// difference grows with `s` at least as fast as `s` does.
fn convex(curve: &LimitCurve, q: &Vector3<f64>) -> Vector3<f64> {
    let (normal, tangential) = (q.x, q.yz());
    let at = |s: f64| {
        let friction = curve.project(&tangential, s);
        s - normal - curve.dissipation(&(friction - tangential))
    };
    let s = root(at, normal.max(0.0), normal + curve.dissipation(&-tangential));
    let friction = curve.project(&tangential, s);
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
