//! Factorisation of Newton's matrix: symmetric quasi-definite, block tridiagonal, without
//! pivoting.
//!
//! Unknowns of segment `e` are the increments of its force and of its rotation vector. Diagonal
//! blocks are `[[-C, S], [S^T, A]]`, the block to the right `[[w E, 0], [0, B]]`. Forces are
//! eliminated before rotations. By Sylvester's law of inertia the reduced Hessian is positive
//! definite exactly when as many pivots of the whole matrix are positive as negative; in single
//! blocks they need not be, as in a rod under thrust that only both its ends together hold.
//! Some 220 multiplications a segment to factor, 100 to solve once more.

use super::chain::store;
use super::lanes::{Array, Lane, M3, Sym, V3, zeros};
use pulp::Simd;
use std::ops::Sub;

/// One diagonal block and its right-hand side.
#[derive(Clone, Copy)]
pub(super) struct Block<S: Simd> {
    pub(super) compliance: Sym<S>,
    pub(super) lever: M3<S>,
    pub(super) stiffness: Sym<S>,
    pub(super) load: V3<S>,
    pub(super) torque: V3<S>,
}

impl<S: Simd> Block<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        let (zero, v) = (Lane::splat(simd, 0.0), V3::splat(simd, 0.0));
        Self {
            compliance: Sym::diagonal(zero),
            lever: M3::splat(simd, 0.0),
            stiffness: Sym::diagonal(zero),
            load: v,
            torque: v,
        }
    }
}

impl<S: Simd> Sub for Block<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self {
            compliance: self.compliance - b.compliance,
            lever: self.lever - b.lever,
            stiffness: self.stiffness - b.stiffness,
            load: self.load - b.load,
            torque: self.torque - b.torque,
        }
    }
}

/// The factors of all segments: `P^-1` (6), `V = P^-1 S` (9), `Sigma^-1` (6), `B` (9), `w`, and
/// the eliminated right-hand side (6), interleaved.
pub(super) struct Factor<S: Simd> {
    data: Array<S>,
    n: usize,
}

const STRIDE: usize = 37;

impl<S: Simd> Factor<S> {
    pub(super) fn new(n: usize) -> Self {
        Self { data: zeros::<S>(STRIDE * n), n }
    }

    /// Eliminates segment `e`, whose block already lacks what its predecessor takes away. Returns
    /// what to take from the next block, and the signature of the pivots.
    #[inline(always)]
    pub(super) fn eliminate(
        &mut self,
        e: usize,
        block: Block<S>,
        w: Lane<S>,
        b: M3<S>,
    ) -> (Block<S>, Lane<S>) {
        let (p, of_forces) = block.compliance.inverse();
        let v = p.times(block.lever);
        let (sigma, of_turns) =
            (block.stiffness - Sym::transposed_product(block.lever, v)).inverse();
        let turn = sigma.apply(block.torque - v.apply_transposed(block.load));
        let force = p.apply(block.load) - v.apply(turn);
        let x = v.times(sigma.full());
        let y = p + Sym::product_transposed(x, v);
        let z = sigma.times(b);
        let next = Block {
            compliance: y.scale(w * w),
            lever: v.times(z).scale(-w),
            stiffness: Sym::transposed_product(b, z),
            load: force.scale(w),
            torque: b.apply_transposed(turn),
        };
        let row = &mut self.data[STRIDE * e..STRIDE * (e + 1)];
        for i in 0..6 {
            row[i] = p.0[i].value;
            row[15 + i] = sigma.0[i].value;
        }
        for i in 0..3 {
            for j in 0..3 {
                row[6 + 3 * i + j] = v.0[i].0[j].value;
                row[21 + 3 * i + j] = b.0[i].0[j].value;
            }
        }
        row[30] = w.value;
        store(&mut row[31..], 0, force);
        store(&mut row[31..], 1, turn);
        (next, of_forces + of_turns)
    }

    /// Solves the last segment again where loads that have no potential make its block unsymmetric:
    /// `follow` is added to the lever above the diagonal, `spin` is the skew part of its stiffness.
    /// Only in the lanes that are wanted; the factors stay those of the symmetric block.
    #[inline(always)]
    pub(super) fn close(&mut self, block: Block<S>, follow: M3<S>, spin: M3<S>, wanted: Lane<S>) {
        let (p, _) = block.compliance.inverse();
        let below = p.times(block.lever);
        let above = p.times(block.lever + follow);
        let sigma = block.stiffness.full() + spin - block.lever.transposed().times(above);
        let turn = sigma.solve(block.torque - below.apply_transposed(block.load));
        let force = p.apply(block.load) - above.apply(turn);
        let at = STRIDE * (self.n - 1) + 31;
        let old = |i: usize| {
            V3([0, 1, 2].map(
                #[inline(always)]
                |k| Lane::new(wanted.simd(), self.data[at + 3 * i + k]),
            ))
        };
        let (force, turn) = (force.positive_or(wanted, old(0)), turn.positive_or(wanted, old(1)));
        store(&mut self.data[at..], 0, force);
        store(&mut self.data[at..], 1, turn);
    }

    /// The block to the right of segment `e`, between turns.
    #[inline(always)]
    pub(super) fn coupling(&self, simd: S, e: usize) -> M3<S> {
        self.row(simd, e).b
    }

    #[inline(always)]
    fn row(&self, simd: S, e: usize) -> Row<S> {
        let row = &self.data[STRIDE * e..STRIDE * (e + 1)];
        let one = |i: usize| Lane::new(simd, row[i]);
        let sym =
            |i: usize| Sym([one(i), one(i + 1), one(i + 2), one(i + 3), one(i + 4), one(i + 5)]);
        let vec = |i: usize| V3([one(i), one(i + 1), one(i + 2)]);
        let mat = |i: usize| M3([vec(i), vec(i + 3), vec(i + 6)]);
        Row {
            p: sym(0),
            v: mat(6),
            sigma: sym(15),
            b: mat(21),
            w: one(30),
            rhs: [vec(31), vec(34)],
        }
    }

