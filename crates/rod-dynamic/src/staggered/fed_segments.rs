//! What a nozzle changes in the equations of a fibre.

use super::array::{at, set, store_quat};
use super::chain::RotationChain;
use super::nozzle::NozzleLanes;
use super::simd_batch::SimdBatch;
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane, M3, Quat, Sym, V3};

/// Stiffness of a frame that is held, N m: a torque turns it by nothing.
const HELD: f64 = 1e30;

impl<S: Simd> RotationChain<S> {
    /// Part of the rod of node `a` that is outside of the nozzle; `None` where all of every fibre
    /// is.
    #[inline(always)]
    pub(super) fn outside(&self, a: usize) -> Option<Lane<S>> {
        self.nozzle.as_ref().map(|nozzle| Lane::new(self.simd, nozzle.outside[a]))
    }

    /// 1 where segment `e` is outside of the nozzle, 0 where its frame is held; `None` where all
    /// are outside.
    #[inline(always)]
    pub(super) fn loose(&self, e: usize) -> Option<Lane<S>> {
        self.nozzle.as_ref().map(|nozzle| Lane::new(self.simd, nozzle.loose[e]))
    }

    /// Stiffness of joint `j`, N m, and its natural rotation vector, rad.
    #[inline(always)]
    pub(super) fn bending(&self, j: usize) -> [V3<S>; 2] {
        let [stiffness, rest] =
            [&self.model.stiffness, &self.model.rest].map(|array| self.vec(array, j));
        match &self.nozzle {
            None => [stiffness, rest],
            Some(nozzle) => {
                let factor = Lane::new(self.simd, nozzle.stiffening[j]);
                [stiffness.scale(factor), rest.scale(factor.recip())]
            }
        }
    }

    /// Takes a segment's torque, Hessian, lever and coupling to the next one out of Newton's
    /// equations where it is not `loose`.
    #[inline(always)]
    pub(super) fn hold_frame(
        loose: Lane<S>,
        (torque, hessian): (&mut V3<S>, &mut Sym<S>),
        (lever, coupling): (&mut M3<S>, &mut M3<S>),
    ) {
        let held = (loose.lift(1.0) - loose) * loose.lift(HELD);
        *torque = torque.scale(loose);
        *hessian = hessian.scale(loose) + Sym::diagonal(held);
        *lever = lever.scale(loose);
        *coupling = coupling.scale(loose);
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Sets how much of the fibre of one lane is inside a nozzle, m.
    pub(super) fn set_nozzle(&mut self, lane: usize, inside: f64) {
        set(std::slice::from_mut(&mut self.chain.ends.inside), 0, lane, inside);
        if inside > 0.0 || self.chain.nozzle.is_some() {
            let RotationChain { simd, n, nozzle, model, .. } = &mut self.chain;
            let lengths: Vec<f64> = (0..*n).map(|e| at(&model.h, e, lane)).collect();
            let nozzle = nozzle.get_or_insert_with(|| Box::new(NozzleLanes::new(*simd, *n)));
            nozzle.set(lane, &lengths, inside);
        }
    }

    /// How much of the fibre of one lane is inside a nozzle, m.
    pub(super) fn inside(&self, lane: usize) -> f64 {
        at(std::slice::from_ref(&self.chain.ends.inside), 0, lane)
    }

    /// Length of joint `j` of one lane in that of its rod which may bend.
    pub(super) fn stiffening(&self, lane: usize, j: usize) -> f64 {
        self.chain.nozzle.as_ref().map_or(1.0, |nozzle| at(&nozzle.stiffening, j, lane))
    }

    /// Turns the segments that are held in nozzles to the frames of these, in the lanes wanted.
    #[inline(always)]
    pub(super) fn hold_in_nozzles(&mut self, wanted: &[bool; LANES]) {
        if self.chain.nozzle.is_none() {
            return;
        }
        let wanted = self.flags(wanted);
        let to = self.chain.quat(&self.chain.ends.root_frame);
        for e in 0..self.chain.n {
            let Some(loose) = self.chain.loose(e) else { return };
            let held = (wanted - loose * wanted).positive();
            if self.chain.spins {
                let old = self.chain.one(&self.chain.kept.spin, e);
                let spin = self.chain.spin_to(e, to);
                self.chain.kept.spin[e] = held.select(spin, old).value;
            }
            let here = Quat::load(self.chain.simd, &self.chain.q, e);
            store_quat(&mut self.chain.q, e, held.select(to, here));
        }
    }
}
