//! Turns about an axis and shifts along it.

use super::tables::{Matrix, Moves, ROWS, Swap, count};
use super::translate::{Kind, LANES, Shift};
use crate::real::Real;
use pulp::Simd;

/// The rotation that takes the offsets onto the z axis, and lengths along it.
pub(super) struct Turn<S: Simd, E: Real> {
    simd: S,
    azimuth: [E::Lanes<S>; 2],
    polar: [E::Lanes<S>; 2],
    distance: E::Lanes<S>,
    scales: [E::Lanes<S>; 2],
}

impl<S: Simd, E: Real> Turn<S, E> {
    #[inline(always)]
    pub(super) fn new(simd: S, shifts: &[Shift<E>]) -> Self {
        // Offsets and both scales; those of lanes without a shift are along z.
        let mut rows = [0.0, 0.0, 1.0, 1.0, 1.0].map(|x| [E::of(x); LANES]);
        for (lane, Shift { offset, scales, .. }) in shifts.iter().enumerate() {
            let values = [offset.x, offset.y, offset.z, scales[0], scales[1]];
            rows.iter_mut().zip(values).for_each(|(row, value)| row[lane] = E::of(value));
        }
        let mut values = [E::splat(simd, E::of(0.0)); 5];
        for (value, row) in values.iter_mut().zip(&rows) {
            *value = E::registers::<S>(row)[0];
        }
        let [x, y, z, from, to] = values;
        let (flat, azimuth) = polar::<S, E>(simd, [x, y]);
        let (distance, polar) = polar::<S, E>(simd, [z, flat]);
        Self { simd, azimuth, polar, distance, scales: [from, to] }
    }

    /// Into the frame whose z axis is the offset.
    #[inline(always)]
    pub(super) fn forth(
        &self,
        moves: &Moves<E>,
        order: usize,
        a: &mut [E::Lanes<S>],
        b: &mut [E::Lanes<S>],
    ) {
        self.about_z(moves, order, self.azimuth, a);
        swap::<S, E>(self.simd, moves, order, a, b);
        self.about_z(moves, order, self.minus(self.polar), b);
        swap::<S, E>(self.simd, moves, order, b, a);
    }

    /// Back from it.
    #[inline(always)]
    pub(super) fn back(
        &self,
        moves: &Moves<E>,
        order: usize,
        a: &mut [E::Lanes<S>],
        b: &mut [E::Lanes<S>],
    ) {
        swap::<S, E>(self.simd, moves, order, a, b);
        self.about_z(moves, order, self.polar, b);
        swap::<S, E>(self.simd, moves, order, b, a);
        self.about_z(moves, order, self.minus(self.azimuth), a);
    }

    #[inline(always)]
    fn minus(&self, [cosine, sine]: [E::Lanes<S>; 2]) -> [E::Lanes<S>; 2] {
        [cosine, E::neg(self.simd, sine)]
    }

    /// Reduces the azimuth by the angle with this cosine and sine.
    #[inline(always)]
    fn about_z(
        &self,
        moves: &Moves<E>,
        order: usize,
        angle: [E::Lanes<S>; 2],
        a: &mut [E::Lanes<S>],
    ) {
        let mut multiple = angle;
        for (m, places) in moves.places[..=order].iter().enumerate().skip(1) {
            for &[i, j] in &places[..=order - m] {
                [a[i], a[j]] = turned::<S, E>(self.simd, multiple, [a[i], a[j]]);
            }
            multiple = self.minus(turned::<S, E>(self.simd, angle, self.minus(multiple)));
        }
    }
}

/// Length of a vector, and cosine and sine of its angle; an angle that is not defined is none.
#[inline(always)]
fn polar<S: Simd, E: Real>(simd: S, [x, y]: [E::Lanes<S>; 2]) -> (E::Lanes<S>, [E::Lanes<S>; 2]) {
    let [zero, one] = [E::splat(simd, E::of(0.0)), E::splat(simd, E::of(1.0))];
    let length = E::sqrt(simd, E::mul_add(simd, x, x, E::mul(simd, y, y)));
    let cosine = E::below(simd, [zero, length], E::div(simd, x, length), one);
    (length, [cosine, E::below(simd, [zero, length], E::div(simd, y, length), zero)])
}

/// The vector `[x, y]` turned back by the angle with this cosine and sine.
#[inline(always)]
fn turned<S: Simd, E: Real>(
    simd: S,
    [c, s]: [E::Lanes<S>; 2],
    [x, y]: [E::Lanes<S>; 2],
) -> [E::Lanes<S>; 2] {
    let cosine = E::mul_add(simd, c, x, E::mul(simd, s, y));
    [cosine, E::mul_from(simd, s, x, E::mul(simd, c, y))]
}

/// Exchanges y and z.
#[inline(always)]
fn swap<S: Simd, E: Real>(
    simd: S,
    moves: &Moves<E>,
    order: usize,
    a: &[E::Lanes<S>],
    b: &mut [E::Lanes<S>],
) {
    b[0] = a[0];
    for swaps in &moves.swaps[1..=order] {
        for Swap { from, to, matrix } in swaps {
            product::<S, E>(simd, matrix, &a[from.clone()], &mut b[to.clone()]);
        }
    }
}

/// Numbers in each lane that [`Axis`] needs for degrees up to `order`.
pub(super) const fn axis_size(order: usize) -> usize {
    5 * (order + 1)
}

/// Scratch space for shifts along the z axis.
pub(super) struct Axis<'a, S: Simd, E: Real> {
    before: &'a mut [E::Lanes<S>],
    after: &'a mut [E::Lanes<S>],
    steps: &'a mut [E::Lanes<S>],
    x: &'a mut [E::Lanes<S>],
    y: &'a mut [E::Lanes<S>],
}

