//! Objects that touch each other.
//!
//! Of a pair each is seen as a skeleton of capsules in the distance field of the other: corners and
//! edges of the one on faces and edges of the other are all places where solids can first meet. A
//! round shape is its own skeleton, and tells all of a pair alone.

use crate::TimeInterval;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::object::{CollisionObject, ObjectMotion};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::{ContactSearch, DistanceField, FieldContact, Posed};
use rayon::prelude::*;

/// How finely edges in contact are sampled, in their length, and how precisely gaps and places of
/// edges that cross are told apart, in the margin.
const SPACING: f64 = 0.1;
const TOLERANCE: f64 = 2e-3;
/// Places of a pair that are nearer to each other than this, in the smaller of the two, are one: a
/// corner is the end of three edges.
const SAME_CORNER: f64 = 1e-6;
/// Cosine of the angle up to which two normals at one place are the same.
const PARALLEL: f64 = 0.99;

/// Pairs of which at least one moves freely: that one first, of two the one with the smaller
/// number.
pub(crate) fn pairs(objects: &[CollisionObject]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    for (a, one) in (0..).zip(objects) {
        for (b, other) in (0..a).zip(objects) {
            match (other.is_free(), one.is_free()) {
                (true, _) => pairs.push([b, a]),
                (false, true) => pairs.push([a, b]),
                (false, false) => (),
            }
        }
    }
    pairs
}

/// Where objects touch each other in a step from a time on by another, s, with gaps up to `margin`,
/// m, at its end.
pub(crate) fn contact_points(
    objects: &[CollisionObject],
    step: TimeInterval,
    margin: f64,
) -> Vec<ContactPoint> {
    let found = pairs(objects).into_par_iter().map(|numbers| {
        let pair = ObjectPair::new(objects, numbers);
        pair.contact_points(numbers.map(BodyRef::Object), step, margin)
    });
    found.collect::<Vec<_>>().concat()
}

/// Two objects, the first of them free.
pub(crate) struct ObjectPair<'a>([&'a CollisionObject; 2]);

/// Poses of the two at the start and at the end of a step.
type Poses = [[Isometry3<f64>; 2]; 2];

impl<'a> ObjectPair<'a> {
    pub(crate) fn new(objects: &'a [CollisionObject], numbers: [u32; 2]) -> Self {
        Self(numbers.map(|i| &objects[i as usize]))
    }

    /// The longest way, m, of a place of one where it may touch, as seen from the other: such
    /// places belong to both, so that the one that moves less bounds it.
    pub(crate) fn way(&self, poses: &Poses) -> f64 {
        let seen = |i: usize| {
            let [before, after] = [0, 1].map(|k| poses[1 - i][k].inverse() * poses[i][k]);
            self.0[i].way_of_skeleton(&[before, after])
        };
        [0, 1]
            .into_iter()
            .filter(|&i| self.0[i].size.is_finite())
            .map(seen)
            .fold(f64::INFINITY, f64::min)
    }

    /// The longest way, m, after which a place of contact and its normal are still told by how far
    /// the one is in the other.
    pub(crate) fn most_way(&self) -> f64 {
        let [a, b] = self.0;
        (0.5 * a.size.min(b.size)).min(a.geometry.field.band()).min(b.geometry.field.band())
    }

    /// Whether the two are farther from each other than `reach`, m, as balls around them tell.
    pub(crate) fn is_apart(&self, poses: [&Isometry3<f64>; 2], reach: f64) -> bool {
        let [(a, r), (b, q)] = [0, 1].map(|i| self.0[i].ball(poses[i]));
        (b - a).norm() > r + q + reach
    }

    /// The contact points at the end of a step. Where an axis has come into the other, inside of
    /// which faces are told by chance, they are those of the start, as in a rebound that has been
    /// missed.
    fn contact_points(
        &self,
        sides: [BodyRef; 2],
        step: TimeInterval,
        margin: f64,
    ) -> Vec<ContactPoint> {
        let poses = self.0.map(|object| object.poses(step));
        let [start, end] =
            [0, 1].map(|when| PairStep { pair: self, sides, poses, when, dt: step.length, margin });
        let (points, inside) = end.contact_points(margin);
        if inside { start.contact_points(margin + self.way(&poses)).0 } else { points }
    }

    /// Which of the two are searched in the other's field.
    fn searched(&self) -> Vec<usize> {
        let is_round = |&i: &usize| self.0[i].geometry.edge_capsules.len() == 1;
        [0, 1].into_iter().find(is_round).map_or_else(|| vec![0, 1], |round| vec![round])
    }
}

/// The contact at a fraction of a capsule.
fn at(field: &impl DistanceField, capsule: &Capsule, fraction: f64) -> FieldContact {
    let sample = field.sample(&capsule.at(fraction));
    let normal = sample.gradient.try_normalize(0.0).unwrap_or_default();
    FieldContact { fraction, gap: sample.value - capsule.radius, normal }
}

