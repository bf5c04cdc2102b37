//! Factorisation of Newton's matrix: symmetric quasi-definite, block tridiagonal, without
//! pivoting.
//!
//! Unknowns of segment `e` are the increments of its force and of its rotation vector. Diagonal
//! blocks are `[[-C, S], [S^T, A]]`, the block to the right `[[w E, 0], [0, B]]`. Forces are
//! eliminated before rotations. By Sylvester's law of inertia the reduced Hessian is positive
//! definite exactly when as many pivots of the whole matrix are positive as negative; in single
//! blocks they need not be, as in a rod under thrust that only both its ends together hold. Some
//! 220 multiplications a segment to factor, 80 to solve once more, 380 for a block of the inverse.

use super::array::{Array, fit, store, zeros};
use super::joint_geometry::hat;
use pulp::Simd;
use rapunzel_lanes::{Lane, M3, Sym, V3};
use std::ops::Sub;

/// Diagonal block `[[-C, S], [S^T, A]]` of one segment and its right-hand side; `compliance` is
/// `-C`, `lever` is `S`, `stiffness` is `A`.
#[derive(Clone, Copy)]
pub(super) struct DiagonalBlock<S: Simd> {
    pub(super) compliance: Sym<S>,
    pub(super) lever: M3<S>,
    pub(super) stiffness: Sym<S>,
    pub(super) load: V3<S>,
    pub(super) torque: V3<S>,
}

impl<S: Simd> DiagonalBlock<S> {
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

impl<S: Simd> Sub for DiagonalBlock<S> {
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

/// The factors of all segments. `D` is a diagonal block less the contributions of the segments
/// before. Interleaved, a segment has `D^-1`: force-force (6, symmetric), force-turn (9), turn-turn
/// (6, symmetric).
///
/// Storing the product with the block to the right too would save one product of a matrix and a
/// vector per segment in a substitution, but substitutions wait for reading the factors: those of
/// many fibres do not stay in the cache.
pub(super) struct Factor<S: Simd> {
    data: Array<S>,
    n: usize,
}

const STRIDE: usize = 21;

/// Off-diagonal blocks to the right of all segments.
///
/// Masses added on the axis leave `B` unchanged. A mass `m` at the arm `a` beside it couples node
/// and rotation by the moments `x = c1 m (1 - f) a` of the node before and `y = c1 m f a` of the
/// node behind: where a node is eliminated its force has the part `x x dtheta` of the segment
/// behind it and `y x dtheta` of the segment before it. The block is then `[[w E, 0], [w hat(y),
/// B]] [[E, hat(x')], [0, E]]`, with `x'` of the next segment.
pub(super) struct Right<'a, S: Simd> {
    /// `B` by rows (9 per segment).
    pub(super) b: &'a [S::f64s],
    /// Inverse masses of all nodes: `w` of a segment is the value of the node behind it.
    pub(super) w: &'a [S::f64s],
    /// `x` and `y` (6 per segment); empty without masses beside the axis.
    pub(super) moments: &'a [S::f64s],
}

impl<S: Simd> Right<'_, S> {
    /// Moments `x` and `y` of segment `e`.
    #[inline(always)]
    pub(super) fn moments(&self, simd: S, e: usize) -> [V3<S>; 2] {
        [V3::load(simd, self.moments, 2 * e), V3::load(simd, self.moments, 2 * e + 1)]
    }
}

impl<S: Simd> Factor<S> {
    pub(super) fn new(n: usize) -> Self {
        Self { data: zeros::<S>(STRIDE * n), n }
    }

    /// Resizes the storage to `n` segments.
    pub(super) fn fit(&mut self, n: usize) {
        fit::<S>(&mut self.data, STRIDE * n);
        self.n = n;
    }

