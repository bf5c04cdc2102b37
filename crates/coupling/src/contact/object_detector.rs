//! Who touches which object.

use super::fiber_contacts::fiber_number;
use super::node_motion::NodeMotion;
use crate::contact_point::ContactPoint;
use crate::fiber_on_object::{MovingFiber, ObjectContacts};
use crate::held_places::HeldPlaces;
use crate::known_values::{KnownValue, KnownValues};
use crate::object::{CollisionObject, MovingObject};
use crate::pair;
use nalgebra::{Isometry3, Point3};
use rapunzel_lanes::all_equal;
use rayon::prelude::*;

/// Fibres that one task looks for at objects.
const FIBERS: usize = 8;

/// Finds contact points on objects. Fibres that touched none are not looked at again while they and
/// the objects move as before: of the lists of a step each is of a motion that only some fibres
/// have changed.
#[derive(Default)]
pub(super) struct ObjectDetector {
    /// Fibres that grow out of objects, by their numbers, in order: their first segments do not
    /// touch these.
    rooted: Vec<[u32; 2]>,
    /// What is known of the fields of objects.
    known: KnownValues,
    /// Positions of all nodes (world), m, at the start and at the end of the last motion.
    start: Vec<Point3<f64>>,
    end: Vec<Point3<f64>>,
    /// Poses of the objects at these times, world.
    poses: Vec<[Isometry3<f64>; 2]>,
    /// By fibre, how far it was clear of objects then.
    clear: Vec<Clearance>,
}

/// How far a fibre was clear of all objects.
#[derive(Clone, Copy)]
struct Clearance {
    /// It had no contact point with a gap up to this, m.
    margin: f64,
    /// The first segment that was looked at.
    first: usize,
}

impl Clearance {
    /// Nothing is known.
    const NONE: Self = Self { margin: f64::NEG_INFINITY, first: usize::MAX };
}

impl ObjectDetector {
    /// Lets fibres grow out of objects from now on: of these pairs by their numbers, in order, the
    /// first segment of the fibre does not touch the object.
    pub(super) fn root(&mut self, rooted: Vec<[u32; 2]>) {
        (self.rooted, self.clear) = (rooted, Vec::new());
    }

    /// What fibres, and objects that move freely, touch of the objects on a motion, with gaps up to
    /// `margin`, m. The first segments of fibres that are inside a nozzle touch nothing.
    pub(super) fn contact_points(
        &mut self,
        motion: &NodeMotion,
        objects: &[CollisionObject],
        held: &HeldPlaces,
        in_nozzles: &[usize],
        margin: f64,
    ) -> Vec<ContactPoint> {
        let moving: Vec<_> =
            objects.iter().map(|object| MovingObject::new(object, motion.step)).collect();
        self.keep_clear(motion, moving.iter().map(|object| object.poses).collect());
        let Self { rooted, known, end, clear, .. } = self;
        let search = |fiber: usize,
                      known: &mut [KnownValue],
                      clear: &mut Clearance,
                      found: &mut ObjectContacts| {
            let nodes = motion.layout.node_range(fiber);
            let hidden = in_nozzles.get(fiber).copied().unwrap_or(0);
            let stays = || are_same(&end[nodes.clone()], &motion.end[nodes.clone()]);
            if clear.margin >= margin && clear.first <= hidden && stays() {
                return;
            }
            let before = found.points.len();
            let all = (0..).zip(objects).zip(&moving).zip(known.chunks_mut(nodes.len()));
            for (((index, object), moving), known) in all {
                let number = fiber_number(fiber);
                let strand = MovingFiber {
                    fiber: number,
                    first: usize::from(rooted.binary_search(&[number, index]).is_ok()).max(hidden),
                    held: held.of_pair([number, index]),
                    start: &motion.start[nodes.clone()],
                    end: &motion.end[nodes.clone()],
                    radii: &motion.radii()[motion.layout.segment_range(fiber)],
                };
                object.contact_points(index, &strand, known, moving, margin, found);
            }
            let is_clear = found.points.len() == before;
            *clear = if is_clear { Clearance { margin, first: hidden } } else { Clearance::NONE };
        };
        // Few of many may be near any.
        let known = known.of_fibers(motion.layout, objects.len());
        let parts = known.par_chunks_mut(FIBERS).zip(clear.par_chunks_mut(FIBERS));
        let part = |(part, (known, clear)): (usize, (&mut [Vec<KnownValue>], &mut [Clearance]))| {
            let mut found = ObjectContacts::default();
            for (fiber, (known, clear)) in (FIBERS * part..).zip(known.iter_mut().zip(clear)) {
                if motion.sought.is_none_or(|sought| sought[fiber]) {
                    search(fiber, known, clear, &mut found);
                }
            }
            found.points
        };
        let found: Vec<_> = parts.enumerate().map(part).collect();
        let mut found = found.concat();
        self.end.clear();
        self.end.extend_from_slice(motion.end);
        if motion.sought.is_none() {
            found.extend(pair::contact_points(objects, motion.step, margin));
        }
        found
    }

