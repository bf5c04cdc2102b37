//! Turns about an axis and shifts along it, of some registers of expansions at once.

use super::products::{TurnBlock, far, product, triangle};
use super::shift::{Shift, TranslationKind};
use super::translation_tables::{Coefficient, Swap, TranslationTables};
use pulp::Simd;
use rapunzel_lanes::{LANES_F32, Real};

/// Count of the numbers in each lane of a block that [`AxisTurn`] needs for degrees up to `order`.
pub(super) const fn turn_size(order: usize) -> usize {
    // Two angles, three powers, three sets of one degree or m, all coefficients with sines for m =
    // 0.
    4 * (order + 1) + 3 * (order + 1) + 3 * (2 * order + 2) + (order + 1) * (order + 2)
}

/// Rotation that takes the offsets onto the z axis, and the shift along it.
pub(super) struct AxisTurn<'a, S: Simd, E: Coefficient, const C: usize> {
    simd: S,
    moves: &'static TranslationTables<E>,
    kind: TranslationKind,
    order: usize,
    /// Cosines and sines of the multiples of the azimuth, and of the negative polar angle.
    angles: [&'a mut [[TurnBlock<S, E, C>; 2]]; 2],
    /// Factors of each degree before the shift.
    before: &'a mut [TurnBlock<S, E, C>],
    /// Factors of each degree after the shift.
    after: &'a mut [TurnBlock<S, E, C>],
    /// Powers of the length of the shift.
    steps: &'a mut [TurnBlock<S, E, C>],
    /// Coefficients of one degree, before and after an exchange of y and z.
    degree: [&'a mut [TurnBlock<S, E, C>]; 2],
    /// Cosines and sines of one m, for each degree from m on.
    rows: &'a mut [[TurnBlock<S, E, C>; 2]],
    /// Cosines and sines of all degrees in the frame of the axis, by m and then by the degree.
    axis: &'a mut [[TurnBlock<S, E, C>; 2]],
}

impl<'a, S: Simd, E: Coefficient, const C: usize> AxisTurn<'a, S, E, C> {
    /// Rotation for the `shifts` of expansions of degree up to `order`, in the space `work` for
    /// this degree or more.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        kind: TranslationKind,
        order: usize,
        shifts: &[Shift<E>],
        work: &'a mut [TurnBlock<S, E, C>],
    ) -> Self {
        let size = order + 1;
        let (azimuth, rest) = work.split_at_mut(2 * size);
        let (polar, rest) = rest.split_at_mut(2 * size);
        let (before, rest) = rest.split_at_mut(size);
        let (after, rest) = rest.split_at_mut(size);
        let (steps, rest) = rest.split_at_mut(size);
        let (degree, rest) = rest.split_at_mut(2 * order + 1);
        let (other, rest) = rest.split_at_mut(2 * order + 1);
        let (rows, axis) = rest.split_at_mut(2 * size);
        let mut turn = Self {
            simd,
            moves: E::moves(),
            kind,
            order,
            angles: [azimuth.as_chunks_mut().0, polar.as_chunks_mut().0],
            before,
            after,
            steps,
            degree: [degree, other],
            rows: rows.as_chunks_mut().0,
            axis: axis.as_chunks_mut().0,
        };
        let lanes = E::lanes::<S>();
        for c in 0..C {
            turn.prepare(c, shifts.get(c * lanes..).unwrap_or(&[]));
        }
        turn
    }

    /// Finds angles and powers of the first of the `shifts`, one for each lane, in the registers
    /// `c`.
    #[inline(always)]
    fn prepare(&mut self, c: usize, shifts: &[Shift<E>]) {
        let simd = self.simd;
        // Offsets and both scales; those of lanes without a shift are along z.
        let mut rows = [0.0, 0.0, 1.0, 1.0, 1.0].map(|x| [E::from_f64(x); LANES_F32]);
        for (lane, Shift { offset, scales, .. }) in shifts.iter().take(E::lanes::<S>()).enumerate()
        {
            let values = [offset.x, offset.y, offset.z, scales[0], scales[1]];
            rows.iter_mut().zip(values).for_each(|(row, value)| row[lane] = E::from_f64(value));
        }
        let mut values = [E::splat(simd, E::from_f64(0.0)); 5];
        for (value, row) in values.iter_mut().zip(&rows) {
            *value = E::registers::<S>(row)[0];
        }
        let [x, y, z, from, to] = values;
        // Polar angles of the offset: a turn by the azimuth about z and by the negative polar angle
        // about y takes it onto z. Their multiples are by the addition theorem.
        let (flat, azimuth) = polar::<S, E>(simd, [x, y]);
        let (distance, [cosine, sine]) = polar::<S, E>(simd, [z, flat]);
        multiples::<S, E, C>(simd, azimuth, c, self.angles[0]);
        multiples::<S, E, C>(simd, [cosine, E::neg(simd, sine)], c, self.angles[1]);

        let one = E::splat(simd, E::from_f64(1.0));
        // Factors per degree before and after, and the length of the shift.
        let (before, first, after, step) = match self.kind {
            // The charges move backward as the center moves forward.
            TranslationKind::Multipole => {
                (E::div(simd, from, to), one, one, { E::neg(simd, E::div(simd, distance, to)) })
            }
            TranslationKind::Far(_) => {
                let inverse = E::div(simd, one, distance);
                (E::mul(simd, from, inverse), inverse, E::mul(simd, to, inverse), one)
            }
            TranslationKind::Local => {
                (one, one, E::div(simd, to, from), E::div(simd, distance, from))
            }
        };
        powers::<S, E, C>(simd, before, one, c, self.before);
        powers::<S, E, C>(simd, after, first, c, self.after);
        powers::<S, E, C>(simd, step, one, c, self.steps);
    }

    /// Turns the coefficients `a` of the degree `n` into the frame whose z axis is the offset.
    #[inline(always)]
    pub(super) fn forth(&mut self, n: usize, a: &mut [TurnBlock<S, E, C>]) {
        let (simd, places) = (self.simd, &self.moves.places[n]);
        let [x, y] = self.degree.each_mut().map(|degree| &mut degree[..2 * n + 1]);
        about_z::<S, E, C, false>(simd, places, self.angles[0], a);
        swap::<S, E, C>(simd, &self.moves.swaps[n], a, x);
        about_z::<S, E, C, false>(simd, places, self.angles[1], x);
        swap::<S, E, C>(simd, &self.moves.swaps[n], x, y);
        for (m, &[i, j]) in places.iter().enumerate() {
            let place = place(self.order, n, m);
            let factor = self.before[n];
            let to = &mut self.axis[place];
            for c in 0..C {
                to[0][c] = E::mul(simd, y[i][c], factor[c]);
                to[1][c] = E::mul(simd, y[j][c], factor[c]);
            }
        }
    }

    /// Coefficients of the degree `n` turned back from the frame of the axis.
    #[inline(always)]
    pub(super) fn back(&mut self, n: usize) -> &[TurnBlock<S, E, C>] {
        let (simd, places) = (self.simd, &self.moves.places[n]);
        for m in (0..=n).rev() {
            let [i, j] = places[m];
            let place = place(self.order, n, m);
            let (from, factor) = (&self.axis[place], self.after[n]);
            let x = &mut self.degree[0];
            for c in 0..C {
                // For m = 0 both places are one, and the cosine is written last.
                x[j][c] = E::mul(simd, from[1][c], factor[c]);
                x[i][c] = E::mul(simd, from[0][c], factor[c]);
            }
        }
        let [x, y] = self.degree.each_mut().map(|degree| &mut degree[..2 * n + 1]);
        swap::<S, E, C>(simd, &self.moves.swaps[n], x, y);
        about_z::<S, E, C, true>(simd, places, self.angles[1], y);
        swap::<S, E, C>(simd, &self.moves.swaps[n], y, x);
        about_z::<S, E, C, true>(simd, places, self.angles[0], x);
        x
    }

    /// Shifts the coefficients of one m along z, from degrees up to `p` to those up to `q`.
    #[inline(always)]
    pub(super) fn along(&mut self, m: usize, [p, q]: [usize; 2]) {
        let (simd, first) = (self.simd, place(self.order, m, m));
        let x = &self.axis[first..first + (p + 1).saturating_sub(m)];
        let y = &mut self.rows[..q + 1 - m];
        match self.kind {
            TranslationKind::Far(least) => {
                let left_out = least.saturating_sub(m).min(x.len());
                for (block, y) in y.chunks_mut(4).enumerate() {
                    let columns = self.moves.far[m].block(block);
                    // A block of rows that are partly without the first columns is made in both
                    // ways.
                    let without = left_out.saturating_sub(4 * block).min(y.len());
                    let mut rest = [[[E::splat(simd, E::from_f64(0.0)); C]; 2]; 4];
                    if without > 0 {
                        far::<S, E, 4, C>(simd, &columns[left_out..], &x[left_out..], &mut rest);
                    }
                    match y.len() {
                        1 => far::<S, E, 1, C>(simd, columns, x, y),
                        2 => far::<S, E, 2, C>(simd, columns, x, y),
                        3 => far::<S, E, 3, C>(simd, columns, x, y),
                        _ => far::<S, E, 4, C>(simd, columns, x, y),
                    }
                    for (y, rest) in y[..without].iter_mut().zip(rest) {
                        *y = rest;
                    }
                }
            }
            kind => triangle::<S, E, C>(simd, &self.moves.shifts[m], kind, self.steps, x, y),
        }
        for (to, row) in self.axis[first..].iter_mut().zip(y) {
            *to = *row;
        }
    }
}