    /// Eliminates segment `e`, whose block already lacks the contribution of its predecessor; the
    /// block to its right has no moments. Returns the contribution to subtract from the next block,
    /// the eliminated right-hand side, and the signature of the pivots.
    #[inline(always)]
    pub(super) fn eliminate(
        &mut self,
        e: usize,
        block: DiagonalBlock<S>,
        w: Lane<S>,
        b: M3<S>,
    ) -> (DiagonalBlock<S>, [V3<S>; 2], Lane<S>) {
        // Eliminate the force (p = compliance^-1, v = p S), then the rotation (sigma = (A - S^T
        // v)^-1).
        let (p, of_forces) = block.compliance.inverse();
        let v = p.times(block.lever);
        let (sigma, of_turns) =
            (block.stiffness - Sym::transposed_product(block.lever, v)).inverse();
        let turn = sigma.apply(block.torque - v.apply_transposed(block.load));
        let force = p.apply(block.load) - v.apply(turn);
        // D^-1 = [[y, -x], [-x^T, sigma]] with x = v sigma and y = p + x v^T.
        let x = v.times(sigma.full());
        let y = p + Sym::product_transposed(x, v);
        let z = sigma.times(b);
        let vz = v.times(z);
        let next = DiagonalBlock {
            compliance: y.scale(w * w),
            lever: vz.scale(-w),
            stiffness: Sym::transposed_product(b, z),
            load: force.scale(w),
            torque: b.apply_transposed(turn),
        };
        let row = &mut self.data[STRIDE * e..STRIDE * (e + 1)];
        for i in 0..6 {
            row[i] = y.0[i].value;
            row[15 + i] = sigma.0[i].value;
        }
        for i in 0..3 {
            for j in 0..3 {
                row[6 + 3 * i + j] = (-x.0[i].0[j]).value;
            }
        }
        (next, [force, turn], of_forces + of_turns)
    }

    /// The contribution that eliminating segment `e` has to the next block, less its loads, where
    /// the block to the right has moments: `x` of the segment behind and `y`.
    #[inline(always)]
    pub(super) fn contribution(&self, simd: S, right: &Right<S>, e: usize) -> DiagonalBlock<S> {
        let row = self.row(simd, right, e);
        let zero = V3::splat(simd, 0.0);
        let [x, y] = row.moments.unwrap_or([zero; 2]);
        let (Inverse { ff, ft, tt }, x, y) = (row.inverse, hat(x), hat(y));
        // D^-1 [[E, 0], [hat(y), B]], where only w is left out, then the same from the left.
        let (force, turn) = (ff.full() + ft.times(y), ft.transposed() + tt.times(y));
        let inner = Sym::symmetric_part(force - y.times(turn)).scale(row.w * row.w);
        let (force, turn) = (ft.times(row.b), tt.times(row.b));
        let beside = (force - y.times(turn)).scale(row.w);
        let outer = Sym::transposed_product(row.b, turn);
        // [[E, hat(x)], [0, E]] from both sides.
        let inner_x = inner.times(x);
        let across = beside.transposed().times(x);
        let stiffness = Sym::symmetric_part(M3::splat(simd, 0.0) - x.times(inner_x))
            + Sym::twice_symmetric_part(across)
            + outer;
        DiagonalBlock {
            compliance: inner,
            lever: inner_x + beside,
            stiffness,
            load: zero,
            torque: zero,
        }
    }

    #[inline(always)]
    fn row(&self, simd: S, right: &Right<S>, e: usize) -> Row<S> {
        let row = &self.data[STRIDE * e..STRIDE * (e + 1)];
        Row {
            inverse: Inverse {
                ff: Sym::load(simd, row, 0),
                ft: matrix(simd, &row[6..15]),
                tt: Sym::load(simd, &row[15..], 0),
            },
            b: matrix(simd, &right.b[9 * e..9 * (e + 1)]),
            w: Lane::new(simd, right.w[e + 1]),
            moments: self.moments_behind(simd, right, e),
        }
    }

    /// Moments `x` of the segment behind `e`, zero behind the last one, and `y` of `e` itself.
    #[inline(always)]
    fn moments_behind(&self, simd: S, right: &Right<S>, e: usize) -> Option<[V3<S>; 2]> {
        if right.moments.is_empty() {
            return None;
        }
        let zero = V3::splat(simd, 0.0);
        let x = if e + 1 < self.n { right.moments(simd, e + 1)[0] } else { zero };
        Some([x, right.moments(simd, e)[1]])
    }