    /// Solves backward from the eliminated right-hand sides; `x` has 6 entries a segment.
    #[inline(always)]
    pub(super) fn back_substitute(&self, simd: S, x: &mut [S::f64s]) {
        let mut force = V3::splat(simd, 0.0);
        let mut turn = force;
        for e in (0..self.n).rev() {
            let row = self.row(simd, e);
            // Behind the last segment there is nothing: its coupling multiplies zeros.
            let (df, dt) = row.inverse(force.scale(row.w), row.b.apply(turn));
            force = row.rhs[0] - df;
            turn = row.rhs[1] - dt;
            store(x, 2 * e, force);
            store(x, 2 * e + 1, turn);
        }
    }

    /// Solves for loads on the constraint rows (3 a segment), without torques.
    #[inline(always)]
    pub(super) fn solve(&mut self, simd: S, loads: &[S::f64s], x: &mut [S::f64s]) {
        let mut carry = [V3::splat(simd, 0.0); 2];
        for e in 0..self.n {
            let row = self.row(simd, e);
            let load = V3([0, 1, 2].map(
                #[inline(always)]
                |i| Lane::new(simd, loads[3 * e + i]),
            ));
            let torque = V3::splat(simd, 0.0) - carry[1];
            let (force, turn) = row.inverse(load - carry[0], torque);
            store(&mut self.data[STRIDE * e + 31..], 0, force);
            store(&mut self.data[STRIDE * e + 31..], 1, turn);
            carry = [force.scale(row.w), row.b.apply_transposed(turn)];
        }
        self.back_substitute(simd, x);
    }

    /// The force-force blocks of the inverse: diagonal (6 a segment) and, in the row of the
    /// segment before, to its right (9). Diagonal blocks are kept symmetric: without that the
    /// recursion loses its digits along the fibre.
    #[inline(always)]
    pub(super) fn inverse_blocks(&self, simd: S, diagonal: &mut [S::f64s], right: &mut [S::f64s]) {
        let zero = Lane::splat(simd, 0.0);
        let mut behind =
            Inverse { ff: Sym::diagonal(zero), ft: M3::splat(simd, 0.0), tt: Sym::diagonal(zero) };
        for e in (0..self.n).rev() {
            let row = self.row(simd, e);
            // M = B Z B^T, with B = diag(w E, b).
            let ft = behind.ft.times(row.b.transposed()).scale(row.w);
            let ff = behind.ff.scale(row.w * row.w);
            let tt = Sym::product_transposed(row.b.times(behind.tt.full()), row.b);
            // -Z_(e, e+1) = D^-1 B Z; only its force-force part is wanted.
            let bz = row.b.times(behind.ft.transposed());
            let wz = behind.ff.scale(row.w).full();
            let side = row.force_rows(wz, bz);
            for i in 0..3 {
                for j in 0..3 {
                    right[9 * e + 3 * i + j] = (-side.0[i].0[j]).value;
                }
            }
            behind = row.sandwich(&Inverse { ff, ft, tt });
            for i in 0..6 {
                diagonal[6 * e + i] = behind.ff.0[i].value;
            }
        }
    }
}

/// A symmetric 6 x 6 block by forces and turns.
struct Inverse<S: Simd> {
    ff: Sym<S>,
    ft: M3<S>,
    tt: Sym<S>,
}

struct Row<S: Simd> {
    p: Sym<S>,
    v: M3<S>,
    sigma: Sym<S>,
    b: M3<S>,
    w: Lane<S>,
    rhs: [V3<S>; 2],
}

impl<S: Simd> Row<S> {
    /// The inverse of the eliminated diagonal block, applied.
    #[inline(always)]
    fn inverse(&self, load: V3<S>, torque: V3<S>) -> (V3<S>, V3<S>) {
        let turn = self.sigma.apply(torque - self.v.apply_transposed(load));
        (self.p.apply(load) - self.v.apply(turn), turn)
    }

    /// The force rows of `D^-1 [load; torque]` for three columns at once.
    #[inline(always)]
    fn force_rows(&self, load: M3<S>, torque: M3<S>) -> M3<S> {
        let turn = self.sigma.times(torque - self.v.transposed().times(load));
        self.p.times(load) - self.v.times(turn)
    }

    /// `D^-1 + D^-1 M D^-1`, through `D^-1 = [P 0; 0 0] + [-V; E] Sigma [-V^T E]`.
    #[inline(always)]
    fn sandwich(&self, m: &Inverse<S>) -> Inverse<S> {
        let vt = self.v.transposed();
        // c = [-V^T E] M: first its force columns, then its turn columns.
        let cf = m.ft.transposed() - vt.times(m.ff.full());
        let ct = m.tt.full() - vt.times(m.ft);
        // s = Sigma + Sigma [-V^T E] M [-V; E] Sigma, and y = P M_f [-V; E] Sigma.
        let inner = Sym::symmetric_part(ct - cf.times(self.v));
        let sc = self.sigma.times(inner.full());
        let tt = self.sigma + Sym::product_transposed(sc, self.sigma.full());
        let y = self.p.times(cf.transposed()).times(self.sigma.full());
        let pmp = Sym::product_transposed(self.p.times(m.ff.full()), self.p.full());
        let vs = self.v.times(tt.full());
        let yv = y.times(vt);
        let ff = self.p + pmp + Sym::product_transposed(vs, self.v) - Sym::twice_symmetric_part(yv);
        Inverse { ff, ft: y - vs, tt }
    }
}