impl<'a, S: Simd, E: Real> Axis<'a, S, E> {
    /// Takes the space from `work`.
    #[inline(always)]
    pub(super) fn new(order: usize, work: &'a mut [E::Lanes<S>]) -> Self {
        let (before, rest) = work.split_at_mut(order + 1);
        let (after, rest) = rest.split_at_mut(order + 1);
        let (steps, rest) = rest.split_at_mut(order + 1);
        let (x, y) = rest.split_at_mut(order + 1);
        Self { before, after, steps, x, y }
    }

    /// Shifts along the z axis, from `a` to `a`.
    #[inline(always)]
    pub(super) fn shift(
        &mut self,
        kind: Kind,
        [p, q]: [usize; 2],
        turn: &Turn<S, E>,
        a: &mut [E::Lanes<S>],
        b: &mut [E::Lanes<S>],
    ) {
        let (simd, moves, [from, to]) = (turn.simd, E::moves(), turn.scales);
        let one = E::splat(simd, E::of(1.0));
        // Factors per degree before and after, and the length of the shift.
        let (before, after, step) = match kind {
            // The charges move backward as the center moves forward.
            Kind::Multipole => {
                let step =
                    E::div(simd, turn.distance, E::mul(simd, to, E::splat(simd, E::of(-1.0))));
                (E::div(simd, from, to), one, step)
            }
            Kind::Far => {
                let inverse = E::div(simd, one, turn.distance);
                (E::mul(simd, from, inverse), E::mul(simd, to, inverse), inverse)
            }
            Kind::Local => (one, E::div(simd, to, from), E::div(simd, turn.distance, from)),
        };
        let far = kind == Kind::Far;
        powers::<S, E>(simd, before, one, &mut self.before[..=p]);
        powers::<S, E>(simd, after, if far { step } else { one }, &mut self.after[..=q]);
        if !far {
            powers::<S, E>(simd, step, one, &mut self.steps[..=p.max(q)]);
        }
        for m in 0..=q {
            for part in 0..if m > 0 { 2 } else { 1 } {
                let [inputs, rows] = [(p + 1).saturating_sub(m), q + 1 - m];
                let (x, y) = (&mut self.x[..inputs], &mut self.y[..rows]);
                for (l, x) in x.iter_mut().enumerate() {
                    let place = moves.places[m][l][part];
                    *x = E::mul(simd, a[place], self.before[l + m]);
                }
                match kind {
                    Kind::Far => product::<S, E>(simd, &moves.far[m], x, y),
                    _ => triangle::<S, E>(simd, &moves.shifts[m], kind, self.steps, x, y),
                }
                for (n, y) in y.iter().enumerate() {
                    b[moves.places[m][n][part]] = E::mul(simd, *y, self.after[n + m]);
                }
            }
        }
        a[..count(q)].copy_from_slice(&b[..count(q)]);
    }
}

/// `first` times the powers of `base`.
#[inline(always)]
fn powers<S: Simd, E: Real>(
    simd: S,
    base: E::Lanes<S>,
    first: E::Lanes<S>,
    out: &mut [E::Lanes<S>],
) {
    let mut power = first;
    for out in out {
        *out = power;
        power = E::mul(simd, power, base);
    }
}

/// The shift of a multipole, or of a local expansion, whose matrix is the transpose.
#[inline(always)]
fn triangle<S: Simd, E: Real>(
    simd: S,
    matrix: &[Vec<E>],
    kind: Kind,
    steps: &[E::Lanes<S>],
    x: &[E::Lanes<S>],
    y: &mut [E::Lanes<S>],
) {
    for (n, y) in y.iter_mut().enumerate() {
        *y = E::splat(simd, E::of(0.0));
        for (l, x) in x.iter().enumerate() {
            let entry = match kind {
                Kind::Multipole if l <= n => matrix[n][l],
                Kind::Local if l >= n => matrix[l][n],
                _ => continue,
            };
            let factor = E::mul(simd, steps[n.abs_diff(l)], E::splat(simd, entry));
            *y = E::mul_add(simd, factor, *x, *y);
        }
    }
}

/// `out = matrix x`, where both may be shorter than the matrix.
#[inline(always)]
fn product<S: Simd, E: Real>(
    simd: S,
    matrix: &Matrix<E>,
    x: &[E::Lanes<S>],
    out: &mut [E::Lanes<S>],
) {
    for (block, out) in out.chunks_mut(ROWS).enumerate() {
        let columns = matrix.block(block);
        match out.len() {
            1 => rows::<S, E, 1>(simd, columns, x, out),
            2 => rows::<S, E, 2>(simd, columns, x, out),
            3 => rows::<S, E, 3>(simd, columns, x, out),
            4 => rows::<S, E, 4>(simd, columns, x, out),
            5 => rows::<S, E, 5>(simd, columns, x, out),
            6 => rows::<S, E, 6>(simd, columns, x, out),
            7 => rows::<S, E, 7>(simd, columns, x, out),
            _ => rows::<S, E, 8>(simd, columns, x, out),
        }
    }
}

#[inline(always)]
fn rows<S: Simd, E: Real, const R: usize>(
    simd: S,
    columns: &[[E; ROWS]],
    x: &[E::Lanes<S>],
    out: &mut [E::Lanes<S>],
) {
    let mut sums = [E::splat(simd, E::of(0.0)); R];
    for (column, x) in columns.iter().zip(x) {
        for (sum, entry) in sums.iter_mut().zip(column) {
            *sum = E::mul_add(simd, E::splat(simd, *entry), *x, *sum);
        }
    }
    out.copy_from_slice(&sums);
}
