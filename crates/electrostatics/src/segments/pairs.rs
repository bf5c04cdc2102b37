//! Pairs of segments by the points of Gauss's rules, a source in each lane.

use super::columns::{ColumnBlock, SegmentColumns};
use super::lines::{Loads, SOFTENING, SegmentLines};
use super::rules::{Node, Rules};
use crate::vectors::{LaneVector, along, dot, minus, scaled};
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES_F32, Lane, Machine, Ways, dispatch};

impl<E: Ways> SegmentColumns<E> {
    /// Adds to `out` the loads of the `targets` by all sources, each pair by the rule that serves
    /// it, and returns the pairs that are too close for any. A target among the sources that feel
    /// nothing is no pair.
    pub(super) fn act(
        &mut self,
        lines: &SegmentLines,
        rules: &Rules<E>,
        targets: &[usize],
        out: &mut [Loads],
    ) -> Vec<[usize; 2]> {
        let mut close = Vec::new();
        dispatch(BarPairs { lines, rules, columns: self, targets, close: &mut close, out });
        close
    }
}

/// Arguments of [`SegmentColumns::act`], with the list of close pairs.
struct BarPairs<'a, E> {
    lines: &'a SegmentLines,
    rules: &'a Rules<E>,
    columns: &'a mut SegmentColumns<E>,
    targets: &'a [usize],
    close: &'a mut Vec<[usize; 2]>,
    out: &'a mut [Loads],
}

/// Segments by their middles and halves, one in each lane.
#[derive(Clone, Copy)]
struct Bars<S: Simd, E: Ways> {
    /// Middles, from the center of the sources (m).
    middle: LaneVector<S, E>,
    /// Halves of the vectors from start to end, m.
    half: LaneVector<S, E>,
    /// Lengths, m.
    length: Lane<S, E>,
    /// Inverse lengths, 1/m.
    inverse_length: Lane<S, E>,
    /// Charges.
    charge: Lane<S, E>,
}

impl<S: Simd, E: Ways> Bars<S, E> {
    /// Segments from the rows of [`SegmentLines::bars`].
    #[inline(always)]
    fn new([x, y, z, a, b, c, length, inverse_length, charge]: [Lane<S, E>; 9]) -> Self {
        Self { middle: [x, y, z], half: [a, b, c], length, inverse_length, charge }
    }
}

/// Sums over the pairs of a target.
#[derive(Clone, Copy)]
struct Sums<S: Simd, E: Ways> {
    /// Sum of `1/r`, 1/m.
    energy: Lane<S, E>,
    /// Sum of `r/r^3`, 1/m^2.
    force: LaneVector<S, E>,
    /// Sum of `r/r^3` times the place on the target, from -1 to 1.
    moment: LaneVector<S, E>,
}

impl<E: Ways> Kernel for BarPairs<'_, E> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { lines, rules, columns, targets, close, out } = self;
        let SegmentColumns { center, blocks, indices, alone, felt } = columns;
        let zero = Lane::<S, E>::splat(simd, E::from_f64(0.0));
        let [sum, difference] = rules.reach();
        let reach = [Lane::splat(simd, sum), Lane::splat(simd, difference)];
        // The sources that no rule serves.
        let mut list = vec![0; indices.len()];
        for (&i, out) in targets.iter().zip(out) {
            let mut own = [zero; 9];
            for (own, value) in own.iter_mut().zip(lines.bar(i, *center)) {
                *own = zero.lift(value);
            }
            let own = Bars::new(own);
            let sums = Sums { energy: zero, force: [zero; 3], moment: [zero; 3] };
            let mut seen = TargetView { rules, reach, own, sums, list: &mut list, count: 0 };
            for (k, block) in blocks.iter().enumerate() {
                for part in 0..LANES_F32 / E::lanes::<S>() {
                    let felt = if k < *alone { None } else { Some(&mut felt[k - *alone]) };
                    seen.add(machine, block, [k, part], felt);
                }
            }
            let TargetView { sums, count, .. } = seen;
            close.extend(list[..count].iter().map(|&k| [i, indices[k]]).filter(|[i, j]| i != j));
            out[0] += sums.energy.reduce_sum().to_f64();
            for c in 0..3 {
                let [force, moment] =
                    [sums.force[c].reduce_sum().to_f64(), sums.moment[c].reduce_sum().to_f64()];
                out[1 + c] += 0.5 * (force - moment);
                out[4 + c] += 0.5 * (force + moment);
            }
        }
    }
}

/// Sources as a target sees them.
struct TargetView<'a, S: Simd, E: Ways> {
    /// Rules for pairs.
    rules: &'a Rules<E>,
    /// Factors of [`Rules::reach`] in all lanes.
    reach: [Lane<S, E>; 2],
    /// Target, in all lanes.
    own: Bars<S, E>,
    /// Sums over the sources so far, a part in each lane.
    sums: Sums<S, E>,
    /// Lanes of the sources that no rule serves.
    list: &'a mut [usize],
    /// Number of the sources that no rule serves.
    count: usize,
}

