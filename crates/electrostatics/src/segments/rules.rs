//! Gauss's rules, and where each is right.
//!
//! The kernel is analytic in the place on a segment, within the ellipse about its ends that passes
//! through the other's nearest point. If the sum of the half axes of this ellipse is r half
//! lengths, the rule of m points errs by `r^(-2m)` (Trefethen, Approximation theory and
//! approximation practice, theorem 19.3). So each rule is right from a place of the other on.

use rapunzel_fiber::quadrature::gauss_legendre;
use rapunzel_lanes::Real;

/// Sum of half axes over half the length from which the rule of the fewest points is used.
const FAR: f64 = 4.7;

/// Most points of a rule over the fewest: what would need more is done in closed form, which is
/// faster than many points.
const QUICK: f64 = 1.7;

/// Most points of a rule over the fewest for errors below [`STRICT`]: the closed form is only exact
/// to some 1e-9.
const EXACT: f64 = 2.5;

/// Error below which as few pairs as possible are done in closed form.
const STRICT: f64 = 1e-6;

/// Fewest points of the rules for a sum over all segments, most of which are far away.
const FEWEST: usize = 2;

/// Point of a rule.
#[derive(Clone, Copy)]
pub(super) struct Node<E> {
    /// Place on the segment, from -1 at its start to 1 at its end.
    pub(super) place: E,
    /// Square of the place.
    pub(super) square: E,
    /// Share of the segment that the point stands for.
    pub(super) weight: E,
}

/// Rule for both segments of a pair.
pub(super) struct Rule<E> {
    /// Points of the rule.
    pub(super) points: Vec<Node<E>>,
    /// Least nearness of a pair for the rule: the square of the sum of the distances of the points
    /// of one from both ends of the other, over the length of this.
    pub(super) least: E,
}

/// Rules that err by about as much, from the fewest points, which serve all that is far away, to
/// the most, which are the closest that they can serve.
pub(super) struct Rules<E> {
    /// Rules from the fewest points to the most.
    rules: Vec<Rule<E>>,
}

impl<E: Real> Rules<E> {
    /// Rules that err by about `error`, for segments in neighboring cells.
    pub(super) fn new(error: f64) -> Self {
        let fewest = count(1.0, error);
        Self { rules: (fewest..=count(most(error), error)).map(|m| rule(m, error)).collect() }
    }

    /// Rules that err by about `error`, for segments at any distance.
    pub(super) fn everywhere(error: f64) -> Self {
        let most = count(most(error), error).max(FEWEST);
        Self { rules: (FEWEST..=most).map(|m| rule(m, error)).collect() }
    }

    /// Rules from the fewest points to the most.
    pub(super) fn all(&self) -> &[Rule<E>] {
        &self.rules
    }

    /// Points of the rule with the fewest.
    pub(super) fn far(&self) -> &[Node<E>] {
        &self.rules[0].points
    }

    /// Factors of the sum and of the difference of the lengths of two segments, which add up to the
    /// distance of their middles from which the rule of the fewest points is used: a point of one
    /// is no closer to the middle of the other than that less half of its own length, and the sum
    /// of its distances from the ends of that is twice as much.
    pub(super) fn reach(&self) -> [E; 2] {
        let axes = self.rules[0].least.to_f64().sqrt();
        [E::from_f64(0.25 * (axes + 1.0)), E::from_f64(0.25 * (axes - 1.0))]
    }

    /// Distance of two segments, over the longer of them, from which [`far`](Self::far) is used.
    pub(super) fn clearance(&self) -> f64 {
        0.5 * (self.rules[0].least.to_f64().sqrt() - 1.0)
    }
}

/// Most points over the fewest for this error.
fn most(error: f64) -> f64 {
    if error < STRICT { EXACT } else { QUICK }
}

/// Number of points that err by `error` from [`FAR`] on, times `times`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some")]
fn count(times: f64, error: f64) -> usize {
    (-0.5 * times * error.ln() / FAR.ln()).round().max(1.0) as usize
}

/// Rule of `count` points, with the nearness from which it errs by `error`.
fn rule<E: Real>(count: usize, error: f64) -> Rule<E> {
    // The derivative of a pole errs by the square of the number of points more.
    let excess = (count as f64 / 3.0).powi(2).max(1.0);
    let axes = (error / excess).powf(-0.5 / count as f64);
    let node = |[x, w]: [f64; 2]| Node {
        place: E::from_f64(x),
        square: E::from_f64(x * x),
        weight: E::from_f64(0.5 * w),
    };
    let points = gauss_legendre(count).into_iter().map(node).collect();
    Rule { points, least: E::from_f64((0.5 * (axes + 1.0 / axes)).powi(2)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Segments of unit length one behind the other are the worst: the derivative of the kernel
    /// makes `[2^m m!^2/(2m)!]^2` of what is `4^-m` for the kernel, at most 4 m times as much, for
    /// both of them.
    #[test]
    fn rules_err_by_as_much_as_the_derivative_of_the_kernel() {
        for error in [1e-3, 1e-5, 1e-7, 1e-9] {
            for Rule { points, least } in Rules::<f64>::everywhere(error).all() {
                let gap = 0.5 * (least.sqrt() - 1.0);
                let exact = ((1.0 + gap).powi(2) / (gap * (gap + 2.0))).ln();
                let pairs = points.iter().flat_map(|u| points.iter().map(move |v| (u, v)));
                let force = |(u, v): (&Node<f64>, &Node<f64>)| {
                    u.weight * v.weight / (1.0 + gap + 0.5 * (u.place - v.place)).powi(2)
                };
                let found = (pairs.map(force).sum::<f64>() / exact - 1.0).abs();
                let most = 8.0 * points.len() as f64 * error;
                assert!(found < most, "{} points, {error:e}: {found:e}", points.len());
            }
        }
    }
}
