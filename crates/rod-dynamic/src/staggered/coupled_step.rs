//! A step that is taken in several calls, with a contact solver between them.
//!
//! Between calls the workspace is returned: [`super::workspace::Kept`] has what the step needs
//! again, and the other coefficients are recomputed from the state and the impulses, which costs
//! less than to keep them.

use super::array::{self, get, store};
use super::ends::Held;
use super::joint_geometry::keep_directors;
use super::scheme::StepProblem;
use super::search::Search;
use super::simd_batch::SimdBatch;
use crate::Impulses;
use pulp::bytemuck::Zeroable;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::{LANES, Lane};

/// Largest rotation increment of rods in contact, rad; longer ones are shortened to it.
const LONGEST_TURN: f64 = 1.0;

/// A step of a batch in several calls.
pub(super) trait BatchCoupledStep {
    /// Lets the batch own the storage that a step needs from call to call, from now on. Not to be
    /// called between [`super::attempt::BatchAttempts::enter`] and `leave`.
    fn keep(&mut self);
    /// Prepares a step of `dt` seconds at the predicted shape, without solving it.
    fn look(&mut self, dt: f64);
    /// Solves Newton's equations at the present shape, without taking the increments. Returns the
    /// largest increment of each lane, rad.
    fn linearize(&mut self) -> [f64; LANES];
    /// Puts other impulses in place of those before. Returns whether they are others; what they
    /// change by is in the workspace then.
    fn press(&mut self, impulses: Impulses) -> bool;
    /// Takes the increments of the last linearisation, unless they have been taken, with those that
    /// other impulses than before cause. Returns the largest increment of each lane, rad.
    fn advance(&mut self, impulses: Impulses) -> [f64; LANES];
    /// Recomputes the shape that the last call of a step has reached, so that it can be committed.
    fn arrive(&mut self);
}

impl<S: Simd> BatchCoupledStep for SimdBatch<S> {
    fn keep(&mut self) {
        self.keeps = true;
        self.chain.kept.fit(self.chain.n);
        array::fit::<S>(&mut self.impulses, 3 * (self.chain.n + 1));
    }