impl<'a, S: Simd, E: Ways> TargetView<'a, S, E> {
    /// Adds the sources in a register, `part` of `block`, which is the `k`th; and to `felt` the
    /// forces and moments of these sources.
    #[inline(always)]
    fn add<M: Machine<S>>(
        &mut self,
        machine: M,
        block: &ColumnBlock<E, 9>,
        [k, part]: [usize; 2],
        felt: Option<&mut ColumnBlock<E, 6>>,
    ) {
        let simd = self.own.charge.simd();
        let mut other = [self.own.charge; 9];
        for (other, row) in other.iter_mut().zip(block) {
            *other = Lane::load(simd, row, part);
        }
        let mut other = Bars::new(other);
        let r = minus(&self.own.middle, &other.middle);
        other.charge = other.charge * self.own.charge;
        let first = k * LANES_F32 + part * E::lanes::<S>();
        let sums = match self.rule(machine, &r, &mut other, first) {
            [node, _] => of_two(machine, node, &self.own, &other, &r),
            rule => sums(machine, rule, &self.own, &other, &r),
        };
        // Inverse roots are doubled.
        let charge = other.charge * other.charge.lift(0.125);
        // The vector between two points is `r + u own - v other`, so force and moments are
        // combinations of the three vectors with the means of `u^i v^j/r^3`.
        let [none, v, vv] = scaled(&[sums[0], sums[2], sums[5]], charge);
        let [u, uv, uu] = scaled(&[sums[1], sums[4], sums[3]], charge);
        let vectors = [&r, &self.own.half, &other.half];
        let (force, moment) = (combined(vectors, [none, u, v]), combined(vectors, [u, uu, uv]));
        let own = &mut self.sums;
        let share = other.charge.lift(if felt.is_some() { 0.5 } else { 0.25 });
        own.energy = (sums[6] * share).mul_add(other.charge, own.energy);
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

    /// Rule that serves all of `other`; what none serves is listed and loses its charge.
    #[inline(always)]
    fn rule<M: Machine<S>>(
        &mut self,
        machine: M,
        r: &LaneVector<S, E>,
        other: &mut Bars<S, E>,
        first: usize,
    ) -> &'a [Node<E>] {
        let (simd, rules) = (other.charge.simd(), self.rules.all());
        let last = rules.len() - 1;
        let [sum, difference] = self.reach;
        let lengths = (self.own.length + other.length) * sum;
        let unlike = (self.own.length - other.length).abs();
        let reach = unlike.mul_add(difference, lengths);
        if !dot(r, r).less_than(reach * reach).any() {
            return &rules[0].points;
        }
        let mut nearness = nearness(machine, &self.own, other, r);
        let least = Lane::splat(simd, rules[last].least);
        if nearness.less_than(least).any() {
            for (k, nearness) in nearness.numbers().iter().enumerate() {
                self.list[self.count] = first + k;
                self.count += usize::from(*nearness < rules[last].least);
            }
            other.charge = nearness.less_than(least).select(least.lift(0.0), other.charge);
            nearness = nearness.less_than(least).select(least.lift(0.9e30), nearness);
        }
        for rule in &rules[..last] {
            if !nearness.less_than(Lane::splat(simd, rule.least)).any() {
                return &rule.points;
            }
        }
        &rules[last].points
    }
}

/// Lower bound of the square of the sum of the distances of a point of one segment from the ends of
/// the other, over the length of this; the less of both ways round. With the distance p across the
/// axis and g beyond the end it is `((2 g + L)^2 + 4 p^2)/L^2` by the triangle inequality.
#[inline(always)]
fn nearness<S: Simd, E: Ways, M: Machine<S>>(
    machine: M,
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &LaneVector<S, E>,
) -> Lane<S, E> {
    let (zero, two, four) = (r[0].lift(0.0), r[0].lift(2.0), r[0].lift(4.0));
    let r2 = dot(r, r);
    let product = dot(&own.half, &other.half).abs() * four;
    let mut least = r2.lift(0.9e30);
    for [bar, partner] in [[own, other], [other, own]] {
        // All in lengths of the bar.
        let inverse = bar.inverse_length;
        let along_bar = dot(r, &bar.half).abs() * inverse * two;
        let reach = product * inverse * r2.lift(0.5);
        let across2 = along_bar.negate_mul_add(along_bar, r2);
        let across2 = across2.less_than(zero).select(zero, across2);
        let partner2 = partner.length * partner.length * r2.lift(0.25);
        // What the partner extends across the axis.
        let lean2 = reach.negate_mul_add(reach, partner2);
        let lean2 = lean2.less_than(zero).select(zero, lean2);
        // The square of the difference of both roots.
        let product = across2 * lean2;
        let twice = product * E::double_rsqrt(machine, product);
        let across2 =
            lean2.less_than(across2).select(across2 + lean2 - twice, zero) * (inverse * inverse);
        let gap = (along_bar - reach) * inverse - r2.lift(0.5);
        let gap = gap.less_than(zero).select(zero, gap);
        let length = gap.mul_add(two, r2.lift(1.0));
        let square = length.mul_add(length, across2 * four);
        least = square.less_than(least).select(square, least);
    }
    least
}

