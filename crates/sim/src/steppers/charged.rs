use super::{NodeLoads, fiber_nodes, fiber_points, fiber_strands, fiber_values};
use crate::SimError;
use crate::folder::CHARGE;
use crate::stepper::{FiberStates, Scenery, Stepper};
use nalgebra::{Point3, Vector3};
use rapunzel_charging::ChargedRods;
use rapunzel_coupling::{StepReport, Surroundings};
use rapunzel_export::Strand;
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{Energy, RodState};
use rapunzel_studio::Coloring;

/// Fibres at rest, on which charge comes.
pub(crate) struct Charged {
    pub(crate) fibers: ChargedRods,
    pub(crate) scenery: Scenery,
}

impl FiberStates for ChargedRods {
    fn assembly(&self) -> &Assembly {
        self.assembly()
    }

    fn state(&self, fiber: usize) -> RodState {
        self.state(fiber)
    }

    fn energy_of(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy {
        self.energy_of(fiber, gravity)
    }
}

impl Charged {
    fn loads(&self) -> NodeLoads {
        NodeLoads { charges: self.fibers.charges(), ..NodeLoads::default() }
    }
}

impl Stepper for Charged {
    fn step(&mut self, around: &mut Surroundings, dt: f64) -> Result<StepReport, SimError> {
        self.fibers.step(around.end, dt)?;
        let fibers = self.fibers.assembly().layout().fibers();
        Ok(StepReport { fibers, ..StepReport::default() })
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let mut sum = Energy::default();
        for fiber in 0..self.fibers.assembly().layout().fibers() {
            let energy = self.fibers.energy_of(fiber, gravity);
            sum.elastic += energy.elastic;
            sum.gravitational += energy.gravitational;
        }
        sum
    }

    fn strand_nodes(&self) -> Vec<usize> {
        fiber_nodes(&self.fibers)
    }

    fn strands(&self) -> Box<dyn Iterator<Item = Strand> + '_> {
        Box::new(fiber_strands(&self.fibers, self.loads()))
    }

    fn points(&self, into: &mut Vec<Point3<f64>>) {
        fiber_points(&self.fibers, into);
    }

    fn values(&self, of: Coloring, into: &mut Vec<f64>) {
        fiber_values(&self.fibers, of, || self.loads(), into);
    }

    fn node(&self, strand: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        let state = self.fibers.state(strand);
        let node = node.unwrap_or(state.positions.len() - 1);
        (state.positions[node], state.velocities[node])
    }

    fn save(&self) -> Box<dyn Iterator<Item = Vec<f64>> + '_> {
        Box::new(self.fibers.save())
    }

    fn restore(&mut self, saved: &[Vec<f64>], time: f64) -> Result<(), SimError> {
        Ok(self.fibers.restore(saved, time)?)
    }

    fn scenery(&self) -> Scenery {
        self.scenery.clone()
    }

    fn tables(&self) -> Vec<(&'static str, Vec<String>)> {
        let names = [
            "charge (C)",
            "drained (C)",
            "electric (J)",
            "mean field (V/m)",
            "lift",
            "evaluations",
            "retreats",
            "unsettled",
            "residual",
        ];
        vec![(CHARGE, names.map(str::to_owned).to_vec())]
    }

    fn row(&self, _: usize) -> Vec<f64> {
        let of = self.fibers.report();
        let counts = [of.evaluations, of.retreats, of.unsettled].map(|count| count as f64);
        let sizes = [of.charge, of.drained, of.energy, of.mean_field, of.lift];
        sizes.into_iter().chain(counts).chain([of.residual]).collect()
    }

    fn fibers(&self) -> Option<&dyn FiberStates> {
        Some(&self.fibers)
    }

    fn charged(&self) -> Option<&ChargedRods> {
        Some(&self.fibers)
    }
}
