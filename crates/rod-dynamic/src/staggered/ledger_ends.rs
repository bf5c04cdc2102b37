//! The two ends in the ledger: their state at the start of a step, and the work of what holds them.

use super::array::{at, set};
use super::ends;
use super::inputs::ahead;
use super::ledger_lanes::LedgerLanes;
use super::simd_batch::SimdBatch;
use crate::{End, Instant, Load};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane, V3};

impl<S: Simd> SimdBatch<S> {
    /// Records the state of the ends of one lane before a step, as
    /// [`super::ledger::BatchLedger::open_ledger`] does.
    pub(super) fn open_ends(&mut self, lane: usize, now: &Instant, known: bool) {
        let n = self.chain.n;
        let joined = self.chain.ends.joined(lane);
        let parts: [(usize, usize, &End); 2] = [(0, 0, &now.root), (n, n - 1, &now.tip)];
        for (k, (node, segment, end)) in parts.into_iter().enumerate() {
            let frame = self.end_frame(lane, k, end).unwrap_or_else(|| ends::frame(end));
            for (i, x) in frame.into_iter().enumerate() {
                set(&mut self.outset.frames[k], i, lane, x);
            }
            for i in 0..3 {
                let force = at(&self.chain.force, 3 * segment + i, lane);
                set(&mut self.outset.forces[k], i, lane, force);
            }
            let strain = self.strain(lane, node);
            let stored = if joined[k] { self.stored(lane, node, &strain) } else { 0.0 };
            set(&mut self.outset.stored, k, lane, stored);
            if self.chain.supports.is_some() || matches!(end, End::Supported(_)) {
                self.open_loads(lane, k, end, &frame);
            }
        }
        if now.inside > 0.0 || self.chain.nozzle.is_some() {
            let bent = (1..n).map(|j| self.stored(lane, j, &self.strain(lane, j))).sum();
            set(std::slice::from_mut(&mut self.outset.bent), 0, lane, bent);
        }
        let share = if known && self.schemes[lane].remembers() { 0.5 } else { 1.0 };
        set(std::slice::from_mut(&mut self.outset.share), 0, lane, share);
    }

    /// Records force and moment of the loads on a supported end at the start of a step; `frame` is
    /// that of the end.
    fn open_loads(&mut self, lane: usize, k: usize, end: &End, frame: &[f64; 4]) {
        let mut loads = [Vector3::zeros(); 2];
        if let End::Supported(_) = end {
            let (segment, joint, sign) =
                if k == 0 { (0, 0, -1.0) } else { (self.chain.n - 1, self.chain.n, 1.0) };
            let turn = sign * self.vector(&self.chain.model.rest, joint, lane);
            if let End::Supported(support) = ahead(end, &turn) {
                let [x, y, z, w] = *frame;
                let own = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
                let world = |load: &Load, frame: &UnitQuaternion<f64>| match load {
                    Load::World(v) => *v,
                    Load::Follower(v) => frame * v,
                };
                let force = world(&support.force, &self.rotation(segment, lane));
                loads = [force, world(&support.moment, &own)];
            }
        }
        for (array, load) in self.outset.loads[k].iter_mut().zip(loads) {
            (0..3).for_each(|i| set(array, i, lane, load[i]));
        }
    }

    /// Books the reactions of the end `k` to a moment of the joint on it, before and after the
    /// step, along the `turn` of its frame, which is `frame` after it.
    #[inline(always)]
    pub(super) fn book_end_turn(
        &self,
        k: usize,
        moments: [V3<S>; 2],
        turn: V3<S>,
        frame: [V3<S>; 3],
        lines: &mut LedgerLanes<S>,
    ) {
        let simd = self.chain.simd;
        let mut reactions = moments;
        if let Some(both) = &self.chain.supports {
            let load = both[k].moment(frame);
            lines.loads = lines.loads + load.dot(turn);
            // Zero where the support leaves the frame wholly free or holds it whole.
            let turns = Lane::new(simd, both[k].turns);
            reactions[0] -= V3::load(simd, &self.outset.loads[k][1], 0).scale(turns);
            reactions[1] -= load;
        }
        self.support(reactions, turn, lines);
    }

