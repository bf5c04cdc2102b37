//! Two nearly parallel charged lines, a pair in each lane.
//!
//! The closed form of [`skew`](super::skew::skew) loses digits here. So only the second line is
//! integrated in closed form, which for one line has no such loss, and the first by Gauss's rule.
//! The integrand has poles beside the ends of the second, p from the first, and where lines cross,
//! their distance over the sine of their angle from it. With `y = p (z - 1/z)/2` from there on they
//! lie at `z = i` and `-i`; panels in which z grows threefold leave Gauss's rule of m points an
//! error of [`RATE`] to the power -2m, however close the lines are.

use super::skew::{ChargedLine, LineMeans, ROUNDINGS};
use crate::vectors::{LaneVector, along, dot, minus, scaled};
use pulp::Simd;
use rapunzel_fiber::quadrature::gauss_legendre;
use rapunzel_lanes::{Lane, Roots, ln};

/// Most growth of z in a panel.
const GROWTH: f64 = 3.0;

/// Sum of the half axes of the ellipse through `i` about the first panel, from 1 to 3, over half of
/// the panel.
const RATE: f64 = 4.3;

/// Most points of a rule: they are exact to rounding.
const MOST_POINTS: i32 = 14;

/// Most panels: they are enough for distances of 1e-7 of the length.
const MOST_PANELS: i32 = 16;

/// Distance of the poles of a crossing, over the length, beyond which the widest panels need not
/// heed them: those are two thirds as long, and from their middle the ellipse of [`RATE`] is half
/// as wide again.
const HEEDED: f64 = 0.7;

/// Smallest square of a sine, which keeps its inverse finite.
const LEAST_SINE_SQUARE: f64 = 1e-30;

/// Integrals over pairs of lines that are nearly parallel.
pub(super) struct Parallel {
    /// Sine of the angle up to which lines are nearly parallel.
    sine: f64,
    /// Places on a panel from -1 to 1, and weights.
    rule: Vec<[f64; 2]>,
}

impl Parallel {
    /// Integrals for forces within `tolerance`, of which rules and rounding may take a tenth each.
    pub(super) fn new(tolerance: f64) -> Self {
        let allowed = 0.1 * tolerance;
        // The derivative of a pole errs by the square of the number of points more.
        let error = |points: i32| 0.5 * f64::from(points * points) * RATE.powi(-2 * points);
        let enough = |points: &i32| error(*points) <= allowed;
        let points = (2..MOST_POINTS).find(enough).unwrap_or(MOST_POINTS);
        let sine = (ROUNDINGS / allowed).cbrt().clamp(1e-3, 0.05);
        Self { sine, rule: gauss_legendre(points.unsigned_abs() as usize) }
    }

    /// Sine of the angle up to which lines are nearly parallel.
    pub(super) fn sine(&self) -> f64 {
        self.sine
    }

