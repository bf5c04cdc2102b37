use crate::mesh::{MeshElement, Scaled};
use crate::shooting::Variation;
use crate::state::State;
use crate::step::ShootingNode;

/// Relative difference below which numbers of two equilibria count as equal.
const SAME: f64 = 1e-7;

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
        self.rod.unscale(&self.scaled_at(s / self.rod.length))
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

    /// Whether two equilibria may be turned or reflected into each other: their energies, and the
    /// sizes of force and moment at both ends, are the same.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let sizes = |e: &Self| {
            let [root, tip] =
                [&e.nodes[0], &e.nodes[e.nodes.len() - 1]].map(|n| [n.m.norm(), n.n.norm()]);
            [e.elastic, e.elastic - e.work, root[0], tip[0], root[1], tip[1]]
        };
        let (a, b) = (sizes(self), sizes(other));
        let unit = 1.0 + a.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        a.iter().zip(&b).all(|(a, b)| (a - b).abs() < SAME * unit)
    }

    /// The node at the scaled arc length `s`.
    fn scaled_at(&self, s: f64) -> ShootingNode {
        self.rod.node_at(&self.elements, &self.nodes, self.factor, s)
    }

    /// The variation at the scaled arc length `s`, from those of the nodes.
    pub(crate) fn varied(&self, variations: &[Variation], s: f64) -> Variation {
        let index = self.elements.partition_point(|e| e.to <= s);
        let last = variations.len() - 1;
        let Some(element) = self.elements.get(index) else { return variations[last] };
        let properties = self.rod.properties(element, self.factor);
        let to = s.max(element.from);
        // A step within one that was taken can be.
        let step = self.nodes[index].step_with_derivatives(element.from, to, properties);
        step.map_or(variations[index], |(_, by)| by * variations[index])
    }
}