    /// Records the state of the ends after the step as the start of the next one, in the lanes that
    /// are `done`.
    #[inline(always)]
    pub(super) fn move_outset(
        &mut self,
        (stored, bent): ([Lane<S>; 2], Lane<S>),
        done: &[bool; LANES],
    ) {
        let (simd, n) = (self.chain.simd, self.chain.n);
        let done = self.flags(done);
        let keep = |new: S::f64s, old: &mut S::f64s| {
            *old = done.positive().select(Lane::new(simd, new), Lane::new(simd, *old)).value;
        };
        let (ends, out) = (&self.chain.ends, &mut self.outset);
        keep(bent.value, &mut out.bent);
        for (k, (frame, segment)) in
            [(&ends.root_frame, 0), (&ends.tip_frame, n - 1)].into_iter().enumerate()
        {
            frame.iter().zip(&mut out.frames[k]).for_each(|(new, old)| keep(*new, old));
            let force = &self.chain.force[3 * segment..3 * segment + 3];
            force.iter().zip(&mut out.forces[k]).for_each(|(new, old)| keep(*new, old));
            keep(stored[k].value, &mut out.stored[k]);
            if let Some(both) = &self.chain.supports {
                let directors =
                    [0, 1, 2].map(|i| self.chain.vec(&self.chain.room.d, 3 * segment + i));
                let load = if k == 0 { ends.root_force } else { ends.tip_force };
                let force = self.chain.world(load, directors);
                let moment = both[k].moment(self.chain.quat(frame).directors());
                for (load, now) in out.loads[k].iter_mut().zip([force, moment]) {
                    (0..3).for_each(|i| keep(now.0[i].value, &mut load[i]));
                }
            }
        }
        let share = self.schemes.map(|scheme| if scheme.remembers() { 0.5 } else { 1.0 });
        keep(Lane::load(simd, &share, 0).value, &mut out.share);
    }

    /// Books the work of the reactions before and after the step along the displacement `way`.
    #[inline(always)]
    pub(super) fn support(&self, reactions: [V3<S>; 2], way: V3<S>, lines: &mut LedgerLanes<S>) {
        let share = Lane::new(self.chain.simd, self.outset.share);
        let change = (reactions[0] - reactions[1]).scale(share.lift(1.0) - share).dot(way);
        lines.supports = lines.supports + reactions[1].dot(way) + change;
        lines.integrator = lines.integrator - change;
    }

    /// Books loads and reactions of the end at node `a`. `before` is the reaction at the start of
    /// the step without the force of the adjoining segment.
    #[inline(always)]
    pub(super) fn book_end(
        &self,
        a: usize,
        before: V3<S>,
        way: V3<S>,
        mean: V3<S>,
        lines: &mut LedgerLanes<S>,
    ) {
        let (simd, n, chain, ends) = (self.chain.simd, self.chain.n, &self.chain, &self.chain.ends);
        let k = usize::from(a == n);
        let one = Lane::splat(simd, 1.0);
        let (load, held, sign, segment) = if a == 0 {
            (ends.root_force, one - Lane::new(simd, ends.root_free), -one, 0)
        } else {
            (ends.tip_force, Lane::new(simd, ends.tip_held), one, n - 1)
        };
        let load = chain.world(load, chain.directors(segment));
        lines.loads = lines.loads + load.dot(way);
        let force = |array: &[S::f64s], i: usize| V3::load(simd, array, i).scale(sign);
        let before = before + force(&self.outset.forces[k], 0);
        let after = way.scale(chain.one(&chain.room.mu, a)) - chain.vec(&chain.room.b, a)
            + force(&chain.force, segment);
        let mut reactions = [before.scale(held), after.scale(held)];
        if let Some(both) = &chain.supports {
            // Along axes that are held or sprung, what the load is not.
            let bound = both[k].bound(simd);
            let at_start = V3::load(simd, &self.outset.loads[k][0], 0);
            reactions[0] += bound.apply(before - at_start);
            reactions[1] += bound.apply(after - load);
        }
        self.support(reactions, way, lines);
        let absorbed = V3::load(simd, &self.absorbed[k], 0).dot(mean);
        lines.contacts = lines.contacts + absorbed;
        lines.supports = lines.supports - absorbed;
    }
}
