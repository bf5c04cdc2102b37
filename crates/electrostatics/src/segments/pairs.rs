//! Pairs of segments by the points of Gauss's rules, a source in each lane.

use super::lines::{Lines, Loads, SOFTENING};
use super::rules::{Node, Rules};
use crate::lanes::{Lanes, Vectors, along, dot, minus, scaled};
use crate::machine::{Kernel, Machine, dispatch};
use crate::real::Real;
use pulp::Simd;
use std::ops::Range;

/// Most lanes of any register.
const MOST_LANES: usize = 16;

/// What fills a register: a segment far from all others, of unit length and without charge.
const NOTHING: [f64; 9] = [1e9, 1e9, 1e9, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0];

/// Segments as sources, coordinate by coordinate, with places from a center.
pub(super) struct Columns<E> {
    center: [f64; 3],
    /// Rows as those of [`Lines::bars`].
    rows: [Vec<E>; 9],
    indices: Vec<usize>,
    /// Of those that act on the targets and feel nothing, which come first.
    alone: usize,
    /// What the others feel: forces and moments.
    felt: [Vec<E>; 6],
}

impl<E: Real> Columns<E> {
    /// The segments `alone`, which act on the targets, and those that are `mutual`, which also feel them.
    pub(super) fn new(
        lines: &Lines,
        center: [f64; 3],
        [alone, mutual]: [&[Range<usize>]; 2],
    ) -> Self {
        let size = |ranges: &[Range<usize>]| {
            ranges.iter().map(Range::len).sum::<usize>().next_multiple_of(MOST_LANES)
        };
        let (alone_size, size) = (size(alone), size(alone) + size(mutual));
        let row = |(k, values): (usize, &Vec<f64>)| {
            let origin = center.get(k).copied().unwrap_or(0.0);
            let mut row = Vec::with_capacity(size);
            for (ranges, end) in [(alone, alone_size), (mutual, size)] {
                for range in ranges {
                    row.extend(values[range.clone()].iter().map(|x| E::of(x - origin)));
                }
                row.resize(end, E::of(NOTHING[k]));
            }
            row
        };
        let mut rows = [(); 9].map(|()| Vec::new());
        for (to, of) in rows.iter_mut().zip(lines.bars.iter().enumerate()) {
            *to = row(of);
        }
        let mut indices = Vec::with_capacity(size);
        for (ranges, end) in [(alone, alone_size), (mutual, size)] {
            indices.extend(ranges.iter().cloned().flatten());
            indices.resize(end, usize::MAX);
        }
        let felt = [(); 6].map(|()| vec![E::of(0.0); size - alone_size]);
        Self { center, rows, indices, alone: alone_size, felt }
    }

    /// Adds to `out` the loads of the `targets` by all, each pair by the rule that serves it, and returns
    /// the pairs that are too close for any. A target among those that are alone is no pair.
    pub(super) fn act(
        &mut self,
        lines: &Lines,
        rules: &Rules<E>,
        targets: &[usize],
        out: &mut [Loads],
    ) -> Vec<[usize; 2]> {
        let mut close = Vec::new();
        dispatch(Pairs { lines, rules, columns: self, targets, close: &mut close, out });
        close
    }

    /// Those that are mutual, and their loads.
    pub(super) fn felt(&self) -> impl Iterator<Item = (usize, Loads)> {
        let loads = move |k: usize| {
            let felt = |row: usize| 0.5 * self.felt[row][k].double();
            let mut loads = [0.0; 7];
            for c in 0..3 {
                loads[1 + c] = felt(3 + c) - felt(c);
                loads[4 + c] = -felt(3 + c) - felt(c);
            }
            loads
        };
        let mutual = self.indices[self.alone..].iter().enumerate();
        mutual.filter(|(_, i)| **i < usize::MAX).map(move |(k, i)| (*i, loads(k)))
    }
}

struct Pairs<'a, E> {
    lines: &'a Lines,
    rules: &'a Rules<E>,
    columns: &'a mut Columns<E>,
    targets: &'a [usize],
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
#[derive(Clone, Copy)]
struct Sums<S: Simd, E: Real> {
    energy: Lanes<S, E>,
    force: Vectors<S, E>,
    moment: Vectors<S, E>,
}

