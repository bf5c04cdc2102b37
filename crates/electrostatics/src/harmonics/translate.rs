//! Expansions moved from one center to another, many at a time, one in each SIMD lane.
//!
//! All three operators turn the offset onto the z axis, shift along it, and turn back. A turn about
//! z mixes cosine and sine of one m; a turn about y is a turn about z between two exchanges of y and
//! z, whose matrices do not depend on the angle. This takes `2 p^3` multiply-adds where the plain
//! double sum takes `p^4`.

use super::MAX_ORDER;
use super::tables::{Matrix, ROWS, Swap, Tables, count};
use aligned_vec::{AVec, ConstAlign, avec};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// What becomes of the expansion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A multipole about another center (M2M).
    Multipole,
    /// A local expansion of a multipole (M2L).
    Far,
    /// A local expansion about another center (L2L).
    Local,
}

/// One expansion that is moved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shift<'a> {
    /// Its coefficients, at least up to the order in use.
    pub(crate) coefficients: &'a [f64],
    /// From its center to the new one.
    pub(crate) offset: Vector3<f64>,
    /// Lengths that the coefficients are scaled with, before and after.
    pub(crate) scales: [f64; 2],
}

/// Scratch space for moving expansions.
pub(crate) struct Translator {
    tables: &'static Tables,
    work: AVec<f64, ConstAlign<64>>,
}

/// Most lanes of any register.
const LANES: usize = 8;

/// Doubles in one buffer of all lanes.
const BUFFER: usize = count(MAX_ORDER) * LANES;

impl Translator {
    pub(crate) fn new(order: usize) -> Self {
        let size = 4 * count(order) * LANES;
        Self { tables: Tables::get(), work: avec![[64]| 0.0; size.min(4 * BUFFER)] }
    }

    /// Moves all `shifts` of degree up to `orders[0]` to expansions of degree up to `orders[1]` and
    /// hands over their sum, coefficient by coefficient.
    pub(crate) fn sum(
        &mut self,
        kind: Kind,
        orders: [usize; 2],
        shifts: &[Shift],
        out: &mut [f64],
    ) {
        let Self { tables, work } = self;
        Arch::new().dispatch(Sum { tables, kind, orders, shifts, work, out: Out::Sum(out) });
    }

    /// Moves each of `shifts` to an expansion of its own; those stand in `out` one after another.
    pub(crate) fn each(
        &mut self,
        kind: Kind,
        orders: [usize; 2],
        shifts: &[Shift],
        out: &mut [f64],
    ) {
        let Self { tables, work } = self;
        Arch::new().dispatch(Sum { tables, kind, orders, shifts, work, out: Out::Each(out) });
    }
}

enum Out<'a> {
    Sum(&'a mut [f64]),
    Each(&'a mut [f64]),
}

struct Sum<'a> {
    tables: &'a Tables,
    kind: Kind,
    orders: [usize; 2],
    shifts: &'a [Shift<'a>],
    work: &'a mut [f64],
    out: Out<'a>,
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { tables, kind, orders, shifts, work, mut out } = self;
        let [p, q] = orders;
        let size = count(p.max(q));
        let (work, _) = S::as_mut_simd_f64s(work);
        let (a, rest) = work.split_at_mut(size);
        let (b, rest) = rest.split_at_mut(size);
        let (total, _) = rest.split_at_mut(size);
        let zero = simd.splat_f64s(0.0);
        total.fill(zero);
        for (chunk, shifts) in shifts.chunks(S::F64_LANES).enumerate() {
            load::<S>(&mut a[..count(p)], shifts);
            let turn = Turn::new(simd, shifts);
            turn.forth(tables, p, a, b);
            along_axis(simd, tables, kind, orders, &turn, a, b);
            turn.back(tables, q, a, b);
            match &mut out {
                Out::Sum(_) => {
                    for (total, a) in total[..count(q)].iter_mut().zip(&*a) {
                        *total = simd.add_f64s(*total, *a);
                    }
                }
                Out::Each(out) => {
                    let lanes: &[f64] = pulp::bytemuck::cast_slice(&a[..count(q)]);
                    let first = chunk * S::F64_LANES * count(q);
                    for (lane, out) in out[first..].chunks_exact_mut(count(q)).enumerate() {
                        if lane < shifts.len() {
                            for (out, a) in out.iter_mut().zip(lanes.chunks_exact(S::F64_LANES)) {
                                *out = a[lane];
                            }
                        }
                    }
                }
            }
        }
        if let Out::Sum(out) = out {
            for (out, total) in out[..count(q)].iter_mut().zip(&*total) {
                *out += simd.reduce_sum_f64s(*total);
            }
        }
    }
}

