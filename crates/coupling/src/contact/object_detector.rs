//! Who touches which object.

use super::detection::NodeMotion;
use super::fiber_contacts::fiber_number;
use crate::contact_point::ContactPoint;
use crate::fiber_on_object::MovingFiber;
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
        type Known<'a> = (&'a mut Vec<KnownValue>, &'a mut Clearance);
        let strand = |(fiber, (known, clear)): (usize, Known)| {
            let mut found = Vec::new();
            let nodes = motion.layout.node_range(fiber);
            if motion.sought.is_some_and(|sought| !sought[fiber]) {
                return found;
            }
            let hidden = in_nozzles.get(fiber).copied().unwrap_or(0);
            let stays = are_same(&end[nodes.clone()], &motion.end[nodes.clone()]);
            if stays && clear.margin >= margin && clear.first <= hidden {
                return found;
            }
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
                object.contact_points(index, &strand, known, moving, margin, &mut found);
            }
            let is_clear = found.is_empty();
            *clear = if is_clear { Clearance { margin, first: hidden } } else { Clearance::NONE };
            found
        };
        // Few of many may be near any.
        let known = known.of_fibers(motion.layout, objects.len());
        let fibers = known.par_iter_mut().zip(clear.par_iter_mut()).enumerate();
        let found: Vec<_> = fibers.with_max_len(FIBERS).map(strand).collect();
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