    /// Back substitution from the eliminated right-hand sides `rhs`; `rhs` and `x` have 6 entries
    /// per segment.
    #[inline(always)]
    pub(super) fn back_substitute(
        &self,
        simd: S,
        right: &Right<S>,
        rhs: &[S::f64s],
        x: &mut [S::f64s],
    ) {
        let mut behind = [V3::splat(simd, 0.0); 2];
        for e in (0..self.n).rev() {
            let rhs = [V3::load(simd, rhs, 2 * e), V3::load(simd, rhs, 2 * e + 1)];
            behind = self.row(simd, right, e).substitute(rhs, behind);
            store(x, 2 * e, behind[0]);
            store(x, 2 * e + 1, behind[1]);
        }
    }

    /// Solves for `K` sets of loads and torques (6 per segment and set) in segment `first` and
    /// those behind it. Segments before it must have none.
    #[inline(always)]
    pub(super) fn solve<const K: usize>(
        &self,
        simd: S,
        right: &Right<S>,
        first: usize,
        loads: &[S::f64s],
        x: &mut [S::f64s],
    ) {
        let zero = V3::splat(simd, 0.0);
        // Forward elimination: x = D^-1 (load - carry).
        let mut carry = [[zero; 2]; K];
        for e in first..self.n {
            let row = self.row(simd, right, e);
            for (k, carry) in carry.iter_mut().enumerate() {
                let i = K * e + k;
                let load = V3::load(simd, loads, 2 * i) - carry[0];
                let torque = V3::load(simd, loads, 2 * i + 1) - carry[1];
                let [force, turn] = row.inverse.apply(load, torque);
                store(x, 2 * i, force);
                store(x, 2 * i + 1, turn);
                *carry = row.carry([force, turn]);
            }
        }
        // Back substitution.
        let mut behind = [[zero; 2]; K];
        for e in (first..self.n).rev() {
            let row = self.row(simd, right, e);
            for (k, behind) in behind.iter_mut().enumerate() {
                let i = 2 * (K * e + k);
                *behind = row.substitute([V3::load(simd, x, i), V3::load(simd, x, i + 1)], *behind);
                store(x, i, behind[0]);
                store(x, i + 1, behind[1]);
            }
        }
    }

    /// Computes blocks of the inverse matrix without masses beside the axis: on the diagonal
    /// between forces and between turns (12 per segment) and, in the row of the segment before,
    /// between forces to its right (9). Diagonal blocks are kept symmetric: without that the
    /// recursion loses its digits along the fibre.
    #[inline(always)]
    pub(super) fn inverse_blocks(
        &self,
        simd: S,
        right: &Right<S>,
        diagonal: &mut [S::f64s],
        beside: &mut [S::f64s],
    ) {
        let zero = Lane::splat(simd, 0.0);
        let mut behind =
            Inverse { ff: Sym::diagonal(zero), ft: M3::splat(simd, 0.0), tt: Sym::diagonal(zero) };
        for e in (0..self.n).rev() {
            let row = self.row(simd, right, e);
            let (here, side) = row.behind(&behind);
            for i in 0..3 {
                for j in 0..3 {
                    beside[9 * e + 3 * i + j] = (-side.0[i].0[j]).value;
                }
            }
            behind = here;
            for i in 0..6 {
                diagonal[12 * e + i] = behind.ff.0[i].value;
                diagonal[12 * e + 6 + i] = behind.tt.0[i].value;
            }
        }
    }
}

#[inline(always)]
fn matrix<S: Simd>(simd: S, a: &[S::f64s]) -> M3<S> {
    M3([V3::load(simd, a, 0), V3::load(simd, a, 1), V3::load(simd, a, 2)])
}

/// Eliminated right-hand side of a last segment with loads that have no potential, which make its
/// block unsymmetric: `follow` is added to the lever above the diagonal, `spin` is the skew part of
/// its stiffness. The factors stay those of the symmetric block.
#[inline(always)]
pub(super) fn close<S: Simd>(block: DiagonalBlock<S>, follow: M3<S>, spin: M3<S>) -> [V3<S>; 2] {
    let (p, _) = block.compliance.inverse();
    let below = p.times(block.lever);
    let above = p.times(block.lever + follow);
    let sigma = block.stiffness.full() + spin - block.lever.transposed().times(above);
    let turn = sigma.solve(block.torque - below.apply_transposed(block.load));
    [p.apply(block.load) - above.apply(turn), turn]
}

