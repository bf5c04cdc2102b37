//! The implicit problem of one step: find the rotations that balance every segment.
//!
//! Node `a` obeys `mu_a u_a = n_(a+1) - n_a + b_a`, with `u_a` its displacement from the start of
//! the step, `mu_a` its mass times the scheme's coefficient, and `b_a` everything known. Segment
//! `e` joins nodes `e - 1` and `e` with `r_e - r_(e-1) = h_e d3_e`; `n_e` is that constraint's
//! multiplier, the force of the part beyond on the part before. Joint `j` lies at node `j`, has
//! the rotation vector `phi = log(R_j^T R_(j+1))` and the energy `(phi - target)^T K (phi -
//! target) / 2`. Rotary inertia is a mass on the directors, so it is one more constant vector
//! `p_k` beside each director: the torque on a segment is
//! `sum d_k x p_k + h d3 x n + M_(j=e) - M_(j=e-1)`.
//!
//! Positions are rebuilt from rotations and forces from positions, so every iterate satisfies the
//! constraints and the momentum balance to rounding. Newton's matrix, in `(dn_e, dtheta_e)`, is
//! symmetric quasi-definite and block tridiagonal; see [`super::factor`].

use super::array::{Array, store, store_quat, zeros};
use super::ends::Ends;
use super::factor::{DiagonalBlock, Right, close};
use super::joint_geometry::{JointEffect, combine, director_hessian, hat};
use super::laws::Laws;
use super::model::BatchModel;
use super::nozzle::NozzleLanes;
use super::supports::BothSupports;
use super::workspace::{BatchWorkspace, Kept};
use pulp::Simd;
use rapunzel_lanes::{Lane, Quat, Sym, V3};
use std::sync::Arc;

/// Unknown rotations of one SIMD batch of fibres, with the model, boundary conditions and workspace
/// that determine them.
///
/// Arrays hold `components * count` registers; `n` segments, `n + 1` nodes and joints.
pub(super) struct RotationChain<S: Simd> {
    pub(super) simd: S,
    pub(super) n: usize,
    pub(super) model: Arc<BatchModel<S>>,
    pub(super) ends: Ends<S>,
    /// Supports whose freedoms are held one by one, once any lane has had one.
    pub(super) supports: Option<Box<BothSupports<S>>>,
    /// Nozzles that fibres are fed through, once any lane has had one.
    pub(super) nozzle: Option<Box<NozzleLanes<S>>>,
    /// Section laws in place of the stiffness and natural rotations in `room`, if any lane has
    /// them.
    pub(super) laws: Option<Box<Laws<S>>>,
    /// Positions of the nodes at the start of the step, m, world (3 per node).
    pub(super) start: Array<S>,
    /// Rotations of the segments as unit quaternions (4 per segment).
    pub(super) q: Array<S>,
    /// Whether spins of segments about their axes are coordinates of their own.
    pub(super) spins: bool,
    /// Forces in the segments at the last shape, N, world (3 per segment).
    pub(super) force: Array<S>,
    /// Weight of the definite part of the Hessian in the last solve, 0 to 1 in each lane.
    pub(super) definite: S::f64s,
    /// Workspace for the problem of the step, empty unless it has been borrowed.
    pub(super) room: BatchWorkspace<S>,
    /// Results of the last solve that a step in several calls needs later.
    pub(super) kept: Kept<S>,
}

impl<S: Simd> RotationChain<S> {
    /// Chain of a model, with spins as coordinates or without.
    pub(super) fn new(simd: S, model: Arc<BatchModel<S>>, spins: bool) -> Self {
        let n = model.h.len();
        Self {
            simd,
            n,
            model,
            ends: Ends::new(),
            supports: None,
            nozzle: None,
            laws: None,
            start: zeros::<S>(3 * (n + 1)),
            q: zeros::<S>(4 * n),
            spins,
            force: zeros::<S>(3 * n),
            definite: simd.splat_f64s(0.0),
            room: BatchWorkspace::empty(),
            kept: Kept::empty(),
        }
    }

