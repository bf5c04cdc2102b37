//! Pairs of segments by the points of Gauss's rules, a source in each lane.
//!
//! The kernel is analytic in the place on a segment, within the ellipse about its ends that passes
//! through the other's nearest point. If the sum of the half axes of this ellipse is r half lengths,
//! the rule of m points errs by `r^(-2m)` (Trefethen, Approximation theory and approximation practice,
//! theorem 19.3). So each rule is right from a place of the other on.

use super::lines::{Lines, Loads, SOFTENING};
use crate::lanes::{Lanes, Vectors, along, dot, minus};
use crate::machine::{Kernel, Roots, dispatch};
use crate::quadrature::gauss_legendre;
use crate::real::Real;
use pulp::Simd;
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
    let indices: Vec<_> = sources.iter().cloned().flatten().collect();
    // The last register is filled with segments without charge.
    let size = indices.len().next_multiple_of(MOST_LANES);
    let mut rows = [(); 9].map(|()| Vec::with_capacity(size));
    for &j in &indices {
        for (row, value) in rows.iter_mut().zip(lines.bar(j, center)) {
            row.push(E::of(value));
        }
    }
    for row in &mut rows {
        row.resize(size, E::of(0.0));
    }
    let mut close = Vec::new();
    dispatch(Pairs { lines, rules, targets, indices, rows, center, close: &mut close, out });
    close
}

/// Most lanes of any register.
const MOST_LANES: usize = 16;

struct Pairs<'a, E> {
    lines: &'a Lines,
    rules: &'a Rules<E>,
    targets: &'a [usize],
    /// The sources, and what [`Lines::bar`] says of them.
    indices: Vec<usize>,
    rows: [Vec<E>; 9],
    center: [f64; 3],
    close: &'a mut Vec<[usize; 2]>,
    out: &'a mut [Loads],
}

/// Segments by their middles and halves.
#[derive(Clone, Copy)]
struct Bars<S: Simd, E: Real> {
    middle: Vectors<S, E>,
    half: Vectors<S, E>,
    length: Lanes<S, E>,
    inverse_length: Lanes<S, E>,
    charge: Lanes<S, E>,
}

impl<S: Simd, E: Real> Bars<S, E> {
    #[inline(always)]
    fn new([x, y, z, a, b, c, length, inverse_length, charge]: [Lanes<S, E>; 9]) -> Self {
        Self { middle: [x, y, z], half: [a, b, c], length, inverse_length, charge }
    }
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
        let Self { lines, rules, targets, indices, rows, center, close, out } = self;
        let lanes = E::lanes::<S>();
        let zero = Lanes::<S, E>::splat(simd, 0.0);
        let far = rules.rules[2].least.sqrt();
        let least = [0, 1, 2].map(|k| E::of(rules.rules[k].least));
        // The sources that no rule serves, and those for the rules with more points, and how many.
        let mut lists = [(); 3].map(|()| vec![0; rows[0].len()]);
        for (&i, out) in targets.iter().zip(out) {
            let mut of = [zero; 9];
            for (of, value) in of.iter_mut().zip(lines.bar(i, center)) {
                *of = Lanes::splat(simd, value);
            }
            let own = Bars::new(of);
            let mut sums = Sums { energy: zero, force: [zero; 3], moment: [zero; 3] };
            let mut counts = [0; 3];
            for first in (0..indices.len()).step_by(lanes) {
                for (of, row) in of.iter_mut().zip(&rows) {
                    *of = Lanes::load(simd, &row[first..]);
                }
                let mut other = Bars::new(of);
                let r = minus(&own.middle, &other.middle);
                let limit = (own.length + other.length) * zero.of(0.5 * far);
                if dot(&r, &r).any_below(limit * limit) {
                    let nearness = nearness(roots, &own, &other, &r);
                    let limit = Lanes::all(simd, least[2]);
                    if nearness.any_below(limit) {
                        other.charge = nearness.below(limit, zero, other.charge);
                        for (k, nearness) in nearness.numbers().iter().enumerate() {
                            if *nearness < least[2] {
                                let rule = usize::from(*nearness >= least[0])
                                    + usize::from(*nearness >= least[1]);
                                lists[rule][counts[rule]] = first + k;
                                counts[rule] += 1;
                            }
                        }
                    }
                }
                add_rule(roots, rules.far(), &own, &other, &mut sums);
            }
            for &k in &lists[0][..counts[0]] {
                if k < indices.len() && indices[k] != i {
                    close.push([i, indices[k]]);
                }
            }
            for k in 0..2 {
                for list in lists[k + 1][..counts[k + 1]].chunks(lanes) {
                    let other = gather(simd, &rows, list);
                    add_rule(roots, &rules.rules[k].points, &own, &other, &mut sums);
                }
            }
            let charge = lines.charge[i];
            out[0] += 0.5 * charge * sums.energy.sum().double();
            for c in 0..3 {
                let force = charge * sums.force[c].sum().double();
                let moment = charge * sums.moment[c].sum().double();
                out[1 + c] += 0.5 * (force - moment);
                out[4 + c] += 0.5 * (force + moment);
            }
        }
    }
}

/// The sources of a list, one in each lane; those beyond have no charge.
#[inline(always)]
fn gather<S: Simd, E: Real>(simd: S, rows: &[Vec<E>; 9], list: &[usize]) -> Bars<S, E> {
    let mut lanes = [[E::of(0.0); MOST_LANES]; 9];
    for (lanes, row) in lanes.iter_mut().zip(rows) {
        for (lane, &k) in lanes.iter_mut().zip(list) {
            *lane = row[k];
        }
    }
    let mut of = [Lanes::splat(simd, 0.0); 9];
    for (of, lanes) in of.iter_mut().zip(&lanes) {
        *of = Lanes::load(simd, lanes);
    }
    Bars::new(of)
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

/// Adds the sums over the points of both segments.
#[inline(always)]
fn add_rule<S: Simd, E: Real, R: Roots<S> + Roots<S, f32>>(
    roots: R,
    rule: &[[E; 2]],
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    sums: &mut Sums<S, E>,
) {
    let softening = other.charge.of(SOFTENING);
    let simd = other.charge.simd;
    let r = minus(&own.middle, &other.middle);
    for [u, w] in rule {
        let place = Lanes::all(simd, *u);
        let charge = other.charge * Lanes::all(simd, *w);
        let from = along(&r, &own.half, place);
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
