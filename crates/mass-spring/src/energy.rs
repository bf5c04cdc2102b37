use crate::{Columns, System};
use nalgebra::SVector;

/// Energy of a system, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Of motion.
    pub kinetic: f64,
    /// Of springs and bends.
    pub elastic: f64,
    /// In gravity, zero at the world's origin.
    pub gravitational: f64,
    /// In the loads, zero at the world's origin.
    pub load: f64,
}

impl Energy {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.load
    }
}

impl<const D: usize> System<D> {
    /// Energy, J; costs a pass over springs and nodes.
    #[must_use]
    pub fn energy(&self) -> Energy {
        let (x, v) = (&self.positions, &self.velocities);
        let mut energy = Energy { elastic: self.elastic_energy(x), ..Energy::default() };
        for (node, mass) in self.masses.iter().enumerate() {
            energy.kinetic += 0.5 * mass * v.get(node).norm_squared();
            energy.gravitational -= mass * self.gravity.dot(&x.get(node));
        }
        energy.load = -self.loads.iter().map(|(&node, f)| f.dot(&x.get(node))).sum::<f64>();
        energy
    }

    /// Energy of springs and bends at other positions, J.
    pub(crate) fn elastic_energy(&self, x: &Columns<D>) -> f64 {
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
    /// drag, W; negative where the wind gives more. With supports at rest and no contacts the
    /// [total](Energy::total) energy falls at this rate.
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
}
