//! Ball joints of fibres that touch: contact points that hold in all directions.
//!
//! To the solver a joint is one more contact, whose law lets it bear any impulse: that with which
//! the gap that the step would leave is closed where it ends. Parts of fibres beside a joint do not
//! touch each other: their surfaces overlap there.

use super::node_arrays::FiberVelocities;
use super::system::CoupledSystem;
use crate::contact_point::{BodyRef, ContactImpulse, ContactPoint};
use crate::joints::refuse_repeated;
use crate::object::ObjectMotion;
use crate::{CouplingError, FiberPlace, TimeInterval};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::Pair;

/// Largest gap of a joint at the start, in lengths of its fibres.
const LARGEST_GAP: f64 = 1e-9;
/// Segments that are nearer to a joint than this, along both fibres, in sums of both radii, do not
/// touch each other: they are in each other where they meet at 30 degrees.
const NEAR_JOINT: f64 = 4.0;

/// A ball joint between a node and something else, at the place where the node starts.
#[derive(Debug, Clone, PartialEq)]
pub struct BallJoint {
    /// What errors call it.
    pub name: String,
    /// The node.
    pub place: FiberPlace,
    /// What it is joined to.
    pub partner: JointPartner,
}

/// What a node is joined to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointPartner {
    /// Another node, at the same place.
    Fiber(FiberPlace),
    /// The object with this index, where the node starts.
    Object(usize),
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

/// All ball joints.
#[derive(Debug, Default)]
pub(super) struct BallJoints {
    joints: Vec<(JoinedNode, JoinedSide)>,
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
    /// [`CouplingError::JointOpen`] for nodes that do not.
    pub(super) fn new(joints: &[BallJoint], system: &CoupledSystem) -> Result<Self, CouplingError> {
        let assembly = system.fibers.assembly();
        let layout = assembly.layout();
        let between = joints.iter().filter_map(|joint| match joint.partner {
            JointPartner::Fiber(place) => Some((&*joint.name, [joint.place, place])),
            JointPartner::Object(_) => None,
        });
        refuse_repeated(between)?;
        let mut all = Self::default();
        for joint in joints {
            let first = joined_node(system, joint.place);
            let at = system.fibers.node(joint.place.fiber, Some(joint.place.node)).0;
            let second = match joint.partner {
                JointPartner::Object(object) => {
                    let pose = system.objects[object].pose(system.start);
                    JoinedSide::Object(number(object), pose.inverse_transform_point(&at))
                }
                JointPartner::Fiber(place) => {
                    let other = system.fibers.node(place.fiber, Some(place.node)).0;
                    let lengths = [joint.place, place].map(|p| assembly.fibers()[p.fiber].length());
                    let (gap, most) =
                        ((at - other).norm(), LARGEST_GAP * lengths[0].max(lengths[1]));
                    if gap > most {
                        let places = [at, other].map(|place| place.coords.into());
                        let joint = joint.name.clone();
                        return Err(CouplingError::JointOpen { joint, gap, most, places });
                    }
                    JoinedSide::Node(joined_node(system, place))
                }
            };
            all.joints.push((first, second));
            let near = near_segments(system, joint.place);
            match joint.partner {
                JointPartner::Object(object) => {
                    let from = layout.segment_range(joint.place.fiber).start;
                    let collided = &system.objects[object];
                    let place = collided.pose(system.start).inverse_transform_point(&at);
                    let depth = (-collided.field().value(&place)).max(0.0);
                    let reach = depth + 2.0 * NEAR_JOINT * assembly.radii()[from];
                    let own = near.iter().filter(|(_, way)| *way <= reach);
                    let own = own.map(|(segment, _)| segment - number(from));
                    let [low, high] = [own.clone().min(), own.max()].map(Option::unwrap_or_default);
                    all.beside_objects.push((first.fiber, number(object), [low, high]));
                }
                JointPartner::Fiber(place) => {
                    let radii = [joint.place.fiber, place.fiber]
                        .map(|fiber| assembly.radii()[layout.segment_range(fiber).start]);
                    let reach = NEAR_JOINT * (radii[0] + radii[1]);
                    for (a, own) in &near {
                        for (b, other) in near_segments(system, place) {
                            if own + other <= reach {
                                all.beside.push([*a.min(&b), *a.max(&b)]);
                            }
                        }
                    }
                }
            }
        }
        all.beside.sort_unstable();
        all.beside_objects.sort_unstable();
        Ok(all)
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

    /// What joints do with impulses on their first sides, N s, world, where a step starts.
    pub(super) fn pushes(
        &self,
        system: &CoupledSystem,
        impulses: &[Vector3<f64>],
    ) -> Vec<ContactImpulse> {
        let each = self.joints.iter().zip(impulses);
        each.map(|(&(first, second), impulse)| {
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
            }
        })
        .collect()
    }

    /// Joints at the end of a step as it has been solved so far, with the mean velocities of
    /// fibres, that bear these impulses on their first sides, N s, world.
    pub(super) fn points(
        &self,
        system: &CoupledSystem,
        step: TimeInterval,
        mean: &FiberVelocities,
        impulses: &[Vector3<f64>],
    ) -> Vec<JointPoint> {
        if self.joints.is_empty() {
            return Vec::new();
        }
        let start = system.fibers.positions();
        let end = |node: usize| start[node] + step.length * mean.nodes[node];
        let axis = |node: &JoinedNode| {
            let root = node.node - usize::from(node.fraction > 0.0);
            end(root + 1) - end(root)
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
                drift: Vector3::zeros(),
                lean: Vector3::zeros(),
                rests: false,
                working: false,
                bonded: false,
                kinematic: false,
            };
            let place = match *second {
                JoinedSide::Node(other) => {
                    (point.segments[1], point.fractions[1]) = (other.segment, other.fraction);
                    point.arms[1] = axis(&other);
                    end(other.node)
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
            JointPoint { gap: end(first.node) - place, point }
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
