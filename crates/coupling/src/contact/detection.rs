//! Who touches whom at the end of a step, and whom they would have passed through.

use super::ball_joints::BallJoints;
use super::fiber_contacts::{fiber_number, fiber_rank, fibers, put_together, same_fibers};
use super::node_motion::NodeMotion;
use super::object_detector::ObjectDetector;
use super::pair_lists::{DETECTION_CHUNK, by_fibers, of_overlapping, sort};
use super::tunnelling::{bends, goes_on, keep_sides, leads_through};
use crate::body_ref::BodyRef;
use crate::contact_point::{ContactPoint, same_place};
use crate::held_places::HeldPlaces;
use crate::merging::{merge, retain_others};
use crate::object::CollisionObject;
use rapunzel_collision::{
    Candidates, CapsuleContact, Capsules, CollisionError, Pair, contacts_of_groups,
    squared_distances,
};
use rayon::prelude::*;

/// How much closer two segments may come before the list of pairs is made anew, in margins.
const RESERVE: f64 = 128.0;

/// Finds contact points, with lists that live for many steps.
pub(crate) struct ContactDetector {
    /// Largest gap of a contact point that is listed, m.
    margin: f64,
    /// How much larger it is where all are asked for, m.
    more: f64,
    /// Whether what is near at the start belongs to a list wherever it ends: a film holds it.
    holds: bool,
    candidates: Candidates,
    objects: ObjectDetector,
    /// What is beside these does not touch.
    pub(super) joints: BallJoints,
    /// Number of segments, from the root on, of each fibre that are inside a nozzle, where they
    /// touch nothing; empty where none is fed.
    in_nozzles: Vec<usize>,
}

/// What fibres and objects are in each other at the end of a motion.
pub(crate) struct Overlaps {
    /// Contact points of the pairs that were listed, sorted by pair and place.
    pub(crate) points: Vec<ContactPoint>,
    /// Largest depth of all pairs, m; not below zero.
    pub(crate) deepest: f64,
    /// Whether the motion leads fibres through each other, whatever the points at its end.
    pub(crate) through: bool,
}

impl ContactDetector {
    /// Lists contact points with gaps up to `margin`, m, and up to `more` above it where all are
    /// asked for; if a film `holds` them, also those that only had such gaps at the start.
    pub(crate) fn new(margin: f64, more: f64, holds: bool) -> Result<Self, CollisionError> {
        // Of what is farther, a list knows what was near when it was made: chance would decide.
        let candidates = Candidates::new(margin + more, RESERVE * margin)?;
        let (objects, joints) = (ObjectDetector::default(), BallJoints::default());
        Ok(Self { margin, more, holds, candidates, objects, joints, in_nozzles: Vec::new() })
    }

    /// Lets fibres grow out of objects from now on: of these pairs by their numbers, in order, the
    /// first segment of the fibre does not touch the object.
    pub(crate) fn root(&mut self, rooted: Vec<[u32; 2]>) {
        self.objects.root(rooted);
    }

    /// Lets the first segments of each fibre touch nothing from now on: as many as it has inside a
    /// nozzle. Empty where none is fed.
    pub(crate) fn hide(&mut self, in_nozzles: Vec<usize>) {
        self.in_nozzles = in_nozzles;
    }

    /// Replaces `points` by all contact points of a motion, with their places and normals at its
    /// end, sorted by pair and place; none is missed that a straight motion of all nodes would lead
    /// through. Fibres touch objects where they are `held`.
    pub(crate) fn detect(
        &mut self,
        motion: &NodeMotion,
        objects: &[CollisionObject],
        held: &HeldPlaces,
        points: &mut Vec<ContactPoint>,
    ) -> Result<(), CollisionError> {
        let margin = self.margin + self.more;
        self.list(motion, objects, held, margin, |_, near, _| near, points).map(|_| ())
    }

    /// Contact points of fibres that are deeper than `depth`, m, in each other at the end of a
    /// motion, or that it would lead through each other, with gaps up to the margin, and contact
    /// points of objects. The others of a dense list are many, and of no use where it has been
    /// solved.
    pub(crate) fn overlaps(
        &mut self,
        motion: &NodeMotion,
        objects: &[CollisionObject],
        depth: f64,
    ) -> Result<Overlaps, CollisionError> {
        let (mut points, mut deepest) = (Vec::new(), 0.0);
        let chosen = |end: &Capsules, near, fast: &[CapsuleContact]| {
            let (chosen, left) = of_overlapping(end, near, fast, depth);
            deepest = left;
            chosen
        };
        let held = HeldPlaces::default();
        let through = self.list(motion, objects, &held, self.margin, chosen, &mut points)?;
        let deepest = points.iter().map(|point| -point.gap).fold(deepest, f64::max);
        Ok(Overlaps { points, deepest, through })
    }

