//! Pairs of segments by the points of Gauss's rules, a source in each lane.

use super::columns::{Block, Columns, WIDEST};
use super::lines::{Lines, Loads, SOFTENING};
use super::rules::{Node, Rules};
use crate::lanes::{Lanes, Vectors, along, dot, minus, scaled};
use crate::machine::{Kernel, Machine, dispatch};
use crate::real::Real;
use pulp::Simd;

impl<E: Real> Columns<E> {
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
        let Columns { center, blocks, indices, alone, felt } = columns;
        let zero = Lanes::<S, E>::splat(simd, 0.0);
        let [sum, difference] = rules.reach();
        let reach = [Lanes::all(simd, sum), Lanes::all(simd, difference)];
        // The sources that no rule serves.
        let mut list = vec![0; indices.len()];
        for (&i, out) in targets.iter().zip(out) {
            let mut own = [zero; 9];
            for (own, value) in own.iter_mut().zip(lines.bar(i, *center)) {
                *own = Lanes::splat(simd, value);
            }
            let own = Bars::new(own);
            let sums = Sums { energy: zero, force: [zero; 3], moment: [zero; 3] };
            let mut seen = Seen { rules, reach, own, sums, list: &mut list, count: 0 };
            for (k, block) in blocks.iter().enumerate() {
                for part in 0..WIDEST / E::lanes::<S>() {
                    let felt = if k < *alone { None } else { Some(&mut felt[k - *alone]) };
                    seen.add(machine, block, [k, part], felt);
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

/// What a target sees.
struct Seen<'a, S: Simd, E: Real> {
    rules: &'a Rules<E>,
    /// As [`Rules::reach`].
    reach: [Lanes<S, E>; 2],
    own: Bars<S, E>,
    sums: Sums<S, E>,
    /// The sources that no rule serves, and how many they are.
    list: &'a mut [usize],
    count: usize,
}

impl<'a, S: Simd, E: Real> Seen<'a, S, E> {
    /// Adds the sources in a register: `part` of `block`, which is the `k`th; and to `felt` what they feel.
    #[inline(always)]
    fn add<M: Machine<S>>(
        &mut self,
        machine: M,
        block: &Block<E, 9>,
        [k, part]: [usize; 2],
        felt: Option<&mut Block<E, 6>>,
    ) {
        let simd = self.own.charge.simd;
        let mut other = [self.own.charge; 9];
        for (other, row) in other.iter_mut().zip(block) {
            *other = Lanes { simd, values: E::registers::<S>(row)[part] };
        }
        let mut other = Bars::new(other);
        let r = minus(&self.own.middle, &other.middle);
        other.charge = other.charge * self.own.charge;
        let first = k * WIDEST + part * E::lanes::<S>();
        let sums = match self.rule(machine, &r, &mut other, first) {
            [node, _] => of_two(machine, node, &self.own, &other, &r),
            rule => sums(machine, rule, &self.own, &other, &r),
        };
        // Inverse roots are doubled.
        let charge = other.charge * other.charge.of(0.125);
        let [none, v, vv] = scaled(&[sums[0], sums[2], sums[5]], charge);
        let [u, uv, uu] = scaled(&[sums[1], sums[4], sums[3]], charge);
        let vectors = [&r, &self.own.half, &other.half];
        let (force, moment) = (combined(vectors, [none, u, v]), combined(vectors, [u, uu, uv]));
        let own = &mut self.sums;
        let share = other.charge.of(if felt.is_some() { 0.5 } else { 0.25 });
        own.energy = (sums[6] * share).times_plus(other.charge, own.energy);
        for c in 0..3 {
            own.force[c] = own.force[c] + force[c];
            own.moment[c] = own.moment[c] + moment[c];
        }
        if let Some(felt) = felt {
            let other_moment = combined(vectors, [v, uv, vv]);
            let (forces, moments) = felt.split_at_mut(3);
            for c in 0..3 {
                add_to(&mut forces[c], part, force[c]);
                add_to(&mut moments[c], part, other_moment[c]);
            }
        }
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
        let [sum, difference] = self.reach;
        let lengths = (self.own.length + other.length) * sum;
        let unlike = (self.own.length - other.length).abs();
        let reach = unlike.times_plus(difference, lengths);
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

/// Means over both segments, whose middles are `r` from each other, by a rule: of `u^i v^j/r^3`, times 8,
/// for (i, j) = (0, 0), (1, 0), (0, 1), (2, 0), (1, 1) and (0, 2); and of `1/r`, times 2.
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
) -> [Lanes<S, E>; 7] {
    let (zero, softening) = (other.charge.of(0.0), other.charge.of(SOFTENING));
    let simd = zero.simd;
    let tangent = scaled(&other.half, other.inverse_length + other.inverse_length);
    let half = other.length * zero.of(0.5);
    let (r_along, own_along) = (dot(r, &tangent), dot(&own.half, &tangent));
    let r_across = along(r, &tangent, -r_along);
    let own_across = along(&own.half, &tangent, -own_along);
    let mut sums = [zero; 7];
    for &Node { place, square, weight } in rule {
        let (place, square) = (Lanes::all(simd, place), Lanes::all(simd, square));
        let weight = Lanes::all(simd, weight);
        let across = along(&r_across, &own_across, place);
        let across2 = across[2].times_plus(across[2], softening);
        let across2 = across[1].times_plus(across[1], across[0].times_plus(across[0], across2));
        let here = own_along.times_plus(place, r_along);
        let mut powers = [zero; 3];
        let mut energy = zero;
        for &Node { place, square, weight } in rule {
            let beside = half.times_from(Lanes::all(simd, place), here);
            let inverse = E::double_inverse_root(machine, beside.times_plus(beside, across2));
            let weighed = inverse * Lanes::all(simd, weight);
            let share = weighed * (inverse * inverse);
            energy = energy + weighed;
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
        sums[6] = energy.times_plus(weight, sums[6]);
    }
    sums
}

/// The same by the rule of two points, of which `node` is one, for segments that are not close: all four
/// distances are from the products of the three vectors.
#[inline(always)]
fn of_two<S: Simd, E: Real, M: Machine<S>>(
    machine: M,
    node: &Node<E>,
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &Vectors<S, E>,
) -> [Lanes<S, E>; 7] {
    let simd = r[0].simd;
    let (place, square) = (Lanes::all(simd, node.place), Lanes::all(simd, node.square));
    let squares = own.length.times_plus(own.length, other.length * other.length);
    let middle = squares.times_plus(square * r[0].of(0.25), dot(r, r));
    let (twice, twice_square) = (place + place, square + square);
    let ahead = dot(r, &own.half) * twice;
    let behind = dot(r, &other.half) * twice;
    let both = dot(&own.half, &other.half) * twice_square;
    let ends = [middle + ahead, middle - ahead];
    let ways = [behind + both, behind - both];
    let (mut cubes, mut energy) = ([[middle; 2]; 2], r[0].of(0.0));
    for u in 0..2 {
        for (v, square) in [ends[u] - ways[u], ends[u] + ways[u]].into_iter().enumerate() {
            let inverse = E::double_inverse_root(machine, square);
            energy = energy + inverse;
            cubes[u][v] = inverse * (inverse * inverse);
        }
    }
    let [[a, b], [c, d]] = cubes;
    let quarter = r[0].of(0.25);
    let (place, square) = (place * quarter, square * quarter);
    let none = (a + b) + (c + d);
    let u = ((a + b) - (c + d)) * place;
    let v = ((a - b) + (c - d)) * place;
    let uv = ((a - b) - (c - d)) * square;
    let uu = none * square;
    [none * quarter, u, v, uu, uv, uu, energy * quarter]
}

/// Adds to a register of a row.
#[inline(always)]
fn add_to<S: Simd, E: Real>(row: &mut [E; WIDEST], part: usize, values: Lanes<S, E>) {
    let sum = &mut E::registers_mut::<S>(row)[part];
    *sum = E::add(values.simd, *sum, values.values);
}

/// `a x + b y - c z`.
#[inline(always)]
fn combined<S: Simd, E: Real>(
    [a, b, c]: [&Vectors<S, E>; 3],
    [x, y, z]: [Lanes<S, E>; 3],
) -> Vectors<S, E> {
    along(&along(&scaled(a, x), b, y), c, -z)
}
