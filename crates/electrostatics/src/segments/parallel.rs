//! Two nearly parallel charged lines, a pair in each lane.
//!
//! The closed form of [`skew`](super::skew::skew) loses digits here. So only the second line is
//! integrated in closed form, which for one line has no such loss, and the first by Gauss's rule. The
//! integrand has poles beside the ends of the second, p from the first. With `y = p (z - 1/z)/2` from
//! there on they lie at `z = i` and `-i`; panels in which z grows threefold leave Gauss's rule of m
//! points an error of [`RATE`] to the power -2m, however close the lines are.

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
        // Lines at larger angles may cross closely, which panels do not heed.
        let sine = (ROUNDINGS / allowed).cbrt().clamp(1e-3, 0.05);
        Self { sine, rule: gauss_legendre(points.unsigned_abs() as usize) }
    }

    /// The sine of the angle up to which lines are nearly parallel.
    pub(super) fn sine(&self) -> f64 {
        self.sine
    }

    /// The means over two lines, which do not come closer than the hundredth part of their length if
    /// they cross. Cost: some 90 operations a point of the rule and panel, of which there are four or more.
    #[inline(always)]
    pub(super) fn means<S: Simd, R: Roots<S>>(
        &self,
        roots: R,
        first: &Line<S>,
        second: &Line<S>,
        softening: Lanes<S>,
    ) -> Means<S> {
        let pair = Pair::new(*first, *second, softening);
        // Places on the first beside the ends of the second.
        let start = -dot(&pair.r, &first.tangent);
        let end = second.length.times_plus(dot(&first.tangent, &second.tangent), start);
        let low = within(start.below(end, start, end), first.length);
        let high = within(start.below(end, end, start), first.length);
        let middle = (low + high) * low.of(0.5);
        let mut sums = [low.of(0.0); 7];
        for [from, to] in [[low, low.of(0.0)], [low, middle], [high, middle], [high, first.length]]
        {
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
        sums: &mut [Lanes<S>; 7],
    ) {
        let (zero, one, half) = (from.of(0.0), from.of(1.0), from.of(0.5));
        let span = to - from;
        if !zero.any_below(span.abs()) {
            return;
        }
        let (_, [a2, b2]) = pair.squares(from);
        let unit = roots.root(a2.below(b2, a2, b2));
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
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn new(first: Line<S>, second: Line<S>, softening: Lanes<S>) -> Self {
        Self { first, second, softening, r: minus(&first.start, &second.start) }
    }

    /// The way of a `place` on the first beyond the start of the second, along it, the square of its
    /// distance from the line of the second, and those from start and end of it.
    #[inline(always)]
    fn squares(&self, place: Lanes<S>) -> ([Lanes<S>; 2], [Lanes<S>; 2]) {
        let r = along(&self.r, &self.first.tangent, place);
        let beyond = dot(&r, &self.second.tangent);
        let across = along(&r, &self.second.tangent, -beyond);
        let across2 = dot(&across, &across) + self.softening;
        let rest = beyond - self.second.length;
        let ends = [beyond.times_plus(beyond, across2), rest.times_plus(rest, across2)];
        ([beyond, across2], ends)
    }

    /// Adds the potential at a `place` on the first, and the means of 1, v and `v^2` over `r^3`, the former
    /// times powers of the place.
    ///
    /// With the distances A and B of the place from start and end of the second, whose product as
    /// vectors is w, the means of `v/r^3` and `(1 - v)/r^3` are `1/(B (A B + w))` and `1/(A (A B + w))`,
    /// that of `1/r` is `ln((A + B + L)^2/(2 A B + 2 w))/L`, and the derivative of `v/r` gives the rest.
    #[inline(always)]
    fn add<R: Roots<S>>(
        &self,
        roots: R,
        place: Lanes<S>,
        share: Lanes<S>,
        sums: &mut [Lanes<S>; 7],
    ) {
        let ([beyond, across2], squares) = self.squares(place);
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
        let first = inverses[1] * inverse;
        let mean = inverses[0].times_plus(inverse, first);
        let second = (beyond * length).times_plus(first, potential - inverses[1]) * over * over;
        let mut power = share;
        for k in 0..3 {
            sums[1 + k] = mean.times_plus(power, sums[1 + k]);
            power = power * place;
        }
        sums[0] = potential.times_plus(share, sums[0]);
        sums[4] = first.times_plus(share, sums[4]);
        sums[5] = first.times_plus(share * place, sums[5]);
        sums[6] = second.times_plus(share, sums[6]);
    }

    /// The means over both lines from the sums over all places.
    #[inline(always)]
    fn means<R: Roots<S>>(&self, roots: R, sums: &[Lanes<S>; 7]) -> Means<S> {
        let over = roots.reciprocal(self.first.length);
        Means {
            energy: sums[0] * over,
            force: scaled(&self.combined([sums[1], sums[2], sums[4]]), over),
            first_end: scaled(&self.combined([sums[2], sums[3], sums[5]]), over * over),
            second_end: scaled(&self.combined([sums[4], sums[5], sums[6]]), over),
        }
    }

    /// `a r + s y - t v` of both starts and both lines.
    #[inline(always)]
    fn combined(&self, [a, s, t]: [Lanes<S>; 3]) -> Vectors<S> {
        let ahead = along(&scaled(&self.r, a), &self.first.tangent, s);
        along(&ahead, &self.second.tangent, -(t * self.second.length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Kernel, dispatch};
    use nalgebra::Vector3;

    /// A line of `parallel.csv`: start and end of the second line, softening, and the means.
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
            let means = parallel.means(roots, &first, &second, of(self.values[6]));
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

    /// Lines beside each other, against each other and one behind the other, at angles from none to those
    /// of the closed form, some as close as a thousandth of their length.
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
