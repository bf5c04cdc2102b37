//! Two nearly parallel charged lines, a pair in each lane.
//!
//! The closed form of [`skew`](super::skew::skew) loses digits here. So only the second line is
//! integrated in closed form, which for one line has no such loss, and the first by Gauss's rule. The
//! integrand has poles beside the ends of the second, p from the first, and where lines cross, their
//! distance over the sine of their angle from it. With `y = p (z - 1/z)/2` from there on they lie at
//! `z = i` and `-i`; panels in which z grows threefold leave Gauss's rule of m points an error of
//! [`RATE`] to the power -2m, however close the lines are.

use super::skew::{Line, Means, ROUNDINGS};
use crate::lanes::{Lanes, Vectors, along, dot, ln, minus, scaled};
use crate::machine::Roots;
use crate::quadrature::gauss_legendre;
use pulp::Simd;

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
        softening: Lanes<S>,
    ) -> Means<S> {
        let pair = Pair::new(roots, *first, *second, softening);
        // Places on the first beside the ends of the second.
        let start = -dot(&pair.r, &first.tangent);
        let end = second.length.times_plus(dot(&first.tangent, &second.tangent), start);
        let low = within(start.below(end, start, end), first.length);
        let high = within(start.below(end, end, start), first.length);
        let crossing = pair.crossing([low, high]);
        let half = low.of(0.5);
        let middles = [(low + crossing) * half, (crossing + high) * half];
        let mut sums = [low.of(0.0); 10];
        for [from, to] in [
            [low, low.of(0.0)],
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
        [from, to]: [Lanes<S>; 2],
        sums: &mut [Lanes<S>; 10],
    ) {
        let (zero, one, half) = (from.of(0.0), from.of(1.0), from.of(0.5));
        let span = to - from;
        if !zero.any_below(span.abs()) {
            return;
        }
        let unit = pair.pole(roots, from);
        let steep = span.abs() * roots.reciprocal(unit);
        let mut growth = steep + roots.root(steep.times_plus(steep, one));
        let mut panels = 1;
        while panels < PANELS && from.of(GROWTH).any_below(growth) {
            growth = roots.root(growth);
            panels *= 2;
        }
        let unit = span.below(zero, -unit, unit) * half;
        let forward = span.below(zero, -one, one);
        let mut least = one;
        for _ in 0..panels {
            let width = least * (growth - one) * half;
            let middle = least + width;
            for &[x, weight] in &self.rule {
                let z = width.times_plus(from.of(x), middle);
                let inverse = roots.reciprocal(z);
                let place = unit.times_plus(z - inverse, from);
                let share = unit * forward * inverse.times_plus(inverse, one) * width;
                pair.add(roots, place, share * from.of(weight), sums);
            }
            least = least * growth;
        }
    }
}

/// The nearest number from 0 to `most`.
#[inline(always)]
fn within<S: Simd>(x: Lanes<S>, most: Lanes<S>) -> Lanes<S> {
    let x = x.below(x.of(0.0), x.of(0.0), x);
    x.below(most, x, most)
}

struct Pair<S: Simd> {
    first: Line<S>,
    second: Line<S>,
    softening: Lanes<S>,
    /// From the start of the second to that of the first.
    r: Vectors<S>,
    /// What the tangent of the first has across the second, and the inverse of its square.
    lean: Vectors<S>,
    steepness: Lanes<S>,
}

/// How a place on the first is seen from the second.
struct Seen<S: Simd> {
    /// Its way beyond the start of the second, along that.
    beyond: Lanes<S>,
    /// The way from the line of the second to it, and the square of that with the softening.
    across: Vectors<S>,
    across2: Lanes<S>,
    /// The squares of the distances from the start and the end of the second.
    squares: [Lanes<S>; 2],
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn new<R: Roots<S>>(roots: R, first: Line<S>, second: Line<S>, softening: Lanes<S>) -> Self {
        let lean = across(&first.tangent, &second.tangent);
        let steepness = roots.reciprocal(dot(&lean, &lean) + softening.of(TINY));
        let r = minus(&first.start, &second.start);
        Self { first, second, softening, r, lean, steepness }
    }

    #[inline(always)]
    fn seen(&self, place: Lanes<S>) -> Seen<S> {
        let r = along(&self.r, &self.first.tangent, place);
        let beyond = dot(&r, &self.second.tangent);
        let across = along(&r, &self.second.tangent, -beyond);
        let across2 = dot(&across, &across) + self.softening;
        let rest = beyond - self.second.length;
        let squares = [beyond.times_plus(beyond, across2), rest.times_plus(rest, across2)];
        Seen { beyond, across, across2, squares }
    }

