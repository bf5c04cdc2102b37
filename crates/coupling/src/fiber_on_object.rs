//! Where a fibre touches an object, and where it would have passed into it.

use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::held_places::HeldPlaces;
use crate::known_values::KnownValue;
use crate::object::{CollisionObject, MovingObject, ObjectMotion};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::continuous::MovingSegment;
use rapunzel_collision::field::{ContactSearch, DistanceField, FieldContact, Sample};

/// How far along a segment, in its length, contacts beside the deepest one are.
const ROLL: f64 = 0.2;

/// Gaps that differ by no more than this, in radii, are the same.
const EVEN: f64 = 1e-3;

/// Segments in a row of which one node tells whether any may be near.
const BLOCK: usize = 8;

/// A node in the frame of an object after a step.
struct NodeByObject {
    place: Point3<f64>,
    /// Lower bound of the object's field there, m; no number where nothing is known.
    least: f64,
    /// Square of how far it has gone in that frame, m^2.
    squared_way: f64,
}

/// Contact points of fibres on objects, and the workspace of the search for them.
#[derive(Default)]
pub(crate) struct ObjectContacts {
    pub(crate) points: Vec<ContactPoint>,
    /// Of the nodes of a block, the squares of their ways too, m^2.
    nodes: Vec<NodeByObject>,
    ways: Vec<f64>,
    /// Of one segment.
    contacts: Vec<FieldContact>,
}

/// One fibre before and after a step.
pub(crate) struct MovingFiber<'a> {
    pub(crate) fiber: u32,
    pub(crate) start: &'a [Point3<f64>],
    pub(crate) end: &'a [Point3<f64>],
    pub(crate) radii: &'a [f64],
    /// The first segment that can touch: not the one that grows out of the object.
    pub(crate) first: usize,
    /// Where it rests on the object.
    pub(crate) held: HeldPlaces<'a>,
}

/// The contacts beside the deepest one of a segment: as it turns it rolls on to them.
fn beside(
    deepest: &FieldContact,
    field: &impl DistanceField,
    capsule: &Capsule,
    margin: f64,
) -> impl Iterator<Item = FieldContact> {
    [-ROLL, ROLL].into_iter().filter_map(move |way| {
        let fraction = deepest.fraction + way;
        let Sample { value, gradient } = field.sample(&capsule.at(fraction));
        let (gap, normal) = (value - capsule.radius, gradient.try_normalize(0.0)?);
        let listed = (0.0..=1.0).contains(&fraction) && gap <= margin;
        listed.then_some(FieldContact { fraction, gap, normal })
    })
}

/// Whether the gaps along a segment change evenly from one end to the other, as at a plane.
fn is_even(
    contacts: &[FieldContact],
    ends: [f64; 2],
    field: &impl DistanceField,
    capsule: &Capsule,
) -> bool {
    let even = |fraction: f64, gap: f64| {
        (gap - ends[0] - fraction * (ends[1] - ends[0])).abs() <= EVEN * capsule.radius
    };
    contacts.iter().all(|contact| even(contact.fraction, contact.gap))
        && even(0.5, field.value(&capsule.at(0.5)) - capsule.radius)
}

/// The contacts at both ends of a segment, with these gaps. Where it lies flat, which end is deeper
/// is a matter of roundings: a place that jumps would lose what it bears.
fn at_ends(
    gaps: [f64; 2],
    field: &impl DistanceField,
    capsule: &Capsule,
    margin: f64,
) -> impl Iterator<Item = FieldContact> {
    [0.0, 1.0].into_iter().zip(gaps).filter_map(move |(fraction, gap)| {
        let normal = field.sample(&capsule.at(fraction)).gradient.try_normalize(0.0)?;
        (gap <= margin).then_some(FieldContact { fraction, gap, normal })
    })
}