/// Place of `m` of the degree `n` in the frame of the axis.
const fn place(order: usize, n: usize, m: usize) -> usize {
    m * (2 * order + 1 - m) / 2 + n
}

/// Length of the vector `[x, y]`, and cosine and sine of its angle; without length the angle is
/// zero.
#[inline(always)]
fn polar<S: Simd, E: Real>(
    simd: S,
    [x, y]: [E::Register<S>; 2],
) -> (E::Register<S>, [E::Register<S>; 2]) {
    let [zero, one] = [E::splat(simd, E::from_f64(0.0)), E::splat(simd, E::from_f64(1.0))];
    let length = E::sqrt(simd, E::mul_add(simd, x, x, E::mul(simd, y, y)));
    let defined = E::less_than(simd, zero, length);
    let cosine = E::select(simd, defined, E::div(simd, x, length), one);
    (length, [cosine, E::select(simd, defined, E::div(simd, y, length), zero)])
}

/// Cosines and sines of the multiples 0, 1, 2, ... of the `angle` with this cosine and sine, in the
/// registers `c`.
#[inline(always)]
fn multiples<S: Simd, E: Real, const C: usize>(
    simd: S,
    angle: [E::Register<S>; 2],
    c: usize,
    out: &mut [[TurnBlock<S, E, C>; 2]],
) {
    let [mut cosine, mut sine] =
        [E::splat(simd, E::from_f64(1.0)), E::splat(simd, E::from_f64(0.0))];
    for out in out {
        (out[0][c], out[1][c]) = (cosine, sine);
        [cosine, sine] = turned::<S, E, true>(simd, angle, [cosine, sine]);
    }
}