    /// The place of `low` to `high` nearest to where the lines cross, if that is heeded; else `low`.
    #[inline(always)]
    fn crossing(&self, [low, high]: [Lanes<S>; 2]) -> Lanes<S> {
        let place = -(dot(&self.lean, &self.r) * self.steepness);
        let place = place.below(low, low, place);
        let place = place.below(high, place, high);
        let reach = self.first.length * low.of(HEEDED);
        let pole2 = self.seen(place).across2 * self.steepness;
        pole2.below(reach * reach, place, low)
    }

    /// How far from a `place` on the first the nearest pole is.
    #[inline(always)]
    fn pole<R: Roots<S>>(&self, roots: R, place: Lanes<S>) -> Lanes<S> {
        let Seen { across2, squares: [a2, b2], .. } = self.seen(place);
        let crossing2 = across2 * self.steepness;
        let end2 = a2.below(b2, a2, b2);
        roots.root(end2.below(crossing2, end2, crossing2))
    }

    /// Adds what the second makes at a `place` on the first: the potential, the means of `r/r^3`, those times
    /// the place, and those of `v r/r^3`.
    ///
    /// With the distances A and B of the place from start and end of the second, whose product as
    /// vectors is w, the means of `v/r^3` and `(1 - v)/r^3` are `1/(B (A B + w))` and `1/(A (A B + w))`,
    /// and that of `1/r` is `P = ln((A + B + L)^2/(2 A B + 2 w))/L`. Along the second, those of `r/r^3` and
    /// `v r/r^3` are `(1/B - 1/A)/L` and `(1/B - P)/L`.
    #[inline(always)]
    fn add<R: Roots<S>>(
        &self,
        roots: R,
        place: Lanes<S>,
        share: Lanes<S>,
        sums: &mut [Lanes<S>; 10],
    ) {
        let Seen { beyond, across, across2, squares } = self.seen(place);
        let length = self.second.length;
        let inverses = [roots.inverse_root(squares[0]), roots.inverse_root(squares[1])];
        let [a, b] = [squares[0] * inverses[0], squares[1] * inverses[1]];
        let (product, ways) = (a * b, beyond * (beyond - length));
        // Between the ends `A B` and the product of the ways cancel.
        let between = (squares[0] + squares[1] - across2) * roots.reciprocal(product + ways.abs());
        let beside = across2.times_plus(between, across2);
        let sum = ways.below(place.of(0.0), beside, product + ways + across2);
        let inverse = roots.reciprocal(sum);
        let around = a + b + length;
        let over = roots.reciprocal(length);
        let potential = ln(roots, around * around * inverse * place.of(0.5)) * over;
        let end = inverses[1] * inverse;
        let mean = inverses[0].times_plus(inverse, end);
        let tangent = scaled(&self.second.tangent, over * share);
        let force = along(&scaled(&across, mean * share), &tangent, inverses[1] - inverses[0]);
        let second_end = along(&scaled(&across, end * share), &tangent, inverses[1] - potential);
        sums[0] = potential.times_plus(share, sums[0]);
        for c in 0..3 {
            sums[1 + c] = sums[1 + c] + force[c];
            sums[4 + c] = force[c].times_plus(place, sums[4 + c]);
            sums[7 + c] = sums[7 + c] + second_end[c];
        }
    }

    /// The means over both lines from the sums over all places.
    #[inline(always)]
    fn means<R: Roots<S>>(&self, roots: R, sums: &[Lanes<S>; 10]) -> Means<S> {
        let over = roots.reciprocal(self.first.length);
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
    use crate::machine::{Kernel, dispatch};
    use nalgebra::Vector3;

    /// A line of `parallel.csv`: start and end of the second line, softening, and the means. Lines that lean
    /// far enough for the closed form are compared with that as well.
    struct Check<'a> {
        values: &'a [f64],
        tolerance: f64,
    }

    impl Kernel for Check<'_> {
        fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
            let of = |value: f64| Lanes::splat(simd, value);
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
            let error = (means.energy.store()[0] / exact[0] - 1.0).abs();
            assert!(error < most, "{:?}: {error:e}", self.values);
            let size = exact[1..].iter().map(|x| x.abs()).fold(0.0, f64::max);
            let vectors = [means.force, means.first_end, means.second_end].concat();
            for (k, found) in vectors.iter().enumerate() {
                let error = (found.store()[0] - exact[1 + k]).abs() / size;
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