/// Puts one expansion into each lane; lanes without one hold zeros.
#[inline(always)]
fn load<S: Simd>(a: &mut [S::f64s], shifts: &[Shift]) {
    let size = a.len();
    let lanes: &mut [f64] = pulp::bytemuck::cast_slice_mut(a);
    if shifts.len() == 8 && S::F64_LANES == 8 {
        let mut rows = [&shifts[0].coefficients[..size]; 8];
        for (row, shift) in rows.iter_mut().zip(shifts) {
            *row = &shift.coefficients[..size];
        }
        for (i, lane) in lanes.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            for k in 0..8 {
                lane[k] = rows[k][i];
            }
        }
        return;
    }
    lanes.fill(0.0);
    for (k, shift) in shifts.iter().enumerate() {
        for (lane, c) in lanes.chunks_exact_mut(S::F64_LANES).zip(&shift.coefficients[..size]) {
            lane[k] = *c;
        }
    }
}

#[inline(always)]
fn lanes<S: Simd>(values: &[f64; LANES]) -> S::f64s {
    S::as_simd_f64s(values).0[0]
}

/// The rotation that takes the offsets onto the z axis, and lengths along it.
struct Turn<S: Simd> {
    simd: S,
    azimuth: [S::f64s; 2],
    polar: [S::f64s; 2],
    distance: S::f64s,
    scales: [S::f64s; 2],
}

impl<S: Simd> Turn<S> {
    #[inline(always)]
    fn new(simd: S, shifts: &[Shift]) -> Self {
        // Cosine and sine of the azimuth, of the polar angle, distance, both scales.
        let mut rows = [1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0].map(|x| [x; LANES]);
        for (lane, shift) in shifts.iter().enumerate() {
            let [x, y, z] = shift.offset.into();
            let flat = (x * x + y * y).sqrt();
            let distance = (flat * flat + z * z).sqrt();
            if flat > 0.0 {
                [rows[0][lane], rows[1][lane]] = [x / flat, y / flat];
            }
            if distance > 0.0 {
                [rows[2][lane], rows[3][lane]] = [z / distance, flat / distance];
            }
            [rows[4][lane], rows[5][lane], rows[6][lane]] =
                [distance, shift.scales[0], shift.scales[1]];
        }
        Self {
            simd,
            azimuth: [lanes::<S>(&rows[0]), lanes::<S>(&rows[1])],
            polar: [lanes::<S>(&rows[2]), lanes::<S>(&rows[3])],
            distance: lanes::<S>(&rows[4]),
            scales: [lanes::<S>(&rows[5]), lanes::<S>(&rows[6])],
        }
    }

    /// Into the frame whose z axis is the offset.
    #[inline(always)]
    fn forth(&self, tables: &Tables, order: usize, a: &mut [S::f64s], b: &mut [S::f64s]) {
        self.about_z(tables, order, self.azimuth, a);
        swap(self.simd, tables, order, a, b);
        self.about_z(tables, order, self.minus(self.polar), b);
        swap(self.simd, tables, order, b, a);
    }

