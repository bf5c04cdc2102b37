use super::{NodeLoads, fiber_nodes, fiber_points, fiber_strands, fiber_values};
use crate::stepper::{FiberStates, Scenery, Stepper};
use crate::{NodePull, SimError};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::{EnergyLedger, Fibers, RodBatch, StepReport, Surroundings};
use rapunzel_export::Strand;
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{Energy, Momentum, NodeQuantity, RodState};
use rapunzel_studio::Coloring;

/// Fibres that touch nothing.
pub(crate) struct Free {
    pub(crate) fibers: Fibers<dyn RodBatch>,
    pub(crate) scenery: Scenery,
    /// Whether the table of energies tells the ledger.
    pub(crate) tells_ledger: bool,
}

/// Names of the columns of a ledger.
pub(super) fn ledger_columns() -> Vec<String> {
    ["gravity", "loads", "drag", "damping", "supports", "the integrator", "the solver"]
        .map(|what| format!("work of {what} (J)"))
        .to_vec()
}

/// Numbers of these columns.
pub(super) fn ledger_row(ledger: Option<EnergyLedger>) -> Vec<f64> {
    let EnergyLedger { gravity, loads, drag, damping, supports, integrator, solver } =
        ledger.unwrap_or_default();
    vec![gravity, loads, drag, damping, supports, integrator, solver]
}

impl<B: RodBatch + ?Sized> FiberStates for Fibers<B> {
    fn assembly(&self) -> &Assembly {
        self.assembly()
    }

    fn state(&self, fiber: usize) -> RodState {
        self.state(fiber)
    }

    fn node_positions(&self, fiber: usize, into: &mut Vec<Point3<f64>>) {
        self.node_positions(fiber, into);
    }

    fn node_values(&self, fiber: usize, of: NodeQuantity, into: &mut Vec<f64>) {
        self.node_values(fiber, of, into);
    }

    fn energy_of(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy {
        self.energy_of(fiber, gravity)
    }

    fn momentum(&self) -> Option<Momentum> {
        self.momentum()
    }

    fn reaction(&self, fiber: usize, at_tip: bool, t: f64) -> Option<[Vector3<f64>; 2]> {
        Some(self.reaction(fiber, at_tip, t))
    }

    fn ledger(&self) -> Option<EnergyLedger> {
        self.ledger()
    }
}

impl Stepper for Free {
    fn step(&mut self, around: &mut Surroundings, dt: f64) -> Result<StepReport, SimError> {
        Ok(self.fibers.step(around, dt)?)
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        self.fibers.energy(gravity)
    }

    fn strand_nodes(&self) -> Vec<usize> {
        fiber_nodes(&self.fibers)
    }

    fn strands(&self) -> Box<dyn Iterator<Item = Strand> + '_> {
        Box::new(fiber_strands(&self.fibers, NodeLoads::default()))
    }

    fn points(&self, into: &mut Vec<Point3<f64>>) {
        fiber_points(&self.fibers, into);
    }

    fn values(&self, of: Coloring, into: &mut Vec<f64>) {
        fiber_values(&self.fibers, of, NodeLoads::default, into);
    }

    fn node(&self, strand: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        self.fibers.node(strand, node)
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
        if self.tells_ledger { ledger_row(self.fibers.ledger()) } else { Vec::new() }
    }

    fn fibers(&self) -> Option<&dyn FiberStates> {
        Some(&self.fibers)
    }

    fn pull(&mut self, pulls: &[NodePull]) -> Result<(), SimError> {
        let pulls = pulls.iter().map(|pull| (pull.strand, pull.node, pull.force));
        self.fibers.pull(pulls);
        Ok(())
    }

    fn set_state(&mut self, fiber: usize, state: &RodState) -> Result<(), SimError> {
        let set = self.fibers.set_state(fiber, state);
        set.map_err(|source| SimError::State { fiber, source })
    }
}
