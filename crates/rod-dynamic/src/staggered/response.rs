//! Response of the rods to impulses, with the matrix that the last solve has factorised.
//!
//! An impulse is a jump of a node's velocity at the start of the step. It moves the end of the
//! step by `dt P / m` if nothing else acts, so it enters the node's balance as the force
//! `c1 dt P`, and the response is the change of the mean velocity, displacement over `dt`. Both
//! maps are the same up to transposition, so the response is symmetric. The moment of an impulse
//! beside the axis enters the balance of its segment as the torque `c1 dt a x P`, and the mean
//! angular velocity is the rotation over `dt`.

use super::array::{at, fit, set, store};
use super::chain::RotationChain;
use super::factor::{DiagonalBlock, Factor, Right, WeightedFactor};
use super::impulse_columns::ImpulseColumns;
use super::joint_geometry::hat;
use super::scheme::Stage;
use super::simd_batch::SimdBatch;
use super::supports::BothSupports;
use super::workspace::BatchWorkspace;
use crate::{Point, PointAction};
use nalgebra::Vector3;
use pulp::bytemuck::Zeroable;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::{Lane, M3, Sym, V3};

/// Inertia with which the rods respond to an impulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Inertia {
    /// Inertia of the rods alone.
    Own,
    /// Inertia of the rods with the masses that were added at points.
    Weighted,
}

/// Query to the factorised step.
pub(super) enum Question<'a, S: Simd> {
    Respond(Inertia, usize),
    RespondThrice(usize, &'a mut ImpulseColumns<S>),
    Blocks,
    Weigh(&'a [Point], &'a [f64]),
}

/// Replaces `K` sets of impulses on nodes and of moments on segments by the mean velocities and
/// angular velocities that they cause, from node and segment `from` on. `factor`, and the inverse
/// masses and moments in `right`, define the inertia; the columns are the values of nodes, those of
/// segments, and scratch memory for loads and solutions.
#[inline(always)]
fn answer<S: Simd, const K: usize>(
    stage: &Stage<S>,
    factor: &Factor<S>,
    right: &Right<S>,
    ends: Option<(&BothSupports<S>, bool)>,
    from: usize,
    [values, turns, loads, solution]: [&mut [S::f64s]; 4],
) {
    let (simd, w) = (stage.dt.simd(), right.w);
    let n = w.len() - 1;
    let gain = stage.c1 * stage.dt;
    let first = from.saturating_sub(1);
    let beside = !right.moments.is_empty();
    write_loads::<S, K>(stage, right, ends, first, [values, turns], loads);
    factor.solve::<K>(simd, right, first, loads, solution);
    // Mean angular velocity of segment e: dtheta_e / dt. Mean velocity of node a: (w_a / dt)
    // (c1 dt P_a + dn_a - dn_(a-1) + x_a x dtheta_a + y_(a-1) x dtheta_(a-1)), dn_a the force and
    // dtheta_a the rotation of the segment behind it.
    let rate = stage.dt.recip();
    for i in K * from.min(n)..K * n {
        store(turns, i, V3::load(simd, solution, 2 * i + 1).scale(rate));
    }
    for a in from..=n {
        for i in K * a..K * (a + 1) {
            let mut sum = V3::load(simd, values, i).scale(gain);
            if a < n {
                sum += V3::load(simd, solution, 2 * i);
                if beside {
                    let turn = V3::load(simd, solution, 2 * i + 1);
                    sum += right.moments(simd, a)[0].cross(turn);
                }
            }
            if a > 0 {
                sum -= V3::load(simd, solution, 2 * (i - K));
                if beside {
                    let turn = V3::load(simd, solution, 2 * (i - K) + 1);
                    sum += right.moments(simd, a - 1)[1].cross(turn);
                }
            }
            store(values, i, moved(ends, [a, n], [Lane::new(simd, w[a]), rate], sum));
        }
    }
}