    /// Means over two lines. Cost: some 100 operations a point of the rule and panel, of which
    /// there are four or more.
    #[inline(always)]
    pub(super) fn means<S: Simd, R: Roots<S>>(
        &self,
        roots: R,
        first: &ChargedLine<S>,
        second: &ChargedLine<S>,
        softening: Lane<S>,
    ) -> LineMeans<S> {
        let pair = LinePair::new(roots, *first, *second, softening);
        // Places on the first beside the ends of the second.
        let start = -dot(&pair.r, &first.tangent);
        let end = second.length.mul_add(dot(&first.tangent, &second.tangent), start);
        let low = within(start.less_than(end).select(start, end), first.length);
        let high = within(start.less_than(end).select(end, start), first.length);
        let crossing = pair.crossing([low, high]);
        let half = low.lift(0.5);
        let middles = [(low + crossing) * half, (crossing + high) * half];
        let mut sums = [low.lift(0.0); 10];
        // Panels begin where the integrand is steepest: beside the ends of the second line and at
        // the crossing.
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

    /// Adds the part of the first line between the places `from` and `to` (m), in panels that grow
    /// from the first of them on.
    #[inline(always)]
    fn add<S: Simd, R: Roots<S>>(
        &self,
        roots: R,
        pair: &LinePair<S>,
        [from, to]: [Lane<S>; 2],
        sums: &mut [Lane<S>; 10],
    ) {
        let (zero, one, half) = (from.lift(0.0), from.lift(1.0), from.lift(0.5));
        let span = to - from;
        if !zero.less_than(span.abs()).any() {
            return;
        }
        // The substitution `y = p (z - 1/z)/2` with the distance p of the nearest pole; z grows
        // from 1 by the same factor in each panel.
        let unit = pair.pole(roots, from);
        let steep = span.abs() * roots.recip(unit);
        let mut growth = steep + roots.sqrt(steep.mul_add(steep, one));
        let mut panels = 1;
        while panels < MOST_PANELS && from.lift(GROWTH).less_than(growth).any() {
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

/// Nearest number from 0 to `most`.
#[inline(always)]
fn within<S: Simd>(x: Lane<S>, most: Lane<S>) -> Lane<S> {
    let x = x.less_than(x.lift(0.0)).select(x.lift(0.0), x);
    x.less_than(most).select(x, most)
}

/// Pair of lines in each lane.
struct LinePair<S: Simd> {
    /// Line that is integrated by a rule.
    first: ChargedLine<S>,
    /// Line that is integrated in closed form.
    second: ChargedLine<S>,
    /// Square of the length that distances are softened with, m^2.
    softening: Lane<S>,
    /// Vector from the start of the second line to that of the first, m.
    r: LaneVector<S>,
    /// Part of the tangent of the first line across the second.
    lean: LaneVector<S>,
    /// Inverse of the square of that part.
    steepness: Lane<S>,
}

/// Place on the first line as seen from the second.
struct PlaceView<S: Simd> {
    /// Way (m) of the place beyond the start of the second line, along that.
    beyond: Lane<S>,
    /// Vector (m) from the line through the second to the place.
    across: LaneVector<S>,
    /// Square of that vector with the softening, m^2.
    across2: Lane<S>,
    /// Squares of the distances from the start and the end of the second line, m^2.
    squares: [Lane<S>; 2],
}

impl<S: Simd> LinePair<S> {
    /// Pair with the vector between both lines.
    #[inline(always)]
    fn new<R: Roots<S>>(
        roots: R,
        first: ChargedLine<S>,
        second: ChargedLine<S>,
        softening: Lane<S>,
    ) -> Self {
        let lean = across(&first.tangent, &second.tangent);
        let steepness = roots.recip(dot(&lean, &lean) + softening.lift(LEAST_SINE_SQUARE));
        let r = minus(&first.start, &second.start);
        Self { first, second, softening, r, lean, steepness }
    }

    /// View of the `place` (m) on the first line.
    #[inline(always)]
    fn seen(&self, place: Lane<S>) -> PlaceView<S> {
        let r = along(&self.r, &self.first.tangent, place);
        let beyond = dot(&r, &self.second.tangent);
        let across = along(&r, &self.second.tangent, -beyond);
        let across2 = dot(&across, &across) + self.softening;
        let rest = beyond - self.second.length;
        let squares = [beyond.mul_add(beyond, across2), rest.mul_add(rest, across2)];
        PlaceView { beyond, across, across2, squares }
    }

    /// Place from `low` to `high` that is nearest to where the lines cross, if that is heeded; else
    /// `low`.
    #[inline(always)]
    fn crossing(&self, [low, high]: [Lane<S>; 2]) -> Lane<S> {
        let place = -(dot(&self.lean, &self.r) * self.steepness);
        let place = place.less_than(low).select(low, place);
        let place = place.less_than(high).select(place, high);
        let reach = self.first.length * low.lift(HEEDED);
        let pole2 = self.seen(place).across2 * self.steepness;
        pole2.less_than(reach * reach).select(place, low)
    }

    /// Distance (m) of the nearest pole from a `place` (m) on the first line.
    #[inline(always)]
    fn pole<R: Roots<S>>(&self, roots: R, place: Lane<S>) -> Lane<S> {
        let PlaceView { across2, squares: [a2, b2], .. } = self.seen(place);
        let crossing2 = across2 * self.steepness;
        let end2 = a2.less_than(b2).select(a2, b2);
        roots.sqrt(end2.less_than(crossing2).select(end2, crossing2))
    }

    /// Adds the action of the second line on a `place` (m) on the first: the potential, the means
    /// of `r/r^3`, those times the place, and those of `v r/r^3`.
    ///
    /// With the distances A and B of the place from start and end of the second, whose product as
    /// vectors is w, the means of `v/r^3` and `(1 - v)/r^3` are `1/(B (A B + w))` and
    /// `1/(A (A B + w))`, and that of `1/r` is `P = ln((A + B + L)^2/(2 A B + 2 w))/L`. Along the
    /// second, those of `r/r^3` and `v r/r^3` are `(1/B - 1/A)/L` and `(1/B - P)/L`.
    #[inline(always)]
    fn add<R: Roots<S>>(&self, roots: R, place: Lane<S>, share: Lane<S>, sums: &mut [Lane<S>; 10]) {
        let PlaceView { beyond, across, across2, squares } = self.seen(place);
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

    /// Means over both lines from the sums over all places.
    #[inline(always)]
    fn means<R: Roots<S>>(&self, roots: R, sums: &[Lane<S>; 10]) -> LineMeans<S> {
        let over = roots.recip(self.first.length);
        let [energy, a, b, c, d, e, f, g, h, i] = *sums;
        LineMeans {
            energy: energy * over,
            force: scaled(&[a, b, c], over),
            first_end: scaled(&[d, e, f], over * over),
            second_end: scaled(&[g, h, i], over),
        }
    }
}

/// Part of `vector` across the unit vector `axis`.
#[inline(always)]
fn across<S: Simd>(vector: &LaneVector<S>, axis: &LaneVector<S>) -> LaneVector<S> {
    along(vector, axis, -dot(vector, axis))
}

#[cfg(test)]
mod tests {
    use super::super::skew::skew;
    use super::*;
    use nalgebra::Vector3;
    use rapunzel_lanes::{Kernel, dispatch};

    /// A line of `parallel.csv`: start and end of the second line, softening, and the means. Lines
    /// that lean far enough for the closed form are compared with that as well.
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
                ChargedLine { start: lanes(a), tangent, length: of((b - a).norm()) }
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
        fn check<S: Simd>(&self, means: &LineMeans<S>, most: f64) {
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

    /// Lines beside each other, against each other, across each other and one behind the other, at
    /// angles from none to those of the closed form, some as close as a thousandth of their length,
    /// where they cross as a ten thousandth.
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