/// Means over both segments, whose middles are `r` from each other, by a rule: of `u^i v^j/r^3`,
/// times 8, for (i, j) = (0, 0), (1, 0), (0, 1), (2, 0), (1, 1) and (0, 2); and of `1/r`, times 2.
///
/// Two points with the places u and v are `r + u own - v other` from each other. Only the part of
/// it along `other` depends on v.
#[inline(always)]
fn sums<S: Simd, E: Ways, M: Machine<S>>(
    machine: M,
    rule: &[Node<E>],
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &LaneVector<S, E>,
) -> [Lane<S, E>; 7] {
    let (zero, softening) = (other.charge.lift(0.0), other.charge.lift(SOFTENING));
    let simd = zero.simd();
    let tangent = scaled(&other.half, other.inverse_length + other.inverse_length);
    let half = other.length * zero.lift(0.5);
    let (r_along, own_along) = (dot(r, &tangent), dot(&own.half, &tangent));
    let r_across = along(r, &tangent, -r_along);
    let own_across = along(&own.half, &tangent, -own_along);
    let mut sums = [zero; 7];
    for &Node { place, square, weight } in rule {
        let (place, square) = (Lane::splat(simd, place), Lane::splat(simd, square));
        let weight = Lane::splat(simd, weight);
        let across = along(&r_across, &own_across, place);
        let across2 = across[2].mul_add(across[2], softening);
        let across2 = across[1].mul_add(across[1], across[0].mul_add(across[0], across2));
        let here = own_along.mul_add(place, r_along);
        let mut powers = [zero; 3];
        let mut energy = zero;
        for &Node { place, square, weight } in rule {
            let beside = half.negate_mul_add(Lane::splat(simd, place), here);
            let inverse = E::double_rsqrt(machine, beside.mul_add(beside, across2));
            let weighed = inverse * Lane::splat(simd, weight);
            let share = weighed * (inverse * inverse);
            energy = energy + weighed;
            powers[0] = powers[0] + share;
            powers[1] = share.mul_add(Lane::splat(simd, place), powers[1]);
            powers[2] = share.mul_add(Lane::splat(simd, square), powers[2]);
        }
        powers = scaled(&powers, weight);
        sums[0] = sums[0] + powers[0];
        sums[1] = powers[0].mul_add(place, sums[1]);
        sums[2] = sums[2] + powers[1];
        sums[3] = powers[0].mul_add(square, sums[3]);
        sums[4] = powers[1].mul_add(place, sums[4]);
        sums[5] = sums[5] + powers[2];
        sums[6] = energy.mul_add(weight, sums[6]);
    }
    sums
}

/// Means as those of [`sums`], by the rule of two points, of which `node` is one, for segments that
/// are not close: all four distances are from the products of the three vectors.
#[inline(always)]
fn of_two<S: Simd, E: Ways, M: Machine<S>>(
    machine: M,
    node: &Node<E>,
    own: &Bars<S, E>,
    other: &Bars<S, E>,
    r: &LaneVector<S, E>,
) -> [Lane<S, E>; 7] {
    let simd = r[0].simd();
    let (place, square) = (Lane::splat(simd, node.place), Lane::splat(simd, node.square));
    let squares = own.length.mul_add(own.length, other.length * other.length);
    let middle = squares.mul_add(square * r[0].lift(0.25), dot(r, r));
    let (twice, twice_square) = (place + place, square + square);
    let ahead = dot(r, &own.half) * twice;
    let behind = dot(r, &other.half) * twice;
    let both = dot(&own.half, &other.half) * twice_square;
    let ends = [middle + ahead, middle - ahead];
    let ways = [behind + both, behind - both];
    let (mut cubes, mut energy) = ([[middle; 2]; 2], r[0].lift(0.0));
    for u in 0..2 {
        for (v, square) in [ends[u] - ways[u], ends[u] + ways[u]].into_iter().enumerate() {
            let inverse = E::double_rsqrt(machine, square);
            energy = energy + inverse;
            cubes[u][v] = inverse * (inverse * inverse);
        }
    }
    let [[a, b], [c, d]] = cubes;
    let quarter = r[0].lift(0.25);
    let (place, square) = (place * quarter, square * quarter);
    let none = (a + b) + (c + d);
    let u = ((a + b) - (c + d)) * place;
    let v = ((a - b) + (c - d)) * place;
    let uv = ((a - b) - (c - d)) * square;
    let uu = none * square;
    [none * quarter, u, v, uu, uv, uu, energy * quarter]
}

/// Adds `values` to the register `part` of a row.
#[inline(always)]
fn add_to<S: Simd, E: Ways>(row: &mut [E; LANES_F32], part: usize, values: Lane<S, E>) {
    (Lane::load(values.simd(), row, part) + values).store(row, part);
}

/// Combination `a x + b y - c z` of vectors.
#[inline(always)]
fn combined<S: Simd, E: Ways>(
    [a, b, c]: [&LaneVector<S, E>; 3],
    [x, y, z]: [Lane<S, E>; 3],
) -> LaneVector<S, E> {
    along(&along(&scaled(a, x), b, y), c, -z)
}
