//! Spin of segments about their axes, an angle of any number of turns in a step.
//!
//! A thin fibre that rolls turns many times while its axis hardly moves. Inertia that is a mass on
//! the directors d1 and d2 cannot tell one turn from two, and brakes them all. So where steps are
//! taken by backward Euler the rotation of a segment over a step is parted into a swing, the
//! shortest rotation that takes d3 from its start `t0` to its end `t`, and a spin `psi` about d3.
//! The spin is a coordinate with the constant polar inertia `J = I1 + I2`, and adds the potential
//! `c1 J (psi - dt omega)^2 / 2` to the step, with the spin rate `omega` at its start: exact for
//! any angle. The swing has the mean of `I1` and `I2` as a mass on d3.
//!
//! A rotation `dtheta` changes the spin by `a dtheta`, `a = (t0 + t) / (1 + t0 t)`: the holonomy of
//! parallel transport (Bergou et al. 2008). Of the Hessian `c1 J a a^T` is used, without what the
//! change of `a` adds.

use super::array::{store, store_quat};
use super::chain::RotationChain;
use super::joint_geometry::{combine, director_hessian};
use super::ledger_lanes::LedgerLanes;
use super::scheme::{Stage, StepProblem};
use super::simd_batch::SimdBatch;
use pulp::Simd;
use rapunzel_lanes::{Lane, Portable, Quat, Sym, V3, angle};
use std::f64::consts::TAU;

/// Keeps quotients finite where d3 has turned right round.
const SMALL: f64 = 1e-100;

/// Derivative of the spin by a rotation, for d3 at the start and at the end of a step.
#[inline(always)]
fn gradient<S: Simd>(before: V3<S>, after: V3<S>) -> V3<S> {
    let cosine = before.dot(after);
    (before + after).scale((cosine + cosine.lift(1.0 + SMALL)).recip())
}

/// Spin from the directors at the start of a step to those at its end, rad; of all angles that
/// differ by whole turns the one that is nearest to `near`.
#[inline(always)]
fn spin<S: Simd>(before: [V3<S>; 3], after: [V3<S>; 3], near: Lane<S>) -> Lane<S> {
    // The swing leaves these two as they are, but for a common factor.
    let cosine = before[0].dot(after[0]) + before[1].dot(after[1]);
    let sine = before[1].dot(after[0]) - before[0].dot(after[1]);
    let found = angle(Portable, cosine + cosine.lift(SMALL), sine);
    // Adding it to a number rounds that to an integer.
    let round = near.lift(6_755_399_441_055_744.0);
    let turns = (near - found).mul_add(near.lift(1.0 / TAU), round) - round;
    turns.mul_add(near.lift(TAU), found)
}

/// Rotation vector of the shortest rotation from a unit vector to another, rad.
#[inline(always)]
fn swing<S: Simd>(before: V3<S>, after: V3<S>) -> V3<S> {
    let (v, cosine) = (before.cross(after), before.dot(after));
    let w = cosine + cosine.lift(1.0 + SMALL);
    let norm = w.mul_add(w, v.dot(v)).sqrt().recip();
    Quat { v: v.scale(norm), w: w * norm }.log().0
}

impl<S: Simd> RotationChain<S> {
    /// Adds torque, Hessian and energy of the rotary inertia of segment `e`, with the directors
    /// `d`.
    #[inline(always)]
    pub(super) fn add_rotary_inertia(
        &self,
        e: usize,
        d: [V3<S>; 3],
        definite: Lane<S>,
        (torque, hessian, potential): (&mut V3<S>, &mut Sym<S>, &mut Lane<S>),
    ) {
        if !self.spins {
            let p = [self.vec(&self.room.p, 2 * e), self.vec(&self.room.p, 2 * e + 1)];
            for (d, p) in [(d[0], p[0]), (d[1], p[1])] {
                *torque += d.cross(p);
                *hessian = *hessian + director_hessian(d, p, definite);
            }
            *potential = *potential - d[0].dot(p[0]) - d[1].dot(p[1]);
            return;
        }
        let p = self.vec(&self.room.p, e);
        *torque += d[2].cross(p);
        *hessian = *hessian + director_hessian(d[2], p, definite);
        *potential = *potential - d[2].dot(p);
        let before = self.directors_before(e);
        let inertia = self.one(&self.room.spin, 2 * e);
        let found = spin(before, d, self.one(&self.kept.spin, e));
        let ahead = found - self.one(&self.room.spin, 2 * e + 1);
        let gradient = gradient(before[2], d[2]);
        *torque += gradient.scale(-(inertia * ahead));
        *hessian = *hessian + Sym::outer(gradient).scale(inertia);
        *potential = (ahead * ahead).mul_add(inertia * ahead.lift(0.5), *potential);
    }

