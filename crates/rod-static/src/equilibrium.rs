use crate::mesh::{MeshElement, Scaled};
use crate::state::State;
use crate::step::ShootingNode;

/// An equilibrium: the rod's state at any arc length, its energies and its stability.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    pub(crate) rod: Scaled,
    pub(crate) elements: Vec<MeshElement>,
    pub(crate) nodes: Vec<ShootingNode>,
    /// Fraction of the loads that acts.
    pub(crate) factor: f64,
    pub(crate) elastic: f64,
    pub(crate) work: f64,
    pub(crate) conjugate_points: usize,
}

impl Equilibrium {
    /// The state at arc length `s`, m, within `[0, length]` (beyond: at the nearer end). One
    /// Runge-Kutta step from the node before.
    #[must_use]
    pub fn at(&self, s: f64) -> State {
        self.rod.unscale(&self.node_at(s / self.rod.length))
    }

    /// State at the clamp; its force and moment are the reactions that the clamp carries.
    #[must_use]
    pub fn root(&self) -> State {
        self.at(0.0)
    }

    /// State at the far end; its force and moment are those that act on the end.
    #[must_use]
    pub fn tip(&self) -> State {
        self.rod.unscale(&self.nodes[self.nodes.len() - 1])
    }

    /// Elastic energy, J.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        self.elastic * self.rod.energy()
    }

    /// Potential energy of the dead loads, J: less the force times the position, from the world's
    /// origin, of the loads along the rod and of the force on a free end.
    #[must_use]
    pub fn load_energy(&self) -> f64 {
        -self.work * self.rod.energy()
    }

    /// Sum of elastic energy and load energy, J.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.elastic_energy() + self.load_energy()
    }

    /// Number of points conjugate to the far end; zero for a stable equilibrium.
    #[must_use]
    pub fn conjugate_points(&self) -> usize {
        self.conjugate_points
    }

    /// Whether the energy is at a minimum.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.conjugate_points == 0
    }

    /// Number of elements, each one step of order eight.
    #[must_use]
    pub fn element_count(&self) -> usize {
        self.elements.len()
    }

    /// The node at the scaled arc length `s`.
    pub(crate) fn node_at(&self, s: f64) -> ShootingNode {
        let index = self.elements.partition_point(|e| e.to <= s);
        let Some(element) = self.elements.get(index) else {
            return self.nodes[self.nodes.len() - 1];
        };
        let properties = self.rod.properties(element, self.factor);
        self.nodes[index].step(element.from, s.max(element.from), properties).node
    }
}
