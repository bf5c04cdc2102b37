//! Pairs of segments by the points of Gauss's rules, a segment in each lane.
//!
//! The kernel is analytic in the place on a segment, within the ellipse about its ends that passes
//! through the other's nearest point. If the sum of the half axes of this ellipse is r half lengths,
//! the rule of m points errs by `r^(-2m)` (Trefethen, Approximation theory and approximation practice,
//! theorem 19.3). So each rule is right from a place of the other on.

use super::lines::{Lines, Loads, SOFTENING};
use crate::lanes::{Kernel, Lanes, Roots, Vectors, along, dispatch, dot, minus};
use crate::quadrature::gauss_legendre;
use crate::real::Real;
use pulp::Simd;
use std::marker::PhantomData;
use std::ops::Range;

/// Sum of half axes over half the length from which the rule of the fewest points is used.
const FAR: f64 = 4.7;

/// Points of the rules over those of the one with the fewest: what would need more is done in closed
/// form, which is faster than many points.
const QUICK: [f64; 3] = [1.7, 1.34, 1.0];

/// The same for errors below [`STRICT`]: the closed form is only exact to some 1e-9.
const EXACT: [f64; 3] = [2.5, 1.5, 1.0];

/// Error below which as few pairs as possible are done in closed form.
const STRICT: f64 = 1e-6;

/// Beyond all rules.
const FARTHEST: f64 = 1e30;

/// A rule for both of a pair.
struct Rule<E> {
    /// Points from -1 to 1 and weights with the sum 1.
    points: Vec<[E; 2]>,
    /// Square of the sum of the distances of the other's points from both ends over the length, from
    /// which on the rule is used.
    least: f64,
}

/// Rules that err by about as much, from the most points, which are the closest that they can serve, to
/// the fewest, which serve all that is far away.
pub(super) struct Rules<E> {
    rules: [Rule<E>; 3],
}

impl<E: Real> Rules<E> {
    /// Rules that err by about `error`.
    pub(super) fn new(error: f64) -> Self {
        let few = -0.5 * error.ln() / FAR.ln();
        let rule = |times: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some")]
            let count = (times * few).round().max(1.0) as usize;
            // The derivative of a pole errs by the square of the number of points more.
            let excess = (count as f64 / 3.0).powi(2).max(1.0);
            let axes = (error / excess).powf(-0.5 / count as f64);
            let points =
                gauss_legendre(count).iter().map(|[x, w]| [*x, 0.5 * w].map(E::of)).collect();
            Rule { points, least: (0.5 * (axes + 1.0 / axes)).powi(2) }
        };
        Self { rules: if error < STRICT { EXACT.map(rule) } else { QUICK.map(rule) } }
    }

    /// The rule with the fewest points.
    pub(super) fn far(&self) -> &[[E; 2]] {
        &self.rules[2].points
    }

    /// Distance of two segments, over the longer of them, from which [`far`](Self::far) is used.
    pub(super) fn clearance(&self) -> f64 {
        0.5 * (self.rules[2].least.sqrt() - 1.0)
    }
}

/// Adds to `out` the loads of the `targets` by the segments `sources`, and returns the pairs that are
/// too close for any rule. Both of `targets` and `sources` may hold a body; it is no pair.
///
/// Numbers are of the kind `E`, with places from `center`.
pub(super) fn add_rules<E: Real>(
    lines: &Lines,
    rules: &Rules<E>,
    targets: &[usize],
    sources: &[Range<usize>],
    center: [f64; 3],
    out: &mut [Loads],
) -> Vec<[usize; 2]> {
    let source = |j: usize| {
        let (middle, half) = (lines.middle(j), lines.half(j));
        let [x, y, z] = [0, 1, 2].map(|c| middle[c] - center[c]);
        let [a, b, c] = half;
        let length = lines.length[j];
        let row = [x, y, z, a, b, c, length, 1.0 / length, lines.charge[j]];
        (j, row.map(E::of))
    };
    let sources: Vec<_> = sources.iter().flat_map(|range| range.clone().map(source)).collect();
    let mut close = Vec::new();
    let real = PhantomData::<E>;
    dispatch(Pairs { lines, rules, targets, sources, center, close: &mut close, out, real });
    close
}

