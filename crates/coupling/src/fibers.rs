use crate::array_pool::ArrayPool;
use crate::conditions::FiberConditions;
use crate::{CouplingError, EnergyLedger, FiberGroup, RodBatch, StepReport, Surroundings};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{
    Conditions, End, Energy, Instant, Ledger, Momentum, NodeQuantity, RodError, RodState,
    elastic_moments,
};
use rayon::prelude::*;

/// All fibres of a scene at one instant, with what acts on them; contacts apart.
pub struct Fibers<B: RodBatch + ?Sized> {
    assembly: Assembly,
    pub(crate) groups: Vec<FiberGroup<B>>,
    /// Group and lane of every fibre.
    pub(crate) lanes: Vec<(usize, usize)>,
    /// Since the start, if it is kept.
    ledger: Option<EnergyLedger>,
    /// Positions and vectors of all nodes or segments, for the steps of fibres in contact.
    pub(crate) positions: ArrayPool<Point3<f64>>,
    pub(crate) vectors: ArrayPool<Vector3<f64>>,
}

impl<B: RodBatch + ?Sized> Fibers<B> {
    /// Fibres of an assembly, in its groups and their order; with a ledger of their energy if asked
    /// for.
    #[must_use]
    pub fn new(assembly: Assembly, mut groups: Vec<FiberGroup<B>>, keeps_ledger: bool) -> Self {
        let mut lanes = vec![(0, 0); assembly.fibers().len()];
        for (g, group) in groups.iter().enumerate() {
            for (lane, &fiber) in group.fibers.iter().enumerate() {
                lanes[fiber] = (g, lane);
            }
        }
        if keeps_ledger {
            groups.iter_mut().for_each(|group| group.batch.keep_ledgers());
        }
        let ledger = keeps_ledger.then(EnergyLedger::default);
        let (positions, vectors) = (ArrayPool::default(), ArrayPool::default());
        Self { assembly, groups, lanes, ledger, positions, vectors }
    }

    /// The fibres in their natural state.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Group and lane of a fibre.
    pub(crate) fn lane(&self, fiber: usize) -> (usize, usize) {
        self.lanes[fiber]
    }