    /// Back from it.
    #[inline(always)]
    fn back(&self, tables: &Tables, order: usize, a: &mut [S::f64s], b: &mut [S::f64s]) {
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

/// Shifts along the z axis, from `a` to `a`.
#[inline(always)]
fn along_axis<S: Simd>(
    simd: S,
    tables: &Tables,
    kind: Kind,
    [p, q]: [usize; 2],
    turn: &Turn<S>,
    a: &mut [S::f64s],
    b: &mut [S::f64s],
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
    let before = powers(simd, before, one, p);
    let after = powers(simd, after, if far { step } else { one }, q);
    let steps = if far { before } else { powers(simd, step, one, p.max(q)) };
    let mut x = [simd.splat_f64s(0.0); MAX_ORDER + 1];
    let mut y = x;
    for m in 0..=q {
        for part in 0..if m > 0 { 2 } else { 1 } {
            let [inputs, rows] = [(p + 1).saturating_sub(m), q + 1 - m];
            for (l, x) in x[..inputs].iter_mut().enumerate() {
                let place = tables.steps[m][l].places[part];
                *x = simd.mul_f64s(a[place], before[l + m]);
            }
            match kind {
                Kind::Far => product(simd, &tables.far[m], &x[..inputs], &mut y[..rows]),
                _ => triangle(simd, &tables.shifts[m], kind, &steps, &x[..inputs], &mut y[..rows]),
            }
            for (n, y) in y[..rows].iter().enumerate() {
                b[tables.steps[m][n].places[part]] = simd.mul_f64s(*y, after[n + m]);
            }
        }
    }
    a[..count(q)].copy_from_slice(&b[..count(q)]);
}

/// `first` times the powers of `base` up to `last`.
#[inline(always)]
fn powers<S: Simd>(
    simd: S,
    base: S::f64s,
    first: S::f64s,
    last: usize,
) -> [S::f64s; MAX_ORDER + 1] {
    let mut powers = [first; MAX_ORDER + 1];
    for n in 1..=last {
        powers[n] = simd.mul_f64s(powers[n - 1], base);
    }
    powers
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

#[cfg(test)]
mod tests {
    use super::super::regular;
    use super::*;

    /// Multipole (`outside` false) or local expansion of unit charges, scaled with `scale`.
    fn expansion(order: usize, points: &[Vector3<f64>], scale: f64, outside: bool) -> Vec<f64> {
        let mut sum = vec![0.0; count(order)];
        for point in points {
            let mut values = vec![0.0; count(order)];
            let x = (if outside { point / point.norm_squared() } else { point / scale }).into();
            regular(pulp::Scalar::new(), Tables::get(), order, x, &mut values);
            for n in 0..=order {
                let factor = if outside { scale.powf(n as f64) / point.norm() } else { 1.0 };
                for k in n * n..count(n) {
                    sum[k] += factor * values[k];
                }
            }
        }
        sum
    }

    fn cloud(seed: u32) -> Vec<Vector3<f64>> {
        let angle = |k: u32| f64::from(k * 7 + seed * 13).sin();
        (0..12).map(|k| 0.3 * Vector3::new(angle(k), angle(k + 50), angle(k + 90))).collect()
    }

    fn directions() -> Vec<Vector3<f64>> {
        let mut all: Vec<_> = (0..6)
            .map(|k| {
                let k = f64::from(k);
                Vector3::new((3.0 * k).sin(), (5.0 * k).cos(), (7.0 * k + 1.0).sin()).normalize()
            })
            .collect();
        all.extend([Vector3::x(), -Vector3::y(), Vector3::z(), -Vector3::z()]);
        all
    }

    fn assert_close(actual: &[f64], expected: &[f64], tolerance: f64, what: &str) {
        for (k, (a, e)) in actual.iter().zip(expected).enumerate() {
            assert!((a - e).abs() <= tolerance, "{what}: coefficient {k} is {a}, not {e}");
        }
    }

    /// A shifted multipole is exactly the multipole about the other center, as far as the orders
    /// reach: also through a zero offset, and for all pairs of orders.
    #[test]
    fn multipoles_shift_exactly_for_every_pair_of_orders() {
        let cloud = cloud(1);
        for (k, direction) in directions().into_iter().enumerate() {
            let offset = direction * [0.4, 0.0][usize::from(k == 3)];
            let moved: Vec<_> = cloud.iter().map(|x| x - offset).collect();
            let [before, after] =
                [expansion(30, &cloud, 0.5, false), expansion(30, &moved, 0.9, false)];
            for (p, q) in (0..=30).flat_map(|p| (0..=30).map(move |q| (p, q))) {
                let mut out = vec![0.0; count(q)];
                let shift = Shift { coefficients: &before, offset, scales: [0.5, 0.9] };
                Translator::new(30).sum(Kind::Multipole, [p, q], &[shift], &mut out);
                let exact = count(p.min(q));
                assert_close(&out[..exact], &after[..exact], 1e-11, &format!("{p} to {q}"));
            }
        }
    }

    /// A local expansion cut off at p is a polynomial, which moves exactly if q is no less; for
    /// smaller q the coefficients that remain are the same.
    #[test]
    fn local_expansions_shift_exactly_for_every_pair_of_orders() {
        for direction in directions() {
            let local = expansion(30, &[Vector3::new(2.0, 1.0, -1.5)], 0.8, true);
            let offset = direction * 0.3;
            for p in 0..=30 {
                let shift = Shift { coefficients: &local, offset, scales: [0.8, 0.4] };
                let mut full = vec![0.0; count(30)];
                Translator::new(30).sum(Kind::Local, [p, 30], &[shift], &mut full);
                assert!(full[count(p)..].iter().all(|c| c.abs() < 1e-13), "{p}: no new degrees");
                let at = |x: Vector3<f64>, scale: f64, c: &[f64]| -> f64 {
                    let values = expansion(30, &[x], scale, false);
                    values.iter().zip(c).map(|(a, b)| a * b).sum()
                };
                for x in cloud(4) {
                    let [old, new] = [at(x, 0.8, &local[..count(p)]), at(x - offset, 0.4, &full)];
                    assert!((old - new).abs() < 1e-12, "order {p}: {old} against {new}");
                }
                for q in 0..=30 {
                    let mut out = vec![0.0; count(q)];
                    Translator::new(30).sum(Kind::Local, [p, q], &[shift], &mut out);
                    assert_close(&out, &full[..count(q)], 1e-13, &format!("{p} to {q}"));
                }
            }
        }
    }

    /// A far multipole becomes the local expansion of the same charges; the error falls as the
    /// ratio of radius to distance to the power of the order of the multipole.
    #[test]
    fn far_multipoles_become_local_for_every_pair_of_orders() {
        let cloud = cloud(2);
        for direction in directions() {
            let offset = direction * 2.0;
            let from_there: Vec<_> = cloud.iter().map(|x| x - offset).collect();
            let multipole = expansion(40, &cloud, 0.5, false);
            let exact = expansion(30, &from_there, 0.4, true);
            for (p, q) in (0..=30).flat_map(|p| (0..=30).map(move |q| (p, q))) {
                let mut out = vec![0.0; count(q)];
                let shift = Shift { coefficients: &multipole, offset, scales: [0.5, 0.4] };
                Translator::new(30).sum(Kind::Far, [p, q], &[shift], &mut out);
                for n in 0..=q {
                    // |R_l(x)| <= 0.52^l, and the coefficient (n+l)!/(n! l!) bounds the matrix.
                    let term = |l: usize| {
                        let binomial: f64 = (1..=n).map(|k| (l + k) as f64 / k as f64).product();
                        binomial * 0.26f64.powf(l as f64) * 0.2f64.powf(n as f64)
                    };
                    let bound: f64 = 0.5 * 12.0 * (p + 1..p + 200).map(term).sum::<f64>();
                    for k in n * n..count(n) {
                        let error = (out[k] - exact[k]).abs();
                        assert!(error <= bound + 1e-12, "{p} to {q}, {k}: {error} > {bound}");
                    }
                }
            }
        }
    }
}