impl<E: Real> Kernel for Pairs<'_, E> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { lines, rules, columns, targets, close, out } = self;
        let Columns { center, rows, indices, alone, felt } = columns;
        let zero = Lanes::<S, E>::splat(simd, 0.0);
        // The sources that no rule serves.
        let mut list = vec![0; indices.len()];
        for (&i, out) in targets.iter().zip(out) {
            let mut own = [zero; 9];
            for (own, value) in own.iter_mut().zip(lines.bar(i, *center)) {
                *own = Lanes::splat(simd, value);
            }
            let own = Bars::new(own);
            let sums = Sums { energy: zero, force: [zero; 3], moment: [zero; 3] };
            let mut seen = Seen { rules, rows, own, sums, list: &mut list, count: 0 };
            for first in (0..indices.len()).step_by(E::lanes::<S>()) {
                let [force, moment] = seen.add(machine, first, first < *alone);
                if first >= *alone {
                    for c in 0..3 {
                        add_to(&mut felt[c][first - *alone..], force[c]);
                        add_to(&mut felt[3 + c][first - *alone..], moment[c]);
                    }
                }
            }
            let Seen { sums, count, .. } = seen;
            close.extend(list[..count].iter().map(|&k| [i, indices[k]]).filter(|[i, j]| i != j));
            out[0] += sums.energy.sum().double();
            for c in 0..3 {
                let [force, moment] = [sums.force[c].sum().double(), sums.moment[c].sum().double()];
                out[1 + c] += 0.5 * (force - moment);
                out[4 + c] += 0.5 * (force + moment);
            }
        }
    }
}

#[inline(always)]
fn add_to<S: Simd, E: Real>(row: &mut [E], values: Lanes<S, E>) {
    let sum = &mut E::registers_mut::<S>(row)[0];
    *sum = E::add(values.simd, *sum, values.values);
}

/// What a target sees.
struct Seen<'a, S: Simd, E: Real> {
    rules: &'a Rules<E>,
    rows: &'a [Vec<E>; 9],
    own: Bars<S, E>,
    sums: Sums<S, E>,
    /// The sources that no rule serves, and how many they are.
    list: &'a mut [usize],
    count: usize,
}

impl<'a, S: Simd, E: Real> Seen<'a, S, E> {
    /// Adds the sources in the register from `first` on, and tells the force on the target and its
    /// moment about their middles.
    #[inline(always)]
    fn add<M: Machine<S>>(&mut self, machine: M, first: usize, alone: bool) -> [Vectors<S, E>; 2] {
        let mut other = [self.own.charge; 9];
        for (other, row) in other.iter_mut().zip(self.rows) {
            *other = Lanes::load(self.own.charge.simd, &row[first..]);
        }
        let mut other = Bars::new(other);
        let r = minus(&self.own.middle, &other.middle);
        other.charge = other.charge * self.own.charge;
        let rule = self.rule(machine, &r, &mut other, first);
        let sums = sums(machine, rule, &self.own, &other, &r);
        // Inverse roots are doubled.
        let charge = other.charge * other.charge.of(0.125);
        let [none, v, vv] = scaled(&[sums[0], sums[2], sums[5]], charge);
        let [u, uv, uu] = scaled(&[sums[1], sums[4], sums[3]], charge);
        let vectors = [&r, &self.own.half, &other.half];
        let force = combined(vectors, [none, u, v]);
        let moment = combined(vectors, [u, uu, uv]);
        let other_moment = combined(vectors, [v, uv, vv]);
        let energy =
            dot(&force, &r) + dot(&moment, &self.own.half) - dot(&other_moment, &other.half);
        let sums = &mut self.sums;
        let share = charge.of(if alone { 0.5 } else { 1.0 });
        sums.energy = energy.times_plus(share, sums.energy);
        for c in 0..3 {
            sums.force[c] = sums.force[c] + force[c];
            sums.moment[c] = sums.moment[c] + moment[c];
        }
        [force, other_moment]
    }

