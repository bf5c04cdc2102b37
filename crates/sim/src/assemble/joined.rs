//! Fibres that are joined to each other or closed.

use super::batch::{rods, side_by_side};
use super::groups::groups;
use super::start::FiberStart;
use crate::SimError;
use crate::scene::{JointHold, JointPlace, ObjectJoint, RodMethod, Scene};
use rapunzel_coupling::{BallJoint, Connection, FiberPlace, Fibers, JoinedFibers, NodeJoint};
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::StaggeredBatch;
use std::f64::consts::TAU;

/// The fibres of a scene with their joints.
pub(super) fn joined(
    scene: &Scene,
    starts: &[FiberStart],
    assembly: Assembly,
    keeps_ledger: bool,
) -> Result<JoinedFibers, SimError> {
    let joints = joints(scene, starts);
    let groups = groups(&assembly, starts, |starts| {
        let batch = match scene.stepper.method() {
            RodMethod::Staggered { rho_infinity } => {
                StaggeredBatch::new(rods(starts), rho_infinity)?
            }
            // All else has been refused.
            _ => StaggeredBatch::backward_euler(rods(starts))?,
        };
        side_by_side(batch, starts)
    })?;
    Ok(JoinedFibers::new(Fibers::new(assembly, groups, keeps_ledger), &joints)?)
}

/// Joints of fibres with objects.
pub(super) fn ball_joints(scene: &Scene, starts: &[FiberStart]) -> Vec<BallJoint> {
    let one = |&ObjectJoint { fiber, at, object }: &ObjectJoint| BallJoint {
        place: place(starts, JointPlace { fiber, at }),
        object,
    };
    scene.object_joints.iter().map(one).collect()
}

fn place(starts: &[FiberStart], JointPlace { fiber, at }: JointPlace) -> FiberPlace {
    FiberPlace { fiber, node: at.number(starts[fiber].rod.fiber.segments()) }
}

/// All joints between fibres: of closed ones, then those that are listed.
pub(super) fn joints(scene: &Scene, starts: &[FiberStart]) -> Vec<NodeJoint> {
    let closed = starts.iter().enumerate().filter_map(|(fiber, start)| {
        let closing = scene.fibers[start.bundle].closed?;
        let [tip, root] = [start.rod.fiber.segments(), 0].map(|node| FiberPlace { fiber, node });
        Some(NodeJoint {
            name: format!("fibre {fiber} of fibers[{}], which is closed,", start.bundle),
            places: [tip, root],
            connection: Connection::Spliced { twist: TAU * closing.turns },
            damping_time: start.rod.damping_time,
        })
    });
    let listed = scene.joints.iter().enumerate().map(|(i, joint)| {
        let places = [joint.first, joint.second].map(|own| place(starts, own));
        let [a, b] = places.map(|place| starts[place.fiber].rod.damping_time);
        let connection = match joint.hold {
            JointHold::Ball => Connection::Ball,
            JointHold::Stiff => Connection::Stiff,
            JointHold::Spliced => Connection::Spliced { twist: 0.0 },
        };
        NodeJoint { name: format!("joints[{i}]"), places, connection, damping_time: 0.5 * (a + b) }
    });
    closed.chain(listed).collect()
}
