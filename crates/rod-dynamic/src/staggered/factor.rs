//! Factorisation of Newton's matrix: symmetric quasi-definite, block tridiagonal, without
//! pivoting.
//!
//! Unknowns of segment `e` are the increments of its force and of its rotation vector. Diagonal
//! blocks are `[[-C, S], [S^T, A]]`, the block to the right `[[w E, 0], [0, B]]`. Forces are
//! eliminated before rotations; the pivots' signs are the inertia, and three negative and three
//! positive ones in every block say that the reduced Hessian is positive definite.
//! Some 220 multiplications a segment to factor, 100 to solve once more.

use super::chain::store;
use super::lanes::{Lane, M3, Sym, V3};
use pulp::Simd;
use pulp::bytemuck::Zeroable;
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
    data: Vec<S::f64s>,
    n: usize,
}

const STRIDE: usize = 37;

impl<S: Simd> Factor<S> {
    pub(super) fn new(n: usize) -> Self {
        Self { data: vec![S::f64s::zeroed(); STRIDE * n], n }
    }

    /// Eliminates segment `e`, whose block already lacks what its predecessor takes away. Returns
    /// what to take from the next block, and the smallest signed pivot.
    #[inline(always)]
    pub(super) fn eliminate(
        &mut self,
        simd: S,
        e: usize,
        block: Block<S>,
        w: Lane<S>,
        b: M3<S>,
    ) -> (Block<S>, Lane<S>) {
        let (p, pivot_force) = block.compliance.inverse(-1.0);
        let v = p.times(block.lever);
        let (sigma, pivot_turn) =
            (block.stiffness - Sym::transposed_product(block.lever, v)).inverse(1.0);
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
        let _ = simd;
        (next, pivot_force.min(pivot_turn))
    }

    #[inline(always)]
    fn row(&self, simd: S, e: usize) -> Row<S> {
        let row = &self.data[STRIDE * e..STRIDE * (e + 1)];
        let one = |i: usize| Lane::new(simd, row[i]);
        let sym = |i: usize| Sym([one(i), one(i + 1), one(i + 2), one(i + 3), one(i + 4), one(i + 5)]);
        let vec = |i: usize| V3([one(i), one(i + 1), one(i + 2)]);
        let mat = |i: usize| M3([vec(i), vec(i + 3), vec(i + 6)]);
        Row { p: sym(0), v: mat(6), sigma: sym(15), b: mat(21), w: one(30), rhs: [vec(31), vec(34)] }
    }

    /// Solves backward from the eliminated right-hand sides; `x` has 6 entries a segment.
    #[inline(always)]
    pub(super) fn back_substitute(&self, simd: S, x: &mut [S::f64s]) {
        let mut force = V3::splat(simd, 0.0);
        let mut turn = force;
        for e in (0..self.n).rev() {
            let row = self.row(simd, e);
            let (df, dt) = if e + 1 < self.n {
                row.inverse(force.scale(row.w), row.b.apply(turn))
            } else {
                (V3::splat(simd, 0.0), V3::splat(simd, 0.0))
            };
            force = row.rhs[0] - df;
            turn = row.rhs[1] - dt;
            store(x, 2 * e, force);
            store(x, 2 * e + 1, turn);
        }
    }
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
    /// The inverse of the eliminated diagonal block.
    #[inline(always)]
    fn inverse(&self, load: V3<S>, torque: V3<S>) -> (V3<S>, V3<S>) {
        let turn = self.sigma.apply(torque - self.v.apply_transposed(load));
        (self.p.apply(load) - self.v.apply(turn), turn)
    }
}