    /// Replaces `points` by the contact points with gaps up to `margin`, m, of the near pairs that
    /// `chosen` leaves. Returns whether the motion leads fibres through each other.
    fn list(
        &mut self,
        motion: &NodeMotion,
        objects: &[CollisionObject],
        held: &HeldPlaces,
        margin: f64,
        chosen: impl FnOnce(&Capsules, Vec<Pair>, &[CapsuleContact]) -> Vec<Pair>,
        points: &mut Vec<ContactPoint>,
    ) -> Result<bool, CollisionError> {
        let (start, end) = (motion.capsules(motion.start)?, motion.capsules(motion.end)?);
        let mut pairs = self.candidates.on_the_way(&start, &end)?;
        if let Some(sought) = motion.sought {
            pairs
                .retain(|(pair, _)| fibers(motion.layout, pair).iter().any(|&fiber| sought[fiber]));
        }
        if !self.joints.is_empty() {
            pairs.retain(|(pair, _)| !self.joints.parts(pair));
        }
        if !self.in_nozzles.is_empty() {
            let layout = motion.layout;
            let mut hidden = vec![false; layout.segments()];
            for (fiber, held) in self.in_nozzles.iter().enumerate() {
                hidden[layout.segment_range(fiber)][..*held].fill(true);
            }
            pairs.retain(|(pair, _)| pair.iter().all(|&segment| !hidden[segment as usize]));
        }
        let inner = motion.sections.inner();
        let (near, fast) = sort(&start, &end, &pairs, margin, (self.holds, inner));
        // They are many more than what follows is of.
        drop(pairs);
        let near = by_fibers(end.layout(), chosen(&end, near, &fast));
        let most = if self.holds { f64::MAX } else { margin };
        let same = |a: &Pair, b: &Pair| same_fibers(end.layout(), a, b);
        let chosen = |found: &[CapsuleContact], stay: &mut Vec<CapsuleContact>| {
            places(&end, &motion.sections.closest(&end, found), stay);
        };
        let mut contacts = Vec::new();
        contacts_of_groups(&end, &near, most, same, chosen, &mut contacts)?;
        drop(near);
        let through = fast.iter().any(|contact| leads_through(&start, &end, contact, inner));
        add(&end, fast, &mut contacts);
        let hidden = &self.in_nozzles;
        let mut others = self.objects.contact_points(motion, objects, held, hidden, margin);
        others.retain(|point| !self.joints.parts_point(point));
        others.sort_unstable_by_key(ContactPoint::rank);
        others.dedup_by(|b, a| a.rank().same(&b.rank()));
        put_together(&end, &contacts, &others, points);
        keep_sides(&start, points);
        motion.sections.seat(motion.layout, points);
        points.par_iter_mut().for_each(ContactPoint::meet);
        Ok(through)
    }
}

/// Puts contacts on the way between the others, but those that are one place with another, or where
/// a fibre only bends.
fn add(end: &Capsules, mut fast: Vec<CapsuleContact>, contacts: &mut Vec<CapsuleContact>) {
    if fast.is_empty() {
        return;
    }
    let layout = end.layout();
    let rank = |contact: &CapsuleContact| fiber_rank(layout, contact);
    fast.sort_unstable_by_key(rank);
    merge(contacts, fast, |a, b| rank(a) > rank(b));
    let same = |[a, b]: [&CapsuleContact; 2]| {
        same_fibers(layout, &a.pair, &b.pair) && rank(a).same(&rank(b))
    };
    let goes = |i: usize| {
        let own = &contacts[i];
        i > 0 && same([&contacts[i - 1], own]) || bends(end, own)
    };
    let goes: Vec<bool> = (0..contacts.len()).into_par_iter().map(goes).collect();
    retain_others(contacts, goes);
}

