//! Two nearly parallel charged lines, a pair in each lane.
//!
//! The closed form of [`skew`](super::skew::skew) loses digits here. So only the second line is
//! integrated in closed form, which for one line has no such loss, and the first by Gauss's rule. The
//! integrand has poles beside the ends of the second, p from the first, and where lines cross, their
//! distance over the sine of their angle from it. With `y = p (z - 1/z)/2` from there on they lie at
//! `z = i` and `-i`; panels in which z grows threefold leave Gauss's rule of m points an error of
//! [`RATE`] to the power -2m, however close the lines are.

use super::skew::{Line, Means, ROUNDINGS};
use crate::quadrature::gauss_legendre;
use crate::vectors::{Vectors, along, dot, minus, scaled};
use pulp::Simd;
use rapunzel_lanes::{Lane, Roots, ln};

/// Most that z grows in a panel.
const GROWTH: f64 = 3.0;

/// The sum of the half axes of the ellipse through `i` about the first panel, from 1 to 3, over half of
/// the panel.
const RATE: f64 = 4.3;

/// Most points of a rule: they are exact to rounding.
const MOST: i32 = 14;

/// Most panels: they are enough for distances of 1e-7 of the length.
const PANELS: i32 = 16;

/// Distance of the poles of a crossing, over the length, beyond which the widest panels need not heed them:
/// those are two thirds as long, and from their middle the ellipse of [`RATE`] is half as wide again.
const HEEDED: f64 = 0.7;

/// What keeps the square of a sine from zero.
const TINY: f64 = 1e-30;

/// Lines that are nearly parallel.
pub(super) struct Parallel {
    sine: f64,
    /// Places and weights on a panel from -1 to 1.
    rule: Vec<[f64; 2]>,
}

impl Parallel {
    /// For forces within `tolerance`, of which rules and rounding may take a tenth each.
    pub(super) fn new(tolerance: f64) -> Self {
        let allowed = 0.1 * tolerance;
        // The derivative of a pole errs by the square of the number of points more.
        let error = |points: i32| 0.5 * f64::from(points * points) * RATE.powi(-2 * points);
        let enough = |points: &i32| error(*points) <= allowed;
        let points = (2..MOST).find(enough).unwrap_or(MOST);
        let sine = (ROUNDINGS / allowed).cbrt().clamp(1e-3, 0.05);
        Self { sine, rule: gauss_legendre(points.unsigned_abs() as usize) }
    }

    /// The sine of the angle up to which lines are nearly parallel.
    pub(super) fn sine(&self) -> f64 {
        self.sine
    }

    /// The means over two lines. Cost: some 100 operations a point of the rule and panel, of which there are
    /// four or more.
    #[inline(always)]
    pub(super) fn means<S: Simd, R: Roots<S>>(
        &self,
        roots: R,
        first: &Line<S>,
        second: &Line<S>,
        softening: Lane<S>,
    ) -> Means<S> {
        let pair = Pair::new(roots, *first, *second, softening);
        // Places on the first beside the ends of the second.
        let start = -dot(&pair.r, &first.tangent);
        let end = second.length.mul_add(dot(&first.tangent, &second.tangent), start);
        let low = within(start.less_than(end).select(start, end), first.length);
        let high = within(start.less_than(end).select(end, start), first.length);
        let crossing = pair.crossing([low, high]);
        let half = low.lift(0.5);
        let middles = [(low + crossing) * half, (crossing + high) * half];
        let mut sums = [low.lift(0.0); 10];
        for [from, to] in [
            [low, low.lift(0.0)],
            [low, middles[0]],
            [crossing, middles[0]],
            [crossing, middles[1]],
            [high, middles[1]],
            [high, first.length],
        ] {
            self.add(roots, &pair, [from, to], &mut sums);
        }
        pair.means(roots, &sums)
    }

    /// Adds the part of the first line between two places, in panels that grow from the first of them on.
    #[inline(always)]
    fn add<S: Simd, R: Roots<S>>(
        &self,
        roots: R,
        pair: &Pair<S>,
        [from, to]: [Lane<S>; 2],
        sums: &mut [Lane<S>; 10],
    ) {
        let (zero, one, half) = (from.lift(0.0), from.lift(1.0), from.lift(0.5));
        let span = to - from;
        if !zero.less_than(span.abs()).any() {
            return;
        }
        let unit = pair.pole(roots, from);
        let steep = span.abs() * roots.recip(unit);
        let mut growth = steep + roots.sqrt(steep.mul_add(steep, one));
        let mut panels = 1;
        while panels < PANELS && from.lift(GROWTH).less_than(growth).any() {
            growth = roots.sqrt(growth);
            panels *= 2;
        }
        let unit = span.less_than(zero).select(-unit, unit) * half;
        let forward = span.less_than(zero).select(-one, one);
        let mut least = one;
        for _ in 0..panels {
            let width = least * (growth - one) * half;
            let middle = least + width;
            for &[x, weight] in &self.rule {
                let z = width.mul_add(from.lift(x), middle);
                let inverse = roots.recip(z);
                let place = unit.mul_add(z - inverse, from);
                let share = unit * forward * inverse.mul_add(inverse, one) * width;
                pair.add(roots, place, share * from.lift(weight), sums);
            }
            least = least * growth;
        }
    }
}