/// Symmetric 6 x 6 block, split into force (f) and turn (t) parts.
struct Inverse<S: Simd> {
    ff: Sym<S>,
    ft: M3<S>,
    tt: Sym<S>,
}

impl<S: Simd> Inverse<S> {
    #[inline(always)]
    fn apply(&self, load: V3<S>, torque: V3<S>) -> [V3<S>; 2] {
        [
            self.ff.apply(load) + self.ft.apply(torque),
            self.ft.apply_transposed(load) + self.tt.apply(torque),
        ]
    }
}

/// Factors of one segment and its off-diagonal block.
struct Row<S: Simd> {
    inverse: Inverse<S>,
    b: M3<S>,
    w: Lane<S>,
    /// Moments `x` of the segment behind and `y`, if there are masses beside the axis.
    moments: Option<[V3<S>; 2]>,
}

impl<S: Simd> Row<S> {
    /// Solution of this segment, from its eliminated right-hand side and the solution of the
    /// segment behind, which is zero behind the last one.
    #[inline(always)]
    fn substitute(&self, [force, turn]: [V3<S>; 2], behind: [V3<S>; 2]) -> [V3<S>; 2] {
        let (mut load, mut torque) = (behind[0].scale(self.w), self.b.apply(behind[1]));
        if let Some([x, y]) = self.moments {
            load = (behind[0] + x.cross(behind[1])).scale(self.w);
            torque += y.cross(load);
        }
        let pull = self.inverse.apply(load, torque);
        [force - pull[0], turn - pull[1]]
    }

    /// Contribution to subtract from the loads of the segment behind.
    #[inline(always)]
    fn carry(&self, [force, turn]: [V3<S>; 2]) -> [V3<S>; 2] {
        let torque = self.b.apply_transposed(turn);
        let Some([x, y]) = self.moments else { return [force.scale(self.w), torque] };
        let load = (force - y.cross(turn)).scale(self.w);
        [load, torque + load.cross(x)]
    }

    /// Diagonal block of the whole inverse, `D^-1 + D^-1 B Z B^T D^-1` with `z` the diagonal block
    /// of the next segment, and the force-force part of `D^-1 B Z`.
    #[inline(always)]
    fn behind(&self, z: &Inverse<S>) -> (Inverse<S>, M3<S>) {
        let Inverse { ff, ft, tt } = &self.inverse;
        let (ff_w, ft_w) = (ff.scale(self.w), ft.scale(self.w));
        let (right_ft, right_tt) = (ft.times(self.b), tt.times(self.b));
        let zft = z.ft.transposed();
        // T = D^-1 B Z.
        let t_ff = ff_w.times(z.ff.full()) + right_ft.times(zft);
        let t_ft = ff_w.times(z.ft) + right_ft.times(z.tt.full());
        let t_tf = ft_w.transposed().times(z.ff.full()) + right_tt.times(zft);
        let t_tt = ft_w.transposed().times(z.ft) + right_tt.times(z.tt.full());
        let side_ft = right_ft.transposed();
        let side_tt = right_tt.transposed();
        let here = Inverse {
            ff: *ff + Sym::symmetric_part(t_ff.times(ff_w.full()) + t_ft.times(side_ft)),
            ft: *ft + t_ff.times(ft_w) + t_ft.times(side_tt),
            tt: *tt + Sym::symmetric_part(t_tf.times(ft_w) + t_tt.times(side_tt)),
        };
        (here, t_ff)
    }
}

/// Inverse masses of the nodes and factors, with masses added at points.
pub(super) struct WeightedFactor<S: Simd> {
    pub(super) w: Array<S>,
    /// Moments of masses beside the axis, as [`Right`] has them; empty without such masses.
    pub(super) moments: Array<S>,
    pub(super) factor: Factor<S>,
    /// Whether they have been computed since the last step started.
    pub(super) used: bool,
}

impl<S: Simd> WeightedFactor<S> {
    pub(super) fn new(n: usize) -> Self {
        Self { w: zeros::<S>(n + 1), moments: zeros::<S>(0), factor: Factor::new(n), used: true }
    }
}
