//! A step that is taken in several calls, with a solver of contacts between them.
//!
//! Between calls the room is given away: what the step needs again is in
//! [`super::workspace::Kept`], and the problem is written anew from the state and the impulses,
//! which costs less than to keep it.

use super::array::{get, store};
use super::ends::Held;
use super::joint_geometry::keep_directors;
use super::response::Inertia;
use super::scheme::StepProblem;
use super::search::Search;
use super::simd_batch::SimdBatch;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::{LANES, Lane};

/// Longer increments of rods in contact are shortened to this, rad.
const LONGEST_TURN: f64 = 1.0;

impl<S: Simd> SimdBatch<S> {
    /// Prepares a step of length `dt` and sets out to where the motion leads, without solving it.
    pub(super) fn look(&mut self, dt: f64) {
        struct LookAhead<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for LookAhead<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let stage = self.0.stage(&self.0.last_dt, StepProblem::Step);
                self.0.look_ahead(&stage, &[true; LANES]);
                self.0.prepare(&stage);
                self.0.begin_laws();
                self.0.chain.shape();
            }
        }
        self.last_dt = [dt; LANES];
        self.chain.simd.vectorize(LookAhead(self));
    }

    /// Solves Newton's equations at the present shape, without taking the increments. Returns the
    /// largest increment, rad.
    pub(super) fn linearize(&mut self) -> [f64; LANES] {
        struct Linearize<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for Linearize<'_, S> {
            type Output = [f64; LANES];
            #[inline(always)]
            fn call(self) -> [f64; LANES] {
                let pack = self.0;
                pack.resume();
                let mut search = [Search::new(false, Held::CLAMPED, false); LANES];
                for lane in 0..S::F64_LANES {
                    search[lane] = Search::new(true, pack.held[lane], false);
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

    /// Takes the increments of the last linearisation together with those that the change of the
    /// impulses in the room causes. Returns the largest increment, rad.
    pub(super) fn advance(&mut self) -> [f64; LANES] {
        struct Advance<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for Advance<'_, S> {
            type Output = [f64; LANES];
            #[inline(always)]
            fn call(self) -> [f64; LANES] {
                let pack = self.0;
                let stage = pack.stage(&pack.last_dt, StepProblem::Step);
                pack.solve_response(&stage, Inertia::Own, 0);
                for i in 0..2 * pack.chain.n {
                    let sum = pack.chain.vec(&pack.chain.kept.step, i)
                        + pack.chain.vec(&pack.chain.room.solution, i);
                    store(&mut pack.chain.kept.step, i, sum);
                }
                let turn = pack.chain.largest_turn();
                let (mut turns, mut scale) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..S::F64_LANES {
                    turns[lane] = get(turn, lane);
                    scale[lane] = (LONGEST_TURN / turns[lane]).min(1.0);
                }
                let simd = pack.chain.simd;
                let scale = Lane::load(simd, &scale, 0);
                pack.chain.advance(Lane::splat(simd, 1.0), scale);
                pack.resume();
                pack.chain.shape();
                turns
            }
        }
        self.chain.simd.vectorize(Advance(self))
    }

    /// Writes the problem of a step that has been set out on once more, from call to call.
    #[inline(always)]
    fn resume(&mut self) {
        self.recall_directors();
        let stage = self.stage(&self.last_dt, StepProblem::Step);
        self.prepare(&stage);
    }

    /// Assembles the matrix of the last linearisation once more, and leaves its factors alone.
    #[inline(always)]
    pub(super) fn reassemble(&mut self) {
        std::mem::swap(&mut self.chain.kept, &mut self.chain.room.kept);
        self.resume();
        let definite = Lane::new(self.chain.simd, self.chain.definite);
        let (_, gap) = self.chain.shape();
        self.chain.assemble(gap, definite);
        std::mem::swap(&mut self.chain.kept, &mut self.chain.room.kept);
    }

    /// Brings back the directors at the start of a step that has been set out on.
    #[inline(always)]
    fn recall_directors(&mut self) {
        let all = Lane::splat(self.chain.simd, 1.0);
        keep_directors(&mut self.chain.room.d_start, &self.before.q, all);
    }

    /// Brings back where the last call of a step has led, for the step to be taken.
    pub(super) fn arrive(&mut self) {
        struct Arrive<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for Arrive<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                self.0.resume();
                self.0.chain.shape();
                self.0.chain.measure_joints();
            }
        }
        self.chain.simd.vectorize(Arrive(self));
    }
}
