use crate::StepReport;
use nalgebra::{Point3, Vector3};
use rapunzel_rod_dynamic::{
    self as rod, Conditions, Energy, Ledger, Momentum, NodeQuantity, RodError, RodIntegrator,
    RodState, SectionLaws, StaggeredBatch, StepError, adaptive,
};

/// How much more a gripper resists what moves an inner node than the node's inertia does in a step:
/// forces are differences of its own, and lose as many digits.
const STIFF: f64 = 1e4;

/// Rods that are stepped together: one in each lane.
pub trait RodBatch: Send + Sync {
    /// The state of the rod in a lane; allocates.
    fn state(&self, lane: usize) -> RodState;
    /// Appends the positions of all nodes of the rod in a lane, m, world.
    fn node_positions(&self, lane: usize, into: &mut Vec<Point3<f64>>) {
        into.extend(self.state(lane).positions);
    }
    /// Appends the values of a quantity at all nodes of the rod in a lane.
    fn node_values(&self, lane: usize, of: NodeQuantity, into: &mut Vec<f64>) {
        of.of_state(&self.state(lane), into);
    }
    /// Puts the rod in a lane into a state.
    ///
    /// # Errors
    /// [`RodError`] for a state of another rod.
    fn set_state(&mut self, lane: usize, state: &RodState) -> Result<(), RodError>;
    /// The energies of the rods in all lanes, J, in a gravity, m/s^2; allocates.
    fn energies(&self, gravity: &Vector3<f64>) -> Vec<Energy>;
    /// Sets the forces on all nodes of the rod in a lane, N, world.
    ///
    /// # Errors
    /// [`RodError`] for forces that are not finite or not one a node.
    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError>;
    /// Holds an inner node of the rod in a lane at a place (m, world) at the end of the next step,
    /// of `dt` (s), or lets it go.
    ///
    /// # Errors
    /// [`RodError`] if the integrator cannot hold it, as most cannot.
    fn hold_node(
        &mut self,
        _lane: usize,
        _node: usize,
        _place: Option<Point3<f64>>,
        _dt: f64,
    ) -> Result<(), RodError> {
        let why = "the integrator of these rods holds no inner nodes";
        Err(RodError::Invalid { what: "node", why })
    }
    /// Gives the sections of the rod in a lane other laws.
    ///
    /// # Errors
    /// [`RodError`] if the integrator cannot change them.
    fn set_laws(&mut self, lane: usize, laws: SectionLaws) -> Result<(), RodError>;
    /// Moves all rods by `dt`, s, under the conditions of their lanes.
    ///
    /// # Errors
    /// [`StepError`] names the lane as the fibre.
    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError>;
    /// The momentum of the rod in a lane, if the integrator tells it.
    fn momentum(&self, _lane: usize) -> Option<Momentum> {
        None
    }
    /// Keeps a ledger of every step from now on, if the integrator can.
    fn keep_ledgers(&mut self) {}
    /// The ledger of the last step of a lane, if it is kept.
    fn ledger(&self, _lane: usize) -> Option<Ledger> {
        None
    }
    /// Appends all numbers that change.
    fn save(&self, numbers: &mut Vec<f64>);
    /// Goes back to saved numbers.
    ///
    /// # Errors
    /// [`RodError`] if they are those of other rods.
    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError>;
}

/// Fibres in SIMD lanes.
impl RodBatch for StaggeredBatch {
    fn state(&self, lane: usize) -> RodState {
        self.state(lane)
    }

    fn node_positions(&self, lane: usize, into: &mut Vec<Point3<f64>>) {
        self.node_positions(lane, into);
    }

    fn node_values(&self, lane: usize, of: NodeQuantity, into: &mut Vec<f64>) {
        self.node_values(lane, of, into);
    }

    fn set_state(&mut self, lane: usize, state: &RodState) -> Result<(), RodError> {
        self.set_state(lane, state)
    }

