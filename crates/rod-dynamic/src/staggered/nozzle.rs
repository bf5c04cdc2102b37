//! A nozzle that a fibre is paid out of, and drawn into, by its root.
//!
//! Segments whose middles are inside are held in the frame of the root. The joint behind the last
//! of them stands for the rod from the mouth to the middle of the first segment outside, `l` long:
//! its stiffness is `B / l` and its natural turn `kappa l`. So the rod is clamped at the mouth
//! itself, wherever that is between nodes, and a segment that leaves or enters has the frame of the
//! nozzle by then. What a bent rod gains or loses where it passes the mouth is work of the nozzle:
//! its axial force on the rod there is `m^2 / 2 B`, that of a sliding sleeve (Bigoni et al. 2015).
//! Gravity, distributed forces and the air act on what is outside.

use super::array::{Array, at, set, zeros};
use super::chain::RotationChain;
use super::simd_batch::SimdBatch;
use pulp::Simd;
use pulp::bytemuck::Zeroable;
use rapunzel_lanes::{LANES, Lane, M3, Quat, Sym, V3};

/// A segment is held until so much of a joint's length is outside of it, in that length: a shorter
/// joint would be stiffer than Newton's method needs to know.
const LEAST: f64 = 1.0 / 64.0;
/// Stiffness of a frame that is held, N m: a torque turns it by nothing.
const HELD: f64 = 1e30;

/// Number of segments of a fibre, from the root on, whose frames a nozzle holds; `lengths` are
/// those of all segments, m, and `inside` is the length of the fibre that is inside, m.
#[must_use]
pub fn segments_in_nozzle(lengths: &[f64], inside: f64) -> usize {
    let mut arc = 0.0;
    let mut before = 0.0;
    let held = lengths.iter().take_while(|h| {
        let left = arc + 0.5 * **h - inside;
        let joint = 0.5 * (before + **h);
        (arc, before) = (arc + **h, **h);
        left < LEAST * joint
    });
    if inside > 0.0 { held.count() } else { 0 }
}

/// Nozzles of all lanes; lanes without one have a fibre that is outside.
pub(super) struct NozzleLanes<S: Simd> {
    /// 1 where a fibre has been inside.
    pub(super) fed: S::f64s,
    /// 1 where a segment is outside, 0 where its frame is held (1 per segment).
    loose: Array<S>,
    /// Part of the rod that a node stands for which is outside (1 per node).
    outside: Array<S>,
    /// Length of a joint in that of its rod which may bend (1 per joint).
    stiffening: Array<S>,
}

impl<S: Simd> NozzleLanes<S> {
    fn new(simd: S, n: usize) -> Self {
        let ones = |count: usize| {
            let mut array = zeros::<S>(count);
            array.fill(simd.splat_f64s(1.0));
            array
        };
        Self {
            fed: S::f64s::zeroed(),
            loose: ones(n),
            outside: ones(n + 1),
            stiffening: ones(n + 1),
        }
    }

    /// Sets one lane to a fibre of these segments, m, that is `inside` by so much, m.
    fn set(&mut self, lane: usize, lengths: &[f64], inside: f64) {
        if inside > 0.0 {
            set(std::slice::from_mut(&mut self.fed), 0, lane, 1.0);
        }
        let n = lengths.len();
        let held = segments_in_nozzle(lengths, inside);
        let half = |e: usize| lengths.get(e).map_or(0.0, |h| 0.5 * h);
        let mut arc = 0.0;
        for a in 0..=n {
            let (behind, ahead) = (if a > 0 { half(a - 1) } else { 0.0 }, half(a));
            let length = behind + ahead;
            let outside = ((arc + ahead - inside) / length).clamp(0.0, 1.0);
            set(&mut self.outside, a, lane, outside);
            let bends = inside > 0.0 && a == held && a < n;
            let stiffening = if bends { length / (arc + ahead - inside) } else { 1.0 };
            set(&mut self.stiffening, a, lane, stiffening);
            if a < n {
                set(&mut self.loose, a, lane, f64::from(a >= held));
                arc += lengths[a];
            }
        }
    }
}

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
            super::array::store_quat(&mut self.chain.q, e, held.select(to, here));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::segments_in_nozzle;

    #[test]
    fn segments_are_held_as_far_as_their_middles_are_inside() {
        let lengths = [1.0, 1.0, 2.0];
        let held = |inside| segments_in_nozzle(&lengths, inside);
        assert_eq!([0.0, 0.4, 0.6, 1.4, 1.6, 2.9, 3.1].map(held), [0, 0, 1, 1, 2, 2, 3]);
    }
}