/// The nearest number from 0 to `most`.
#[inline(always)]
fn within<S: Simd>(x: Lane<S>, most: Lane<S>) -> Lane<S> {
    let x = x.less_than(x.lift(0.0)).select(x.lift(0.0), x);
    x.less_than(most).select(x, most)
}

struct Pair<S: Simd> {
    first: Line<S>,
    second: Line<S>,
    softening: Lane<S>,
    /// From the start of the second to that of the first.
    r: Vectors<S>,
    /// What the tangent of the first has across the second, and the inverse of its square.
    lean: Vectors<S>,
    steepness: Lane<S>,
}

/// How a place on the first is seen from the second.
struct Seen<S: Simd> {
    /// Its way beyond the start of the second, along that.
    beyond: Lane<S>,
    /// The way from the line of the second to it, and the square of that with the softening.
    across: Vectors<S>,
    across2: Lane<S>,
    /// The squares of the distances from the start and the end of the second.
    squares: [Lane<S>; 2],
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn new<R: Roots<S>>(roots: R, first: Line<S>, second: Line<S>, softening: Lane<S>) -> Self {
        let lean = across(&first.tangent, &second.tangent);
        let steepness = roots.recip(dot(&lean, &lean) + softening.lift(TINY));
        let r = minus(&first.start, &second.start);
        Self { first, second, softening, r, lean, steepness }
    }

    #[inline(always)]
    fn seen(&self, place: Lane<S>) -> Seen<S> {
        let r = along(&self.r, &self.first.tangent, place);
        let beyond = dot(&r, &self.second.tangent);
        let across = along(&r, &self.second.tangent, -beyond);
        let across2 = dot(&across, &across) + self.softening;
        let rest = beyond - self.second.length;
        let squares = [beyond.mul_add(beyond, across2), rest.mul_add(rest, across2)];
        Seen { beyond, across, across2, squares }
    }

    /// The place of `low` to `high` nearest to where the lines cross, if that is heeded; else `low`.
    #[inline(always)]
    fn crossing(&self, [low, high]: [Lane<S>; 2]) -> Lane<S> {
        let place = -(dot(&self.lean, &self.r) * self.steepness);
        let place = place.less_than(low).select(low, place);
        let place = place.less_than(high).select(place, high);
        let reach = self.first.length * low.lift(HEEDED);
        let pole2 = self.seen(place).across2 * self.steepness;
        pole2.less_than(reach * reach).select(place, low)
    }

    /// How far from a `place` on the first the nearest pole is.
    #[inline(always)]
    fn pole<R: Roots<S>>(&self, roots: R, place: Lane<S>) -> Lane<S> {
        let Seen { across2, squares: [a2, b2], .. } = self.seen(place);
        let crossing2 = across2 * self.steepness;
        let end2 = a2.less_than(b2).select(a2, b2);
        roots.sqrt(end2.less_than(crossing2).select(end2, crossing2))
    }