/// Puts the contacts of two fibres behind a list in the order of their places; of those that are
/// one place the first stays, and none where a fibre only bends, or goes on towards the other.
fn places(end: &Capsules, found: &[CapsuleContact], stay: &mut Vec<CapsuleContact>) {
    let Some(first) = found.first() else { return };
    let layout = end.layout();
    // As by rank, with less to look up, and less to move.
    let firsts = fibers(layout, &first.pair).map(|f| layout.segment_range(f).start);
    let key = |(i, contact): (usize, &CapsuleContact)| {
        let at = |side: usize| {
            let segment = contact.pair[side] as usize - firsts[side];
            (segment as f64 + contact.fractions[side]).to_bits()
        };
        ([at(0), at(1)], contact.pair, i)
    };
    let proper = found.iter().enumerate().filter(|(_, contact)| !goes_on(end, contact));
    let mut ordered: Vec<_> = proper.map(key).collect();
    ordered.sort_unstable();
    let mut before = None;
    for (at, _, i) in ordered {
        if !before.is_some_and(|before| same_place(before, at)) && !bends(end, &found[i]) {
            stay.push(found[i]);
        }
        before = Some(at);
    }
}

/// How far apart the fibres of some contact points are at the end of a motion, m, whatever the
/// places and normals of these; infinitely if one side is an object.
pub(crate) fn gaps(
    motion: &NodeMotion,
    points: &[ContactPoint],
) -> Result<Vec<f64>, CollisionError> {
    let end = motion.capsules(motion.end)?;
    let first = |fiber: u32| fiber_number(motion.layout.segment_range(fiber as usize).start);
    let chunk = |(points, gaps): (&[ContactPoint], &mut [f64])| {
        let (mut places, mut pairs, mut squared) = (Vec::new(), Vec::new(), Vec::new());
        for (i, point) in points.iter().enumerate() {
            if let [BodyRef::Fiber(fiber), BodyRef::Fiber(partner)] = point.sides {
                let [s, t] = point.segments;
                places.push(i);
                pairs.push([first(fiber) + s, first(partner) + t]);
            }
        }
        squared_distances(&end, &pairs, &mut squared);
        for ((place, pair), squared) in places.into_iter().zip(pairs).zip(squared) {
            gaps[place] = motion.sections.gap(&end, pair, squared, &points[place].normal);
        }
    };
    let mut gaps = vec![f64::INFINITY; points.len()];
    points.par_chunks(DETECTION_CHUNK).zip(gaps.par_chunks_mut(DETECTION_CHUNK)).for_each(chunk);
    Ok(gaps)
}

#[cfg(test)]
mod tests {
    use super::super::sections::{OrientedSections, SectionShapes};
    use super::super::tunnelling::LEAN;
    use super::*;
    use crate::TimeInterval;
    use nalgebra::Point3;
    use proptest::prelude::*;
    use rapunzel_fiber::Layout;

    const RADIUS: f64 = 3.5e-5;
    const LENGTH: f64 = 3e-3;

    /// The contact points of fibres that do not move, by their nodes in lengths of a segment; the
    /// last coordinate in radii.
    fn touches_at_rest(fibers: &[&[[f64; 3]]]) -> Vec<ContactPoint> {
        sought_at_rest(fibers, None)
    }

    /// The same of those that are `sought`.
    fn sought_at_rest(fibers: &[&[[f64; 3]]], sought: Option<&[bool]>) -> Vec<ContactPoint> {
        let layout = Layout::new(fibers.iter().map(|nodes| nodes.len() - 1));
        let at = |&[x, y, z]: &[f64; 3]| Point3::new(x * LENGTH, y * LENGTH, z * RADIUS);
        let nodes: Vec<_> = fibers.concat().iter().map(at).collect();
        let shapes = SectionShapes::round(vec![RADIUS; layout.segments()]);
        let sections = OrientedSections { shapes: &shapes, directors: &[] };
        let (start, end) = (&nodes[..], &nodes[..]);
        let step = TimeInterval { start: 0.0, length: 1e-3 };
        let motion = NodeMotion { layout: &layout, sections, start, end, step, sought };
        let mut detector = ContactDetector::new(RADIUS, RADIUS, false).expect("lengths");
        let mut points = Vec::new();
        detector.detect(&motion, &[], &HeldPlaces::default(), &mut points).expect("one layout");
        points
    }

