//! What fibres lie on and bump into, and each other.

use super::free::FreeBody;
use super::pair::{Pair, pairs};
use super::touch::{Partner, Touch};
use crate::scene::Friction;
use crate::{SimError, World};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::continuous::MovingSegment;
use rapunzel_collision::field::{DistanceField, FieldContact, Sample, Search, Soup};
use rapunzel_contact::ContactError;
use rapunzel_export::surface::Placed;
use rapunzel_mass_spring::Obstacle;

/// How far along a segment, in its length, contacts beside the deepest one are.
const ROLL: f64 = 0.2;

/// Gaps that differ by no more than this, in radii, are the same.
const EVEN: f64 = 1e-3;

/// A surface and what moves it.
pub(crate) struct Object {
    /// In the object's own frame, as the surface is.
    pub(super) field: Box<dyn DistanceField + Send + Sync>,
    /// In the same frame: what touches other objects.
    pub(super) skeleton: Vec<Capsule>,
    /// What is shown of it.
    surface: Soup,
    /// Corners of the box around that.
    corners: [Point3<f64>; 8],
    /// Its smallest extent, m; infinite for what has no end.
    pub(super) size: f64,
    /// Of what lies on it; `None` for that of the scene.
    pub(super) friction: Option<Friction>,
    /// Of what bounces off it; `None` for that of the scene.
    pub(super) restitution: Option<f64>,
    pub(crate) way: Way,
}

/// What moves an object.
pub(crate) enum Way {
    /// Its pose at a time, s.
    Led(Box<dyn Fn(f64) -> Isometry3<f64> + Send + Sync>),
    /// Gravity and contacts.
    Free(Box<FreeBody>),
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

/// The contacts at both ends of a segment, with these gaps. Where it lies flat, which end is deeper is a matter of
/// roundings: a place that jumps would lose what it bears.
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

/// One fibre before and after a step.
pub(crate) struct Strand<'a> {
    pub(crate) fiber: u32,
    pub(crate) start: &'a [Point3<f64>],
    pub(crate) end: &'a [Point3<f64>],
    pub(crate) radii: &'a [f64],
}

impl Object {
    /// `endless` tells that it reaches on beyond what is shown of it.
    pub(super) fn new(
        field: Box<dyn DistanceField + Send + Sync>,
        skeleton: Vec<Capsule>,
        surface: Soup,
        friction: Option<Friction>,
        restitution: Option<f64>,
        way: Way,
        endless: bool,
    ) -> Self {
        let ends = extents(&surface);
        let corners = std::array::from_fn(|c| Point3::from([0, 1, 2].map(|k| ends[k][c >> k & 1])));
        let least = ends.iter().map(|[low, high]| high - low).fold(f64::INFINITY, f64::min);
        let size = if endless { f64::INFINITY } else { least };
        Self { field, skeleton, surface, corners, size, friction, restitution, way }
    }

    /// It where it is at the time `t`, s.
    pub(crate) fn placed(&self, t: f64) -> Placed {
        let pose = match &self.way {
            Way::Led(pose) => pose(t),
            Way::Free(body) => body.poses()[0],
        };
        let vertices = self.surface.vertices.iter().map(|p| pose * p).collect();
        Placed { pose, surface: Soup { vertices, triangles: self.surface.triangles.clone() } }
    }

    pub(super) fn is_free(&self) -> bool {
        matches!(self.way, Way::Free(_))
    }

    /// Its poses at the start and at the end of the step from `time` by `dt`, s.
    pub(super) fn poses(&self, [time, dt]: [f64; 2]) -> [Isometry3<f64>; 2] {
        match &self.way {
            Way::Led(pose) => [pose(time), pose(time + dt)],
            Way::Free(body) => body.poses(),
        }
    }

