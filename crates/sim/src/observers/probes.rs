//! What probes read of a world.

use crate::World;
use crate::scene::{ContactPartner, Probe, ProbeNode, ProbeQuantity};
use nalgebra::Vector3;
use rapunzel_coupling::BodyRef;
use rapunzel_rod_dynamic::{RodState, elastic_moments};

/// Names, with units, of what a probe reads.
pub(super) fn probe_columns(probe: &Probe) -> Vec<String> {
    let node = match probe.node {
        ProbeNode::Tip => "tip".to_owned(),
        ProbeNode::At { index } => format!("node {index}"),
    };
    let own = format!("fiber {}", probe.fiber);
    let vector = |what: &str, unit: &str| {
        ["x", "y", "z"].map(|axis| format!("{own} {node} {what}{axis} ({unit})")).to_vec()
    };
    match probe.quantity {
        ProbeQuantity::Position => vector("", "m"),
        ProbeQuantity::Velocity => vector("v", "m/s"),
        ProbeQuantity::Force => vector("force ", "N"),
        ProbeQuantity::Tension => vec![format!("{own} {node} tension (N)")],
        ProbeQuantity::Moment => vector("moment ", "N m"),
        ProbeQuantity::Curvature => {
            [1, 2, 3].map(|axis| format!("{own} {node} kappa{axis} (1/m)")).to_vec()
        }
        ProbeQuantity::Twist => vec![format!("{own} {node} twist (rad/m)")],
        ProbeQuantity::Reaction => {
            [vector("reaction ", "N"), vector("reaction moment ", "N m")].concat()
        }
        ProbeQuantity::Energy => {
            ["kinetic", "elastic", "gravitational"].map(|e| format!("{own} {e} (J)")).to_vec()
        }
        ProbeQuantity::Contact { with } => {
            let other = match with {
                ContactPartner::Fiber(index) => format!("fiber {index}"),
                ContactPartner::Object(index) => format!("objects[{index}]"),
            };
            ["x", "y", "z"].map(|axis| format!("{own} force of {other} {axis} (N)")).to_vec()
        }
    }
}

/// What probes read of a world. Each state is taken once for probes of a fibre that follow each
/// other.
pub(super) fn read_probes(probes: &[Probe], world: &World) -> Vec<f64> {
    let mut last: Option<(usize, RodState)> = None;
    let mut row = Vec::new();
    for probe in probes {
        if last.as_ref().is_none_or(|(fiber, _)| *fiber != probe.fiber) {
            let fibers = world.stepper().fibers();
            last = fibers.map(|fibers| (probe.fiber, fibers.state(probe.fiber)));
        }
        row.extend(read(probe, world, last.as_ref().map(|(_, state)| state)));
    }
    row
}

/// What a probe reads, of a fibre in its state, if it is one.
fn read(probe: &Probe, world: &World, state: Option<&RodState>) -> Vec<f64> {
    let node = match probe.node {
        ProbeNode::Tip => None,
        ProbeNode::At { index } => Some(index),
    };
    let numbers = |vector: Vector3<f64>| vec![vector.x, vector.y, vector.z];
    let Some(state) = state else {
        // Other quantities of what is no fibre have been refused.
        let (position, velocity) = world.node(probe.fiber, node);
        let is_velocity = probe.quantity == ProbeQuantity::Velocity;
        return numbers(if is_velocity { velocity } else { position.coords });
    };
    let node = node.unwrap_or(state.positions.len() - 1);
    let segment = node.saturating_sub(1);
    match probe.quantity {
        ProbeQuantity::Position => numbers(state.positions[node].coords),
        ProbeQuantity::Velocity => numbers(state.velocities[node]),
        ProbeQuantity::Force => numbers(state.forces[segment]),
        ProbeQuantity::Tension => {
            vec![state.forces[segment].dot(&(state.frames[segment] * Vector3::z()))]
        }
        ProbeQuantity::Moment => {
            let fiber = &world.assembly().fibers()[probe.fiber];
            numbers(elastic_moments(fiber, state)[node])
        }
        ProbeQuantity::Curvature => numbers(state.curvatures[node]),
        ProbeQuantity::Twist => vec![state.curvatures[node].z],
        ProbeQuantity::Reaction => {
            let fibers = world.stepper().fibers();
            let reaction = fibers.and_then(|f| f.reaction(probe.fiber, node > 0, world.time()));
            reaction.unwrap_or_default().into_iter().flat_map(numbers).collect()
        }
        ProbeQuantity::Energy => {
            let energy = world.fiber_energy(probe.fiber, &world.gravity());
            vec![energy.kinetic, energy.elastic, energy.gravitational]
        }
        ProbeQuantity::Contact { with } => numbers(force_on(probe.fiber, with, world)),
    }
}

/// Mean force of a partner on a fibre over the last substep, N, world frame.
fn force_on(fiber: usize, with: ContactPartner, world: &World) -> Vector3<f64> {
    let is_own = |side: BodyRef| matches!(side, BodyRef::Fiber(f) if f as usize == fiber);
    let is_other = |side: BodyRef| match (side, with) {
        (BodyRef::Fiber(a), ContactPartner::Fiber(b))
        | (BodyRef::Object(a), ContactPartner::Object(b)) => a as usize == b,
        _ => false,
    };
    let mut sum = Vector3::zeros();
    for contact in world.contacts() {
        let [a, b] = contact.sides;
        if is_own(a) && is_other(b) {
            sum += contact.force;
        } else if is_own(b) && is_other(a) {
            sum -= contact.force;
        }
    }
    sum
}