    proptest! {
        /// Fibres that lie side by side touch across, at every node, wherever the nodes of the
        /// other are: nothing catches as they slide.
        #[test]
        fn fibers_side_by_side_touch_across(shift in prop_oneof![-1e-2..1e-2, -0.9..0.9_f64]) {
            let line = |from: f64, z: f64| [0.0, 1.0, 2.0, 3.0, 4.0].map(|i| [from + i, 0.0, z]);
            let points = touches_at_rest(&[&line(0.0, 0.0), &line(shift, 2.01)]);
            for point in &points {
                prop_assert!(point.normal.x.abs() <= LEAN * (1.0 + 1e-9), "{point:?}");
            }
            // Of places that are nearer to each other than a radius one stays.
            let apart = RADIUS / LENGTH;
            for node in [1.0, 2.0, 3.0] {
                for side in [0, 1] {
                    let there = |point: &ContactPoint| (point.at()[side] - node).abs() <= apart;
                    prop_assert!(points.iter().any(there), "{node}: {points:?}");
                }
            }
        }
    }

    proptest! {
        /// Of fibres that are sought the same contact points are found as if all were, and none of
        /// the others.
        #[test]
        fn what_is_sought_is_found_as_among_all(
            turns in prop::array::uniform4(-1.0..1.0_f64),
            sought in prop::array::uniform4(any::<bool>()),
        ) {
            let line = |k: usize| {
                let (y, x) = (1.5 * turns[k]).sin_cos();
                let along = |i: f64| [i * x, i * y, 2.01 * k as f64];
                [-1.5, -0.5, 0.5, 1.5].map(along)
            };
            let lines = [0, 1, 2, 3].map(line);
            let fibers = lines.each_ref().map(|line| &line[..]);
            let is_sought = |side: &BodyRef| {
                matches!(side, BodyRef::Fiber(fiber) if sought[*fiber as usize])
            };
            let mut all = touches_at_rest(&fibers);
            prop_assert!(all.len() >= 3, "crossed in a row: {}", all.len());
            all.retain(|point| point.sides.iter().any(is_sought));
            let key = |points: &[ContactPoint]| -> Vec<_> {
                points.iter().map(|point| (point.rank(), point.gap, point.normal)).collect()
            };
            prop_assert_eq!(key(&sought_at_rest(&fibers, Some(&sought))), key(&all));
        }
    }

    /// Where both segments lead away from what their node touches it is the node that contact
    /// points.
    #[test]
    fn a_bend_touches_with_its_node() {
        let bent = [[-1.0, 0.0, 40.0], [0.0, 0.0, 0.0], [1.0, 0.0, 40.0]];
        let points = touches_at_rest(&[&bent, &[[0.0, -1.0, -2.01], [0.0, 1.0, -2.01]]]);
        let [point] = points[..] else { panic!("one touch: {points:?}") };
        assert!((point.at()[0] - 1.0).abs() < 1e-12 && point.normal.z > 1.0 - 1e-12, "{point:?}");
    }

    /// Of two crossed fibres the upper one, two diameters above, moves to another height: below the
    /// lower one it has passed through it.
    #[test]
    fn a_way_through_another_fibre_is_told() {
        let radius = 3.5e-5;
        let layout = Layout::new([1, 1]);
        let at = |height: f64| {
            let z = 2.0 * radius * height;
            [[-5e-4, 0.0, 0.0], [5e-4, 0.0, 0.0], [0.0, -5e-4, z], [0.0, 5e-4, z]].map(Point3::from)
        };
        let heights = [(1.01, false), (0.98, false), (0.6, false), (-0.1, true), (-2.0, true)];
        for (height, through) in heights {
            let (start, end) = (&at(2.0), &at(height));
            let shapes = SectionShapes::round(vec![radius; 2]);
            let sections = OrientedSections { shapes: &shapes, directors: &[] };
            let step = TimeInterval { start: 0.0, length: 1e-3 };
            let motion = NodeMotion { layout: &layout, sections, start, end, step, sought: None };
            let mut detector = ContactDetector::new(radius, radius, false).expect("lengths");
            let found = detector.overlaps(&motion, &[], 0.1 * radius).expect("one layout");
            assert_eq!(found.through, through, "{height}");
            let deep = found.points.iter().any(|point| point.gap < -0.5 * radius);
            assert_eq!(deep, height < 0.7, "{height}");
            // What is hardly deep is told, but not listed.
            assert_eq!(found.points.is_empty(), height > 0.7, "{height}");
            let (depth, deepest) = (2.0 * radius * (1.0 - height).max(0.0), found.deepest);
            assert!(through || (deepest - depth).abs() < 1e-9 * radius, "{height}: {deepest}");
        }
    }
}
