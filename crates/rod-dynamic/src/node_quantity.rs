//! What a picture shows of the nodes of a rod.

use crate::RodState;

/// A quantity at the nodes of a rod, which can be read without the rest of its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeQuantity {
    /// Speed, m/s.
    Speed,
    /// Curvature of the centerline, 1/m: the part of the Darboux vector across the tangent.
    Curvature,
    /// Tension, N: the mean of those of the segments beside the node.
    Tension,
}

impl NodeQuantity {
    /// Appends the values at all nodes of a state.
    pub fn of_state(self, state: &RodState, into: &mut Vec<f64>) {
        match self {
            Self::Speed => into.extend(state.velocities.iter().map(|v| v.norm())),
            Self::Curvature => into.extend(state.curvatures.iter().map(|kappa| kappa.xy().norm())),
            Self::Tension => {
                let segments = state.frames.iter().zip(&state.forces);
                into.extend(at_nodes(
                    segments.map(|(frame, force)| frame.matrix().column(2).dot(force)),
                ));
            }
        }
    }
}

/// Values at nodes from those of the segments, at least one, between them: means, and at an end
/// that of its only segment.
pub(crate) fn at_nodes(segments: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    let mut before = None;
    let segments = segments.map(Some).chain([None]);
    segments.map(move |next| {
        let ends = [before.or(next), next.or(before)].map(Option::unwrap_or_default);
        before = next;
        0.5 * (ends[0] + ends[1])
    })
}
