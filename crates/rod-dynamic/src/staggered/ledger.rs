//! Energy ledger of a step, from the equations that the step has solved.
//!
//! A node obeys `m A = n_(a+1) - n_a + F + R` at the end of the step, with its acceleration `A`,
//! loads `F` and the reaction `R` of a support; a segment obeys
//! `sum I d_k x A_k = h d3 x n + M_(j=e) - M_(j=e-1)`. The first is multiplied with the
//! displacement `u`, the second with a vector `c` that turns the segment's directors over the step
//! up to terms of higher order, `c = sum d_k x d_k' / 2`, and all products are added. Since nodes
//! are where the segments put them, forces leave only `h n (d d3 - c x d3)` of each segment, the
//! difference of chord and tangent. The inertia of directors leaves the same difference, and a
//! joint leaves `M (c_(j+1) - c_j)` against `m dphi`.
//!
//! With `m` the joint's moment at the end, elastic energy grows by
//! `m_elastic dphi - dphi K dphi / 2`. Kinetic energy grows by `(v' - v) (v' + v) / 2` for each
//! unit of mass; of an impulse `P = m p` and the inertia `A` along `u = w dt` that leaves
//! `(A dt + p - (v' - v)) w + (v' - v) (w - (v' + v)/2)`, which for backward Euler is
//! `(v' - v)^2 / 2`. All these differences are booked as the integrator's, with the difference
//! between the work of forces at the end and at the mean. Nodes are in balance to rounding; where
//! Newton's method left a torque on a segment, its product with `c` is booked as the solver's. A
//! joint with a law stores and dissipates what the law says; its moment after the step also stands
//! for the one before it.

use super::chain::RotationChain;
use super::joint_geometry::{moment, slope_of_log, turn};
use super::laws::Turns;
use super::ledger_lanes::LedgerLanes;
use super::scheme::{Rates, Stage, StepProblem};
use super::simd_batch::SimdBatch;
use crate::{Instant, Ledger};
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::{LANES, Lane, V3};

/// Motion over a step of a coordinate with mass 1.
pub(super) struct CoordinateMotion<S: Simd> {
    /// Velocity at the end of the step.
    pub(super) end: V3<S>,
    /// Mean velocity over the step.
    mean: V3<S>,
    /// Acceleration at the end of the step.
    pub(super) acceleration: V3<S>,
    /// Kinetic energy gained.
    gain: Lane<S>,
    /// Work of inertia and impulse that does not become kinetic energy.
    loss: Lane<S>,
}

/// Moments and energies of a joint in a step.
struct Bend<S: Simd> {
    /// Moments on the segment before the joint, N m, world, before and after the step.
    moments: [V3<S>; 2],
    /// Elastic energies before and after the step, J.
    stored: [Lane<S>; 2],
}

/// Ledgers of the steps of a batch.
pub(super) trait BatchLedger {
    /// Records the frames and forces of the ends of one lane before a step whose ledger is wanted;
    /// `now` are the conditions at that time. Unless the reactions are `known`, those after the
    /// step also stand for them.
    fn open_ledger(&mut self, lane: usize, now: &Instant, known: bool);
    /// Ledgers of the step of length `dt[lane]` (s) that has been solved and not been committed. In
    /// lanes that are `done` the next step starts from its end.
    fn account(&mut self, dt: &[f64; LANES], done: &[bool; LANES]) -> [Ledger; LANES];
}

impl<S: Simd> BatchLedger for SimdBatch<S> {
    fn open_ledger(&mut self, lane: usize, now: &Instant, known: bool) {
        self.open_ends(lane, now, known);
    }

