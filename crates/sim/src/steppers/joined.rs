use super::free::{ledger_columns, ledger_row};
use super::{NodeLoads, fiber_nodes, fiber_points, fiber_strands, fiber_values};
use crate::stepper::{FiberStates, Scenery, Stepper};
use crate::{NodePull, SimError};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::{JoinedFibers, StepReport, Surroundings};
use rapunzel_export::Strand;
use rapunzel_rod_dynamic::{Energy, RodState};
use rapunzel_studio::Coloring;

/// Fibres that are joined to each other or closed, and touch nothing.
pub(crate) struct Joined {
    pub(crate) fibers: JoinedFibers,
    pub(crate) scenery: Scenery,
    /// Whether the table of energies tells the ledger.
    pub(crate) tells_ledger: bool,
}

impl Stepper for Joined {
    fn step(&mut self, around: &mut Surroundings, dt: f64) -> Result<StepReport, SimError> {
        Ok(self.fibers.step(around, dt)?)
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        self.fibers.energy(gravity)
    }

    fn strand_nodes(&self) -> Vec<usize> {
        fiber_nodes(self.fibers.fibers())
    }

    fn strands(&self) -> Box<dyn Iterator<Item = Strand> + '_> {
        Box::new(fiber_strands(self.fibers.fibers(), NodeLoads::default()))
    }

    fn points(&self, into: &mut Vec<Point3<f64>>) {
        fiber_points(self.fibers.fibers(), into);
    }

    fn values(&self, of: Coloring, into: &mut Vec<f64>) {
        fiber_values(self.fibers.fibers(), of, NodeLoads::default, into);
    }

    fn node(&self, strand: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        self.fibers.fibers().node(strand, node)
    }

    fn save(&self) -> Box<dyn Iterator<Item = Vec<f64>> + '_> {
        Box::new(self.fibers.save())
    }

    fn restore(&mut self, saved: &[Vec<f64>], _: f64) -> Result<(), SimError> {
        Ok(self.fibers.restore(saved)?)
    }

    fn scenery(&self) -> Scenery {
        self.scenery.clone()
    }

    fn energy_columns(&self) -> Vec<String> {
        if self.tells_ledger { ledger_columns() } else { Vec::new() }
    }

    fn energy_row(&self) -> Vec<f64> {
        if self.tells_ledger { ledger_row(self.fibers.fibers().ledger()) } else { Vec::new() }
    }

    fn fibers(&self) -> Option<&dyn FiberStates> {
        Some(self.fibers.fibers())
    }

    fn pull(&mut self, pulls: &[NodePull]) -> Result<(), SimError> {
        let pulls = pulls.iter().map(|pull| (pull.strand, pull.node, pull.force));
        self.fibers.fibers_mut().pull(pulls);
        Ok(())
    }

    fn set_state(&mut self, fiber: usize, state: &RodState) -> Result<(), SimError> {
        let set = self.fibers.fibers_mut().set_state(fiber, state);
        set.map_err(|source| SimError::State { fiber, source })
    }
}
