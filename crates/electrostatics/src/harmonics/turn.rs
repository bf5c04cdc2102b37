//! Turns about an axis and shifts along it.

use super::tables::{Matrix, ROWS, Swap, Tables, count};
use super::translate::{Kind, LANES, Shift};
use pulp::Simd;

/// The rotation that takes the offsets onto the z axis, and lengths along it.
pub(super) struct Turn<S: Simd> {
    simd: S,
    azimuth: [S::f64s; 2],
    polar: [S::f64s; 2],
    distance: S::f64s,
    scales: [S::f64s; 2],
}

impl<S: Simd> Turn<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, shifts: &[Shift]) -> Self {
        // Offsets and both scales; those of lanes without a shift are along z.
        let mut rows = [0.0, 0.0, 1.0, 1.0, 1.0].map(|x| [x; LANES]);
        for (lane, Shift { offset, scales, .. }) in shifts.iter().enumerate() {
            let values = [offset.x, offset.y, offset.z, scales[0], scales[1]];
            rows.iter_mut().zip(values).for_each(|(row, value)| row[lane] = value);
        }
        let [x, y, z, from, to] = [0, 1, 2, 3, 4].map(|k| S::as_simd_f64s(&rows[k]).0[0]);
        let length = |a, b| simd.sqrt_f64s(simd.mul_add_f64s(a, a, simd.mul_f64s(b, b)));
        let flat = length(x, y);
        let distance = length(flat, z);
        // An angle that is not defined is none.
        let angle = |adjacent, opposite, length| {
            let positive = simd.greater_than_f64s(length, simd.splat_f64s(0.0));
            let over = |x, none| {
                let none = simd.splat_f64s(none);
                simd.select_f64s(positive, simd.div_f64s(x, length), none)
            };
            [over(adjacent, 1.0), over(opposite, 0.0)]
        };
        let (azimuth, polar) = (angle(x, y, flat), angle(z, flat, distance));
        Self { simd, azimuth, polar, distance, scales: [from, to] }
    }

    /// Into the frame whose z axis is the offset.
    #[inline(always)]
    pub(super) fn forth(
        &self,
        tables: &Tables,
        order: usize,
        a: &mut [S::f64s],
        b: &mut [S::f64s],
    ) {
        self.about_z(tables, order, self.azimuth, a);
        swap(self.simd, tables, order, a, b);
        self.about_z(tables, order, self.minus(self.polar), b);
        swap(self.simd, tables, order, b, a);
    }

    /// Back from it.
    #[inline(always)]
    pub(super) fn back(&self, tables: &Tables, order: usize, a: &mut [S::f64s], b: &mut [S::f64s]) {
        swap(self.simd, tables, order, a, b);
        self.about_z(tables, order, self.polar, b);
        swap(self.simd, tables, order, b, a);
        self.about_z(tables, order, self.minus(self.azimuth), a);
    }

    #[inline(always)]
    fn minus(&self, [cosine, sine]: [S::f64s; 2]) -> [S::f64s; 2] {
        [cosine, self.simd.sub_f64s(self.simd.splat_f64s(0.0), sine)]
    }

    /// Reduces the azimuth by the angle with this cosine and sine.
    #[inline(always)]
    fn about_z(&self, tables: &Tables, order: usize, angle: [S::f64s; 2], a: &mut [S::f64s]) {
        let mut multiple = angle;
        for (m, steps) in tables.steps[..=order].iter().enumerate().skip(1) {
            for step in &steps[..=order - m] {
                let [i, j] = step.places;
                [a[i], a[j]] = turned(self.simd, multiple, [a[i], a[j]]);
            }
            multiple = self.minus(turned(self.simd, angle, self.minus(multiple)));
        }
    }
}

/// The vector `[x, y]` turned back by the angle with this cosine and sine.
#[inline(always)]
fn turned<S: Simd>(simd: S, [c, s]: [S::f64s; 2], [x, y]: [S::f64s; 2]) -> [S::f64s; 2] {
    let cosine = simd.mul_add_e_f64s(c, x, simd.mul_f64s(s, y));
    [cosine, simd.negate_mul_add_e_f64s(s, x, simd.mul_f64s(c, y))]
}

/// Exchanges y and z.
#[inline(always)]
fn swap<S: Simd>(simd: S, tables: &Tables, order: usize, a: &[S::f64s], b: &mut [S::f64s]) {
    b[0] = a[0];
    for swaps in &tables.swaps[1..=order] {
        for Swap { from, to, matrix } in swaps {
            product(simd, matrix, &a[from.clone()], &mut b[to.clone()]);
        }
    }
}

/// Scratch space for shifts along the z axis.
pub(super) struct Axis<'a, V> {
    before: &'a mut [V],
    after: &'a mut [V],
    steps: &'a mut [V],
    x: &'a mut [V],
    y: &'a mut [V],
}

impl<'a, V: Copy> Axis<'a, V> {
    /// Numbers in each lane that degrees up to `order` need.
    pub(super) fn size(order: usize) -> usize {
        5 * (order + 1)
    }

