//! Spin of segments about their axes, an angle of any number of turns in a step.
//!
//! A thin fibre that rolls turns many times while its axis hardly moves. Inertia that is a mass on
//! the directors d1 and d2 cannot tell one turn from two, and brakes them all. So where fibres may
//! bear contacts the rotation of a segment over a step is parted into a swing, the shortest
//! rotation that takes d3 from its start `t0` to its end `t`, and a spin `psi` about d3. The spin
//! is a coordinate with the constant polar inertia `J = I1 + I2`, for any angle; the swing has the
//! mean of `I1` and `I2` as a mass on d3.
//!
//! The torque by the spin is that of its acceleration along d3, `J c1 (psi - dpsi)`, and the
//! gyroscopic one, `J omega d3'`: by the values at the end of a step, for backward Euler by the
//! spin rate at its start, with which angular momenta add up. A rotation `dtheta` changes the spin
//! by `a dtheta`, `a = (t0 + t) / (1 + t0 t)`: the holonomy of parallel transport (Bergou et al.
//! 2008). Newton's matrix has `J c1 a a^T` of it, without the gyroscopic part, which is not
//! symmetric.
//!
//! Whole turns are those of a whole fibre: between two segments a joint would resist them, but its
//! rotation vector does not tell them, and what one segment alone had of them would never end.

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
    let turns = ((near - found) * near.lift(1.0 / TAU)).round();
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
        let p = self.vec(&self.room.p, 2 * e);
        *torque += d[2].cross(p);
        *hessian = *hessian + director_hessian(d[2], p, definite);
        *potential = *potential - d[2].dot(p);
        let before = self.directors_before(e);
        let found = spin(before, d, self.one(&self.kept.spin, e));
        let of_spin = |k: usize| self.one(&self.room.spin, 4 * e + k);
        let [inertia, target, still, rate] = [of_spin(0), of_spin(1), of_spin(2), of_spin(3)];
        let ahead = found - target;
        let axis_rate = (d[2] - before[2]).scale(Lane::new(self.simd, self.room.rate))
            + self.vec(&self.room.p, 2 * e + 1);
        *torque -= d[2].scale(inertia * ahead) + axis_rate.scale(rate.mul_add(found, still));
        *hessian = *hessian + Sym::outer(gradient(before[2], d[2])).scale(inertia);
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
        let expected = self.tied(e, known + gradient(before[2], axis).dot(turn));
        (to, spin(before, to.directors(), expected))
    }

    /// Spin of segment `e` over the step, rad, where a rotation `to` is given to it.
    #[inline(always)]
    pub(super) fn spin_to(&self, e: usize, to: Quat<S>) -> Lane<S> {
        let still = Lane::splat(self.simd, 0.0);
        self.tied(e, spin(self.directors_before(e), to.directors(), still))
    }

    /// Spin of segment `e` over the step, rad, without the whole turns that it is ahead of the
    /// segment before, or of a root that is clamped and turns by less than half a turn.
    #[inline(always)]
    fn tied(&self, e: usize, spin: Lane<S>) -> Lane<S> {
        let (before, joined) = if e > 0 {
            (self.one(&self.kept.spin, e - 1), spin.lift(1.0))
        } else {
            (spin.lift(0.0), Lane::new(self.simd, self.ends.root_joint))
        };
        let turns = ((spin - before) * spin.lift(1.0 / TAU)).round();
        joined.positive().select(turns.mul_add(spin.lift(-TAU), spin), spin)
    }

    /// A vector that turns segment `e` as the step does, but for terms of higher order in the
    /// swing: the axis of the swing with the sine of its angle, and the spin.
    #[inline(always)]
    pub(super) fn turn_with_spin(&self, e: usize) -> V3<S> {
        let (before, axis) = (self.directors_before(e)[2], self.directors(e)[2]);
        axis.mul_add(self.one(&self.kept.spin, e), before.cross(axis))
    }

    /// Largest rotation increment, rad, of the last solve. The spin of a whole fibre that nothing
    /// resists counts as what moves its surface as far as a swing moves the ends of segments: by
    /// the radius over the length. That of a fibre with a natural bend or a flat section counts
    /// whole, or Newton's method would find it whole turns away.
    #[inline(always)]
    pub(super) fn largest_swing(&self) -> Lane<S> {
        let mut largest = Lane::splat(self.simd, 0.0);
        let mut before = largest;
        let resists = before.lift(1.0) - Lane::new(self.simd, self.model.round[0]);
        for e in 0..self.n {
            let (turn, axis) = (self.vec(&self.kept.step, 2 * e + 1), self.axis(e));
            let about = axis.dot(turn);
            largest = largest.max((turn - axis.scale(about)).max_abs());
            // Of a solid cylinder the polar inertia is m r^2 / 2.
            let polar = self.polar_inertia(e);
            let mass = self.one(&self.model.mass, e) + self.one(&self.model.mass, e + 1);
            let radius = (polar * polar.lift(4.0) * mass.recip()).sqrt();
            let surface = radius * self.one(&self.model.h, e).recip();
            largest = largest.max(about.abs() * surface.max(resists));
            let joined = Lane::new(self.simd, self.ends.root_joint);
            let apart = if e > 0 { about - before } else { about * joined };
            largest = largest.max(apart.abs());
            before = about;
        }
        largest.max((before * Lane::new(self.simd, self.ends.tip_joint)).abs())
    }

    /// Polar inertia of segment `e`, kg m^2.
    #[inline(always)]
    fn polar_inertia(&self, e: usize) -> Lane<S> {
        self.one(&self.model.inertia, 2 * e) + self.one(&self.model.inertia, 2 * e + 1)
    }

    /// Director d3 of segment `e` at its present rotation.
    #[inline(always)]
    fn axis(&self, e: usize) -> V3<S> {
        self.quat(&self.q[4 * e..4 * e + 4]).directors()[2]
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Spin of segment `e` over the step, in the first of three components, rad.
    #[inline(always)]
    fn spin_vector(&self, e: usize) -> V3<S> {
        let zero = Lane::splat(self.chain.simd, 0.0);
        V3([self.chain.one(&self.chain.kept.spin, e), zero, zero])
    }

    /// Writes what the equations of d3 and of the spins have of the step.
    #[inline(always)]
    pub(super) fn prepare_spins(&mut self, stage: &Stage<S>) {
        let rest = stage.problem == StepProblem::Rest;
        self.chain.room.rate = stage.cv.value;
        let weight = if rest { stage.c1.lift(0.0) } else { stage.c1.lift(1.0) };
        for e in 0..self.chain.n {
            let (of_axis, of_spin) = (
                self.directors.rates(&self.chain, stage, 2 * e),
                self.directors.rates(&self.chain, stage, 2 * e + 1),
            );
            let (du, vc) = stage.predict(of_axis);
            let (ahead, known) = stage.predict(of_spin);
            let polar = self.chain.polar_inertia(e) * weight;
            let inertia = polar * stage.c1;
            let d = self.chain.directors_before(e)[2];
            let room = &mut self.chain.room;
            store(&mut room.p, 2 * e, (d + du).scale(inertia * inertia.lift(0.5)));
            store(&mut room.p, 2 * e + 1, vc);
            // Spin rate of the gyroscopic torque: at the end, or at the start of the step.
            let [by_spin, still] = [
                stage.late.positive().select(stage.cv, stage.cv.lift(0.0)),
                stage.late.positive().select(known.0[0], of_spin.v.0[0]),
            ];
            let all = [inertia, ahead.0[0], polar * still, polar * by_spin];
            for (k, x) in all.into_iter().enumerate() {
                room.spin[4 * e + k] = x.value;
            }
        }
    }

    /// Turns segment `e` by the swing of its nodes, `chord` their displacement from each other in
    /// lengths of the segment, and by its predicted spin, in lanes that are `wanted`.
    #[inline(always)]
    pub(super) fn spin_ahead(&mut self, stage: &Stage<S>, e: usize, chord: V3<S>, wanted: Lane<S>) {
        let spin = stage.predict(self.directors.rates(&self.chain, stage, 2 * e + 1)).0.0[0];
        let spin = self.chain.tied(e, spin);
        let swing = self.chain.directors_before(e)[2].cross(chord);
        self.chain.turn(e, swing, wanted);
        let q = Quat::load(self.chain.simd, &self.chain.q, e);
        store_quat(&mut self.chain.q, e, wanted.positive().select(q.spun_by(spin), q));
        let old = self.chain.one(&self.chain.kept.spin, e);
        self.chain.kept.spin[e] = wanted.positive().select(spin, old).value;
    }

    /// Displacements of d3 and of the spin of segment `e` over the step.
    #[inline(always)]
    pub(super) fn spin_ways(&self, e: usize) -> [V3<S>; 2] {
        let axis = self.chain.directors(e)[2] - self.chain.directors_before(e)[2];
        [axis, self.spin_vector(e)]
    }

    /// Rotation of segment `e` over the step as it has been solved so far, rad, world: swing and
    /// spin, or the rotation vector.
    #[inline(always)]
    pub(super) fn step_rotation(&self, e: usize) -> V3<S> {
        let simd = self.chain.simd;
        let from = Quat::load(simd, &self.before.q, e);
        let to = Quat::load(simd, &self.chain.q, e);
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
        let zero = V3::splat(self.chain.simd, 0.0);
        let [axis, spin] = self.spin_ways(e);
        let rates = |k: usize| self.directors.rates(&self.chain, stage, 2 * e + k);
        let rates = [rates(0), rates(1)];
        let of_axis = self.motion(stage, rates[0], zero, axis);
        let of_spin = self.motion(stage, rates[1], zero, spin);
        // Torque by d3, by the acceleration of the spin, and the gyroscopic one.
        let polar = self.chain.polar_inertia(e);
        let rate = stage.late.positive().select(of_spin.end.0[0], rates[1].v.0[0]);
        let torque = d[2].cross(of_axis.acceleration).scale(polar * polar.lift(-0.5))
            - (d[2].scale(of_spin.acceleration.0[0]) + of_axis.end.scale(rate)).scale(polar);
        // What of its work does not become kinetic energy is the integrator's.
        let mut gain = polar.lift(0.0);
        for k in 0..2 {
            let inertia = self.chain.one(&self.chain.model.inertia, 2 * e + k);
            let (lean, rate) = (of_axis.end.dot(d[k]), of_spin.end.0[0]);
            let (lean_before, rate_before) = (rates[0].v.dot(before[k]), rates[1].v.0[0]);
            let change = (lean - lean_before) * (lean + lean_before)
                + (rate - rate_before) * (rate + rate_before);
            gain = change.mul_add(inertia * inertia.lift(0.5), gain);
        }
        lines.kinetic = lines.kinetic + gain;
        lines.integrator = lines.integrator + gain + torque.dot(turn);
        torque
    }
}