    /// Turns segment `e`, whose rotation and spin since the start of the step are given, by a
    /// rotation vector, rad. Returns the new rotation and spin.
    #[inline(always)]
    pub(super) fn turned(
        &self,
        e: usize,
        (q, known): (Quat<S>, Lane<S>),
        turn: V3<S>,
    ) -> (Quat<S>, Lane<S>) {
        let (before, axis) = (self.directors_before(e), q.directors()[2]);
        let about = axis.dot(turn);
        let to = q.turned_by(turn - axis.scale(about)).spun_by(about);
        let expected = known + gradient(before[2], axis).dot(turn);
        (to, spin(before, to.directors(), expected))
    }

    /// A vector that turns segment `e` as the step does, but for terms of higher order in the swing:
    /// the axis of the swing with the sine of its angle, and the spin.
    #[inline(always)]
    pub(super) fn turn_with_spin(&self, e: usize) -> V3<S> {
        let (before, axis) = (self.directors_before(e)[2], self.directors(e)[2]);
        axis.mul_add(self.one(&self.kept.spin, e), before.cross(axis))
    }

    /// Largest rotation increment, rad, of the last solve, of which a spin of a whole fibre is no
    /// part: how far it leads is known exactly, and joints do not feel it.
    #[inline(always)]
    pub(super) fn largest_swing(&self) -> Lane<S> {
        let mut largest = Lane::splat(self.simd, 0.0);
        let mut before = largest;
        for e in 0..self.n {
            let (turn, axis) = (self.vec(&self.kept.step, 2 * e + 1), self.axis(e));
            let about = axis.dot(turn);
            largest = largest.max((turn - axis.scale(about)).max_abs());
            let joined = Lane::new(self.simd, self.ends.root_joint);
            let apart = if e > 0 { about - before } else { about * joined };
            largest = largest.max(apart.abs());
            before = about;
        }
        largest.max((before * Lane::new(self.simd, self.ends.tip_joint)).abs())
    }

    /// Director d3 of segment `e` at its present rotation.
    #[inline(always)]
    fn axis(&self, e: usize) -> V3<S> {
        self.quat(&self.q[4 * e..4 * e + 4]).directors()[2]
    }
}

/// Rates of a segment by its directors.
pub(super) struct SegmentRates<S: Simd> {
    /// Spin about d3, rad/s.
    pub(super) spin: Lane<S>,
    /// Velocity of d3, 1/s, world.
    pub(super) axis: V3<S>,
}

impl<S: Simd> SegmentRates<S> {
    /// Rates of directors `d` with the velocities `v` of d1 and d2.
    #[inline(always)]
    pub(super) fn new(d: [V3<S>; 3], v: [V3<S>; 2]) -> Self {
        let spin = (d[1].dot(v[0]) - d[0].dot(v[1])) * d[0].0[0].lift(0.5);
        let axis = d[0].scale(-d[2].dot(v[0])) - d[1].scale(d[2].dot(v[1]));
        Self { spin, axis }
    }