impl CollisionObject {
    /// Appends where a fibre touches the object after a step, with gaps up to `margin`, m, or would
    /// have passed into it on the way. What is `known` of the field at the nodes is used and
    /// renewed.
    pub(crate) fn contact_points(
        &self,
        index: u32,
        strand: &MovingFiber,
        known: &mut [KnownValue],
        motion: &MovingObject,
        margin: f64,
        found: &mut ObjectContacts,
    ) {
        let MovingObject { poses, turns, spin, length: dt } = motion;
        let field = &*self.geometry.field;
        let slope = field.lipschitz();
        let own = |node: &Point3<f64>, when: usize| {
            turns[when].inverse_transform_point(&(node - poses[when].translation.vector))
        };
        // Where it rests ways are as long in any frame.
        let rests = poses[0] == poses[1];
        let squared_way = |node: usize| {
            let (before, after) = (&strand.start[node], &strand.end[node]);
            if rests { after - before } else { own(after, 1) - own(before, 0) }.norm_squared()
        };
        // Without regard to what is no number, which `f64::max` takes time for.
        let larger = |a: f64, b: f64| if b > a { b } else { a };
        let largest = |all: &[f64]| all.iter().copied().fold(0.0, larger);
        let ObjectContacts { points, nodes, ways, contacts } = found;
        for first in (strand.first..strand.radii.len()).step_by(BLOCK) {
            let radii = &strand.radii[first..strand.radii.len().min(first + BLOCK)];
            let block = first..first + radii.len() + 1;
            ways.clear();
            ways.extend(block.clone().map(squared_way));
            // What one node tells of all that is not farther from it.
            let at_middle = first + radii.len() / 2;
            let middle = &strand.end[at_middle];
            let around =
                strand.end[block.clone()].iter().map(|node| (node - middle).norm_squared());
            let around = around.fold(0.0, larger).sqrt();
            let reach = slope * (around + largest(ways).sqrt()) + largest(radii) + margin;
            let (place, there) = (own(middle, 1), &mut known[at_middle]);
            // Roundings of what is known are far less than what is even.
            let is_far = there.least_at(&place, slope) > reach + EVEN * largest(radii);
            if is_far || there.value_at(&place, field) > reach {
                continue;
            }
            nodes.clear();
            nodes.extend(block.zip(&*ways).map(|(node, &squared_way)| {
                let place = own(&strand.end[node], 1);
                NodeByObject { place, least: known[node].least_at(&place, slope), squared_way }
            }));
            for (k, &radius) in radii.iter().enumerate() {
                let s = first + k;
                let ends = [&nodes[k], &nodes[k + 1]];
                let (start, end) = (strand.end[s], strand.end[s + 1]);
                let length = (end - start).norm();
                let way = larger(ends[0].squared_way, ends[1].squared_way).sqrt();
                // No point of other segments is near enough, or was on the way.
                let reach = slope * way + radius + margin;
                let nearest = |ends: [f64; 2]| 0.5 * (ends[0] + ends[1] - slope * length);
                if nearest(ends.map(|node| node.least)) > reach + EVEN * radius {
                    continue;
                }
                let after = ends.map(|node| node.place);
                let values = [0, 1].map(|end| known[s + end].value_at(&after[end], field));
                let nearest = nearest(values);
                if nearest > reach {
                    continue;
                }
                let nearest = nearest.max(field.least_between(&after[0], &after[1]));
                if nearest > reach {
                    continue;
                }
                contacts.clear();
                let [a, b] = [s, s + 1].map(|node| own(&strand.start[node], 0));
                let moving = MovingSegment { before: [a, b], after };
                let half = 0.5 * slope * way;
                let clears = |[a, b]: [Point3<f64>; 2]| {
                    field.least_between(&a, &b) > half || self.clears(&a, &b, half)
                };
                let clear = way < radius || clears(moving.before) && clears(moving.after);
                let passed = if clear { None } else { self.passing(&moving, radius) };
                if let Some(contact) = passed {
                    contacts.push(contact);
                } else if nearest <= radius + margin {
                    let capsule = Capsule { start: after[0], end: after[1], radius };
                    let search =
                        ContactSearch { margin, spacing: 0.1 * length, tolerance: EVEN * radius };
                    let ends = values.map(|value| value - radius);
                    // A search would find nothing between them that is nearer.
                    let known = nearest - radius >= ends[0].min(ends[1]) - EVEN * radius
                        && is_even(&[], ends, &field, &capsule);
                    if !known {
                        search.contacts(&field, &capsule, contacts);
                    }
                    if known || is_even(contacts, ends, &field, &capsule) {
                        contacts.clear();
                        contacts.extend(at_ends(ends, &field, &capsule, margin));
                    } else {
                        strand.held.keep(s, &field, &capsule, contacts);
                        if let &[deepest] = &contacts[..] {
                            contacts.extend(beside(&deepest, &field, &capsule, margin));
                        }
                    }
                }
                for contact in contacts.iter().filter(|c| c.normal != Vector3::zeros()) {
                    let normal = poses[1] * contact.normal;
                    let axis = start + contact.fraction * (end - start);
                    let was = poses[0] * poses[1].inverse_transform_point(&axis);
                    let own = match &self.motion {
                        ObjectMotion::Kinematic(_) => (axis - was) / *dt,
                        ObjectMotion::Dynamic(body) => axis - radius * normal - body.centers()[1],
                    };
                    #[expect(clippy::cast_possible_truncation, reason = "counted with 32 bits")]
                    let segment = s as u32;
                    points.push(ContactPoint {
                        sides: [BodyRef::Fiber(strand.fiber), BodyRef::Object(index)],
                        segments: [segment, 0],
                        fractions: [contact.fraction, 0.0],
                        normal,
                        arms: [end - start, own],
                        offsets: [-radius * normal, Vector3::zeros()],
                        spin: *spin,
                        gap: contact.gap,
                        kinematic: !self.is_free(),
                        ..ContactPoint::IDLE
                    });
                }
            }
        }
    }