/// Writes what `K` sets of impulses on nodes and of moments on segments are in the equations of
/// segment `first` and those behind it.
#[inline(always)]
fn write_loads<S: Simd, const K: usize>(
    stage: &Stage<S>,
    right: &Right<S>,
    ends: Option<(&BothSupports<S>, bool)>,
    first: usize,
    [values, turns]: [&[S::f64s]; 2],
    loads: &mut [S::f64s],
) {
    let (simd, w) = (stage.dt.simd(), right.w);
    let n = w.len() - 1;
    let (gain, one) = (stage.c1 * stage.dt, Lane::splat(simd, 1.0));
    let beside = !right.moments.is_empty();
    // Constraint row of segment e: c1 dt (w_e P_e - w_(e+1) P_(e+1)), e its node before. Torque:
    // c1 dt (T + w_e P_e x x_e + w_(e+1) P_(e+1) x y_e), with the moments of masses beside the
    // axis.
    for e in first..n {
        let (w0, w1) = (Lane::new(simd, w[e]), Lane::new(simd, w[e + 1]));
        for i in K * e..K * (e + 1) {
            let (at_node, behind) = (V3::load(simd, values, i), V3::load(simd, values, i + K));
            let before = moved(ends, [e, n], [w0, one], at_node);
            let here = moved(ends, [e + 1, n], [w1, one], behind);
            let mut torque = V3::load(simd, turns, i);
            if beside {
                let [x, y] = right.moments(simd, e);
                torque += before.cross(x) + here.cross(y);
            }
            store(loads, 2 * i, (before - here).scale(gain));
            store(loads, 2 * i + 1, torque.scale(gain));
        }
    }
}