struct Pairs<'a, E> {
    lines: &'a Lines,
    rules: &'a Rules<E>,
    targets: &'a [usize],
    sources: Vec<(usize, [E; 9])>,
    center: [f64; 3],
    close: &'a mut Vec<[usize; 2]>,
    out: &'a mut [Loads],
    real: PhantomData<E>,
}

/// Segments by their middles and halves.
#[derive(Clone, Copy)]
struct Bars<S: Simd, E: Real> {
    middle: Vectors<S, E>,
    half: Vectors<S, E>,
    length: Lanes<S, E>,
    inverse_length: Lanes<S, E>,
}

/// Sums over pairs: of `1/r`, of `r/r^3`, and of the latter times the place on the target.
struct Sums<S: Simd, E: Real> {
    energy: Lanes<S, E>,
    force: Vectors<S, E>,
    moment: Vectors<S, E>,
}

impl<E: Real> Kernel for Pairs<'_, E> {
    #[inline(always)]
    fn run<S: Simd, R: Roots<S> + Roots<S, f32>>(self, simd: S, roots: R) {
        let lanes = E::lanes::<S>();
        let Self { lines, rules, targets, sources, center, close, out, .. } = self;
        let zero = Lanes::<S, E>::splat(simd, 0.0);
        let far = rules.rules[2].least.sqrt();
        for (targets, out) in targets.chunks(lanes).zip(out.chunks_mut(lanes)) {
            let own = bars(simd, lines, targets, center);
            let mut sums = Sums { energy: zero, force: [zero; 3], moment: [zero; 3] };
            for (j, row) in &sources {
                let mut of = [zero; 9];
                for k in 0..9 {
                    of[k] = Lanes::all(simd, row[k]);
                }
                let [x, y, z, a, b, c, length, inverse_length, charge] = of;
                let other = Bars { middle: [x, y, z], half: [a, b, c], length, inverse_length };
                let r = minus(&own.middle, &other.middle);
                let limit = (own.length + other.length) * zero.of(0.5 * far);
                if !dot(&r, &r).any_below(limit * limit) {
                    let rule = rules.far();
                    add_rule(roots, rule, &own, &other, &r, charge, &mut sums);
                    continue;
                }
                let nearness = nearness(roots, &own, &other, &r);
                let least = zero.of(rules.rules[0].least);
                let share = nearness.below(least, zero, charge);
                if nearness.any_below(least) {
                    let near = nearness.below(least, zero.of(1.0), zero);
                    for (i, near) in targets.iter().zip(near.numbers()) {
                        if *near > E::of(0.0) && i != j {
                            close.push([*i, *j]);
                        }
                    }
                }
                // One rule serves all lanes: what is enough for the closest is so for the others.
                let nearness = nearness.below(least, zero.of(FARTHEST), nearness);
                let mut rule = &rules.rules[0];
                for next in &rules.rules[1..] {
                    if !nearness.any_below(zero.of(next.least)) {
                        rule = next;
                    }
                }
                add_rule(roots, &rule.points, &own, &other, &r, share, &mut sums);
            }
            for (k, (i, out)) in targets.iter().zip(out).enumerate() {
                let lane = |x: &Lanes<S, E>| lines.charge[*i] * x.numbers()[k].double();
                out[0] += 0.5 * lane(&sums.energy);
                for c in 0..3 {
                    let (force, moment) = (lane(&sums.force[c]), lane(&sums.moment[c]));
                    out[1 + c] += 0.5 * (force - moment);
                    out[4 + c] += 0.5 * (force + moment);
                }
            }
        }
    }
}