    /// Whether all points between two, in the object's frame, are seen to be more than a `distance`
    /// outside. Motions that begin and end so far from what they could reach in half their way
    /// never meet the surface; few samples show that, where the search for an impact takes many.
    fn clears(&self, a: &Point3<f64>, b: &Point3<f64>, distance: f64) -> bool {
        let middle = nalgebra::center(a, b);
        let (value, change) = (
            self.geometry.field.value(&middle),
            0.5 * self.geometry.field.lipschitz() * (b - a).norm(),
        );
        value - change > distance
            || value > distance
                && change > 0.1 * distance
                && self.clears(a, &middle, distance)
                && self.clears(&middle, b, distance)
    }

    /// Where the axis of a segment that moves in the object's frame meets the surface, with the gap
    /// along the normal there that the end of the motion would leave.
    fn passing(&self, moving: &MovingSegment, radius: f64) -> Option<FieldContact> {
        let impact = moving.impact_on(&&*self.geometry.field, 0.0, 0.1 * radius)?;
        let [fraction] = impact.coordinates;
        let place = moving.at(impact.time, radius).at(fraction);
        let Sample { value, gradient } = self.geometry.field.sample(&place);
        let normal = gradient.try_normalize(0.0)?;
        let surface = place - value * normal;
        let gap = normal.dot(&(moving.at(1.0, radius).at(fraction) - surface)) - radius;
        Some(FieldContact { fraction, gap, normal })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TimeInterval;
    use crate::held_places::HeldPlace;
    use crate::object::{Field, ObjectGeometry};
    use nalgebra::Isometry3;
    use proptest::prelude::*;
    use rapunzel_collision::field::{Ball, HalfSpace, Soup};
    use std::sync::Arc;

    const RADIUS: f64 = 3.5e-5;
    const LENGTH: f64 = 3e-3;

    /// The contact points of one segment, 3 mm long, whose ends have these gaps above the top of a
    /// shape.
    fn contact_points(field: Field, gaps: [f64; 2], held: HeldPlaces) -> Vec<ContactPoint> {
        let object = object(field);
        let [a, b] = gaps.map(|gap| RADIUS + gap);
        let nodes = [Point3::new(-0.5 * LENGTH, 0.0, a), Point3::new(0.5 * LENGTH, 0.0, b)];
        let strand =
            MovingFiber { fiber: 0, start: &nodes, end: &nodes, radii: &[RADIUS], first: 0, held };
        found_at(&object, &strand, &mut [KnownValue::NONE; 2])
    }

    /// An object at rest.
    fn object(field: Field) -> CollisionObject {
        let surface = Soup { vertices: Vec::new(), triangles: Vec::new() };
        let geometry = ObjectGeometry { field, edge_capsules: Vec::new(), surface, endless: true };
        let rests = ObjectMotion::Kinematic(Box::new(|_| Isometry3::identity()));
        CollisionObject::new(geometry, rests, None, None)
    }

    fn found_at(
        object: &CollisionObject,
        strand: &MovingFiber,
        known: &mut [KnownValue],
    ) -> Vec<ContactPoint> {
        let moving = MovingObject::new(object, TimeInterval { start: 0.0, length: 1e-3 });
        let mut found = ObjectContacts::default();
        object.contact_points(0, strand, known, &moving, RADIUS, &mut found);
        found.points
    }

    fn plane() -> Field {
        Arc::new(HalfSpace { point: Point3::origin(), normal: Vector3::z_axis() })
    }

    proptest! {
        /// On a plane a segment touches at its ends that are near, whether it lies flat or not.
        #[test]
        fn a_segment_touches_a_plane_at_its_ends(
            gaps in (-1e-6..1e-6, prop_oneof![-1e-7..1e-7, -1e-5..1e-4_f64]),
            turned: bool,
        ) {
            let gaps = if turned { [gaps.1, gaps.0] } else { [gaps.0, gaps.1] };
            let found = contact_points(plane(), gaps, HeldPlaces::default());
            let ends = [0.0, 1.0].into_iter().zip(gaps).filter(|(_, gap)| *gap <= RADIUS);
            let ends: Vec<_> = ends.collect();
            prop_assert_eq!(found.len(), ends.len());
            for (point, (end, gap)) in found.iter().zip(ends) {
                prop_assert_eq!(point.fractions[0], end);
                prop_assert!((point.gap - gap).abs() < 1e-15);
            }
        }
    }

    proptest! {
        /// What is known from places where a fibre was before changes nothing of what it touches.
        #[test]
        fn what_is_known_changes_nothing(
            places in prop::collection::vec(
                prop::array::uniform3(prop_oneof![Just(0.0), -1.0..1.0_f64]), 1..12,
            ),
            far in prop_oneof![Just(0.0), Just(RADIUS), Just(LENGTH), Just(0.1)],
        ) {
            let field: Field = Arc::new(Ball { center: Point3::origin(), radius: 0.1 });
            let object = object(field);
            let top = Point3::new(0.0, 0.0, 0.1 + RADIUS);
            let mut known = [KnownValue::NONE; 12];
            let mut start = fiber_at(&top);
            for place in places {
                let end = fiber_at(&(top + far * Vector3::from(place)));
                let strand = MovingFiber {
                    fiber: 0,
                    start: &start,
                    end: &end,
                    radii: &[RADIUS; 11],
                    first: 0,
                    held: HeldPlaces::default(),
                };
                let places = |known: &mut [KnownValue]| {
                    let of = |p: &ContactPoint| (p.segments, p.fractions, p.gap, p.normal);
                    found_at(&object, &strand, known).iter().map(of).collect::<Vec<_>>()
                };
                prop_assert_eq!(places(&mut known), places(&mut [KnownValue::NONE; 12]));
                start = end;
            }
        }
    }

    /// Twelve nodes along x around a point.
    fn fiber_at(middle: &Point3<f64>) -> [Point3<f64>; 12] {
        std::array::from_fn(|k| middle + Vector3::new((k as f64 - 5.5) * LENGTH, 0.0, 0.0))
    }

    /// On a ball it touches between its ends, and beside that, as it may roll.
    #[test]
    fn a_segment_touches_a_ball_where_it_is_deepest() {
        let ball = Ball { center: Point3::origin(), radius: 0.1 };
        let found = contact_points(Arc::new(ball), [0.1; 2], HeldPlaces::default());
        let places: Vec<_> = found.iter().map(|point| point.fractions[0]).collect();
        assert_eq!(places.len(), 3, "{places:?}");
        assert!(places.iter().any(|place| (place - 0.5).abs() < 0.05), "{places:?}");
    }

    /// A place where it rests stays its contact until it is deeper elsewhere by more than the
    /// slack, and others are beside that.
    #[test]
    fn a_segment_touches_where_it_rests() {
        let radius = 0.1;
        let touches = |fraction: f64, slack: f64| {
            let ball = Ball { center: Point3::new(0.0, 0.0, -radius), radius };
            let places = [HeldPlace { pair: [0, 0], at: fraction }];
            let held = HeldPlaces { places: &places, slack };
            let found = contact_points(Arc::new(ball), [0.0; 2], held);
            let mut places: Vec<_> = found.iter().map(|point| point.fractions[0]).collect();
            places.sort_by(f64::total_cmp);
            places
        };
        // There it is this much higher than at the middle, where it is deepest.
        let higher = (0.05 * LENGTH).powi(2) / (2.0 * radius);
        assert_eq!(touches(0.45, 1.01 * higher), [0.45 - ROLL, 0.45, 0.45 + ROLL]);
        let [_, middle, _] = touches(0.45, 0.99 * higher)[..] else { panic!("three contacts") };
        assert!((middle - 0.5).abs() < 1e-3, "{middle}");
    }
}
