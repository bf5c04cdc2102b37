//! Joints of fibres that touch: contact points that hold nodes together in all directions.
//!
//! To the solver a joint is one more contact, whose law lets it bear any impulse: that with which
//! the gap that the step would leave is closed where it ends. What bends at joints that are no
//! balls is in `junctions`. Parts of fibres beside a joint do not touch each other: their surfaces
//! overlap there.

use super::junctions::ContactJunctions;
use super::system::CoupledSystem;
use crate::body_ref::BodyRef;
use crate::contact_point::{ContactImpulse, ContactPoint};
use crate::joints::refuse_repeated;
use crate::object::ObjectMotion;
use crate::{Connection, CouplingError, FiberPlace, NodeJoint, TimeInterval};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::Pair;

/// Segments that are nearer to a joint than this, along both fibres, in sums of both radii, do not
/// touch each other: they are in each other where they meet at 30 degrees.
const NEAR_JOINT: f64 = 4.0;

/// A ball joint between a node and an object, at the place where the node starts.
#[derive(Debug, Clone, PartialEq)]
pub struct BallJoint {
    /// The node.
    pub place: FiberPlace,
    /// Index of the object.
    pub object: usize,
}

/// Joints of fibres in contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactJoints<'a> {
    /// Those between fibres.
    pub fibers: &'a [NodeJoint],
    /// Those of fibres with objects.
    pub objects: &'a [BallJoint],
}

impl ContactJoints<'_> {
    /// Number of impulses that they bear: of nodes, and of what bends between fibres.
    pub(super) fn impulses(&self) -> usize {
        let bends = self.fibers.iter().filter(|joint| joint.connection != Connection::Ball);
        self.fibers.len() + self.objects.len() + bends.count()
    }
}

/// A node as a place of a segment.
#[derive(Debug, Clone, Copy)]
struct JoinedNode {
    fiber: u32,
    segment: u32,
    fraction: f64,
    /// Among the nodes of all fibres.
    node: usize,
}

/// The second side of a joint.
#[derive(Debug, Clone, Copy)]
enum JoinedSide {
    Node(JoinedNode),
    /// An object, and the place in its frame, m.
    Object(u32, Point3<f64>),
}

/// All joints.
#[derive(Debug, Default)]
pub(super) struct BallJoints {
    joints: Vec<(JoinedNode, JoinedSide)>,
    /// What bends between fibres that they join.
    pub(super) junctions: ContactJunctions,
    /// Pairs of segments that do not touch each other, the smaller first, sorted.
    beside: Vec<Pair>,
    /// Fibres and objects that are joined, sorted, with the segments that do not touch the object.
    beside_objects: Vec<(u32, u32, [u32; 2])>,
}

/// A joint in a problem of contacts.
pub(super) struct JointPoint {
    pub(super) point: ContactPoint,
    /// From the second side to the first at the end of the step, m, world.
    pub(super) gap: Vector3<f64>,
}

impl BallJoints {
    /// Joints between what lies at one place.
    ///
    /// # Errors
    /// [`CouplingError::JointOpen`] for nodes that do not, [`CouplingError::JointTwice`] for joints
    /// between nodes that others join already.
    pub(super) fn new(
        ContactJoints { fibers, objects }: ContactJoints,
        system: &CoupledSystem,
    ) -> Result<Self, CouplingError> {
        refuse_repeated(fibers)?;
        let mut all = Self::default();
        for joint in fibers {
            joint.check_closed(system.fibers)?;
            let [first, second] = joint.places.map(|place| joined_node(system, place));
            all.joints.push((first, JoinedSide::Node(second)));
            all.part_fibers(system, joint.places);
        }
        for &BallJoint { place, object } in objects {
            let at = system.fibers.node(place.fiber, Some(place.node)).0;
            let pose = system.objects[object].pose(system.start);
            let within = pose.inverse_transform_point(&at);
            let side = JoinedSide::Object(number(object), within);
            all.joints.push((joined_node(system, place), side));
            all.part_from_object(system, place, object, &within);
        }
        all.beside.sort_unstable();
        all.beside_objects.sort_unstable();
        all.junctions = ContactJunctions::new(fibers, system);
        Ok(all)
    }

    /// Notes the segments beside a joint of two nodes.
    fn part_fibers(&mut self, system: &CoupledSystem, places: [FiberPlace; 2]) {
        let assembly = system.fibers.assembly();
        let radius = |place: FiberPlace| {
            assembly.radii()[assembly.layout().segment_range(place.fiber).start]
        };
        let reach = NEAR_JOINT * (radius(places[0]) + radius(places[1]));
        let [near, others] = places.map(|place| near_segments(system, place));
        for (a, own) in &near {
            for (b, other) in &others {
                if own + other <= reach {
                    self.beside.push([*a.min(b), *a.max(b)]);
                }
            }
        }
    }