    #[inline(always)]
    pub(super) fn one(&self, a: &[S::f64s], i: usize) -> Lane<S> {
        Lane::new(self.simd, a[i])
    }
    #[inline(always)]
    pub(super) fn vec(&self, a: &[S::f64s], i: usize) -> V3<S> {
        V3::load(self.simd, a, i)
    }
    /// Vector `i` of an array that is empty where all its vectors are zero.
    #[inline(always)]
    pub(super) fn vec_or_zero(&self, a: &[S::f64s], i: usize) -> V3<S> {
        if a.is_empty() { V3::splat(self.simd, 0.0) } else { self.vec(a, i) }
    }
    #[inline(always)]
    pub(super) fn quat(&self, a: &[S::f64s]) -> Quat<S> {
        Quat::load(self.simd, a, 0)
    }
    #[inline(always)]
    pub(super) fn directors(&self, e: usize) -> [V3<S>; 3] {
        // Not by `map`, which is called with all registers in memory.
        let d = |k: usize| self.vec(&self.room.d, 3 * e + k);
        [d(0), d(1), d(2)]
    }
    /// Directors d1, d2, d3 of segment `e` at the start of the step, world.
    #[inline(always)]
    pub(super) fn directors_before(&self, e: usize) -> [V3<S>; 3] {
        let d = |k: usize| self.vec(&self.room.d_start, 3 * e + k);
        [d(0), d(1), d(2)]
    }
    /// World components of a load given in world and follower components, for an end with the
    /// directors `frame`.
    #[inline(always)]
    pub(super) fn world(&self, load: [[S::f64s; 3]; 2], frame: [V3<S>; 3]) -> V3<S> {
        let [x, y, z] = self.vec(&load[1], 0).0;
        frame[0].mul_add(x, frame[1].mul_add(y, frame[2].mul_add(z, self.vec(&load[0], 0))))
    }

    /// Turns segment `e` by the rotation vector `u` (rad, world) in lanes where `wanted > 0`.
    #[inline(always)]
    pub(super) fn turn(&mut self, e: usize, u: V3<S>, wanted: Lane<S>) {
        let here = self.quat(&self.q[4 * e..4 * e + 4]);
        let to = wanted.positive().select(here.turned_by(u), here);
        store_quat(&mut self.q, e, to);
    }

    /// Rebuilds directors, positions and forces from the rotations. Returns the potential energy of
    /// the nodes, and the vector from a held tip to its support (zero for a free tip).
    #[inline(always)]
    pub(super) fn shape(&mut self) -> (Lane<S>, V3<S>) {
        let (simd, n, ends) = (self.simd, self.n, self.ends);
        self.take_directors();
        // End forces in the world.
        let last = self.directors(n - 1);
        let tip_force = self.world(ends.tip_force, last);
        let root_force = self.world(ends.root_force, self.directors(0));
        let root_free = Lane::new(simd, ends.root_free);
        let mut position = self.vec(&ends.root_position, 0);
        if ends.any_root_free {
            // A free root follows from the sum of all node equations:
            // sum mu_a u_a = F_root + F_tip + sum b_a with u_a = r_0 + chord_a - start_a.
            let mut sum = tip_force + root_force;
            let mut mass = Lane::splat(simd, 0.0);
            let mut chord = V3::splat(simd, 0.0);
            for a in 0..=n {
                if a > 0 {
                    chord = self
                        .vec(&self.room.d, 3 * a - 1)
                        .mul_add(self.one(&self.model.h, a - 1), chord);
                }
                let mu = self.one(&self.room.mu, a);
                sum += self.vec(&self.room.b, a) - (chord - self.vec(&self.start, a)).scale(mu);
                mass = mass + mu;
            }
            let free = sum.scale(mass.recip());
            position = root_free.positive().select(free, position);
        }
        if let Some(supports) = &self.supports {
            position = self.supported_root(supports, position, [root_force, tip_force]);
        }
        position = self.lay(position);
        let mut gap =
            (self.vec(&ends.tip_position, 0) - position).scale(Lane::new(simd, ends.tip_held));
        // Forces from the tip inward, n_a = n_(a+1) + b_a - mu_a u_a; the tip's own balance gives
        // the first unless it is held.
        let (mut u, mut potential) = self.node_potential(n);
        let free = tip_force + self.vec(&self.room.b, n) - u.scale(self.one(&self.room.mu, n));
        let held = self.vec(&ends.tip_reaction, 0);
        let tip_held = Lane::new(simd, ends.tip_held);
        potential = potential - tip_force.dot(u);
        let mut force = tip_held.positive().select(held, free);
        if let Some(supports) = &self.supports {
            [force, gap] = self.supported_tip(&supports[1], position, free, [force, gap]);
        }
        store(&mut self.force, n - 1, force);
        for a in (1..n).rev() {
            let (node, energy) = self.node_potential(a);
            u = node;
            potential = potential + energy;
            force += self.vec(&self.room.b, a) - u.scale(self.one(&self.room.mu, a));
            store(&mut self.force, a - 1, force);
        }
        let (u, energy) = self.node_potential(0);
        potential = potential + root_free * (energy - root_force.dot(u));
        (potential, gap)
    }

