//! What a joint between two nodes is.

use crate::{CouplingError, Fibers};
use rapunzel_rod_dynamic::StaggeredBatch;

/// Largest gap of a joint at the start, in lengths of its fibres.
const LARGEST_GAP: f64 = 1e-9;

/// A node of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiberPlace {
    /// Index of the fibre in the assembly.
    pub fiber: usize,
    /// Index of the node, from the root.
    pub node: usize,
}

impl FiberPlace {
    /// Index of the segment before the node, at a root of that behind it.
    pub(crate) fn segment(self) -> usize {
        self.node.saturating_sub(1)
    }
}

/// What a joint holds beside the nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Connection {
    /// Nothing: a ball joint.
    Ball,
    /// The angle at which the segments before the nodes, at a root behind it, are at the start:
    /// what is between their middles bends and twists as their fibres do.
    Stiff,
    /// A tip and a root as one fibre: what is between bends and twists as within a fibre. The
    /// root's fibre goes on turned about the tangent.
    Spliced {
        /// Angle by which it is turned back, rad: a straight fibre that is closed to a ring gets as
        /// much twist.
        twist: f64,
    },
}

/// A joint between two nodes that lie at the same place.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeJoint {
    /// What errors call it.
    pub name: String,
    /// The two nodes; of a spliced joint the tip comes first.
    pub places: [FiberPlace; 2],
    /// What it holds beside the nodes.
    pub connection: Connection,
    /// Retardation time of the internal damping of what bends at it, s: of the mean strain rate
    /// over a step.
    pub damping_time: f64,
}

impl NodeJoint {
    /// Refuses a joint whose nodes do not meet.
    pub(crate) fn check_closed(
        &self,
        fibers: &Fibers<StaggeredBatch>,
    ) -> Result<(), CouplingError> {
        let [a, b] = self.places.map(|place| fibers.node(place.fiber, Some(place.node)).0);
        let own = self.places.map(|place| fibers.assembly().fibers()[place.fiber].length());
        let (gap, most) = ((a - b).norm(), LARGEST_GAP * own[0].max(own[1]));
        if gap <= most {
            return Ok(());
        }
        let places = [a, b].map(|place| place.coords.into());
        Err(CouplingError::JointOpen { joint: self.name.clone(), gap, most, places })
    }
}

/// Refuses joints between nodes that others join already.
pub(crate) fn refuse_repeated(joints: &[NodeJoint]) -> Result<(), CouplingError> {
    // By node that is joined: a number that all that are joined to it have in common, and the last
    // joint there.
    let mut known: Vec<(FiberPlace, usize, &str)> = Vec::new();
    for NodeJoint { name: joint, places, .. } in joints {
        let sets = places.map(|place| {
            let found = known.iter().position(|(other, ..)| *other == place);
            found.unwrap_or_else(|| {
                known.push((place, known.len(), joint));
                known.len() - 1
            })
        });
        let [a, b] = sets.map(|at| known[at].1);
        if a == b {
            let other = known[sets[0]].2.to_owned();
            return Err(CouplingError::JointTwice { joint: joint.clone(), other });
        }
        known.iter_mut().filter(|(_, set, _)| *set == b).for_each(|(_, set, _)| *set = a);
        sets.iter().for_each(|&at| known[at].2 = joint);
    }
    Ok(())
}
