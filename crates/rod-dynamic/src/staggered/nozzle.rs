//! A nozzle that a fibre is paid out of, and drawn into, by its root.
//!
//! Segments whose middles are inside are held in the frame of the root. The joint behind the last
//! of them stands for the rod from the mouth to the middle of the first segment outside, `l` long:
//! its stiffness is `B / l` and its natural turn `kappa l`. So the rod is clamped at the mouth
//! itself, wherever that is between nodes, and a segment that leaves or enters has the frame of the
//! nozzle by then. What a bent rod gains or loses where it passes the mouth is work of the nozzle:
//! its axial force on the rod there is `m^2 / 2 B`, that of a sliding sleeve (Bigoni et al. 2015).
//! Gravity, distributed forces and the air act on what is outside.

use super::array::{Array, set, zeros};
use pulp::Simd;
use pulp::bytemuck::Zeroable;

/// A segment is held until so much of a joint's length is outside of it, in that length: a shorter
/// joint would be stiffer than Newton's method needs to know.
const LEAST: f64 = 1.0 / 64.0;

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
    pub(super) loose: Array<S>,
    /// Part of the rod that a node stands for which is outside (1 per node).
    pub(super) outside: Array<S>,
    /// Length of a joint in that of its rod which may bend (1 per joint).
    pub(super) stiffening: Array<S>,
}

impl<S: Simd> NozzleLanes<S> {
    pub(super) fn new(simd: S, n: usize) -> Self {
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
    pub(super) fn set(&mut self, lane: usize, lengths: &[f64], inside: f64) {
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