    /// Adds what the second makes at a `place` on the first: the potential, the means of `r/r^3`, those times
    /// the place, and those of `v r/r^3`.
    ///
    /// With the distances A and B of the place from start and end of the second, whose product as
    /// vectors is w, the means of `v/r^3` and `(1 - v)/r^3` are `1/(B (A B + w))` and `1/(A (A B + w))`,
    /// and that of `1/r` is `P = ln((A + B + L)^2/(2 A B + 2 w))/L`. Along the second, those of `r/r^3` and
    /// `v r/r^3` are `(1/B - 1/A)/L` and `(1/B - P)/L`.
    #[inline(always)]
    fn add<R: Roots<S>>(&self, roots: R, place: Lane<S>, share: Lane<S>, sums: &mut [Lane<S>; 10]) {
        let Seen { beyond, across, across2, squares } = self.seen(place);
        let length = self.second.length;
        let inverses = [roots.rsqrt(squares[0]), roots.rsqrt(squares[1])];
        let [a, b] = [squares[0] * inverses[0], squares[1] * inverses[1]];
        let (product, ways) = (a * b, beyond * (beyond - length));
        // Between the ends `A B` and the product of the ways cancel.
        let between = (squares[0] + squares[1] - across2) * roots.recip(product + ways.abs());
        let beside = across2.mul_add(between, across2);
        let sum = ways.less_than(place.lift(0.0)).select(beside, product + ways + across2);
        let inverse = roots.recip(sum);
        let around = a + b + length;
        let over = roots.recip(length);
        let potential = ln(roots, around * around * inverse * place.lift(0.5)) * over;
        let end = inverses[1] * inverse;
        let mean = inverses[0].mul_add(inverse, end);
        let tangent = scaled(&self.second.tangent, over * share);
        let force = along(&scaled(&across, mean * share), &tangent, inverses[1] - inverses[0]);
        let second_end = along(&scaled(&across, end * share), &tangent, inverses[1] - potential);
        sums[0] = potential.mul_add(share, sums[0]);
        for c in 0..3 {
            sums[1 + c] = sums[1 + c] + force[c];
            sums[4 + c] = force[c].mul_add(place, sums[4 + c]);
            sums[7 + c] = sums[7 + c] + second_end[c];
        }
    }

    /// The means over both lines from the sums over all places.
    #[inline(always)]
    fn means<R: Roots<S>>(&self, roots: R, sums: &[Lane<S>; 10]) -> Means<S> {
        let over = roots.recip(self.first.length);
        let [energy, a, b, c, d, e, f, g, h, i] = *sums;
        Means {
            energy: energy * over,
            force: scaled(&[a, b, c], over),
            first_end: scaled(&[d, e, f], over * over),
            second_end: scaled(&[g, h, i], over),
        }
    }
}

/// What of a vector is across the unit vector `axis`.
#[inline(always)]
fn across<S: Simd>(vector: &Vectors<S>, axis: &Vectors<S>) -> Vectors<S> {
    along(vector, axis, -dot(vector, axis))
}

#[cfg(test)]
mod tests {
    use super::super::skew::skew;
    use super::*;
    use nalgebra::Vector3;
    use rapunzel_lanes::{Kernel, dispatch};

    /// A line of `parallel.csv`: start and end of the second line, softening, and the means. Lines that lean
    /// far enough for the closed form are compared with that as well.
    struct Check<'a> {
        values: &'a [f64],
        tolerance: f64,
    }

    impl Kernel for Check<'_> {
        fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
            let of = |value: f64| Lane::splat(simd, value);
            let line = |a: Vector3<f64>, b: Vector3<f64>| {
                let lanes = |v: Vector3<f64>| [of(v.x), of(v.y), of(v.z)];
                let tangent = lanes((b - a).normalize());
                Line { start: lanes(a), tangent, length: of((b - a).norm()) }
            };
            let vector = |k: usize| Vector3::from_column_slice(&self.values[k..k + 3]);
            let (first, second) =
                (line(Vector3::zeros(), Vector3::z()), line(vector(0), vector(3)));
            let parallel = Parallel::new(self.tolerance);
            // Inverse roots err by 6e-13.
            let most = 0.1 * self.tolerance + 2e-12;
            let softening = of(self.values[6]);
            self.check(&parallel.means(roots, &first, &second, softening), most);
            let leaning = (vector(3) - vector(0)).normalize().xy().norm();
            if leaning > parallel.sine() {
                self.check(&skew(roots, &first, &second, softening), most);
            }
        }
    }

    impl Check<'_> {
        fn check<S: Simd>(&self, means: &Means<S>, most: f64) {
            let exact = &self.values[7..];
            let error = (means.energy.numbers()[0] / exact[0] - 1.0).abs();
            assert!(error < most, "{:?}: {error:e}", self.values);
            let size = exact[1..].iter().map(|x| x.abs()).fold(0.0, f64::max);
            let vectors = [means.force, means.first_end, means.second_end].concat();
            for (k, found) in vectors.iter().enumerate() {
                let error = (found.numbers()[0] - exact[1 + k]).abs() / size;
                assert!(error < most, "{:?}: {k}: {error:e}", self.values);
            }
        }
    }

    /// Lines beside each other, against each other, across each other and one behind the other, at angles from
    /// none to those of the closed form, some as close as a thousandth of their length, where they cross
    /// as a ten thousandth.
    #[test]
    fn nearly_parallel_lines_are_the_integrals() {
        let table = include_str!("../../tests/data/parallel.csv");
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            for line in table.lines().filter(|line| !line.starts_with('#')) {
                let values: Vec<f64> =
                    line.split(',').map(|x| x.parse().expect("a number")).collect();
                dispatch(Check { values: &values, tolerance });
            }
        }
    }
}
