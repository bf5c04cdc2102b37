//! Who touches whom at the end of a step, and whom they would have passed through.

use super::object::{Object, Strand};
use super::touch::{Partner, Touch};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::continuous::MovingSegment;
use rapunzel_collision::{Candidates, Capsules, CollisionError, Contact, Pair, Update, contacts};
use rapunzel_fiber::Layout;
use rayon::prelude::*;

/// Pairs that one task takes.
const CHUNK: usize = 2048;

/// Finds touches, with lists that live for many steps.
pub(crate) struct Detector {
    /// Largest gap of a touch that is listed, m.
    margin: f64,
    /// How much larger gaps may be asked for, m.
    more: f64,
    /// How much closer two segments may come before the list is made anew, m.
    reserve: f64,
    candidates: Candidates,
    contacts: Vec<Contact>,
}

/// All nodes before and after a step.
pub(crate) struct Motion<'a> {
    pub(crate) layout: &'a Layout,
    pub(crate) radii: &'a [f64],
    pub(crate) start: &'a [Point3<f64>],
    pub(crate) end: &'a [Point3<f64>],
    pub(crate) time: f64,
    pub(crate) dt: f64,
}

impl Detector {
    /// Lists touches with gaps up to `margin`, m, and up to `more` above it where asked.
    pub(crate) fn new(margin: f64, more: f64) -> Result<Self, CollisionError> {
        let reserve = 8.0 * margin;
        // Of what is farther, a list knows what was near when it was made: chance would decide.
        let candidates = Candidates::new(margin + more, reserve)?;
        Ok(Self { margin, more, reserve, candidates, contacts: Vec::new() })
    }

    /// All touches at the end of a motion, sorted by pair and place; none is missed that a straight
    /// motion of all nodes would lead through. Gaps up to `more`, m, above the margin are listed
    /// too; that is at most what the detector was made for.
    pub(crate) fn touches(
        &mut self,
        motion: &Motion,
        objects: &[Object],
        more: f64,
        touches: &mut Vec<Touch>,
    ) -> Result<(), CollisionError> {
        let [start, end] = [motion.start, motion.end]
            .map(|positions| Capsules::new(motion.layout, positions, motion.radii));
        let (start, end) = (start?, end?);
        self.cover(&start, &end)?;
        let pairs = self.candidates.pairs();
        let (near, fast) = sort(&start, &end, pairs);
        let margin = self.margin + more.min(self.more);
        contacts(&end, &near, margin, &mut self.contacts)?;
        touches.clear();
        let found = self.contacts.iter().chain(&fast).filter(|contact| !bends(&end, contact));
        touches.extend(found.map(|contact| fiber_touch(&end, contact)));
        let fibers = motion.layout.fibers();
        let strand = |fiber: usize| {
            let mut found = Vec::new();
            for (index, object) in (0..).zip(objects) {
                let strand = Strand {
                    fiber: fiber_number(fiber),
                    start: &motion.start[motion.layout.node_range(fiber)],
                    end: &motion.end[motion.layout.node_range(fiber)],
                    radii: &motion.radii[motion.layout.segment_range(fiber)],
                };
                let span = [motion.time, motion.dt];
                object.touches(index, &strand, span, margin, &mut found);
            }
            found
        };
        let found: Vec<_> = (0..fibers).into_par_iter().map(strand).collect();
        found.iter().for_each(|found| touches.extend_from_slice(found));
        touches.par_sort_unstable_by(Touch::order);
        touches.dedup_by(|a, b| a.same(b));
        Ok(())
    }

    /// Makes the list cover the whole motion from `start` to `end`.
    fn cover(&mut self, start: &Capsules, end: &Capsules) -> Result<(), CollisionError> {
        self.candidates.update(start)?;
        while self.candidates.update(end)? != Update::Kept
            && self.candidates.update(start)? != Update::Kept
        {
            // The motion of a single step is wider than the reserve.
            self.reserve *= 2.0;
            self.candidates = Candidates::new(self.margin + self.more, self.reserve)?;
            self.candidates.update(start)?;
        }
        Ok(())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "nodes are counted with 32 bits")]
fn fiber_number(fiber: usize) -> u32 {
    fiber as u32
}

