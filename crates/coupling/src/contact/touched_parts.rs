//! The parts of fibres that have contact points.

use crate::Fibers;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use rapunzel_rod_dynamic::StaggeredBatch;

/// All fibres are looked at where there is a contact point for one in so many segments.
const CROWDED: usize = 4;

/// The segments at which fibres have contact points, and their nodes: by group, ascending, those of
/// any of its fibres.
pub(super) struct TouchedParts {
    pub(super) nodes: Vec<Vec<usize>>,
    pub(super) segments: Vec<Vec<usize>>,
}

impl TouchedParts {
    /// What some contact points touch; `None` where there are so many that to look at all fibres
    /// costs less.
    pub(super) fn new<'a>(
        fibers: &Fibers<StaggeredBatch>,
        points: impl Iterator<Item = &'a ContactPoint> + Clone,
    ) -> Option<Self> {
        if CROWDED * points.clone().count() > fibers.assembly().layout().segments() {
            return None;
        }
        let mut segments = vec![Vec::new(); fibers.groups.len()];
        for point in points {
            for (side, segment) in point.sides.into_iter().zip(point.segments) {
                if let BodyRef::Fiber(fiber) = side {
                    segments[fibers.lane(fiber as usize).0].push(segment as usize);
                }
            }
        }
        for own in &mut segments {
            own.sort_unstable();
            own.dedup();
        }
        let nodes = |own: &Vec<usize>| {
            let mut nodes: Vec<_> =
                own.iter().flat_map(|&segment| [segment, segment + 1]).collect();
            nodes.dedup();
            nodes
        };
        Some(Self { nodes: segments.iter().map(nodes).collect(), segments })
    }
}
