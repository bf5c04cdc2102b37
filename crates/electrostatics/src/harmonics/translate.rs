//! Expansions moved from one center to another, many at a time, one in each SIMD lane.
//!
//! All three operators turn the offset onto the z axis, shift along it, and turn back. A turn about
//! z mixes cosine and sine of one m; a turn about y is a turn about z between two exchanges of y and
//! z, whose matrices do not depend on the angle. This takes `2 p^3` multiply-adds where the plain
//! double sum takes `p^4`.

use super::tables::count;
use super::turn::{Axis, Turn, axis_size};
use crate::real::Real;
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
pub(crate) struct Shift<'a, E> {
    /// Its coefficients, at least up to the degree in use.
    pub(crate) coefficients: &'a [E],
    /// Degree up to which it is taken, and that of what it becomes.
    pub(crate) degrees: [usize; 2],
    /// From its center to the new one.
    pub(crate) offset: Vector3<f64>,
    /// Lengths that the coefficients are scaled with, before and after.
    pub(crate) scales: [f64; 2],
}

/// Scratch space for moving expansions.
pub(crate) struct Translator<E> {
    order: usize,
    work: AVec<E, ConstAlign<64>>,
}

/// Most lanes of any register.
pub(super) const LANES: usize = 16;

impl<E: Real> Translator<E> {
    /// For expansions of degree up to `order`.
    pub(crate) fn new(order: usize) -> Self {
        let size = (3 * count(order) + axis_size(order)) * LANES;
        Self { order, work: avec![[64]| E::of(0.0); size] }
    }

    /// Adds the moved `shifts` to `out`. As many as there are lanes are moved at once, by the highest of
    /// their degrees: it is fastest to have like degrees together.
    pub(crate) fn sum(&mut self, kind: Kind, shifts: &[Shift<E>], out: &mut [E]) {
        let Self { order, work } = self;
        Arch::new().dispatch(Sum { order: *order, kind, shifts, work, out: Out::Sum(out) });
    }

    /// Moves each of `shifts` to an expansion of its own, all of one degree; those stand in `out` one
    /// after another.
    pub(crate) fn each(&mut self, kind: Kind, shifts: &[Shift<E>], out: &mut [E]) {
        let Self { order, work } = self;
        Arch::new().dispatch(Sum { order: *order, kind, shifts, work, out: Out::Each(out) });
    }
}

enum Out<'a, E> {
    Sum(&'a mut [E]),
    Each(&'a mut [E]),
}

struct Sum<'a, E> {
    order: usize,
    kind: Kind,
    shifts: &'a [Shift<'a, E>],
    work: &'a mut [E],
    out: Out<'a, E>,
}

impl<E: Real> WithSimd for Sum<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { order, kind, shifts, work, mut out } = self;
        let size = count(order);
        let (moves, lanes) = (E::moves(), E::lanes::<S>());
        let work = E::registers_mut::<S>(work);
        let (a, rest) = work.split_at_mut(size);
        let (b, rest) = rest.split_at_mut(size);
        let (total, rest) = rest.split_at_mut(size);
        let mut axis = Axis::new(order, rest);
        total.fill(E::splat(simd, E::of(0.0)));
        for (chunk, shifts) in shifts.chunks(lanes).enumerate() {
            let [p, q] =
                [0, 1].map(|k| shifts.iter().map(|shift| shift.degrees[k]).max().unwrap_or(0));
            load::<S, E>(&mut a[..count(p)], shifts);
            let turn = Turn::new(simd, shifts);
            turn.forth(moves, p, a, b);
            axis.shift(kind, [p, q], &turn, a, b);
            turn.back(moves, q, a, b);
            match &mut out {
                Out::Sum(_) => {
                    for (total, a) in total[..count(q)].iter_mut().zip(&*a) {
                        *total = E::add(simd, *total, *a);
                    }
                }
                Out::Each(out) => {
                    let rows: &[E] = pulp::bytemuck::cast_slice(&a[..count(q)]);
                    let first = chunk * lanes * count(q);
                    for (lane, out) in out[first..].chunks_exact_mut(count(q)).enumerate() {
                        if lane < shifts.len() {
                            for (out, a) in out.iter_mut().zip(rows.chunks_exact(lanes)) {
                                *out = a[lane];
                            }
                        }
                    }
                }
            }
        }
        if let Out::Sum(out) = out {
            for (out, total) in out.iter_mut().zip(&*total) {
                *out = E::of(out.double() + E::sum(simd, *total).double());
            }
        }
    }
}

/// Puts one expansion into each lane; lanes without one hold zeros.
#[inline(always)]
fn load<S: Simd, E: Real>(a: &mut [E::Lanes<S>], shifts: &[Shift<E>]) {
    let lanes = E::lanes::<S>();
    let places: &mut [E] = pulp::bytemuck::cast_slice_mut(a);
    if shifts.len() == lanes && lanes == 16 {
        fill::<E, 16>(places, shifts);
    } else if shifts.len() == lanes && lanes == 8 {
        fill::<E, 8>(places, shifts);
    } else {
        places.fill(E::of(0.0));
        for (k, shift) in shifts.iter().enumerate() {
            for (lane, c) in places.chunks_exact_mut(lanes).zip(shift.coefficients) {
                lane[k] = *c;
            }
        }
    }
}

/// Puts the expansions into all of the lanes.
#[inline(always)]
fn fill<E: Real, const N: usize>(places: &mut [E], shifts: &[Shift<E>]) {
    let size = places.len() / N;
    let mut rows = [&shifts[0].coefficients[..size]; N];
    for (row, shift) in rows.iter_mut().zip(shifts) {
        *row = &shift.coefficients[..size];
    }
    for (i, lane) in places.as_chunks_mut::<N>().0.iter_mut().enumerate() {
        for k in 0..N {
            lane[k] = rows[k][i];
        }
    }
}
