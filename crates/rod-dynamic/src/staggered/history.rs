//! Rates of one class of vector coordinates of a SIMD batch: nodes, directors, or joints.

use super::array::{Array, set, store, zeros};
use super::chain::RotationChain;
use super::scheme::{Rates, Stage, StepProblem};
use pulp::Simd;
use rapunzel_lanes::{Lane, V3};

/// Rates of vector coordinates (3 registers each). Arrays that would always be zero are empty:
/// accelerations of a scheme without memory of them, and all rates of joints without damping.
pub(super) struct KinematicHistory<S: Simd> {
    pub(super) v: Array<S>,
    pub(super) a: Array<S>,
    pub(super) acceleration: Array<S>,
}

impl<S: Simd> KinematicHistory<S> {
    pub(super) fn new(count: usize, memory: bool) -> Self {
        let remembered = if memory { count } else { 0 };
        let track = |count: usize| zeros::<S>(3 * count);
        Self { v: track(count), a: track(remembered), acceleration: track(remembered) }
    }

    /// Rates of coordinate `i` at the start of a step. Where its methods do not depend on them,
    /// accelerations are not read: those of many fibres do not stay in the cache.
    #[inline(always)]
    pub(super) fn rates(&self, chain: &RotationChain<S>, stage: &Stage<S>, i: usize) -> Rates<S> {
        let v = chain.vec_or_zero(&self.v, i);
        if !stage.remembers {
            let none = V3::splat(chain.simd, 0.0);
            return Rates { v, a: none, acceleration: none };
        }
        let (a, acceleration) = (&self.a, &self.acceleration);
        Rates { v, a: chain.vec_or_zero(a, i), acceleration: chain.vec_or_zero(acceleration, i) }
    }

    /// Commits the displacement `u` of coordinate `i` in the lanes where `done > 0`. At the start
    /// of a motion only the acceleration is taken. Accelerations are written if the stage or the
    /// next step is of methods that depend on them.
    #[inline(always)]
    pub(super) fn commit(
        &mut self,
        chain: &RotationChain<S>,
        stage: &Stage<S>,
        i: usize,
        u: V3<S>,
        (done, next_remembers): (Lane<S>, bool),
    ) {
        let old = self.rates(chain, stage, i);
        let (du, vc) = stage.predict(old);
        let acceleration = (u - du).scale(stage.c1);
        let new = if stage.problem == StepProblem::Start {
            Rates { v: old.v, a: acceleration, acceleration }
        } else {
            stage.finish(old, u.mul_add(stage.cv, vc), acceleration)
        };
        store(&mut self.v, i, done.positive().select(new.v, old.v));
        if self.a.is_empty() || !(stage.remembers || next_remembers) {
            return;
        }
        store(&mut self.a, i, done.positive().select(new.a, old.a));
        store(
            &mut self.acceleration,
            i,
            done.positive().select(new.acceleration, old.acceleration),
        );
    }

    /// Sets the accelerations of one lane to zero.
    pub(super) fn forget(&mut self, lane: usize) {
        for array in [&mut self.a, &mut self.acceleration] {
            (0..array.len()).for_each(|i| set(array, i, lane, 0.0));
        }
    }

    pub(super) fn arrays(&self) -> [&[S::f64s]; 3] {
        [&self.v, &self.a, &self.acceleration]
    }

    pub(super) fn arrays_mut(&mut self) -> [&mut [S::f64s]; 3] {
        [&mut self.v, &mut self.a, &mut self.acceleration]
    }
}