/// `rate` times what a force on node `a` of the last `n` does, by its inverse mass `w` and, at an
/// end, by the mobility that a support of freedoms leaves; the flag says whether with added masses.
#[inline(always)]
fn moved<S: Simd>(
    ends: Option<(&BothSupports<S>, bool)>,
    [a, n]: [usize; 2],
    [w, rate]: [Lane<S>; 2],
    force: V3<S>,
) -> V3<S> {
    match ends {
        Some((both, weighted)) if a == 0 || a == n => {
            let own = both[usize::from(a == n)].mobility(w.simd(), weighted);
            force.scale(w * rate) + own.apply(force.scale(rate))
        }
        _ => force.scale(w * rate),
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Borrows room for three sets of impulses, to be put back; its numbers are of another use.
    pub(super) fn borrow_columns(&mut self) -> ImpulseColumns<S> {
        let room = &mut self.chain.room.columns;
        let mut columns = std::mem::replace(room, ImpulseColumns::empty());
        columns.fit(self.chain.n);
        columns
    }

    /// Replaces three sets of impulses (N s, N m s) in `columns` by mean velocities (m/s, rad/s),
    /// from node and segment `from` on, in one solve.
    pub(super) fn respond_thrice(&mut self, from: usize, columns: &mut ImpulseColumns<S>) {
        self.ask(Question::RespondThrice(from, columns));
    }

    pub(super) fn ask(&mut self, question: Question<'_, S>) {
        struct Ask<'a, 'b, S: Simd>(&'a mut SimdBatch<S>, Question<'b, S>);
        impl<S: Simd> NullaryFnOnce for Ask<'_, '_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let stage = self.0.stage(&self.0.last_dt, self.0.problem);
                match self.1 {
                    Question::Respond(inertia, from) => {
                        self.0.solve_response(&stage, inertia, from);
                    }
                    Question::RespondThrice(from, columns) => {
                        let ImpulseColumns { values, turns, loads, solution } = columns;
                        let columns = [values, turns, loads, solution].map(|array| &mut array[..]);
                        let RotationChain { kept, supports, .. } = &self.0.chain;
                        let ends = supports.as_deref().map(|both| (both, false));
                        let right = kept.right(&kept.w, &[]);
                        answer::<S, 3>(&stage, &kept.factor, &right, ends, from, columns);
                    }
                    Question::Blocks => self.0.solve_blocks(&stage),
                    Question::Weigh(points, masses) => {
                        self.0.factorize_weighted(&stage, points, masses);
                    }
                }
            }
        }
        self.chain.simd.vectorize(Ask(self, question));
    }

    #[inline(always)]
    pub(super) fn solve_response(&mut self, stage: &Stage<S>, inertia: Inertia, from: usize) {
        let RotationChain { kept, room, supports, .. } = &mut self.chain;
        let (w, moments, factor) = match (inertia, &self.weighted) {
            (Inertia::Weighted, Some(weighted)) => {
                (&weighted.w, &weighted.moments[..], &weighted.factor)
            }
            _ => (&kept.w, &[][..], &kept.factor),
        };
        let BatchWorkspace { values, turns, loads, solution, .. } = room;
        let columns = [values, turns, loads, solution].map(|array| &mut array[..]);
        let weighted = inertia == Inertia::Weighted && self.weighted.is_some();
        let ends = supports.as_deref().map(|both| (both, weighted));
        answer::<S, 1>(stage, factor, &kept.right(w, moments), ends, from, columns);
    }

    /// Solves for the increments that the impulses in the workspace cause, and not for velocities.
    #[inline(always)]
    pub(super) fn solve_increments(&mut self, stage: &Stage<S>) {
        let RotationChain { kept, room, supports, .. } = &mut self.chain;
        let BatchWorkspace { values, turns, loads, solution, .. } = room;
        let ends = supports.as_deref().map(|both| (both, false));
        let right = kept.right(&kept.w, &[]);
        write_loads::<S, 1>(stage, &right, ends, 0, [values, turns], loads);
        kept.factor.solve::<1>(stage.dt.simd(), &right, 0, loads, solution);
    }

    #[inline(always)]
    fn solve_blocks(&mut self, stage: &Stage<S>) {
        let (simd, n) = (self.chain.simd, self.chain.n);
        let RotationChain { kept, room, supports, .. } = &mut self.chain;
        let right = kept.right(&kept.w, &[]);
        kept.factor.inverse_blocks(simd, &right, &mut room.diagonal, &mut room.right);
        let one = Lane::splat(simd, 1.0);
        for a in 0..=n {
            // Block of node a: c1 w (E + w Z), Z from the inverse's blocks of the segments beside
            // it.
            let w = Lane::new(simd, kept.w[a]);
            let mut inner = Sym::diagonal(w.lift(0.0));
            if a > 0 {
                inner = inner + Sym::load(simd, &room.diagonal, 2 * (a - 1));
            }
            if a < n {
                inner = inner + Sym::load(simd, &room.diagonal, 2 * a);
                // Block of segment a: c1 Z, between rotations.
                let turns = Sym::load(simd, &room.diagonal, 2 * a + 1).scale(stage.c1);
                for i in 0..6 {
                    room.turn_blocks[6 * a + i] = turns.0[i].value;
                }
            }
            if a > 0 && a < n {
                let right = &room.right[9 * (a - 1)..];
                let rows =
                    [V3::load(simd, right, 0), V3::load(simd, right, 1), V3::load(simd, right, 2)];
                inner = inner - Sym::twice_symmetric_part(M3(rows));
            }
            let mut block = (Sym::diagonal(one) + inner.scale(w)).scale(w * stage.c1);
            if let (Some(both), true) = (supports.as_deref(), a == 0 || a == n) {
                let own = both[usize::from(a == n)].mobility(simd, false);
                let round = Sym::symmetric_part(own.times(inner.times(own.full())));
                block = block + (own + round).scale(stage.c1);
            }
            for i in 0..6 {
                room.blocks[6 * a + i] = block.0[i].value;
            }
        }
    }

    /// Factorises with masses added at points: a mass `m` at the fraction `f` of a rigid segment is
    /// `m (1 - f)` and `m f` on its nodes, and takes away `m f (1 - f) h^2` of the inertia of its
    /// d3; at an arm `a` it has the inertia `m (a^2 E - a a^T)`, and the moments of [`Right`]. That
    /// of a couple with the lever `L` is the inertia `m L L^T`.
    #[inline(always)]
    fn factorize_weighted(&mut self, stage: &Stage<S>, points: &[Point], masses: &[f64]) {
        let (simd, n) = (self.chain.simd, self.chain.n);
        self.reassemble();
        let RotationChain { model, kept, room, supports, .. } = &mut self.chain;
        let weighted = self.weighted.get_or_insert_with(|| WeightedFactor::new(n));
        weighted.used = true;
        // Masses of the nodes and inertias of d3 that the points add.
        room.mass.fill(S::f64s::zeroed());
        room.inertia.fill(S::f64s::zeroed());
        let on_axis = |point: &Point| match point.action {
            PointAction::Force { arm, .. } => arm == Vector3::zeros(),
            PointAction::Couple { .. } => false,
        };
        let is_beside = |(point, mass): (&Point, &f64)| *mass > 0.0 && !on_axis(point);
        let beside = points.iter().zip(masses).any(is_beside);
        fit::<S>(&mut weighted.moments, if beside { 6 * n } else { 0 });
        weighted.moments.fill(S::f64s::zeroed());
        fit::<S>(&mut room.gyration, if beside { 6 * n } else { 0 });
        room.gyration.fill(S::f64s::zeroed());
        for (point, m) in points.iter().zip(masses) {
            let (lane, e) = (point.fiber as usize, point.segment as usize);
            let h = at(&model.h, e, lane);
            let add = |array: &mut [S::f64s], i: usize, x: f64| {
                let old = at(array, i, lane);
                set(array, i, lane, old + x);
            };
            let (f, a) = match point.action {
                PointAction::Force { fraction, arm } => (fraction, arm),
                PointAction::Couple { lever } => {
                    if beside {
                        let inertia = lever * lever.transpose();
                        let places = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
                        for (i, place) in places.into_iter().enumerate() {
                            add(&mut room.gyration, 6 * e + i, m * inertia[place]);
                        }
                    }
                    continue;
                }
            };
            add(&mut room.mass, e, m * (1.0 - f));
            add(&mut room.mass, e + 1, m * f);
            add(&mut room.inertia, e, -m * f * (1.0 - f) * h * h);
            if beside {
                for i in 0..3 {
                    add(&mut weighted.moments, 6 * e + i, m * (1.0 - f) * a[i]);
                    add(&mut weighted.moments, 6 * e + 3 + i, m * f * a[i]);
                }
                let square = a.norm_squared();
                let own = [square - a.x * a.x, square - a.y * a.y, square - a.z * a.z];
                for (i, x) in
                    own.into_iter().chain([-a.x * a.y, -a.x * a.z, -a.y * a.z]).enumerate()
                {
                    add(&mut room.gyration, 6 * e + i, m * x);
                }
            }
        }
        // Inverse mass coefficients with the added masses.
        for a in 0..=n {
            let free = Lane::new(simd, kept.w[a]);
            let mu = stage.c1.mul_add(Lane::new(simd, room.mass[a]), Lane::new(simd, room.mu[a]));
            weighted.w[a] = free.positive().select(mu.recip(), free).value;
            if let (Some(both), true) = (supports.as_deref_mut(), a == 0 || a == n) {
                both[usize::from(a == n)].set_mobility(mu, true);
            }
        }
        for moment in &mut weighted.moments[..] {
            *moment = (Lane::new(simd, *moment) * stage.c1).value;
        }
        // Elimination of all segments, with the Hessians and couplings of the last assembly.
        let mut carry = DiagonalBlock::zero(simd);
        let zero = V3::splat(simd, 0.0);
        for e in 0..n {
            let h = Lane::new(simd, model.h[e]);
            let d = V3::load(simd, &room.d, 3 * e + 2);
            let inertia = Lane::new(simd, room.inertia[e]) * stage.c1;
            let hessian = Sym::load(simd, &room.hessian, e);
            let across = Sym::diagonal(inertia) - Sym::outer(d).scale(inertia);
            let (w0, w1) = (Lane::new(simd, weighted.w[e]), Lane::new(simd, weighted.w[e + 1]));
            let none = Sym::diagonal(w0.lift(0.0));
            let at_end = |k: usize, here: bool| match supports.as_deref() {
                Some(both) if here => both[k].mobility(simd, true),
                _ => none,
            };
            let (end0, end1) = (at_end(0, e == 0), at_end(1, e + 1 == n));
            let mut block = DiagonalBlock {
                compliance: Sym::diagonal(-(w0 + w1)) - end0 - end1,
                lever: hat(d.scale(h)),
                stiffness: hessian + across,
                load: zero,
                torque: zero,
            };
            let right = kept.right(&weighted.w, &weighted.moments);
            if beside {
                // Nodes with moments are eliminated: [[-w0 - w1, w1 hat(y) - w0 hat(x)],
                // [., w0 hat(x)^2 + w1 hat(y)^2]].
                let [x, y] = right.moments(simd, e);
                block.lever = block.lever + hat(y.scale(w1) - x.scale(w0)) + end1.times(hat(y))
                    - end0.times(hat(x));
                let square =
                    |v: V3<S>, w: Lane<S>| (Sym::outer(v) - Sym::diagonal(v.dot(v))).scale(w);
                let turned =
                    |v: V3<S>, end: Sym<S>| Sym::symmetric_part(hat(v).times(end.times(hat(v))));
                let gyration = Sym::load(simd, &room.gyration, e).scale(stage.c1);
                block.stiffness = block.stiffness + square(x, w0) + square(y, w1) + gyration;
                block.stiffness = block.stiffness + turned(x, end0) + turned(y, end1);
            }
            let row = |i: usize| V3::load(simd, &kept.coupling, 3 * e + i);
            let coupling = M3([row(0), row(1), row(2)]);
            (carry, _, _) = weighted.factor.eliminate(e, block - carry, w1, coupling);
            if beside {
                carry = weighted.factor.contribution(simd, &right, e);
            }
        }
    }
}