    fn look(&mut self, dt: f64) {
        struct LookAhead<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for LookAhead<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let pack = self.0;
                let stage = pack.stage(&pack.last_dt, pack.problem);
                if pack.problem == StepProblem::Step {
                    pack.look_ahead(&stage, &[true; LANES]);
                } else {
                    pack.chain.kept.spin.fill(S::f64s::zeroed());
                }
                pack.hold_in_nozzles(&[true; LANES]);
                // Positions alone may need no equations, and what follows writes these anew.
                if pack.holds || pack.chain.laws.is_some() || !pack.chain.lies_from_root() {
                    pack.prepare(&stage);
                    pack.begin_laws();
                }
                if pack.chain.lies_from_root() {
                    pack.chain.place();
                } else {
                    pack.chain.shape();
                }
            }
        }
        self.last_dt = [dt; LANES];
        self.chain.simd.vectorize(LookAhead(self));
    }

    fn linearize(&mut self) -> [f64; LANES] {
        struct Linearize<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for Linearize<'_, S> {
            type Output = [f64; LANES];
            #[inline(always)]
            fn call(self) -> [f64; LANES] {
                let pack = self.0;
                if !pack.holds {
                    pack.resume();
                }
                let mut search = [Search::new(false, Held::CLAMPED, false); LANES];
                // Of joined fibres each by itself may be at a saddle where all together are not.
                let alone = pack.joint_forces.is_empty();
                for lane in 0..S::F64_LANES {
                    let held = pack.held[lane];
                    let held = Held { conservative: alone && held.conservative, ..held };
                    // Spare lanes have no conditions: nothing is to be raised for them.
                    search[lane] = Search::new(lane < pack.fibers, held, false);
                }
                let (turn, gap) = pack.chain.increments(&mut search);
                store(&mut pack.chain.kept.gap, 0, gap);
                let mut turns = [0.0; LANES];
                for lane in 0..S::F64_LANES {
                    turns[lane] = get(turn, lane);
                }
                turns
            }
        }
        self.chain.simd.vectorize(Linearize(self))
    }

    fn press(&mut self, impulses: Impulses) -> bool {
        !(self.pressed.is_empty() && impulses.is_empty()) && self.exchange_impulses(impulses)
    }

    fn advance(&mut self, impulses: Impulses) -> [f64; LANES] {
        let change = self.press(impulses);
        self.take_with_response(change)
    }

    fn arrive(&mut self) {
        struct Arrive<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for Arrive<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                if !self.0.holds {
                    self.0.resume();
                }
                self.0.chain.shape();
                self.0.chain.measure_joints();
            }
        }
        self.chain.simd.vectorize(Arrive(self));
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Takes the increments of the last linearisation together with those that the change of the
    /// impulses in the workspace causes, if there is a `change`. Returns the largest increment of
    /// each lane, rad.
    fn take_with_response(&mut self, change: bool) -> [f64; LANES] {
        struct Advance<'a, S: Simd>(&'a mut SimdBatch<S>, bool);
        impl<S: Simd> NullaryFnOnce for Advance<'_, S> {
            type Output = [f64; LANES];
            #[inline(always)]
            fn call(self) -> [f64; LANES] {
                let pack = self.0;
                let stage = pack.stage(&pack.last_dt, pack.problem);
                if !pack.holds {
                    pack.recall_directors();
                }
                if self.1 {
                    pack.solve_increments(&stage);
                    pack.add_solution();
                }
                let turns = pack.take_step();
                if pack.chain.lies_from_root() {
                    pack.chain.place();
                } else {
                    pack.prepare(&stage);
                    pack.chain.shape();
                }
                turns
            }
        }
        self.chain.simd.vectorize(Advance(self, change))
    }

    /// Adds the solution in the workspace to the increments of the last linearisation.
    #[inline(always)]
    pub(super) fn add_solution(&mut self) {
        for i in 0..2 * self.chain.n {
            let sum = self.chain.vec(&self.chain.kept.step, i)
                + self.chain.vec(&self.chain.room.solution, i);
            store(&mut self.chain.kept.step, i, sum);
        }
    }

    /// Takes the increments of the last linearisation; none are left then. Returns the largest
    /// increment of each lane, rad.
    #[inline(always)]
    pub(super) fn take_step(&mut self) -> [f64; LANES] {
        let turn = self.chain.largest_turn();
        let (mut turns, mut scale) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..S::F64_LANES {
            turns[lane] = get(turn, lane);
            scale[lane] = (LONGEST_TURN / turns[lane]).min(1.0);
        }
        let simd = self.chain.simd;
        let scale = Lane::load(simd, &scale, 0);
        self.chain.advance(Lane::splat(simd, 1.0), scale);
        self.chain.kept.step.fill(S::f64s::zeroed());
        self.chain.kept.gap = [S::f64s::zeroed(); 3];
        turns
    }

    /// Recomputes the coefficients of the step under way in a workspace that was just borrowed.
    #[inline(always)]
    fn resume(&mut self) {
        self.recall_directors();
        let stage = self.stage(&self.last_dt, self.problem);
        self.prepare(&stage);
    }

    /// Assembles the matrix of the last linearisation again in the workspace, and leaves its
    /// factors unchanged.
    #[inline(always)]
    pub(super) fn reassemble(&mut self) {
        std::mem::swap(&mut self.chain.kept, &mut self.chain.room.kept);
        std::mem::swap(&mut self.chain.kept.spin, &mut self.chain.room.kept.spin);
        self.resume();
        let definite = Lane::new(self.chain.simd, self.chain.definite);
        let (_, gap) = self.chain.shape();
        self.chain.assemble(gap, definite);
        std::mem::swap(&mut self.chain.kept.spin, &mut self.chain.room.kept.spin);
        std::mem::swap(&mut self.chain.kept, &mut self.chain.room.kept);
    }

    /// Recomputes the directors at the start of the step under way.
    #[inline(always)]
    pub(super) fn recall_directors(&mut self) {
        let all = Lane::splat(self.chain.simd, 1.0);
        keep_directors(&mut self.chain.room.d_start, &self.before.q, all);
    }
}
