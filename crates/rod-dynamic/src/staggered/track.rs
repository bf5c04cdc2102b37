//! The motion of one class of vector coordinates of a pack: nodes, directors, or joints.

use super::chain::{Chain, store};
use super::lanes::{Array, Lane, V3, zeros};
use super::scheme::{Problem, Rates, Scheme, Stage};
use pulp::Simd;

/// Rates of `count` vector coordinates.
pub(super) struct Track<S: Simd> {
    pub(super) v: Array<S>,
    pub(super) a: Array<S>,
    pub(super) acceleration: Array<S>,
}

impl<S: Simd> Track<S> {
    pub(super) fn new(count: usize) -> Self {
        let track = || zeros::<S>(3 * count);
        Self { v: track(), a: track(), acceleration: track() }
    }

    #[inline(always)]
    pub(super) fn rates(&self, chain: &Chain<S>, i: usize) -> Rates<S> {
        Rates {
            v: chain.vec(&self.v, i),
            a: chain.vec(&self.a, i),
            acceleration: chain.vec(&self.acceleration, i),
        }
    }

    /// Takes over the displacement `u` of coordinate `i` in the lanes where `done > 0`. At the
    /// start of a motion only the acceleration is taken.
    #[inline(always)]
    pub(super) fn commit(
        &mut self,
        chain: &Chain<S>,
        scheme: Scheme,
        stage: &Stage<S>,
        i: usize,
        u: V3<S>,
        done: Lane<S>,
    ) {
        let old = self.rates(chain, i);
        let (du, vc) = scheme.predict(stage, old);
        let acceleration = (u - du).scale(stage.c1);
        let new = if stage.problem == Problem::Start {
            Rates { v: old.v, a: acceleration, acceleration }
        } else {
            scheme.finish(stage, old, u.fma(stage.cv, vc), acceleration)
        };
        store(&mut self.v, i, new.v.positive_or(done, old.v));
        store(&mut self.a, i, new.a.positive_or(done, old.a));
        store(&mut self.acceleration, i, new.acceleration.positive_or(done, old.acceleration));
    }

    pub(super) fn arrays(&self) -> [&[S::f64s]; 3] {
        [&self.v, &self.a, &self.acceleration]
    }

    pub(super) fn arrays_mut(&mut self) -> [&mut [S::f64s]; 3] {
        [&mut self.v, &mut self.a, &mut self.acceleration]
    }
}