/// Pairs that cannot have passed through each other, and contacts of those that would.
fn sort(start: &Capsules, end: &Capsules, pairs: &[Pair]) -> (Vec<Pair>, Vec<Contact>) {
    let chunk = |pairs: &[Pair]| {
        let (mut near, mut fast) = (Vec::new(), Vec::new());
        for &pair in pairs {
            match passing(start, end, pair) {
                Some(contact) => fast.push(contact),
                None => near.push(pair),
            }
        }
        (near, fast)
    };
    let parts: Vec<_> = pairs.par_chunks(CHUNK).map(chunk).collect();
    let (mut near, mut fast) = (Vec::new(), Vec::new());
    for (n, f) in parts {
        near.extend(n);
        fast.extend(f);
    }
    (near, fast)
}

/// Where two segments would pass through each other: the place of their impact, with the normal at
/// that time and the gap along it at the end.
fn passing(start: &Capsules, end: &Capsules, pair: Pair) -> Option<Contact> {
    let [i, j] = pair.map(|s| s as usize);
    let (a0, b0, a1, b1) = (start.get(i), start.get(j), end.get(i), end.get(j));
    let reach = a0.radius + b0.radius;
    let ways = [a1.start - a0.start, a1.end - a0.end];
    let others = [b1.start - b0.start, b1.end - b0.end];
    let mut travel: f64 = 0.0;
    for way in ways {
        for other in others {
            travel = travel.max((way - other).norm_squared());
        }
    }
    // Axes that were apart by more than the way cannot have crossed.
    if travel < 0.25 * reach * reach || travel < a0.closest(&b0).offset.norm_squared() {
        return None;
    }
    let (a, b) = (MovingSegment::between(&a0, &a1), MovingSegment::between(&b0, &b1));
    let impact = a.impact(&b, 0.9 * reach, 1e-3 * reach)?;
    let normal = nalgebra::Unit::try_new(impact.offset, 0.0)?;
    let [s, t] = impact.coordinates;
    let offset = b1.at(t) - a1.at(s);
    let gap = offset.dot(&normal) - reach;
    Some(Contact { pair, fractions: [s, t], normal, gap })
}

/// Whether two places are so near along one fibre that not even the tightest bend, a half turn about
/// its own radius, lets them touch: what is between them is too short, and only straight capsules
/// overlap there.
fn bends(end: &Capsules, contact: &Contact) -> bool {
    let layout = end.layout();
    let [first, second] = contact.pair.map(|segment| segment as usize);
    if layout.segment_fibers()[first] != layout.segment_fibers()[second] {
        return false;
    }
    let length = |segment: usize| {
        let capsule = end.get(segment);
        (capsule.end - capsule.start).norm()
    };
    let [s, t] = contact.fractions;
    let reach = 0.5 * std::f64::consts::PI * (end.radii()[first] + end.radii()[second]);
    let mut between = (1.0 - s) * length(first) + t * length(second);
    for segment in first + 1..second {
        between += length(segment);
        if between > reach {
            return false;
        }
    }
    between < reach
}

/// The touch of two fibres; the one with the smaller number comes first.
fn fiber_touch(end: &Capsules, contact: &Contact) -> Touch {
    let layout = end.layout();
    let numbers = contact.pair.map(|segment| {
        let fiber = layout.segment_fibers()[segment as usize];
        let first = layout.segment_range(fiber).start;
        (fiber_number(fiber), segment - fiber_number(first))
    });
    let [(fiber, s), (partner, t)] = numbers;
    let axis = |segment: u32| {
        let capsule = end.get(segment as usize);
        capsule.end - capsule.start
    };
    let [own, other] = contact.pair.map(axis);
    let touch = Touch {
        fiber,
        partner: Partner::Fiber(partner),
        segments: [s, t],
        fractions: contact.fractions,
        normal: -*contact.normal,
        axis: own,
        other_axis: other,
        gap: contact.gap,
        drive: Vector3::zeros(),
        lever: Vector3::zeros(),
        impulse: Vector3::zeros(),
    };
    if (fiber, s) <= (partner, t) {
        return touch;
    }
    let [u, v] = contact.fractions;
    Touch {
        fiber: partner,
        partner: Partner::Fiber(fiber),
        segments: [t, s],
        fractions: [v, u],
        normal: *contact.normal,
        axis: other,
        other_axis: own,
        ..touch
    }
}