    /// The rule that serves all of `other`; what none serves is listed and loses its charge.
    #[inline(always)]
    fn rule<M: Machine<S>>(
        &mut self,
        machine: M,
        r: &Vectors<S, E>,
        other: &mut Bars<S, E>,
        first: usize,
    ) -> &'a [Node<E>] {
        let (simd, rules) = (other.charge.simd, self.rules.all());
        let last = rules.len() - 1;
        let reach = (self.own.length + other.length) * Lanes::all(simd, self.rules.reach());
        if !dot(r, r).any_below(reach * reach) {
            return &rules[0].points;
        }
        let mut nearness = nearness(machine, &self.own, other, r);
        let least = Lanes::all(simd, rules[last].least);
        if nearness.any_below(least) {
            for (k, nearness) in nearness.numbers().iter().enumerate() {
                self.list[self.count] = first + k;
                self.count += usize::from(*nearness < rules[last].least);
            }
            other.charge = nearness.below(least, least.of(0.0), other.charge);
            nearness = nearness.below(least, least.of(0.9e30), nearness);
        }
        for rule in &rules[..last] {
            if !nearness.any_below(Lanes::all(simd, rule.least)) {
                return &rule.points;
            }
        }
        &rules[last].points
    }
}

/// At most the square of the sum of the distances of a point of one segment from the ends of the other,
/// over the length of this; the less of both ways round. With the distance p across the axis and g
/// beyond the end it is `((2 g + L)^2 + 4 p^2)/L^2` by the triangle inequality.
#[inline(always)]
fn nearness<S: Simd, E: Real, M: Machine<S>>(
    machine: M,
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
        // The square of the difference of both roots.
        let product = across2 * lean2;
        let twice = product * E::double_inverse_root(machine, product);
        let across2 = lean2.below(across2, across2 + lean2 - twice, zero) * (inverse * inverse);
        let gap = (along_bar - reach) * inverse - r2.of(0.5);
        let gap = gap.below(zero, zero, gap);
        let length = gap.times_plus(two, r2.of(1.0));
        let square = length.times_plus(length, across2 * four);
        least = square.below(least, square, least);
    }
    least
}

/// Means of `u^i v^j/r^3` over both segments, whose middles are `r` from each other, by a rule, times 8: for (i, j) = (0, 0), (1, 0), (0, 1), (2, 0), (1, 1) and
/// (0, 2).
///
/// Two points with the places u and v are `r + u own - v other` from each other. Only the part of it along
/// `other` depends on v.
#[inline(always)]
fn sums<S: Simd, E: Real, M: Machine<S>>(
    machine: M,
    rule: &[Node<E>],
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &Vectors<S, E>,
) -> [Lanes<S, E>; 6] {
    let (zero, softening) = (other.charge.of(0.0), other.charge.of(SOFTENING));
    let simd = zero.simd;
    let tangent = scaled(&other.half, other.inverse_length + other.inverse_length);
    let half = other.length * zero.of(0.5);
    let (r_along, own_along) = (dot(r, &tangent), dot(&own.half, &tangent));
    let r_across = along(r, &tangent, -r_along);
    let own_across = along(&own.half, &tangent, -own_along);
    let mut sums = [zero; 6];
    for &Node { place, square, weight } in rule {
        let (place, square) = (Lanes::all(simd, place), Lanes::all(simd, square));
        let weight = Lanes::all(simd, weight);
        let across = along(&r_across, &own_across, place);
        let across2 = across[2].times_plus(across[2], softening);
        let across2 = across[1].times_plus(across[1], across[0].times_plus(across[0], across2));
        let here = own_along.times_plus(place, r_along);
        let mut powers = [zero; 3];
        for &Node { place, square, weight } in rule {
            let beside = half.times_from(Lanes::all(simd, place), here);
            let inverse = E::double_inverse_root(machine, beside.times_plus(beside, across2));
            let share = (inverse * Lanes::all(simd, weight)) * (inverse * inverse);
            powers[0] = powers[0] + share;
            powers[1] = share.times_plus(Lanes::all(simd, place), powers[1]);
            powers[2] = share.times_plus(Lanes::all(simd, square), powers[2]);
        }
        powers = scaled(&powers, weight);
        sums[0] = sums[0] + powers[0];
        sums[1] = powers[0].times_plus(place, sums[1]);
        sums[2] = sums[2] + powers[1];
        sums[3] = powers[0].times_plus(square, sums[3]);
        sums[4] = powers[1].times_plus(place, sums[4]);
        sums[5] = sums[5] + powers[2];
    }
    sums
}

/// `a x + b y - c z`.
#[inline(always)]
fn combined<S: Simd, E: Real>(
    [a, b, c]: [&Vectors<S, E>; 3],
    [x, y, z]: [Lanes<S, E>; 3],
) -> Vectors<S, E> {
    along(&along(&scaled(a, x), b, y), c, -z)
}
