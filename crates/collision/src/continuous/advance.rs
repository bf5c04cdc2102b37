//! Conservative advancement of parts.
//!
//! A convex body that moves passes the origin. At any time, its point nearest to the origin gives a
//! plane that separates the two, and the velocities of its corners along the normal of the plane
//! say how long the plane keeps separating: until then nothing is missed, whatever the accuracy of
//! the nearest point. Time is advanced from plane to plane (Mirtich 1996). Where the corners of a
//! large body come much faster than its nearest point, so that the steps would creep, the body is
//! cut in halves that are advanced on their own, always the one that is behind first.

use super::{Impact, Path};
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

/// After so many evaluations the search is given up. Only bodies that stay within a few tolerances
/// of the reach, all along, come near it.
const MAX_EVALUATIONS: usize = 8192;

/// Coordinates are computed to within this many times the largest of them.
const ADVANCE_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A cut pays when the halves may advance this many times as far.
const CREEP: f64 = 4.0;

/// A part of what moves past the origin.
pub(super) trait MovingPart<const N: usize>: Copy {
    /// Where the part is at `time`, and how long it stays farther than `keep`.
    fn look(&self, time: f64, keep: f64) -> PartSample<N>;

    /// Two parts that cover this one.
    fn halves(&self, look: &PartSample<N>) -> [Self; 2];
}

/// A part at one time.
pub(super) struct PartSample<const N: usize> {
    /// Where its nearest point is.
    pub(super) coordinates: [f64; N],
    /// Its nearest point.
    pub(super) offset: Vector3<f64>,
    /// The distance of that.
    pub(super) distance: f64,
    /// Up to this time the part stays away; infinite if for good.
    pub(super) safe: f64,
    /// What `safe` would be if all the part moved as its nearest point does.
    pub(super) hope: f64,
}

/// Up to which time a plane with unit `normal` keeps corners farther than `keep` from the origin.
pub(super) fn separated(paths: &[Path], normal: &Vector3<f64>, time: f64, keep: f64) -> f64 {
    let mut safe = f64::INFINITY;
    for path in paths {
        let rate = normal.dot(&path.velocity);
        let gap = normal.dot(&path.at(time)) - keep;
        if rate < 0.0 {
            safe = safe.min(time - gap.max(0.0) / rate);
        } else if gap <= 0.0 {
            safe = time;
        }
    }
    safe
}

/// The first time at which `body` comes within `reach` of the origin; `scale` bounds the
/// coordinates that occur.
pub(super) fn first_impact<const N: usize>(
    body: impl MovingPart<N>,
    scale: f64,
    reach: f64,
    tolerance: f64,
) -> Option<Impact<N>> {
    let tolerance = tolerance.max(ADVANCE_ROUNDING * (scale + reach));
    // Half of the tolerance bounds every step from below, and covers the rounding.
    let keep = reach + 0.5 * tolerance;
    let mut waiting = BinaryHeap::new();
    let mut next = Some(Waiting { safe: 0.0, part: body });
    let mut evaluations = 0;
    while let Some(Waiting { safe: time, part }) = next {
        let look = part.look(time, keep);
        evaluations += 1;
        // What is not finite touches.
        let finite = scale.is_finite();
        let apart = finite && look.distance > reach + tolerance;
        if !apart || evaluations == MAX_EVALUATIONS {
            let PartSample { coordinates, offset, .. } = look;
            let resolved = finite && !apart;
            return Some(Impact { time, coordinates, offset, resolved, evaluations });
        }
        next = None;
        if look.safe < 1.0 {
            if CREEP * (look.safe - time) < look.hope.min(1.0) - time {
                for part in part.halves(&look) {
                    waiting.push(Waiting { safe: look.safe, part });
                }
            } else {
                next = Some(Waiting { safe: look.safe, part });
            }
        }
        next = match (next, waiting.peek_mut()) {
            (None, Some(first)) => Some(PeekMut::pop(first)),
            (Some(part), Some(mut first)) if first.safe < part.safe => {
                Some(std::mem::replace(&mut *first, part))
            }
            (part, _) => part,
        };
    }
    None
}

/// A part that is safe up to a time; the greatest is the one that is safe for the shortest.
struct Waiting<P> {
    safe: f64,
    part: P,
}

impl<P> Ord for Waiting<P> {
    fn cmp(&self, other: &Self) -> Ordering {
        other.safe.total_cmp(&self.safe)
    }
}

impl<P> PartialOrd for Waiting<P> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<P> PartialEq for Waiting<P> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<P> Eq for Waiting<P> {}
