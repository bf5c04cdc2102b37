use crate::supports::Guide;
use crate::{NodeVectors, System};
use nalgebra::SVector;

/// Energy of a system, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringEnergy {
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Elastic energy of springs and bends, J.
    pub elastic: f64,
    /// Potential energy in gravity, J, zero at the world's origin.
    pub gravitational: f64,
    /// Potential energy of the loads, J, zero at the world's origin.
    pub load: f64,
}

impl SpringEnergy {
    /// Sum of all four energies, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.load
    }
}

impl<const D: usize> System<D> {
    /// Energy of the present state, J; costs a pass over springs and nodes.
    #[must_use]
    pub fn energy(&self) -> SpringEnergy {
        let (x, v) = (&self.positions, &self.velocities);
        let mut energy =
            SpringEnergy { elastic: self.elastic_energy(x), ..SpringEnergy::default() };
        for (node, mass) in self.masses.iter().enumerate() {
            energy.kinetic += 0.5 * mass * v.get(node).norm_squared();
            energy.gravitational -= mass * self.gravity.dot(&x.get(node));
        }
        energy.load = -self.loads.iter().map(|(&node, f)| f.dot(&x.get(node))).sum::<f64>();
        energy
    }

    /// Energy of springs and bends at other positions, J.
    pub(crate) fn elastic_energy(&self, x: &NodeVectors<D>) -> f64 {
        let spring = |s: usize| {
            let [i, j] = self.springs.nodes[s];
            let length = (x.get(j) - x.get(i)).norm();
            0.5 * self.springs.stiffness[s] * (length - self.springs.rest_length[s]).powi(2)
        };
        let springs: f64 = (0..self.springs()).map(spring).sum();
        springs + self.bends.iter().map(|bend| bend.energy(x)).sum::<f64>()
    }

    /// Total momentum (world), kg m/s.
    #[must_use]
    pub fn momentum(&self) -> SVector<f64, D> {
        let masses = self.masses.iter().enumerate();
        masses.map(|(node, &mass)| self.velocities.get(node) * mass).sum()
    }

    /// Power that drag and dampers take from the motion, and that the wind gives back through the
    /// drag, W; negative where the wind gives more. The [total](SpringEnergy::total) energy falls
    /// at this rate less the [power of the supports](Self::support_power).
    ///
    /// This balance leaves out instantaneous changes (contacts, springs that give way, supports
    /// that take a moving node), the controller of an [`Enclosure`](crate::Enclosure), loads and
    /// gravity that change in time, and the numerical damping of the implicit integrator.
    #[must_use]
    pub fn dissipation(&self) -> f64 {
        let air = self.wind.at(self.time);
        let drag = |node: usize| {
            let velocity = self.velocities.get(node);
            self.drag * self.masses[node] * velocity.dot(&(velocity - air))
        };
        let damper = |s: usize| {
            let [i, j] = self.springs.nodes[s];
            let apart = self.positions.get(j) - self.positions.get(i);
            let parting = self.velocities.get(j) - self.velocities.get(i);
            let length = apart.norm();
            let rate = if length > 0.0 { parting.dot(&apart) / length } else { 0.0 };
            self.springs.damping[s] * rate * rate
        };
        let drags: f64 = (0..self.nodes()).map(drag).sum();
        drags + (0..self.springs()).map(damper).sum::<f64>()
    }

    /// Power that supports put into the nodes that they move, W: against the sum of all forces on
    /// these nodes. Costs an evaluation of forces. The tensions of a
    /// [`RigidChain`](crate::RigidChain) are in [its own power](crate::RigidChain::support_power).
    #[must_use]
    pub fn support_power(&self) -> f64 {
        let (x, v) = (&self.positions, &self.velocities);
        let mut forces = self.internal_forces(x, v);
        self.loads.iter().for_each(|(&node, load)| forces.add(node, load));
        let air = self.wind.at(self.time);
        let push = |node: usize| {
            let field = self.gravity - (v.get(node) - air) * self.drag;
            forces.get(node) + field * self.masses[node]
        };
        self.driven_power(push)
    }

    /// Power against `force` of the components that are driven, W.
    pub(crate) fn driven_power(&self, force: impl Fn(usize) -> SVector<f64, D>) -> f64 {
        let of_node = |&(node, guides): &(usize, [Guide; D])| {
            let (force, velocity) = (force(node), self.velocities.get(node));
            let driven = (0..D).filter(|&axis| guides[axis] == Guide::Driven);
            driven.map(|axis| -force[axis] * velocity[axis]).sum::<f64>()
        };
        self.supports.guided.iter().map(of_node).sum()
    }
}
