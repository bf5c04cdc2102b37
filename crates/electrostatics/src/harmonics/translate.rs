//! Expansions moved from one center to another, many at a time, one in each SIMD lane.
//!
//! All three operators turn the offset onto the z axis, shift along it, and turn back. A turn about
//! z mixes cosine and sine of one m; a turn about y is a turn about z between two exchanges of y and
//! z, whose matrices do not depend on the angle. This takes `2 p^3` multiply-adds where the plain
//! double sum takes `p^4`.

use super::tables::{Tables, count};
use super::turn::{Axis, Turn};
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
    /// Its coefficients, at least up to the degree in use.
    pub(crate) coefficients: &'a [f64],
    /// Degree up to which it is taken, and that of what it becomes.
    pub(crate) degrees: [usize; 2],
    /// From its center to the new one.
    pub(crate) offset: Vector3<f64>,
    /// Lengths that the coefficients are scaled with, before and after.
    pub(crate) scales: [f64; 2],
}

/// Scratch space for moving expansions.
pub(crate) struct Translator {
    tables: &'static Tables,
    order: usize,
    work: AVec<f64, ConstAlign<64>>,
}

/// Most lanes of any register.
pub(super) const LANES: usize = 8;

impl Translator {
    /// For expansions of degree up to `order`.
    pub(crate) fn new(order: usize) -> Self {
        let size = 3 * count(order) + Axis::<f64>::size(order);
        Self { tables: Tables::get(), order, work: avec![[64]| 0.0; size * LANES] }
    }

    /// Adds the moved `shifts` to `out`. As many as there are lanes are moved at once, by the highest of
    /// their degrees: it is fastest to have like degrees together.
    pub(crate) fn sum(&mut self, kind: Kind, shifts: &[Shift], out: &mut [f64]) {
        let Self { tables, order, work } = self;
        Arch::new().dispatch(Sum { tables, order: *order, kind, shifts, work, out: Out::Sum(out) });
    }

    /// Moves each of `shifts` to an expansion of its own, all of one degree; those stand in `out` one
    /// after another.
    pub(crate) fn each(&mut self, kind: Kind, shifts: &[Shift], out: &mut [f64]) {
        let Self { tables, order, work } = self;
        let out = Out::Each(out);
        Arch::new().dispatch(Sum { tables, order: *order, kind, shifts, work, out });
    }
}

enum Out<'a> {
    Sum(&'a mut [f64]),
    Each(&'a mut [f64]),
}

struct Sum<'a> {
    tables: &'a Tables,
    order: usize,
    kind: Kind,
    shifts: &'a [Shift<'a>],
    work: &'a mut [f64],
    out: Out<'a>,
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { tables, order, kind, shifts, work, mut out } = self;
        let size = count(order);
        let (work, _) = S::as_mut_simd_f64s(work);
        let (a, rest) = work.split_at_mut(size);
        let (b, rest) = rest.split_at_mut(size);
        let (total, rest) = rest.split_at_mut(size);
        let mut axis = Axis::new(order, rest);
        total.fill(simd.splat_f64s(0.0));
        for (chunk, shifts) in shifts.chunks(S::F64_LANES).enumerate() {
            let [p, q] =
                [0, 1].map(|k| shifts.iter().map(|shift| shift.degrees[k]).max().unwrap_or(0));
            load::<S>(&mut a[..count(p)], shifts);
            let turn = Turn::new(simd, shifts);
            turn.forth(tables, p, a, b);
            axis.shift(simd, tables, kind, [p, q], &turn, a, b);
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
            for (out, total) in out.iter_mut().zip(&*total) {
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