    /// Whether positions follow from rotations alone: only where all roots are held.
    pub(super) fn lies_from_root(&self) -> bool {
        !self.ends.any_root_free && self.supports.is_none()
    }

    /// Rebuilds directors and positions of fibres with held roots from the rotations.
    #[inline(always)]
    pub(super) fn place(&mut self) {
        self.take_directors();
        self.lay(self.vec(&self.ends.root_position, 0));
    }

    /// Computes the directors of all segments at the present rotations.
    #[inline(always)]
    fn take_directors(&mut self) {
        for e in 0..self.n {
            let d = self.quat(&self.q[4 * e..4 * e + 4]).directors();
            for k in 0..3 {
                store(&mut self.room.d, 3 * e + k, d[k]);
            }
        }
    }

    /// Positions `r_(e+1) = r_e + h_e d3_e` of all nodes behind the root at a position. Returns
    /// the tip's.
    #[inline(always)]
    fn lay(&mut self, root: V3<S>) -> V3<S> {
        let mut position = root;
        store(&mut self.kept.r, 0, position);
        for e in 0..self.n {
            position =
                self.vec(&self.room.d, 3 * e + 2).mul_add(self.one(&self.model.h, e), position);
            store(&mut self.kept.r, e + 1, position);
        }
        position
    }

    /// Displacement `u` of node `a` from the start of the step, and its potential `mu u^2 / 2 - b
    /// u`.
    #[inline(always)]
    fn node_potential(&self, a: usize) -> (V3<S>, Lane<S>) {
        let u = self.vec(&self.kept.r, a) - self.vec(&self.start, a);
        let half = u.scale(self.one(&self.room.mu, a) * Lane::splat(self.simd, 0.5));
        (u, (half - self.vec(&self.room.b, a)).dot(u))
    }

