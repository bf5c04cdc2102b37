//! Directions in which branches of equilibria go.

use crate::shooting::Variation;
use crate::step::ShootingNode;

/// A direction in the space of equilibria and parameter.
pub(crate) struct Direction {
    pub(crate) nodes: Vec<Variation>,
    pub(crate) parameter: f64,
}

impl Direction {
    /// The direction as a functional: the sum of products of positions and rotations in the mean
    /// over the nodes, and of the parameter in parts of its `range`.
    pub(crate) fn functional(&self, range: f64) -> Self {
        let share = 1.0 / self.nodes.len() as f64;
        let part =
            |v: &Variation| Variation::from_fn(|i, _| if i < 6 { v[i] * share } else { 0.0 });
        let nodes = self.nodes.iter().map(part).collect();
        Self { nodes, parameter: self.parameter / (range * range) }
    }

    pub(crate) fn product(&self, other: &Self) -> f64 {
        let nodes = self.nodes.iter().zip(&other.nodes).map(|(a, b)| a.dot(b)).sum::<f64>();
        nodes + self.parameter * other.parameter
    }
}

/// The way from one point to another on the same mesh.
pub(crate) fn direction(from: &[ShootingNode], a: f64, to: &[ShootingNode], b: f64) -> Direction {
    let nodes = from.iter().zip(to).map(|(from, to)| to.minus(from)).collect();
    Direction { nodes, parameter: b - a }
}