    fn account(&mut self, dt: &[f64; LANES], done: &[bool; LANES]) -> [Ledger; LANES] {
        struct Account<'a, S: Simd>(&'a mut SimdBatch<S>, &'a [f64; LANES], &'a [bool; LANES]);
        impl<S: Simd> NullaryFnOnce for Account<'_, S> {
            type Output = [Ledger; LANES];
            #[inline(always)]
            fn call(self) -> [Ledger; LANES] {
                let Self(pack, dt, done) = self;
                let stage = pack.stage(dt, StepProblem::Step);
                pack.book_laws();
                pack.lines(&stage, done).ledgers()
            }
        }
        self.chain.simd.vectorize(Account(self, dt, done))
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Evaluates what the section laws store and dissipate in the step.
    fn book_laws(&mut self) {
        let RotationChain { model, laws, room, ends, .. } = &mut self.chain;
        let before = Turns { phi: &self.phi, rest: &model.rest, ends };
        let after = Turns { phi: &room.phi, ..before };
        laws.iter_mut().for_each(|laws| laws.book(before, after));
    }

    #[inline(always)]
    fn lines(&mut self, stage: &Stage<S>, done: &[bool; LANES]) -> LedgerLanes<S> {
        let (simd, n) = (self.chain.simd, self.chain.n);
        let mut lines = LedgerLanes::zero(simd);
        // Nodes: inertia, contacts, drag, gravity, loads and supports.
        for a in 0..=n {
            self.book_node(stage, a, &mut lines);
        }
        // Rotations of the clamps at both ends over the step.
        let ends = self.chain.ends;
        let frame = |frame: &[S::f64s; 4]| self.chain.quat(frame).directors();
        let clamps = [&ends.root_frame, &ends.tip_frame].map(frame);
        let clamps_before = [&self.outset.frames[0], &self.outset.frames[1]].map(frame);
        let turns = [0, 1].map(|k| turn(clamps_before[k], clamps[k]));
        let (mut stored, mut bent) = ([lines.kinetic; 2], [lines.kinetic.lift(0.0); 2]);
        let zero = V3::splat(simd, 0.0);
        let (mut before, mut torque, mut left) = (turns[0], zero, zero);
        // Segments and joints from root to tip; `torque` is the torque on the segment before joint
        // j.
        for j in 0..=n {
            let [after, inner] =
                if j < n { self.book_segment(stage, j, &mut lines) } else { [turns[1], zero] };
            let frames = if j < n {
                [self.chain.directors_before(j), self.chain.directors(j)]
            } else {
                [clamps_before[1], clamps[1]]
            };
            let bend = self.book_joint(stage, j, after - before, frames, &mut lines);
            let right = bend.moments[1];
            let mut outer = zero;
            // Moments and clamps of the two ends.
            if j == 0 {
                outer = self.chain.world(ends.root_moment, frames[1]);
                lines.loads = lines.loads + outer.dot(after);
                let moments = [zero - bend.moments[0], zero - right];
                self.book_end_turn(0, moments, turns[0], clamps[0], &mut lines);
            } else if j == n {
                let moment = self.chain.world(ends.tip_moment, self.chain.directors(n - 1));
                lines.loads = lines.loads + moment.dot(before);
                torque += moment;
                self.book_end_turn(1, bend.moments, turns[1], clamps[1], &mut lines);
            }
            if j > 0 {
                // The segment before the joint is complete with it.
                let left_over = (torque + right - left).dot(before);
                let loose = self.chain.loose(j - 1).unwrap_or(left_over.lift(1.0));
                lines.solver = loose.negate_mul_add(left_over, lines.solver);
                lines.supports = lines.supports - (left_over - loose * left_over);
            }
            // Energy of an end joint that a change of conditions has clamped or released.
            if j == 0 || j == n {
                let k = usize::from(j == n);
                let made = bend.stored[0] - Lane::new(simd, self.outset.stored[k]);
                lines.supports = lines.supports + made;
                lines.elastic = lines.elastic + made;
                stored[k] = bend.stored[1];
            } else if self.chain.nozzle.is_some() {
                bent = [0, 1].map(|k| bent[k] + bend.stored[k]);
            }
            (before, torque, left) = (after, inner + outer, right);
        }
        if let Some(nozzle) = &self.chain.nozzle {
            // What bent rod has come out of a nozzle, or gone into it.
            let made = bent[0] - Lane::new(simd, self.outset.bent);
            let made = made * Lane::new(simd, nozzle.fed);
            lines.supports = lines.supports + made;
            lines.elastic = lines.elastic + made;
        }
        self.move_outset((stored, bent[1]), done);
        lines
    }

    #[inline(always)]
    fn book_node(&self, stage: &Stage<S>, a: usize, lines: &mut LedgerLanes<S>) {
        let (simd, n, chain) = (self.chain.simd, self.chain.n, &self.chain);
        let field = |i: usize| V3::load(simd, &self.fields, i);
        let (gravity, distributed, wind) = (field(0), field(1), field(2));
        let (across, excess) = (Lane::new(simd, self.fields[9]), Lane::new(simd, self.fields[10]));
        let mass = Lane::new(simd, self.chain.model.mass[a]);
        let way = chain.vec(&chain.kept.r, a) - chain.vec(&self.chain.start, a);
        let rates = self.nodes.rates(chain, stage, a);
        // Inertia and impulses.
        let jump = self.jump(a);
        let motion = self.motion(stage, rates, jump, way);
        lines.kinetic = mass.mul_add(motion.gain, lines.kinetic);
        lines.integrator = mass.negate_mul_add(motion.loss, lines.integrator);
        lines.contacts = lines.contacts + chain.vec_or_zero(&self.impulses, a).dot(motion.mean);
        // Drag at the mean velocity; its difference to the drag in the equations is the
        // integrator's.
        let outside = chain.outside(a).unwrap_or(mass.lift(1.0));
        let (length, tangent) = self.reach(&chain.room.d_start, a);
        let (_, tangent_after) = self.reach(&chain.room.d, a);
        let middle = (tangent + tangent_after).scale(length.lift(0.5));
        let air = |across_at: V3<S>, along_at: V3<S>, tangent: V3<S>| {
            let slip = tangent.dot(along_at - wind) * excess * length.recip();
            ((wind - across_at).scale(across * length) + tangent.scale(slip)).scale(outside)
        };
        let drag = air(motion.end, rates.v, tangent);
        let mean_drag = air(motion.mean, motion.mean, middle);
        lines.drag = lines.drag + mean_drag.dot(way);
        lines.integrator = lines.integrator + (drag - mean_drag).dot(way);
        // Gravity and other loads.
        let weight = gravity.scale(mass * outside);
        lines.gravity = lines.gravity + weight.dot(way);
        let loads = distributed.scale(length * outside) + chain.vec_or_zero(&self.node_forces, a);
        lines.loads = lines.loads + loads.dot(way);
        lines.joints = lines.joints + chain.vec_or_zero(&self.joint_forces, a).dot(way);
        // What holds the node.
        let (_, pull) = self.spring(a, chain.vec(&chain.kept.r, a));
        lines.supports = lines.supports + pull.dot(way);
        // Ends: `before` is inertia less loads at the start of the step.
        if a == 0 || a == n {
            let forces = weight + loads + air(rates.v, rates.v, tangent);
            let before = rates.acceleration.scale(mass) - forces;
            self.book_end(a, before, way, motion.mean, lines);
        }
    }

    /// Books rotary inertia of segment `e` and the difference of its chord and tangent. Returns its
    /// rotation over the step, and the torque on it without its joints.
    #[inline(always)]
    fn book_segment(&self, stage: &Stage<S>, e: usize, lines: &mut LedgerLanes<S>) -> [V3<S>; 2] {
        let (simd, chain) = (self.chain.simd, &self.chain);
        let (before, after) = (chain.directors_before(e), chain.directors(e));
        let turn = if chain.spins { chain.turn_with_spin(e) } else { turn(before, after) };
        let ways = [0, 1, 2].map(|k| after[k] - before[k]);
        let chord = |k: usize| ways[k] - turn.cross(after[k]);
        let zero = V3::splat(simd, 0.0);
        let force = chain.vec(&chain.force, e).scale(chain.one(&chain.model.h, e));
        lines.integrator = lines.integrator - force.dot(chord(2));
        // Impulses beside the axis do work along the rotation vector over the step.
        let joints = chain.vec_or_zero(&self.joint_moments, e);
        lines.joints = lines.joints + joints.dot(turn);
        let mut torque = after[2].cross(force) + joints;
        if !self.moments.is_empty() {
            let pressed = chain.vec(&chain.room.torque, e) - joints;
            let spin = self.step_rotation(e).scale(stage.dt.recip());
            let work = chain.vec(&self.moments, e).dot(spin);
            lines.contacts = lines.contacts + work;
            lines.integrator = lines.integrator + pressed.dot(turn) - work;
            torque += pressed;
        }
        if chain.spins {
            return [turn, torque + self.book_spin(stage, e, turn, lines)];
        }
        for k in 0..2 {
            let inertia = Lane::new(simd, self.chain.model.inertia[2 * e + k]);
            let rates = self.directors.rates(chain, stage, 2 * e + k);
            let motion = self.motion(stage, rates, zero, ways[k]);
            lines.kinetic = inertia.mul_add(motion.gain, lines.kinetic);
            let kept = motion.acceleration.dot(chord(k)) - motion.loss;
            lines.integrator = inertia.mul_add(kept, lines.integrator);
            torque -= after[k].cross(motion.acceleration).scale(inertia);
        }
        [turn, torque]
    }

    /// Books joint `j`, whose segments rotate by `apart` relative to each other; `frames` are the
    /// directors of the segment behind it, before and after the step.
    #[inline(always)]
    fn book_joint(
        &self,
        stage: &Stage<S>,
        j: usize,
        apart: V3<S>,
        frames: [[V3<S>; 3]; 2],
        lines: &mut LedgerLanes<S>,
    ) -> Bend<S> {
        let (simd, n, chain) = (self.chain.simd, self.chain.n, &self.chain);
        // Stiffness, zero at an end that is not clamped.
        let [mut stiffness, rest] = chain.bending(j);
        if j == 0 {
            stiffness = stiffness.scale(Lane::new(simd, chain.ends.root_joint));
        } else if j == n {
            stiffness = stiffness.scale(Lane::new(simd, chain.ends.tip_joint));
        }
        // Elastic energy gained: (K dphi) (strain + strain_before) / 2.
        let half = Lane::splat(simd, 0.5);
        let (phi, phi_before) = (chain.vec(&chain.room.phi, j), chain.vec(&self.phi, j));
        let bend = phi - phi_before;
        let resisted = stiffness.times(bend);
        let (strain, strain_before) = (phi - rest, phi_before - rest);
        let mut gain = resisted.dot(strain + strain_before) * half;
        // Without damping there are no rates of joints, and none are needed.
        let damping = Lane::new(simd, self.damping);
        let rates = self.joints.rates(chain, stage, j);
        let (_, known) = stage.predict(rates);
        let rate = bend.mul_add(stage.cv, known);
        let lost = -(damping * resisted.dot(rate));
        let mut mean_lost = -(damping * resisted.dot(bend) * stage.dt.recip());
        let mut m = stiffness.times(rate.mul_add(damping, strain));
        // Potentials before and after the step; section laws replace energies and moments.
        let energy = |strain: V3<S>| half * stiffness.times(strain).dot(strain);
        let mut stored = [energy(strain_before), energy(strain)];
        let has = chain.laws.as_ref().map(|laws| laws.has(simd));
        if let (Some(laws), Some(has)) = (&chain.laws, has) {
            let [before, after, dissipated] = laws.booked(simd, j);
            stored =
                [has.positive().select(before, stored[0]), has.positive().select(after, stored[1])];
            gain = has.positive().select(after - before, gain);
            mean_lost = has.positive().select(-dissipated, mean_lost);
            m = has.positive().select(laws.model(simd, j, phi).0, m);
        }
        lines.elastic = lines.elastic + gain;
        lines.damping = lines.damping + mean_lost;
        // Moment of the joint in the world, and the work that is the integrator's.
        let (_, fw) = chain.joint_turn(j);
        let slope = slope_of_log(phi.dot(phi), fw);
        let at_end = moment(phi, m, slope, frames[1]);
        let chord = at_end.dot(apart) - m.dot(bend);
        let mut late = (lost - mean_lost) - half * resisted.dot(bend);
        let m_before = stiffness.times(rates.v.mul_add(damping, strain_before));
        // Of the moment before the step only its mean with that after it is used, for which the
        // slope of the logarithm after the step will do.
        let mut at_start = moment(phi_before, m_before, slope, frames[0]);
        if let Some(has) = has {
            late = has.positive().select(gain - mean_lost - m.dot(bend), late);
            at_start = has.positive().select(at_end, at_start);
        }
        lines.integrator = lines.integrator - chord + late;
        Bend { moments: [at_start, at_end], stored }
    }

    #[inline(always)]
    pub(super) fn motion(
        &self,
        stage: &Stage<S>,
        rates: Rates<S>,
        jump: V3<S>,
        way: V3<S>,
    ) -> CoordinateMotion<S> {
        let (du, vc) = stage.predict(Rates { v: rates.v + jump, ..rates });
        let acceleration = (way - du).scale(stage.c1);
        let end = way.mul_add(stage.cv, vc);
        let mean = way.scale(stage.dt.recip());
        let change = end - rates.v;
        let middle = (end + rates.v).scale(stage.dt.lift(0.5));
        let lag = acceleration.mul_add(stage.dt, jump - change);
        let loss = lag.dot(mean) + change.dot(mean - middle);
        CoordinateMotion { end, mean, acceleration, gain: change.dot(middle), loss }
    }
}