/// A step of a pair, whose contacts are taken at its start or its end, 0 or 1.
struct PairStep<'a> {
    pair: &'a ObjectPair<'a>,
    sides: [BodyRef; 2],
    poses: Poses,
    when: usize,
    dt: f64,
    /// Largest gap at the end of the step, m.
    margin: f64,
}

impl PairStep<'_> {
    /// The contact points with gaps up to `reach`, m, where they are taken, and whether an axis is
    /// inside there.
    fn contact_points(&self, reach: f64) -> (Vec<ContactPoint>, bool) {
        let (objects, poses) = (self.pair.0, self.poses.map(|of_one| of_one[self.when]));
        if self.pair.is_apart([&poses[0], &poses[1]], reach) {
            return (Vec::new(), false);
        }
        let tolerance = TOLERANCE * self.margin;
        let (mut found, mut inside) = (Vec::new(), false);
        for of in self.pair.searched() {
            let field = Posed { field: &*objects[1 - of].geometry.field, pose: poses[1 - of] };
            let (center, radius) = objects[1 - of].ball(&poses[1 - of]);
            let center = poses[of].inverse_transform_point(&center);
            // Of a terrain most edges are far.
            let is_near = |bone: &Capsule| {
                let half = 0.5 * (bone.end - bone.start).norm();
                (bone.at(0.5) - center).norm() <= radius + half + bone.radius + reach
            };
            let bones = (0..).zip(&objects[of].geometry.edge_capsules);
            for (number, bone) in bones.filter(|(_, bone)| is_near(bone)) {
                let [start, end] = [bone.start, bone.end].map(|p| poses[of] * p);
                let bone = Capsule { start, end, ..*bone };
                let spacing = SPACING * (end - start).norm();
                let mut contacts = Vec::new();
                ContactSearch { margin: reach, spacing, tolerance }.contacts(
                    &field,
                    &bone,
                    &mut contacts,
                );
                if !contacts.is_empty() {
                    // As the two turn in a step they may roll on to the ends.
                    contacts.extend([0.0, 1.0].map(|end| at(&field, &bone, end)));
                }
                inside |= contacts.iter().any(|contact| contact.gap < -bone.radius);
                let sound = contacts.iter().filter(|c| c.normal != Vector3::zeros());
                let points = sound.map(|contact| self.point(of, number, &bone, contact));
                found.extend(points.filter(|(point, _)| point.gap <= self.margin));
            }
        }
        (distinct(found, SAME_CORNER * objects[0].size.min(objects[1].size)), inside)
    }

    /// The contact point that a contact of capsule number `bone` of one of the two is, and its
    /// place.
    fn point(
        &self,
        of: usize,
        number: u32,
        bone: &Capsule,
        contact: &FieldContact,
    ) -> (ContactPoint, Point3<f64>) {
        let FieldContact { fraction, gap, normal } = *contact;
        let axis = bone.at(fraction);
        let foot = axis - normal * (bone.radius + gap);
        // Both get their impulse at the same place.
        let place = axis - normal * (bone.radius + 0.5 * gap);
        let opened = (self.way_of(of, &axis) - self.way_of(1 - of, &foot)).dot(&normal);
        let gap = if self.when == 1 { gap } else { gap + opened };
        let own = |i: usize| match &self.pair.0[i].motion {
            ObjectMotion::Dynamic(body) => place - body.centers()[self.when],
            ObjectMotion::Kinematic(_) => self.way_of(i, &place) / self.dt,
        };
        // Numbers of one skeleton are so far apart that no two of its capsules are taken for one.
        let (mut segments, mut fractions) = ([0; 2], [0.0; 2]);
        (segments[of], fractions[of]) = (2 * number + 1, fraction);
        let point = ContactPoint {
            sides: self.sides,
            segments,
            fractions,
            normal: if of == 0 { normal } else { -normal },
            arms: [0, 1].map(own),
            offsets: [Vector3::zeros(); 2],
            gap,
            kinematic: !self.pair.0[1].is_free(),
            ..ContactPoint::IDLE
        };
        (point, place)
    }

    /// The way, m, in the step of a point fixed on one of the two.
    fn way_of(&self, i: usize, point: &Point3<f64>) -> Vector3<f64> {
        let [start, end] = &self.poses[i];
        let own = self.poses[i][self.when].inverse_transform_point(point);
        end * own - start * own
    }
}

/// Drops all but the first of those that name one place, to within `distance`, m, and one normal.
fn distinct(found: Vec<(ContactPoint, Point3<f64>)>, distance: f64) -> Vec<ContactPoint> {
    let mut kept: Vec<(ContactPoint, Point3<f64>)> = Vec::new();
    for (point, place) in found {
        let same = |(other, at): &(ContactPoint, Point3<f64>)| {
            (place - at).norm() <= distance && point.normal.dot(&other.normal) > PARALLEL
        };
        if !kept.iter().any(same) {
            kept.push((point, place));
        }
    }
    kept.into_iter().map(|(point, _)| point).collect()
}
