//! Expansions moved from one center to another, many at a time, one in each SIMD lane.
//!
//! All three operators turn the offset onto the z axis, shift along it, and turn back. A turn about
//! z mixes cosine and sine of one m; a turn about y is a turn about z between two exchanges of y
//! and z, whose matrices do not depend on the angle. This takes `2 p^3` multiply-adds where the
//! plain double sum takes `p^4`.

use super::products::TurnBlock;
use super::shift::{Shift, TranslationKind};
use super::tables::count;
use super::translation_tables::Coefficient;
use super::turn::{AxisTurn, turn_size};
use aligned_vec::{AVec, ConstAlign, avec};
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES_F32, Machine, Ways, dispatch};

/// Highest degree at which four registers are faster than two, from measured rates.
const LOW: usize = 8;

/// Number of coefficients up to degree `order`, with what fills the last register.
pub(crate) const fn padded(order: usize) -> usize {
    count(order).next_multiple_of(LANES_F32)
}

/// Number of registers of expansions that are moved at once, which share the constants.
const fn most_registers(order: usize) -> usize {
    if order <= LOW { 4 } else { 2 }
}

/// Scratch space for moving expansions of degree up to `order`.
pub(crate) struct Translator<E> {
    order: usize,
    work: AVec<E, ConstAlign<64>>,
}

impl<E: Coefficient> Translator<E> {
    /// Space for expansions of degree up to `order`.
    pub(crate) fn new(order: usize) -> Self {
        let most = most_registers(order);
        let size = (count(order) + most * (padded(order) + turn_size(order))) * LANES_F32;
        Self { order, work: avec![[64]| E::from_f64(0.0); size] }
    }

    /// Adds the moved `shifts` to `out`. As many as some registers have lanes are moved at once, by
    /// the highest of their degrees: it is fastest to have like degrees together.
    pub(crate) fn sum(&mut self, kind: TranslationKind, shifts: &[Shift<E>], out: &mut [E]) {
        let Self { order, work } = self;
        dispatch(TranslationSum { order: *order, kind, shifts, work, out: Out::Sum(out) });
    }

    /// Moves each of `shifts` to an expansion of its own, all of one degree; those stand in `out`
    /// one after another.
    pub(crate) fn each(&mut self, kind: TranslationKind, shifts: &[Shift<E>], out: &mut [E]) {
        let Self { order, work } = self;
        dispatch(TranslationSum { order: *order, kind, shifts, work, out: Out::Each(out) });
    }
}

/// Place of the moved expansions: one sum of all, or one after another.
enum Out<'a, E> {
    Sum(&'a mut [E]),
    Each(&'a mut [E]),
}

/// Expansions that are moved by one call, and where they go.
struct TranslationSum<'a, E> {
    order: usize,
    kind: TranslationKind,
    shifts: &'a [Shift<'a, E>],
    work: &'a mut [E],
    out: Out<'a, E>,
}

impl<E: Coefficient> Kernel for TranslationSum<'_, E> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { order, kind, shifts, work, mut out } = self;
        let lanes = E::lanes::<S>();
        // Sums stay in registers, a lane for each expansion, and are added over the lanes at the
        // end.
        let (total, work) = E::registers_mut::<S>(work).split_at_mut(count(order));
        total.fill(E::splat(simd, E::from_f64(0.0)));
        let mut rest = shifts;
        while !rest.is_empty() {
            let (now, later) = rest.split_at(rest.len().min(most_registers(order) * lanes));
            if now.len() > 2 * lanes {
                moved::<S, E, M, 4>(simd, machine, kind, now, work, total, &mut out);
            } else if now.len() > lanes {
                moved::<S, E, M, 2>(simd, machine, kind, now, work, total, &mut out);
            } else {
                moved::<S, E, M, 1>(simd, machine, kind, now, work, total, &mut out);
            }
            rest = later;
        }
        if let Out::Sum(out) = out {
            for (out, total) in out.iter_mut().zip(&*total) {
                *out = E::from_f64(out.to_f64() + E::reduce_sum(simd, *total).to_f64());
            }
        }
    }
}

/// Moves as many expansions as `C` registers have lanes, and adds them to `total` or puts each into
/// its place.
#[inline(always)]
fn moved<S: Simd, E: Coefficient, M: Machine<S>, const C: usize>(
    simd: S,
    machine: M,
    kind: TranslationKind,
    shifts: &[Shift<E>],
    work: &mut [E::Register<S>],
    total: &mut [E::Register<S>],
    out: &mut Out<E>,
) {
    let lanes = E::lanes::<S>();
    let [p, q] = [0, 1].map(|k| shifts.iter().map(|shift| shift.degrees[k]).max().unwrap_or(0));
    let order = p.max(q);
    let (a, work) = work.as_chunks_mut::<C>().0.split_at_mut(padded(order));
    // Three steps: the frame is turned until the offset is along z, ...
    let mut turn = AxisTurn::new(simd, kind, order, shifts, work);
    let mut loaded = 0;
    for n in 0..=p {
        while loaded < count(n) {
            load::<S, E, M, C>(simd, machine, loaded, shifts, &mut a[loaded..loaded + lanes]);
            loaded += lanes;
        }
        turn.forth(n, &mut a[n * n..count(n)]);
    }
    // ... expansions are shifted along z, which mixes degrees of one m only, ...
    for m in 0..=q {
        turn.along(m, [p, q]);
    }
    // ... and the frame is turned back.
    for n in 0..=q {
        let degree = turn.back(n);
        match out {
            Out::Sum(_) => {
                for (total, block) in total[n * n..].iter_mut().zip(degree) {
                    for a in block {
                        *total = E::add(simd, *total, *a);
                    }
                }
            }
            Out::Each(out) => {
                let numbers: &[E] = pulp::bytemuck::cast_slice(degree.as_flattened());
                for (lane, out) in out.chunks_exact_mut(count(q)).take(shifts.len()).enumerate() {
                    for (out, a) in out[n * n..].iter_mut().zip(numbers.chunks_exact(C * lanes)) {
                        *out = a[lane];
                    }
                }
            }
        }
    }
    if let Out::Each(out) = out {
        *out = std::mem::take(out).split_at_mut(shifts.len() * count(q)).1;
    }
}

/// Puts the coefficients of the `shifts` from `first` on into `a`, a shift in each lane and as many
/// coefficients as lanes; those that are missing are zero.
#[inline(always)]
fn load<S: Simd, E: Ways, M: Machine<S>, const C: usize>(
    simd: S,
    machine: M,
    first: usize,
    shifts: &[Shift<E>],
    a: &mut [TurnBlock<S, E, C>],
) {
    let lanes = E::lanes::<S>();
    let none = [E::from_f64(0.0); LANES_F32];
    let mut last = [none; LANES_F32];
    for c in 0..C {
        let shifts = shifts.get(c * lanes..).unwrap_or(&[]);
        let mut rows = [&none[..]; LANES_F32];
        for ((row, last), shift) in rows[..lanes].iter_mut().zip(&mut last).zip(shifts) {
            *row = match shift.coefficients.get(first..first + lanes) {
                Some(row) => row,
                None => {
                    let rest = &shift.coefficients[first..];
                    last[..rest.len()].copy_from_slice(rest);
                    last
                }
            };
        }
        E::transpose(simd, machine, &rows, c, a);
    }
}