    fn energies(&self, gravity: &Vector3<f64>) -> Vec<Energy> {
        self.energies(gravity)[..self.rods().len()].to_vec()
    }

    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        self.set_node_forces(lane, forces)
    }

    fn hold_node(
        &mut self,
        lane: usize,
        node: usize,
        place: Option<Point3<f64>>,
        dt: f64,
    ) -> Result<(), RodError> {
        let fiber = &self.rods()[lane].fiber;
        let mass = 0.5 * (fiber.segment_mass(node - 1) + fiber.segment_mass(node));
        let stiffness = if place.is_some() { STIFF * mass / (dt * dt) } else { 0.0 };
        self.set_node_spring(lane, node, stiffness, &place.unwrap_or_default())
    }

    fn set_laws(&mut self, lane: usize, laws: SectionLaws) -> Result<(), RodError> {
        self.set_laws(lane, laws)
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        let mut reports = [rod::RodStepReport::default(); Self::MAX_FIBERS];
        self.step(dt, lanes, &mut reports)?;
        let mut sum = StepReport::default();
        for one in &reports[..lanes.len()] {
            sum.add(&StepReport::of_one(one.iterations, one.halvings, 0));
        }
        Ok(sum)
    }

    fn momentum(&self, lane: usize) -> Option<Momentum> {
        Some(self.momentum(lane))
    }

    fn keep_ledgers(&mut self) {
        self.keep_ledgers(true);
    }

    fn ledger(&self, lane: usize) -> Option<Ledger> {
        self.ledger(lane)
    }

    fn save(&self, numbers: &mut Vec<f64>) {
        self.save(numbers);
    }

    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        self.restore(numbers)
    }
}

/// Rods that are stepped one after another.
pub struct Rods<I> {
    /// One in each lane.
    pub rods: Vec<I>,
    /// Error allowed in a second, m/s; `None` for steps as they are asked for.
    pub tolerance: Option<f64>,
}

impl<I: RodIntegrator> Rods<I> {
    fn step_one(
        &mut self,
        lane: usize,
        dt: f64,
        conditions: &dyn Conditions,
    ) -> Result<StepReport, StepError> {
        let rod = &mut self.rods[lane];
        match self.tolerance {
            None => {
                let one = rod.step(dt, conditions)?;
                Ok(StepReport::of_one(one.iterations, one.halvings, 0))
            }
            Some(tolerance) => {
                let one = adaptive::advance(rod, dt, tolerance * dt, conditions)?;
                Ok(StepReport::of_one(one.iterations, one.halvings, one.missed))
            }
        }
    }
}

impl<I: RodIntegrator + Sync> RodBatch for Rods<I> {
    fn state(&self, lane: usize) -> RodState {
        self.rods[lane].state()
    }

    fn set_state(&mut self, lane: usize, state: &RodState) -> Result<(), RodError> {
        self.rods[lane].set_state(state)
    }

    fn energies(&self, gravity: &Vector3<f64>) -> Vec<Energy> {
        self.rods.iter().map(|rod| rod.energy(gravity)).collect()
    }

    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        self.rods[lane].set_node_forces(forces)
    }

    fn set_laws(&mut self, _: usize, _: SectionLaws) -> Result<(), RodError> {
        let why = "rods that are stepped one after another keep their laws";
        Err(RodError::Invalid { what: "laws", why })
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        let mut sum = StepReport::default();
        for (lane, conditions) in lanes.iter().enumerate() {
            let one = self.step_one(lane, dt, *conditions);
            sum.add(&one.map_err(|error| error.renumbered(|_| lane))?);
        }
        Ok(sum)
    }

    /// Each rod's numbers after their count.
    fn save(&self, numbers: &mut Vec<f64>) {
        for rod in &self.rods {
            let at = numbers.len();
            numbers.push(0.0);
            rod.save(numbers);
            numbers[at] = (numbers.len() - at - 1) as f64;
        }
    }

    fn restore(&mut self, mut numbers: &[f64]) -> Result<(), RodError> {
        let found = numbers.len();
        for rod in &mut self.rods {
            let short = RodError::Length { what: "saved numbers", expected: found + 1, found };
            let (count, rest) = numbers.split_first().ok_or(short.clone())?;
            #[expect(clippy::cast_possible_truncation, reason = "a length written by save")]
            let (own, rest) = rest.split_at_checked(*count as usize).ok_or(short)?;
            rod.restore(own)?;
            numbers = rest;
        }
        Ok(())
    }
}