    /// What acts on a fibre.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn conditions(&self, fiber: usize) -> &FiberConditions {
        let (group, lane) = self.lane(fiber);
        &self.groups[group].lanes[lane]
    }

    /// State of a fibre. Allocates; costs one pass over its nodes.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn state(&self, fiber: usize) -> RodState {
        let (group, lane) = self.lanes[fiber];
        self.groups[group].batch.state(lane)
    }

    /// Appends the positions of all nodes of a fibre, m, world: those of its state, for a small
    /// part of the cost.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    pub fn node_positions(&self, fiber: usize, into: &mut Vec<Point3<f64>>) {
        let (group, lane) = self.lanes[fiber];
        self.groups[group].batch.node_positions(lane, into);
    }

    /// Appends the values of a quantity at all nodes of a fibre.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    pub fn node_values(&self, fiber: usize, of: NodeQuantity, into: &mut Vec<f64>) {
        let (group, lane) = self.lanes[fiber];
        self.groups[group].batch.node_values(lane, of, into);
    }

    /// Puts a fibre into a state.
    ///
    /// # Errors
    /// [`RodError`] for a state of another fibre.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    pub fn set_state(&mut self, fiber: usize, state: &RodState) -> Result<(), RodError> {
        let (group, lane) = self.lanes[fiber];
        self.groups[group].batch.set_state(lane, state)
    }

    /// Lets hands pull at nodes from the next step on, in place of those before: fibre, node and
    /// force, N, world.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does; a step panics if there is no such node.
    pub fn pull(&mut self, pulls: impl IntoIterator<Item = (usize, usize, Vector3<f64>)>) {
        for lane in self.groups.iter_mut().flat_map(|group| &mut group.lanes) {
            if let Some(before) = &mut lane.pulls {
                before.clear();
            }
        }
        for (fiber, node, force) in pulls {
            let (group, lane) = self.lanes[fiber];
            self.groups[group].lanes[lane].pulls.get_or_insert_default().push((node, force));
        }
    }

    /// Position (m) and velocity (m/s) of a node of a fibre, world; of its tip for `None`.
    ///
    /// # Panics
    /// If there is no such fibre or node, as indexing does.
    #[must_use]
    pub fn node(&self, fiber: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        let state = self.state(fiber);
        let node = node.unwrap_or(state.positions.len() - 1);
        (state.positions[node], state.velocities[node])
    }

    /// Energy of a fibre, J, in a gravity, m/s^2. Costs one pass over the nodes of its group.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn energy_of(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy {
        let (group, lane) = self.lanes[fiber];
        self.groups[group].batch.energies(gravity)[lane]
    }

    /// Energy of all fibres, J, in a gravity, m/s^2. Costs one pass over all nodes.
    #[must_use]
    pub fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let groups = self.groups.par_iter().map(|group| group.batch.energies(gravity));
        let groups: Vec<_> = groups.collect();
        let mut sum = Energy::default();
        for energy in groups.into_iter().flatten() {
            sum.kinetic += energy.kinetic;
            sum.elastic += energy.elastic;
            sum.gravitational += energy.gravitational;
        }
        sum
    }

    /// Force (N) and moment (N m) of what holds an end of a fibre with the linear law, its tip or
    /// its root, on the fibre at time `t` (s), world frame; zero at a free end.
    ///
    /// They balance the segment and the joint at the end, and the weight of half of that segment
    /// and the forces on its node. The inertia of that half is left out, and so is the air on it.
    /// Of a fibre that is fed through a nozzle that of the root is the force at the mouth, but for
    /// what speeds up the part inside.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn reaction(&self, fiber: usize, at_tip: bool, t: f64) -> [Vector3<f64>; 2] {
        let (group, lane) = self.lanes[fiber];
        let own = &self.assembly.fibers()[fiber];
        let conditions = &self.groups[group].lanes[lane];
        let Instant { mut gravity, root, tip, inside, .. } = conditions.during(t).at(t);
        if !at_tip && inside > 0.0 {
            // What is inside a nozzle has no weight.
            gravity = Vector3::zeros();
        }
        let state = self.groups[group].batch.state(lane);
        let last = own.segments();
        // The force of the segment and the moment of the joint on the end's own node.
        let (end, node, segment, sign) =
            if at_tip { (tip, last, last - 1, 1.0) } else { (root, 0, 0, -1.0) };
        let forces = conditions.node_forces(t);
        let own_force = forces.map_or_else(Vector3::zeros, |forces| forces[node]);
        let load = gravity * (0.5 * own.segment_mass(segment)) + own_force;
        let force = sign * state.forces[segment] - load;
        match end {
            End::Loaded { .. } => [Vector3::zeros(); 2],
            End::Pinned { .. } => [force, Vector3::zeros()],
            End::Held(_) => [force, sign * elastic_moments(own, &state)[node]],
            End::Supported(support) => {
                let moment = sign * elastic_moments(own, &state)[node];
                support.reaction([force, moment], &state.frames[segment])
            }
        }
    }

    /// Momentum of all fibres about the world's origin, if their integrators tell it.
    #[must_use]
    pub fn momentum(&self) -> Option<Momentum> {
        let mut sum = Momentum::default();
        for group in &self.groups {
            for lane in 0..group.fibers.len() {
                sum += group.batch.momentum(lane)?;
            }
        }
        Some(sum)
    }

    /// Works done since the start, if a ledger is kept.
    #[must_use]
    pub fn ledger(&self) -> Option<EnergyLedger> {
        self.ledger
    }

    /// Records the step, or part of one, that all groups have taken, beside the works on free
    /// objects.
    pub(crate) fn record(&mut self, objects: &Ledger) {
        let Some(ledger) = &mut self.ledger else { return };
        ledger.record(objects);
        for group in &self.groups {
            let lanes = (0..group.fibers.len()).filter_map(|lane| group.batch.ledger(lane));
            lanes.for_each(|one| ledger.record(&one));
        }
    }

    /// Moves every fibre by itself, without contacts, in parallel over groups. The result does not
    /// depend on the number of threads.
    ///
    /// # Errors
    /// [`CouplingError::Step`] names the first fibre that failed; others have been moved then:
    /// [restore](Self::restore) what was saved before going on.
    pub fn step(&mut self, around: &Surroundings, dt: f64) -> Result<StepReport, CouplingError> {
        let time = around.start;
        // The order of the results is the order of the groups, whoever computes them.
        let results: Vec<_> = self.groups.par_iter_mut().map(|g| g.step(time, dt)).collect();
        let mut report = StepReport::default();
        for result in results {
            report.add(&result.map_err(|source| CouplingError::Step { time, source })?);
        }
        self.record(&Ledger::default());
        Ok(report)
    }

    /// All numbers that change: a list for each group, made one at a time, and one of the ledger.
    pub fn save(&self) -> impl ExactSizeIterator<Item = Vec<f64>> {
        let ledger = self.ledger.map_or_else(Vec::new, |ledger| ledger.numbers().to_vec());
        (0..self.groups.len() + 1).map(move |i| match self.groups.get(i) {
            Some(group) => {
                let mut numbers = Vec::new();
                group.save(&mut numbers);
                numbers
            }
            None => ledger.clone(),
        })
    }

    /// Goes back to saved numbers.
    ///
    /// # Errors
    /// [`CouplingError::Restore`] if they are those of other fibres.
    pub fn restore(&mut self, saved: &[Vec<f64>]) -> Result<(), CouplingError> {
        let (expected, found) = (self.groups.len() + 1, saved.len());
        let [groups @ .., ledger] = saved else {
            return Err(RodError::Length { what: "groups of fibers", expected, found }.into());
        };
        if groups.len() != self.groups.len() {
            return Err(RodError::Length { what: "groups of fibers", expected, found }.into());
        }
        for (group, numbers) in self.groups.iter_mut().zip(groups) {
            group.restore(numbers)?;
        }
        if let Some(own) = &mut self.ledger {
            *own = EnergyLedger::from_numbers(ledger).ok_or(RodError::Length {
                what: "energy ledger",
                expected: own.numbers().len(),
                found: ledger.len(),
            })?;
        }
        Ok(())
    }
}