    /// Takes the space from `work`.
    #[inline(always)]
    pub(super) fn new(order: usize, work: &'a mut [V]) -> Self {
        let (before, rest) = work.split_at_mut(order + 1);
        let (after, rest) = rest.split_at_mut(order + 1);
        let (steps, rest) = rest.split_at_mut(order + 1);
        let (x, y) = rest.split_at_mut(order + 1);
        Self { before, after, steps, x, y }
    }

    /// Shifts along the z axis, from `a` to `a`.
    #[inline(always)]
    pub(super) fn shift<S: Simd<f64s = V>>(
        &mut self,
        simd: S,
        tables: &Tables,
        kind: Kind,
        [p, q]: [usize; 2],
        turn: &Turn<S>,
        a: &mut [V],
        b: &mut [V],
    ) {
        let [from, to] = turn.scales;
        let one = simd.splat_f64s(1.0);
        // Factors per degree before and after, and the length of the shift.
        let (before, after, step) = match kind {
            // The charges move backward as the center moves forward.
            Kind::Multipole => {
                let step = simd.div_f64s(turn.distance, simd.mul_f64s(to, simd.splat_f64s(-1.0)));
                (simd.div_f64s(from, to), one, step)
            }
            Kind::Far => {
                let inverse = simd.div_f64s(one, turn.distance);
                (simd.mul_f64s(from, inverse), simd.mul_f64s(to, inverse), inverse)
            }
            Kind::Local => (one, simd.div_f64s(to, from), simd.div_f64s(turn.distance, from)),
        };
        let far = kind == Kind::Far;
        powers(simd, before, one, &mut self.before[..=p]);
        powers(simd, after, if far { step } else { one }, &mut self.after[..=q]);
        if !far {
            powers(simd, step, one, &mut self.steps[..=p.max(q)]);
        }
        for m in 0..=q {
            for part in 0..if m > 0 { 2 } else { 1 } {
                let [inputs, rows] = [(p + 1).saturating_sub(m), q + 1 - m];
                let (x, y) = (&mut self.x[..inputs], &mut self.y[..rows]);
                for (l, x) in x.iter_mut().enumerate() {
                    let place = tables.steps[m][l].places[part];
                    *x = simd.mul_f64s(a[place], self.before[l + m]);
                }
                match kind {
                    Kind::Far => product(simd, &tables.far[m], x, y),
                    _ => triangle(simd, &tables.shifts[m], kind, self.steps, x, y),
                }
                for (n, y) in y.iter().enumerate() {
                    b[tables.steps[m][n].places[part]] = simd.mul_f64s(*y, self.after[n + m]);
                }
            }
        }
        a[..count(q)].copy_from_slice(&b[..count(q)]);
    }
}

/// `first` times the powers of `base`.
#[inline(always)]
fn powers<S: Simd>(simd: S, base: S::f64s, first: S::f64s, out: &mut [S::f64s]) {
    let mut power = first;
    for out in out {
        *out = power;
        power = simd.mul_f64s(power, base);
    }
}

/// The shift of a multipole, or of a local expansion, whose matrix is the transpose.
#[inline(always)]
fn triangle<S: Simd>(
    simd: S,
    matrix: &[Vec<f64>],
    kind: Kind,
    steps: &[S::f64s],
    x: &[S::f64s],
    y: &mut [S::f64s],
) {
    for (n, y) in y.iter_mut().enumerate() {
        *y = simd.splat_f64s(0.0);
        for (l, x) in x.iter().enumerate() {
            let entry = match kind {
                Kind::Multipole if l <= n => matrix[n][l],
                Kind::Local if l >= n => matrix[l][n],
                _ => continue,
            };
            let factor = simd.mul_f64s(steps[n.abs_diff(l)], simd.splat_f64s(entry));
            *y = simd.mul_add_e_f64s(factor, *x, *y);
        }
    }
}

/// `out = matrix x`, where both may be shorter than the matrix.
#[inline(always)]
fn product<S: Simd>(simd: S, matrix: &Matrix, x: &[S::f64s], out: &mut [S::f64s]) {
    for (block, out) in out.chunks_mut(ROWS).enumerate() {
        let columns = matrix.block(block);
        match out.len() {
            1 => rows::<S, 1>(simd, columns, x, out),
            2 => rows::<S, 2>(simd, columns, x, out),
            3 => rows::<S, 3>(simd, columns, x, out),
            4 => rows::<S, 4>(simd, columns, x, out),
            5 => rows::<S, 5>(simd, columns, x, out),
            6 => rows::<S, 6>(simd, columns, x, out),
            7 => rows::<S, 7>(simd, columns, x, out),
            _ => rows::<S, 8>(simd, columns, x, out),
        }
    }
}

#[inline(always)]
fn rows<S: Simd, const R: usize>(
    simd: S,
    columns: &[[f64; ROWS]],
    x: &[S::f64s],
    out: &mut [S::f64s],
) {
    let mut sums = [simd.splat_f64s(0.0); R];
    for (column, x) in columns.iter().zip(x) {
        for (sum, entry) in sums.iter_mut().zip(column) {
            *sum = simd.mul_add_e_f64s(simd.splat_f64s(*entry), *x, *sum);
        }
    }
    out.copy_from_slice(&sums);
}