    /// Assembles Newton's matrix at the present shape, factors it, and solves for the increments.
    /// `definite` lanes (flag 1) use the part of the Hessian that is positive by construction.
    /// Returns the potential energy of joints and directors, and the signature of the matrix: zero
    /// where the Hessian is positive definite.
    #[inline(always)]
    pub(super) fn assemble(&mut self, gap: V3<S>, definite: Lane<S>) -> (Lane<S>, Lane<S>) {
        let (simd, n, ends) = (self.simd, self.n, self.ends);
        let exact = Lane::splat(simd, 1.0) - definite;
        let half = Lane::splat(simd, 0.5);
        let zero = V3::splat(simd, 0.0);
        let mut potential = Lane::splat(simd, 0.0);
        let mut signature = Lane::splat(simd, 0.0);
        let mut before = self.quat(&ends.root_frame);
        let mut directors = [zero; 3];
        let mut left = JointEffect::none(simd);
        let mut carry = DiagonalBlock::zero(simd);
        let mut root_end = None;
        // Joint j comes after segment j - 1, which is complete with it.
        for j in 0..=n {
            let after = self.quat(if j < n { &self.q[4 * j..4 * j + 4] } else { &ends.tip_frame });
            let next = after.directors();
            let right = self.joint(j, before, after, next, exact);
            potential = potential + right.energy;
            // The unknown frame of a supported end.
            let mut end = None;
            if (j == 0 || j == n) && self.supports.is_some() {
                let (stiffness, torque, signs) =
                    self.eliminate_end(usize::from(j == n), &right, exact);
                signature = signature + signs;
                end = Some((stiffness, torque));
            }
            if j == 0 {
                root_end = end;
            }
            if j > 0 {
                let (e, d) = (j - 1, directors);
                let h = self.one(&self.model.h, e);
                // Torque on segment e and its Hessian, from the joints at both ends, rotary inertia
                // and the director term with h n.
                let axial = self.vec(&self.force, e).scale(h);
                let mut torque = right.moment - left.moment;
                let mut hessian = left.hessian + right.hessian;
                let sums = (&mut torque, &mut hessian, &mut potential);
                self.add_rotary_inertia(e, d, definite, sums);
                torque += d[2].cross(axial);
                hessian = hessian + director_hessian(d[2], axial, definite);
                // End moments, and the gap of a held tip on the right-hand side of its constraint
                // row.
                if j == 1 {
                    torque += self.world(ends.root_moment, d);
                }
                torque += self.vec_or_zero(&self.room.torque, e);
                let mut load = zero;
                if j == n {
                    torque += self.world(ends.tip_moment, d);
                    load = zero - gap;
                }
                let of_root = if j == 1 { root_end } else { None };
                for (stiffness, moment) in [of_root, end].into_iter().flatten() {
                    hessian = hessian - stiffness;
                    torque -= moment;
                }
                // Diagonal block [[-(w0 + w1) E, S], [S^T, A]] less the contribution of the
                // previous segment, and the coupling B to the next one: B = hat(M)/2 - H of the
                // joint, where the first term is left out in definite lanes.
                let (w0, w1) = (self.one(&self.kept.w, e), self.one(&self.kept.w, j));
                let mut compliance = Sym::diagonal(-(w0 + w1));
                if let Some(supports) = &self.supports {
                    if j == 1 {
                        compliance = compliance - supports[0].mobility(simd, false);
                    }
                    if j == n {
                        compliance = compliance - supports[1].mobility(simd, false);
                    }
                }
                let mut lever = hat(d[2].scale(h));
                let mut coupling = hat(right.moment.scale(exact * half)) - right.hessian.full();
                if let Some(loose) = self.loose(e) {
                    let own = (&mut torque, &mut hessian);
                    Self::hold_frame(loose, own, (&mut lever, &mut coupling));
                }
                for i in 0..6 {
                    self.room.hessian[6 * e + i] = hessian.0[i].value;
                }
                let block =
                    DiagonalBlock { compliance, lever, stiffness: hessian, load, torque } - carry;
                let (passed, mut rhs, signs) = self.kept.factor.eliminate(e, block, w1, coupling);
                // Loads without a potential make the last block unsymmetric.
                if j == n && ends.any_circulatory {
                    let force = combine(d, self.vec(&ends.tip_force[1], 0));
                    let moment = self.vec(&ends.tip_moment[0], 0)
                        - combine(d, self.vec(&ends.tip_moment[1], 0));
                    let wanted = Lane::new(simd, ends.circulatory);
                    let mut follow = hat(force.scale(-w1));
                    if let Some(supports) = &self.supports {
                        follow = follow - supports[1].mobility(simd, false).times(hat(force));
                    }
                    let [force, turn] = close(block, follow, hat(moment.scale(-half)));
                    rhs = [
                        wanted.positive().select(force, rhs[0]),
                        wanted.positive().select(turn, rhs[1]),
                    ];
                }
                // Keep the eliminated right-hand side and the coupling for the back substitution.
                store(&mut self.room.rhs, 2 * e, rhs[0]);
                store(&mut self.room.rhs, 2 * e + 1, rhs[1]);
                for i in 0..3 {
                    store(&mut self.kept.coupling, 3 * e + i, coupling.0[i]);
                }
                carry = passed;
                signature = signature + signs;
            }
            left = right;
            before = after;
            directors = next;
        }
        // Back substitution of the block tridiagonal system, from tip to root.
        let Kept { factor, coupling, w, step, .. } = &mut self.kept;
        factor.back_substitute(simd, &Right { b: coupling, w, moments: &[] }, &self.room.rhs, step);
        (potential, signature)
    }

    /// Rotation vector of joint `j`, and the second value of [`Quat::log`].
    #[inline(always)]
    pub(super) fn joint_turn(&self, j: usize) -> (V3<S>, Lane<S>) {
        let before =
            self.quat(if j > 0 { &self.q[4 * (j - 1)..4 * j] } else { &self.ends.root_frame });
        let after =
            self.quat(if j < self.n { &self.q[4 * j..4 * j + 4] } else { &self.ends.tip_frame });
        before.inverse_times(after).log()
    }

    /// Computes the rotation vectors of all joints at the present rotations.
    #[inline(always)]
    pub(super) fn measure_joints(&mut self) {
        for j in 0..=self.n {
            let (phi, _) = self.joint_turn(j);
            store(&mut self.room.phi, j, phi);
        }
    }
}
