use super::free::{ledger_columns, ledger_row};
use super::{NodeLoads, fiber_nodes, fiber_points, fiber_strands, fiber_values};
use crate::folder::{CONTACTS, OBJECTS};
use crate::stepper::{FiberStates, Scenery, Stepper};
use crate::{NodePull, SimError};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::{ContactWork, FibersInContact, StepReport, Stopwatch, Surroundings};
use rapunzel_export::Strand;
use rapunzel_rod_dynamic::{Energy, RodState};
use rapunzel_studio::Coloring;

/// Fibres that touch each other and objects.
pub(crate) struct InContact {
    pub(crate) fibers: FibersInContact,
    pub(crate) scenery: Scenery,
    /// Whether the table of energies tells the ledger.
    pub(crate) tells_ledger: bool,
    /// Number of objects.
    pub(crate) objects: usize,
}

impl InContact {
    fn loads(&self) -> NodeLoads {
        NodeLoads { contact_forces: self.fibers.contact_forces(), ..NodeLoads::default() }
    }
}

impl Stepper for InContact {
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
        Box::new(fiber_strands(self.fibers.fibers(), self.loads()))
    }

    fn points(&self, into: &mut Vec<Point3<f64>>) {
        fiber_points(self.fibers.fibers(), into);
    }

    fn values(&self, of: Coloring, into: &mut Vec<f64>) {
        fiber_values(self.fibers.fibers(), of, || self.loads(), into);
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
        let contacts = [
            "friction",
            "closing",
            "gap repair",
            "restitution",
            "adhesion",
            "compliance",
            "led objects",
        ];
        let mut names = contacts.map(|what| format!("work of {what} (J)")).to_vec();
        if self.tells_ledger {
            names.extend(ledger_columns());
        }
        names
    }

    fn energy_row(&self) -> Vec<f64> {
        let ContactWork { friction, closing, repair, restitution, adhesion, compliance, kinematic } =
            self.fibers.contact_work();
        let mut row = vec![friction, closing, repair, restitution, adhesion, compliance, kinematic];
        if self.tells_ledger {
            row.extend(ledger_row(self.fibers.fibers().ledger()));
        }
        row
    }

    /// Contacts, then, where there are objects, the forces of all fibres on them.
    fn tables(&self) -> Vec<(&'static str, Vec<String>)> {
        let contacts = [
            "listed",
            "active",
            "parts",
            "lists",
            "solves",
            "iterations",
            "unresolved",
            "residual",
            "normal error (m/s)",
            "slip error (m/s)",
            "creep (m/s)",
            "depth (m)",
        ];
        let force = |object: usize| {
            ["x", "y", "z"].map(|axis| format!("objects[{object}] force {axis} (N)"))
        };
        let mut tables = vec![(CONTACTS, contacts.map(str::to_owned).to_vec())];
        if self.objects > 0 {
            tables.push((OBJECTS, (0..self.objects).flat_map(force).collect()));
        }
        tables
    }

    fn row(&self, table: usize) -> Vec<f64> {
        if table > 0 {
            let forces = (0..self.objects).map(|object| self.fibers.force_on(object));
            return forces.flat_map(|force| [force.x, force.y, force.z]).collect();
        }
        let of = self.fibers.contact_report();
        let counts = [of.listed, of.active, of.parts, of.lists, of.solves, of.iterations];
        let counts = counts.into_iter().chain([of.unresolved]).map(|count| count as f64);
        counts.chain([of.residual, of.normal_error, of.slip_error, of.creep, of.depth]).collect()
    }

    fn set_stopwatch(&mut self, stopwatch: Option<Stopwatch>) {
        self.fibers.set_stopwatch(stopwatch);
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

    fn in_contact(&self) -> Option<&FibersInContact> {
        Some(&self.fibers)
    }
}