/// Products of `first` with the powers 0, 1, 2, ... of `base`, in the registers `c`.
#[inline(always)]
fn powers<S: Simd, E: Real, const C: usize>(
    simd: S,
    base: E::Register<S>,
    first: E::Register<S>,
    c: usize,
    out: &mut [TurnBlock<S, E, C>],
) {
    let mut power = first;
    for out in out {
        out[c] = power;
        power = E::mul(simd, power, base);
    }
}

/// Vector `[x, y]` turned by the angle with the cosine c and the sine s: forward if `FORWARD`, else
/// backward.
#[inline(always)]
fn turned<S: Simd, E: Real, const FORWARD: bool>(
    simd: S,
    [c, s]: [E::Register<S>; 2],
    [x, y]: [E::Register<S>; 2],
) -> [E::Register<S>; 2] {
    let (cx, cy) = (E::mul(simd, c, x), E::mul(simd, c, y));
    if FORWARD {
        [E::negate_mul_add(simd, s, y, cx), E::mul_add(simd, s, x, cy)]
    } else {
        [E::mul_add(simd, s, y, cx), E::negate_mul_add(simd, s, x, cy)]
    }
}

/// Reduces the azimuth by the angle with these cosines and sines of multiples, or adds it.
#[inline(always)]
fn about_z<S: Simd, E: Real, const C: usize, const FORWARD: bool>(
    simd: S,
    places: &[[usize; 2]],
    angle: &[[TurnBlock<S, E, C>; 2]],
    x: &mut [TurnBlock<S, E, C>],
) {
    for (&[i, j], [cosine, sine]) in places[1..].iter().zip(&angle[1..]) {
        for c in 0..C {
            [x[i][c], x[j][c]] =
                turned::<S, E, FORWARD>(simd, [cosine[c], sine[c]], [x[i][c], x[j][c]]);
        }
    }
}

/// Exchanges y and z in one degree.
#[inline(always)]
fn swap<S: Simd, E: Real, const C: usize>(
    simd: S,
    swaps: &[Swap<E>; 4],
    x: &[TurnBlock<S, E, C>],
    out: &mut [TurnBlock<S, E, C>],
) {
    for Swap { from, to, matrix } in swaps {
        product::<S, E, C>(simd, matrix, &x[from.clone()], &mut out[to.clone()]);
    }
}