    /// Velocities of d1 and d2 of the directors `d`, 1/s, world.
    #[inline(always)]
    pub(super) fn directors(&self, d: [V3<S>; 3]) -> [V3<S>; 2] {
        let lean = [self.axis.dot(d[0]), self.axis.dot(d[1])];
        [d[1].scale(self.spin) - d[2].scale(lean[0]), d[2].scale(-lean[1]) - d[0].scale(self.spin)]
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Rates of segment `e` at the start of the step.
    #[inline(always)]
    fn rates_before(&self, e: usize) -> SegmentRates<S> {
        let v = [2 * e, 2 * e + 1].map(|i| self.chain.vec(&self.directors.v, i));
        SegmentRates::new(self.chain.directors_before(e), v)
    }

    /// Rates of segment `e` at the end of the step that has been solved.
    #[inline(always)]
    fn rates_after(&self, stage: &Stage<S>, e: usize) -> SegmentRates<S> {
        let way = self.chain.directors(e)[2] - self.chain.directors_before(e)[2];
        let spin = self.chain.one(&self.chain.kept.spin, e) * stage.cv;
        SegmentRates { spin, axis: way.scale(stage.cv) }
    }

    /// Polar inertia of segment `e`, kg m^2.
    #[inline(always)]
    fn polar_inertia(&self, e: usize) -> Lane<S> {
        let inertia = &self.chain.model.inertia;
        self.chain.one(inertia, 2 * e) + self.chain.one(inertia, 2 * e + 1)
    }

    /// Writes the inertia vectors of d3, and inertias and targets of the spins, for the step.
    #[inline(always)]
    pub(super) fn prepare_spins(&mut self, stage: &Stage<S>) {
        let rest = stage.problem == StepProblem::Rest;
        let weight = if rest { stage.c1.lift(0.0) } else { stage.c1 };
        for e in 0..self.chain.n {
            let rates = self.rates_before(e);
            let polar = self.polar_inertia(e) * weight;
            let d = self.chain.directors_before(e)[2];
            let p = rates.axis.mul_add(stage.dt, d).scale(polar * polar.lift(0.5));
            store(&mut self.chain.room.p, e, p);
            self.chain.room.spin[2 * e] = polar.value;
            self.chain.room.spin[2 * e + 1] = (rates.spin * stage.dt).value;
        }
    }

    /// Turns segment `e` by the swing of its nodes, `chord` their displacement from each other in
    /// lengths of the segment, and by its spin at the start of the step, in lanes that are
    /// `wanted`.
    #[inline(always)]
    pub(super) fn spin_ahead(&mut self, stage: &Stage<S>, e: usize, chord: V3<S>, wanted: Lane<S>) {
        let spin = self.rates_before(e).spin * stage.dt;
        let swing = self.chain.directors_before(e)[2].cross(chord);
        self.chain.turn(e, swing, wanted);
        let q = Quat::load(self.chain.simd, &self.chain.q, e);
        store_quat(&mut self.chain.q, e, wanted.positive().select(q.spun_by(spin), q));
        let old = self.chain.one(&self.chain.kept.spin, e);
        self.chain.kept.spin[e] = wanted.positive().select(spin, old).value;
    }

    /// Commits the rates of all segments in lanes that are `done`.
    #[inline(always)]
    pub(super) fn take_over_spins(&mut self, stage: &Stage<S>, done: Lane<S>) {
        for e in 0..self.chain.n {
            let new = self.rates_after(stage, e).directors(self.chain.directors(e));
            for (k, new) in new.into_iter().enumerate() {
                let old = self.chain.vec(&self.directors.v, 2 * e + k);
                store(&mut self.directors.v, 2 * e + k, done.positive().select(new, old));
            }
        }
    }

    /// Rotation of segment `e` over the step as it has been solved so far, rad, world: swing and
    /// spin, or the rotation vector.
    #[inline(always)]
    pub(super) fn step_rotation(&self, e: usize) -> V3<S> {
        let simd = self.chain.simd;
        let [from, to] = [&self.before.q, &self.chain.q].map(|q| Quat::load(simd, q, e));
        let before = from.directors();
        if !self.chain.spins {
            return combine(before, from.inverse_times(to).log().0);
        }
        let axis = to.directors()[2];
        axis.mul_add(self.chain.one(&self.chain.kept.spin, e), swing(before[2], axis))
    }

    /// Books the rotary inertia of segment `e`, which has turned by `turn` (rad, world). Returns
    /// the torque by it.
    #[inline(always)]
    pub(super) fn book_spin(
        &self,
        stage: &Stage<S>,
        e: usize,
        turn: V3<S>,
        lines: &mut LedgerLanes<S>,
    ) -> V3<S> {
        let [before, d] = [self.chain.directors_before(e), self.chain.directors(e)];
        let rates = self.rates_before(e);
        // Torques by the inertias of the spin and of d3.
        let polar = self.polar_inertia(e);
        let spin = self.chain.one(&self.chain.kept.spin, e);
        let push = stage.dt.negate_mul_add(rates.spin, spin) * polar * stage.c1;
        let lag = (d[2] - before[2] - rates.axis.scale(stage.dt)).scale(stage.c1);
        let of_axis = d[2].cross(lag.scale(polar * polar.lift(0.5)));
        let torque = gradient(before[2], d[2]).scale(-push) - of_axis;
        // What of their work does not become kinetic energy is the integrator's.
        let [v, v_before] = [self.rates_after(stage, e).directors(d), rates.directors(before)];
        let mut gain = polar.lift(0.0);
        for k in 0..2 {
            let inertia = self.chain.one(&self.chain.model.inertia, 2 * e + k);
            let half = inertia * inertia.lift(0.5);
            gain = (v[k] - v_before[k]).dot(v[k] + v_before[k]).mul_add(half, gain);
        }
        lines.kinetic = lines.kinetic + gain;
        lines.integrator = lines.integrator + gain + torque.dot(turn);
        torque
    }
}