    /// What nodes of a mass-spring system bump into, at the end of the step from `time` by `dt`, s.
    pub(crate) fn obstacle(&self, [time, dt]: [f64; 2]) -> Obstacle<'_> {
        Obstacle { field: &*self.field, poses: self.poses([time, dt]), dt }
    }

    /// The same if nothing is in the way.
    fn free_poses(
        &self,
        [time, dt]: [f64; 2],
        gravity: &Vector3<f64>,
    ) -> Result<[Isometry3<f64>; 2], ContactError> {
        match &self.way {
            Way::Led(_) => Ok(self.poses([time, dt])),
            Way::Free(body) => body.fall(dt, gravity),
        }
    }

    /// The longest way, m, of a point of its surface from one pose to another.
    fn way(&self, poses: &[Isometry3<f64>; 2]) -> f64 {
        longest_way(&self.corners, poses)
    }

    /// The same of what touches other objects: a round shape turns in itself.
    pub(super) fn way_of_skeleton(&self, poses: &[Isometry3<f64>; 2]) -> f64 {
        match self.skeleton[..] {
            [Capsule { start, end, .. }] => longest_way(&[start, end], poses),
            _ => self.way(poses),
        }
    }

    /// Center and radius, m, of a ball around it at a pose; the radius is infinite for what has no end.
    pub(super) fn ball(&self, pose: &Isometry3<f64>) -> (Point3<f64>, f64) {
        let [low, high] = [&self.corners[0], &self.corners[7]];
        let radius = if self.size.is_finite() { 0.5 * (high - low).norm() } else { f64::INFINITY };
        (pose * nalgebra::center(low, high), radius)
    }

    /// Appends where a fibre touches the object after the step from a time on by another, s, with
    /// gaps up to `margin`, m, or would have passed into it on the way.
    pub(crate) fn touches(
        &self,
        index: u32,
        strand: &Strand,
        span: [f64; 2],
        margin: f64,
        found: &mut Vec<Touch>,
    ) {
        let poses = self.poses(span);
        let field = &*self.field;
        let slope = field.lipschitz();
        let turns = poses.map(|pose| pose.rotation.to_rotation_matrix());
        let own = |node: &Point3<f64>, when: usize| {
            turns[when].inverse_transform_point(&(node - poses[when].translation.vector))
        };
        let after: Vec<_> = strand.end.iter().map(|node| own(node, 1)).collect();
        let values: Vec<f64> = after.iter().map(|node| field.value(node)).collect();
        // Where it rests they are as long in any frame.
        let both = strand.start.iter().zip(strand.end);
        let ways: Vec<f64> = if poses[0] == poses[1] {
            both.map(|(before, after)| (after - before).norm()).collect()
        } else {
            both.map(|(before, after)| (own(after, 1) - own(before, 0)).norm()).collect()
        };
        let mut contacts: Vec<FieldContact> = Vec::new();
        for (s, &radius) in strand.radii.iter().enumerate() {
            let (start, end) = (strand.end[s], strand.end[s + 1]);
            let length = (end - start).norm();
            let (way, nearest) =
                (ways[s].max(ways[s + 1]), 0.5 * (values[s] + values[s + 1] - slope * length));
            // No point of other segments is near enough, or was on the way.
            let reach = slope * way + radius + margin;
            if nearest > reach {
                continue;
            }
            let nearest = nearest.max(field.least_between(&after[s], &after[s + 1]));
            if nearest > reach {
                continue;
            }
            contacts.clear();
            let [a, b] = [s, s + 1].map(|node| own(&strand.start[node], 0));
            let moving = MovingSegment { before: [a, b], after: [after[s], after[s + 1]] };
            let half = 0.5 * slope * way;
            let clears = |[a, b]: [Point3<f64>; 2]| {
                field.least_between(&a, &b) > half || self.clears(&a, &b, half)
            };
            let clear = way < radius || clears(moving.before) && clears(moving.after);
            let passed = if clear { None } else { self.passing(&moving, radius) };
            if let Some(contact) = passed {
                contacts.push(contact);
            } else if nearest <= radius + margin {
                let capsule = Capsule { start: after[s], end: after[s + 1], radius };
                let search = Search { margin, spacing: 0.1 * length, tolerance: EVEN * radius };
                let ends = [0, 1].map(|i| values[s + i] - radius);
                // A search would find nothing between them that is nearer.
                let known = nearest - radius >= ends[0].min(ends[1]) - EVEN * radius
                    && is_even(&[], ends, &field, &capsule);
                if !known {
                    search.contacts(&field, &capsule, &mut contacts);
                }
                if known || is_even(&contacts, ends, &field, &capsule) {
                    contacts.clear();
                    contacts.extend(at_ends(ends, &field, &capsule, margin));
                } else if let [deepest] = contacts[..] {
                    contacts.extend(beside(&deepest, &field, &capsule, margin));
                }
            }
            for contact in contacts.iter().filter(|c| c.normal != Vector3::zeros()) {
                let normal = poses[1] * contact.normal;
                let axis = start + contact.fraction * (end - start);
                let place = axis - normal * (contact.gap + radius);
                let was = poses[0] * poses[1].inverse_transform_point(&place);
                let own = match &self.way {
                    Way::Led(_) => (place - was) / span[1],
                    Way::Free(body) => axis - body.centers()[1],
                };
                #[expect(clippy::cast_possible_truncation, reason = "counted with 32 bits")]
                let segment = s as u32;
                found.push(Touch {
                    sides: [Partner::Fiber(strand.fiber), Partner::Object(index)],
                    segments: [segment, 0],
                    fractions: [contact.fraction, 0.0],
                    normal,
                    arms: [end - start, own],
                    gap: contact.gap,
                    impulse: Vector3::zeros(),
                    working: false,
                    bonded: false,
                    led: !self.is_free(),
                });
            }
        }
    }

    /// Whether all points between two, in the object's frame, are seen to be more than a `distance`
    /// outside. Motions that begin and end so far from what they could reach in half their way never
    /// meet the surface; few samples show that, where the search for an impact takes many.
    fn clears(&self, a: &Point3<f64>, b: &Point3<f64>, distance: f64) -> bool {
        let middle = nalgebra::center(a, b);
        let (value, change) =
            (self.field.value(&middle), 0.5 * self.field.lipschitz() * (b - a).norm());
        value - change > distance
            || value > distance
                && change > 0.1 * distance
                && self.clears(a, &middle, distance)
                && self.clears(&middle, b, distance)
    }

    /// Where the axis of a segment that moves in the object's frame meets the surface, with the gap
    /// along the normal there that the end of the motion would leave.
    fn passing(&self, moving: &MovingSegment, radius: f64) -> Option<FieldContact> {
        let impact = moving.impact_on(&&*self.field, 0.0, 0.1 * radius)?;
        let [fraction] = impact.coordinates;
        let place = moving.at(impact.time, radius).at(fraction);
        let Sample { value, gradient } = self.field.sample(&place);
        let normal = gradient.try_normalize(0.0)?;
        let surface = place - value * normal;
        let gap = normal.dot(&(moving.at(1.0, radius).at(fraction) - surface)) - radius;
        Some(FieldContact { fraction, gap, normal })
    }
}