/// The segments `indices`, one in each lane; the lanes beyond repeat the first.
#[inline(always)]
fn bars<S: Simd, E: Real>(
    simd: S,
    lines: &Lines,
    indices: &[usize],
    center: [f64; 3],
) -> Bars<S, E> {
    let mut rows = [[E::of(0.0); 16]; 8];
    for k in 0..E::lanes::<S>() {
        let i = indices[if k < indices.len() { k } else { 0 }];
        let (middle, half) = (lines.middle(i), lines.half(i));
        for c in 0..3 {
            rows[c][k] = E::of(middle[c] - center[c]);
            rows[3 + c][k] = E::of(half[c]);
        }
        rows[6][k] = E::of(lines.length[i]);
        rows[7][k] = E::of(1.0 / lines.length[i]);
    }
    let [x, y, z, a, b, c, length, inverse_length] = rows;
    Bars {
        middle: [Lanes::load(simd, &x), Lanes::load(simd, &y), Lanes::load(simd, &z)],
        half: [Lanes::load(simd, &a), Lanes::load(simd, &b), Lanes::load(simd, &c)],
        length: Lanes::load(simd, &length),
        inverse_length: Lanes::load(simd, &inverse_length),
    }
}

/// At most the square of the sum of the distances of a point of one segment from the ends of the other,
/// over the length of this; the less of both ways round. With the distance p across the axis and g
/// beyond the end it is `((2 g + L)^2 + 4 p^2)/L^2` by the triangle inequality.
#[inline(always)]
fn nearness<S: Simd, E: Real, R: Roots<S> + Roots<S, f32>>(
    roots: R,
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &Vectors<S, E>,
) -> Lanes<S, E> {
    let (zero, two, four) = (r[0].of(0.0), r[0].of(2.0), r[0].of(4.0));
    let r2 = dot(r, r);
    let product = dot(&own.half, &other.half).abs() * four;
    let mut least = r2.of(0.9e30);
    for [bar, partner] in [[own, other], [other, own]] {
        // All in lengths of the bar.
        let inverse = bar.inverse_length;
        let along_bar = dot(r, &bar.half).abs() * inverse * two;
        let reach = product * inverse * r2.of(0.5);
        let across2 = along_bar.times_from(along_bar, r2);
        let across2 = across2.below(zero, zero, across2);
        let partner2 = partner.length * partner.length * r2.of(0.25);
        // What the partner extends across the axis.
        let lean2 = reach.times_from(reach, partner2);
        let lean2 = lean2.below(zero, zero, lean2);
        let across =
            across2 * E::inverse_root(roots, across2) - lean2 * E::inverse_root(roots, lean2);
        let across = across.below(zero, zero, across) * inverse;
        let gap = (along_bar - reach) * inverse - r2.of(0.5);
        let gap = gap.below(zero, zero, gap);
        let length = gap.times_plus(two, r2.of(1.0));
        let square = length.times_plus(length, across * across * four);
        least = square.below(least, square, least);
    }
    least
}

/// Adds the sums over the points of both segments, with the middles apart by `r`.
#[inline(always)]
fn add_rule<S: Simd, E: Real, R: Roots<S> + Roots<S, f32>>(
    roots: R,
    rule: &[[E; 2]],
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &Vectors<S, E>,
    charge: Lanes<S, E>,
    sums: &mut Sums<S, E>,
) {
    let softening = charge.of(SOFTENING);
    let simd = charge.simd;
    for [u, w] in rule {
        let place = Lanes::all(simd, *u);
        let charge = charge * Lanes::all(simd, *w);
        let from = along(r, &own.half, place);
        let mut force = [charge.of(0.0); 3];
        for [v, x] in rule {
            let back = Lanes::all(simd, *v);
            let mut r = from;
            for c in 0..3 {
                r[c] = other.half[c].times_from(back, from[c]);
            }
            let r2 = r[2].times_plus(r[2], r[1].times_plus(r[1], r[0].times_plus(r[0], softening)));
            let inverse = E::inverse_root(roots, r2);
            let share = inverse * (charge * Lanes::all(simd, *x));
            sums.energy = sums.energy + share;
            force = along(&force, &r, share * (inverse * inverse));
        }
        for c in 0..3 {
            sums.force[c] = sums.force[c] + force[c];
        }
        sums.moment = along(&sums.moment, &force, place);
    }
}