    /// Notes the segments beside a joint of a node with an object, at a place in its frame.
    fn part_from_object(
        &mut self,
        system: &CoupledSystem,
        place: FiberPlace,
        object: usize,
        within: &Point3<f64>,
    ) {
        let assembly = system.fibers.assembly();
        let from = assembly.layout().segment_range(place.fiber).start;
        let depth = (-system.objects[object].field().value(within)).max(0.0);
        let reach = depth + 2.0 * NEAR_JOINT * assembly.radii()[from];
        let near = near_segments(system, place);
        let own = near.iter().filter(|(_, way)| *way <= reach);
        let own = own.map(|(segment, _)| segment - number(from));
        let [low, high] = [own.clone().min(), own.max()].map(Option::unwrap_or_default);
        self.beside_objects.push((number(place.fiber), number(object), [low, high]));
    }

    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Whether two segments, of all, do not touch each other for being beside a joint.
    pub(super) fn parts(&self, &[a, b]: &Pair) -> bool {
        self.beside.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// Whether a contact point of a fibre on an object is none, for being beside a joint.
    pub(super) fn parts_point(&self, point: &ContactPoint) -> bool {
        let [BodyRef::Fiber(fiber), BodyRef::Object(object)] = point.sides else { return false };
        let segment = point.segments[0];
        self.beside_objects.iter().any(|(own, other, [low, high])| {
            *own == fiber && *other == object && (low..=high).contains(&&segment)
        })
    }

    /// All sides.
    pub(super) fn sides(&self) -> impl Iterator<Item = BodyRef> {
        self.joints.iter().flat_map(|(first, second)| [BodyRef::Fiber(first.fiber), side(second)])
    }

    /// What joints do with impulses on their first sides, N s, and with moments of impulses there,
    /// N m s, world, where a step starts.
    pub(super) fn pushes(
        &self,
        system: &CoupledSystem,
        impulses: &[Vector3<f64>],
    ) -> Vec<ContactImpulse> {
        let (own, moments) = impulses.split_at(self.joints.len());
        let each = self.joints.iter().zip(own);
        let pushes = each.map(|(&(first, second), impulse)| {
            let (other, lever) = match second {
                JoinedSide::Node(other) => (Some(other), Vector3::zeros()),
                JoinedSide::Object(object, place) => {
                    let lever = match &system.objects[object as usize].motion {
                        ObjectMotion::Dynamic(body) => body.poses()[0] * place - body.centers()[0],
                        ObjectMotion::Kinematic(_) => Vector3::zeros(),
                    };
                    (None, lever)
                }
            };
            ContactImpulse {
                sides: [BodyRef::Fiber(first.fiber), side(&second)],
                segments: [first.segment, other.map_or(0, |node| node.segment)],
                fractions: [first.fraction, other.map_or(0.0, |node| node.fraction)],
                levers: [Vector3::zeros(), lever],
                impulse: *impulse,
                couple: false,
            }
        });
        pushes.chain(self.junctions.pushes(moments)).collect()
    }

    /// Joints at the end of a step as it has been solved so far, that bear these impulses on their
    /// first sides, N s, world.
    pub(super) fn points(
        &self,
        system: &CoupledSystem,
        step: TimeInterval,
        impulses: &[Vector3<f64>],
    ) -> Vec<JointPoint> {
        if self.joints.is_empty() {
            return Vec::new();
        }
        let ends = system.fibers.end_positions();
        let axis = |node: &JoinedNode| {
            let root = node.node - usize::from(node.fraction > 0.0);
            ends[root + 1] - ends[root]
        };
        let each = self.joints.iter().zip(impulses);
        each.map(|((first, second), impulse)| {
            let mut point = ContactPoint {
                sides: [BodyRef::Fiber(first.fiber), side(second)],
                segments: [first.segment, 0],
                fractions: [first.fraction, 0.0],
                normal: Vector3::x(),
                arms: [axis(first), Vector3::zeros()],
                offsets: [Vector3::zeros(); 2],
                gap: 0.0,
                impulse: *impulse,
                ..ContactPoint::IDLE
            };
            let place = match *second {
                JoinedSide::Node(other) => {
                    (point.segments[1], point.fractions[1]) = (other.segment, other.fraction);
                    point.arms[1] = axis(&other);
                    ends[other.node]
                }
                JoinedSide::Object(object, place) => {
                    let object = &system.objects[object as usize];
                    let [before, after] = object.poses(step).map(|pose| pose * place);
                    point.arms[1] = match &object.motion {
                        // Of the middle of the step: what it turns is then of third order off.
                        ObjectMotion::Dynamic(body) => {
                            let [first, last] = body.centers();
                            0.5 * ((before - first) + (after - last))
                        }
                        ObjectMotion::Kinematic(_) => {
                            point.kinematic = true;
                            (after - before) / step.length
                        }
                    };
                    after
                }
            };
            JointPoint { gap: ends[first.node] - place, point }
        })
        .collect()
    }
}

fn side(partner: &JoinedSide) -> BodyRef {
    match partner {
        JoinedSide::Node(node) => BodyRef::Fiber(node.fiber),
        JoinedSide::Object(object, _) => BodyRef::Object(*object),
    }
}

fn joined_node(system: &CoupledSystem, FiberPlace { fiber, node }: FiberPlace) -> JoinedNode {
    let (segment, fraction) = if node == 0 { (0, 0.0) } else { (node - 1, 1.0) };
    let first = system.fibers.assembly().layout().node_range(fiber).start;
    JoinedNode { fiber: number(fiber), segment: number(segment), fraction, node: first + node }
}

/// Segments of a fibre, among those of all, with how far each is from a node along it, m.
fn near_segments(
    system: &CoupledSystem,
    FiberPlace { fiber, node }: FiberPlace,
) -> Vec<(u32, f64)> {
    let assembly = system.fibers.assembly();
    let first = assembly.layout().segment_range(fiber).start;
    let lengths = assembly.fibers()[fiber].segment_lengths();
    let way = |segment: usize| {
        let between = if segment < node { segment + 1..node } else { node..segment };
        lengths[between].iter().sum()
    };
    (0..lengths.len()).map(|segment| (number(first + segment), way(segment))).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "nodes are counted with 32 bits")]
fn number(index: usize) -> u32 {
    index as u32
}