    /// Forgets which fibres were clear of objects unless all begin where they began, and all
    /// objects have the same `poses`.
    fn keep_clear(&mut self, motion: &NodeMotion, poses: Vec<[Isometry3<f64>; 2]>) {
        let same = self.poses == poses && are_same(&self.start, motion.start);
        if same && !self.clear.is_empty() {
            return;
        }
        self.start.clear();
        self.start.extend_from_slice(motion.start);
        self.end.resize(motion.end.len(), Point3::origin());
        self.poses = poses;
        self.clear.clear();
        self.clear.resize(motion.layout.fibers(), Clearance::NONE);
    }
}

/// Whether places are what they were.
fn are_same(before: &[Point3<f64>], now: &[Point3<f64>]) -> bool {
    all_equal(before, now, |place| place.coords.into())
}

#[cfg(test)]
mod tests {
    use super::super::sections::{OrientedSections, SectionShapes};
    use super::*;
    use crate::TimeInterval;
    use crate::contact_point::ContactKey;
    use crate::object::{ObjectGeometry, ObjectMotion};
    use proptest::prelude::*;
    use rapunzel_collision::field::{HalfSpace, Soup};
    use rapunzel_fiber::Layout;
    use std::sync::Arc;

    const RADIUS: f64 = 3.5e-5;
    const LENGTH: f64 = 3e-3;

    /// A plane at a height, m.
    fn plane(height: f64) -> CollisionObject {
        let surface = Soup { vertices: Vec::new(), triangles: Vec::new() };
        let field =
            Arc::new(HalfSpace { point: Point3::origin(), normal: nalgebra::Vector3::z_axis() });
        let geometry = ObjectGeometry { field, edge_capsules: Vec::new(), surface, endless: true };
        let rests = move |_| Isometry3::translation(0.0, 0.0, height);
        CollisionObject::new(geometry, ObjectMotion::Kinematic(Box::new(rests)), None, None)
    }

    /// The ranks and gaps of what a detector finds of three fibres of four segments that move from
    /// one height to others, in radii.
    fn found(
        detector: &mut ObjectDetector,
        (start, ends): (f64, [f64; 3]),
        height: f64,
        in_nozzles: &[usize],
        margin: f64,
    ) -> Vec<(ContactKey, f64)> {
        let layout = Layout::new([4, 4, 4]);
        let place = |node: usize, z: f64| Point3::new(node as f64 * LENGTH, 0.0, z * RADIUS);
        let start: Vec<_> = (0..15).map(|i| place(i % 5, start)).collect();
        let end: Vec<_> = (0..15).map(|i| place(i % 5, ends[i / 5])).collect();
        let shapes = SectionShapes::round(vec![RADIUS; layout.segments()]);
        let motion = NodeMotion {
            layout: &layout,
            sections: OrientedSections { shapes: &shapes, directors: &[] },
            start: &start,
            end: &end,
            step: TimeInterval { start: 0.0, length: 1e-3 },
            sought: None,
        };
        let objects = [plane(height * RADIUS)];
        let held = HeldPlaces::default();
        let points = detector.contact_points(&motion, &objects, &held, in_nozzles, margin * RADIUS);
        points.iter().map(|point| (point.rank(), point.gap)).collect()
    }

    proptest! {
        /// What is remembered of fibres that were clear changes nothing that is found.
        #[test]
        fn memory_of_what_is_clear_changes_nothing(
            motions in prop::collection::vec(
                (
                    prop_oneof![3 => Just(9.0), 1 => Just(2.0)],
                    prop::array::uniform3(prop_oneof![Just(8.0), Just(0.9), 0.9..9.0]),
                    prop_oneof![3 => Just(0.0), 1 => Just(-7.0)],
                    prop::array::uniform3(prop_oneof![Just(0), Just(4), 0..4_usize]),
                    prop_oneof![Just(0.5), Just(1.0)],
                ),
                1..12,
            ),
            rooted: bool,
        ) {
            let rooted = if rooted { vec![[1, 0]] } else { Vec::new() };
            let mut detector = ObjectDetector::default();
            detector.root(rooted.clone());
            for (start, ends, height, in_nozzles, margin) in motions {
                let mut fresh = ObjectDetector::default();
                fresh.root(rooted.clone());
                let expected = found(&mut fresh, (start, ends), height, &in_nozzles, margin);
                let again = found(&mut detector, (start, ends), height, &in_nozzles, margin);
                prop_assert_eq!(again, expected);
            }
        }
    }
}
