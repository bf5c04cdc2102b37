//! One attempt at a step, and what leads to it and follows from it.

use super::array::store;
use super::chain::RotationChain;
use super::joint_geometry::keep_directors;
use super::scheme::StepProblem;
use super::search::SearchOutcome;
use super::simd_batch::SimdBatch;
use super::workspace;
use pulp::bytemuck::Zeroable;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::LANES;

/// Attempts at a step of a batch, in the lanes that are wanted.
pub(super) trait BatchAttempts {
    /// Borrows the thread's workspace, without which only state can be read and set.
    fn enter(&mut self);
    /// Returns the workspace to the thread, unless the batch holds it.
    fn leave(&mut self);
    /// Lets the batch hold its workspace from call to call, or not any more. Only between calls.
    fn hold_workspace(&mut self, holds: bool);
    /// Exchanges the storage of the linearisation for that of the borrowed workspace, or back: of
    /// one that no later call needs nothing is written to what the batch owns.
    fn exchange_linearization(&mut self);
    /// Stores the present directors as those at the start of a step.
    fn set_out(&mut self, wanted: &[bool; LANES]);
    /// Takes the rotation vectors of the joints from the present rotations: the damping of the
    /// first step starts from them.
    fn measure(&mut self, wanted: &[bool; LANES]);
    /// Solves a problem with steps of length `dt[lane]` (s) without committing it.
    fn attempt(
        &mut self,
        dt: &[f64; LANES],
        wanted: &[bool; LANES],
        problem: StepProblem,
        out: &mut [SearchOutcome; LANES],
    );
    /// Makes the last attempt the state, in the lanes that are `done`.
    fn commit(&mut self, dt: &[f64; LANES], done: &[bool; LANES], problem: StepProblem);
}

impl<S: Simd> BatchAttempts for SimdBatch<S> {
    fn enter(&mut self) {
        if self.borrowed.is_none() {
            let mut room = workspace::borrow(self.chain.n);
            std::mem::swap(&mut self.chain.room, &mut room);
            self.exchange_kept();
            self.borrowed = Some(room);
        }
    }

    fn leave(&mut self) {
        if self.holds {
            return;
        }
        if let Some(mut room) = self.borrowed.take() {
            self.exchange_kept();
            std::mem::swap(&mut self.chain.room, &mut room);
            workspace::give_back(room);
        }
    }

    fn hold_workspace(&mut self, holds: bool) {
        self.holds = holds;
        if !holds {
            self.leave();
        }
    }

    fn exchange_linearization(&mut self) {
        let RotationChain { room, kept, .. } = &mut self.chain;
        std::mem::swap(&mut kept.w, &mut room.kept.w);
        std::mem::swap(&mut kept.factor, &mut room.kept.factor);
        std::mem::swap(&mut kept.coupling, &mut room.kept.coupling);
        std::mem::swap(&mut kept.step, &mut room.kept.step);
    }

    fn set_out(&mut self, wanted: &[bool; LANES]) {
        struct SetOut<'a, S: Simd>(&'a mut SimdBatch<S>, &'a [bool; LANES]);
        impl<S: Simd> NullaryFnOnce for SetOut<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let wanted = self.0.flags(self.1);
                let RotationChain { room, q, .. } = &mut self.0.chain;
                keep_directors(&mut room.d_start, q, wanted);
            }
        }
        self.chain.simd.vectorize(SetOut(self, wanted));
    }

    fn measure(&mut self, wanted: &[bool; LANES]) {
        struct Measure<'a, S: Simd>(&'a mut SimdBatch<S>, &'a [bool; LANES]);
        impl<S: Simd> NullaryFnOnce for Measure<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(pack, lanes) = self;
                let wanted = pack.flags(lanes);
                pack.before.phi = pack.phi.clone();
                pack.chain.measure_joints();
                for j in 0..=pack.chain.n {
                    let (new, old) =
                        (pack.chain.vec(&pack.chain.room.phi, j), pack.chain.vec(&pack.phi, j));
                    store(&mut pack.phi, j, wanted.positive().select(new, old));
                }
                for lane in (0..S::F64_LANES).filter(|&lane| lanes[lane]) {
                    pack.strain_laws_at_once(lane);
                }
            }
        }
        self.chain.simd.vectorize(Measure(self, wanted));
    }

    fn attempt(
        &mut self,
        dt: &[f64; LANES],
        wanted: &[bool; LANES],
        problem: StepProblem,
        out: &mut [SearchOutcome; LANES],
    ) {
        struct Attempt<'a, S: Simd>(
            &'a mut SimdBatch<S>,
            &'a [f64; LANES],
            &'a [bool; LANES],
            StepProblem,
            &'a mut [SearchOutcome; LANES],
        );
        impl<S: Simd> NullaryFnOnce for Attempt<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(pack, dt, wanted, problem, out) = self;
                let stage = pack.stage(dt, problem);
                if problem == StepProblem::Step {
                    pack.look_ahead(&stage, wanted);
                } else {
                    pack.chain.kept.spin.fill(S::f64s::zeroed());
                }
                pack.hold_in_nozzles(wanted);
                pack.prepare(&stage);
                pack.begin_laws();
                pack.chain.newton(wanted, &pack.held, problem == StepProblem::Rest, out);
            }
        }
        self.last_dt = *dt;
        self.chain.simd.vectorize(Attempt(self, dt, wanted, problem, out));
    }

    fn commit(&mut self, dt: &[f64; LANES], done: &[bool; LANES], problem: StepProblem) {
        struct Commit<'a, S: Simd>(
            &'a mut SimdBatch<S>,
            &'a [f64; LANES],
            &'a [bool; LANES],
            StepProblem,
        );
        impl<S: Simd> NullaryFnOnce for Commit<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(pack, dt, done, problem) = self;
                let stage = pack.stage(dt, problem);
                pack.take_over(&stage, done);
            }
        }
        self.chain.simd.vectorize(Commit(self, dt, done, problem));
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Exchanges the storage that a step needs from call to call with that of the workspace, unless
    /// the batch owns it.
    fn exchange_kept(&mut self) {
        if !self.keeps {
            let RotationChain { room, kept, .. } = &mut self.chain;
            std::mem::swap(kept, &mut room.kept);
        }
    }
}