fn longest_way(corners: &[Point3<f64>], [start, end]: &[Isometry3<f64>; 2]) -> f64 {
    // The way is a convex function of the place: at a corner it is longest.
    let ways = corners.iter().map(|corner| (end * corner - start * corner).norm());
    ways.fold(0.0, f64::max)
}

/// The least and the largest coordinate of a surface along each axis, m.
pub(super) fn extents(surface: &Soup) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|k| {
        let along = surface.vertices.iter().map(|p| p[k]);
        [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
    })
}

/// Refuses a step of `dt`, s, in which an object would jump over fibres or another object.
pub(super) fn refuse_leaps(world: &World, dt: f64) -> Result<(), SimError> {
    let segments = world.assembly().fibers().iter().map(|f| f.length() / f.segments() as f64);
    let (segment, time) = (segments.fold(f64::INFINITY, f64::min), world.time());
    let gravity = world.gravity_at(time + 0.5 * dt);
    let poses = world.objects.iter().map(|object| object.free_poses([time, dt], &gravity));
    let poses = poses.collect::<Result<Vec<_>, _>>()?;
    let refuse = |object, way, most| {
        if way > most {
            return Err(SimError::Leap { object, time, way, most, dt: dt * most / way });
        }
        Ok(())
    };
    for (object, one) in world.objects.iter().enumerate() {
        refuse(object, one.way(&poses[object]), one.size.min(segment))?;
    }
    for numbers in pairs(&world.objects) {
        let (pair, [a, b]) = (Pair::new(&world.objects, numbers), numbers.map(|i| i as usize));
        let way = pair.way(&[poses[a], poses[b]]);
        if !pair.is_apart([&poses[a][0], &poses[b][0]], way) {
            refuse(a, way, pair.most_way())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use proptest::prelude::*;

    const RADIUS: f64 = 3.5e-5;

    /// The touches of one segment, 3 mm long, whose ends have these gaps above the top of a shape; the fibre of
    /// the scene is only there because a scene has one.
    fn touches(shape: &str, gaps: [f64; 2]) -> Vec<Touch> {
        let scene = format!(
            "(format: 1, name: \"A segment\", duration: 1.0, fibers: [(length: 3e-3, segments: 2, \
             section: Circle(radius: {RADIUS}), root: (position: (0, 0, 1)))], \
             objects: [(shape: {shape})], contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3))"
        );
        let world = World::build(&Scene::from_ron(&scene).expect("sound")).expect("a scene");
        let [a, b] = gaps.map(|gap| RADIUS + gap);
        let nodes = [Point3::new(-1.5e-3, 0.0, a), Point3::new(1.5e-3, 0.0, b)];
        let strand = Strand { fiber: 0, start: &nodes, end: &nodes, radii: &[RADIUS] };
        let mut found = Vec::new();
        world.objects[0].touches(0, &strand, [0.0, 1e-3], RADIUS, &mut found);
        found
    }

    proptest! {
        /// On a plane a segment touches at its ends that are near, whether it lies flat or not.
        #[test]
        fn a_segment_touches_a_plane_at_its_ends(
            gaps in (-1e-6..1e-6, prop_oneof![-1e-7..1e-7, -1e-5..1e-4_f64]),
            turned: bool,
        ) {
            let gaps = if turned { [gaps.1, gaps.0] } else { [gaps.0, gaps.1] };
            let found = touches("Plane(normal: (0, 0, 1))", gaps);
            let ends = [0.0, 1.0].into_iter().zip(gaps).filter(|(_, gap)| *gap <= RADIUS);
            let ends: Vec<_> = ends.collect();
            prop_assert_eq!(found.len(), ends.len());
            for (touch, (end, gap)) in found.iter().zip(ends) {
                prop_assert_eq!(touch.fractions[0], end);
                prop_assert!((touch.gap - gap).abs() < 1e-15);
            }
        }
    }

    /// On a ball it touches between its ends, and beside that, as it may roll.
    #[test]
    fn a_segment_touches_a_ball_where_it_is_deepest() {
        let found = touches("Ball(radius: 0.1)", [0.1; 2]);
        let places: Vec<_> = found.iter().map(|touch| touch.fractions[0]).collect();
        assert_eq!(places.len(), 3, "{places:?}");
        assert!(places.iter().any(|place| (place - 0.5).abs() < 0.05), "{places:?}");
    }
}
