use super::check::{check_laws, check_state};
use super::erased_batch::{ErasedBatch, build};
use super::scheme::Scheme;
use crate::joint::Joint;
use crate::{Energy, Ledger, Momentum, NodeQuantity, Rod, RodError, RodState, SectionLaws};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::so3;
use rapunzel_lanes::LANES;

/// Up to eight fibres with equally many segments, moved together in SIMD lanes.
///
/// Each fibre has its own conditions and its steps are halved on their own; its motion does not
/// depend on the other fibres in the batch. Cost: four to five Newton iterations a step, linear in
/// the number of segments; no allocation in a step that converges without halving. Memory: half a
/// kilobyte a segment, with backward Euler a third of one, and as much again once steps are taken
/// in several calls; rods that are copies of each other share their fibre. Each thread keeps one
/// workspace for the solve of one batch, as long as the longest rods it has moved.
///
/// The method is second order in time and in space. `rho_inf` is the spectral radius at infinite
/// frequency: 0 loses most, 0.3 is the default, above 0.4 a whip may need halving. Near 1 the
/// forces of the constraints oscillate ever more, as for any such method (Arnold and Bruls 2007),
/// and a long run ends.
pub struct StaggeredBatch {
    pub(super) engine: Box<dyn ErasedBatch>,
    pub(super) rods: Vec<Rod>,
    pub(super) time: f64,
    /// Size of the step that is under way across calls, s; zero if none is.
    pub(super) predicted: f64,
    /// Whether the linearisation of the step under way is there for later calls.
    pub(super) is_linearized: bool,
    /// Method of the fibres, and of those that bear nothing where it is another one.
    pub(super) scheme: Scheme,
    pub(super) flight: Option<Scheme>,
    /// Whether the initial acceleration of a fibre is still to be found.
    pub(super) fresh: [bool; LANES],
    /// Value of `fresh` before the step that has been predicted.
    pub(super) fresh_before: [bool; LANES],
    /// Ledgers of the last step, if they are kept.
    pub(super) ledgers: Option<[Ledger; LANES]>,
}

impl StaggeredBatch {
    /// Largest number of fibres in a batch.
    pub const MAX_FIBERS: usize = LANES;
    /// The default spectral radius at infinite frequency.
    pub const DEFAULT_RHO_INF: f64 = 0.3;

    /// Creates fibres at rest in their natural shape, each at its root pose, at time 0.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless there are 1 to 8 rods of equally many segments, at least two,
    /// with damping times that are finite and not negative, and `0 <= rho_inf <= 1`; and for laws
    /// beside a damping time. [`RodError::Length`] for laws that are not one a node.
    pub fn new(rods: Vec<Rod>, rho_inf: f64) -> Result<Self, RodError> {
        Self::with_scheme(rods, Self::generalised_alpha(rho_inf)?, None)
    }

    /// Creates fibres as [`StaggeredBatch::new`] does, integrated with the backward Euler method:
    /// first order in time. It damps more, but the velocity at the end of a step is the mean
    /// velocity over the step, so that a node stopped by an impulse stays at rest, and contact
    /// forces need no acceleration to balance them.
    ///
    /// # Errors
    /// As [`StaggeredBatch::new`].
    pub fn backward_euler(rods: Vec<Rod>) -> Result<Self, RodError> {
        Self::with_scheme(rods, Scheme::backward_euler(), None)
    }

    /// Creates fibres that move by the generalised-alpha method, second order in time, while they
    /// bear nothing, and by backward Euler while they do: [`Self::set_bearing`] says when. None
    /// bears at first. What turns in a step about the axis of a fibre may be any number of turns.
    ///
    /// # Errors
    /// As [`StaggeredBatch::new`].
    pub fn hybrid(rods: Vec<Rod>, rho_inf: f64) -> Result<Self, RodError> {
        let flight = Self::generalised_alpha(rho_inf)?;
        Self::with_scheme(rods, flight, Some(flight))
    }

    fn generalised_alpha(rho_inf: f64) -> Result<Scheme, RodError> {
        if !(0.0..=1.0).contains(&rho_inf) {
            return Err(RodError::Invalid { what: "rho_inf", why: "must be between 0 and 1" });
        }
        Ok(Scheme::generalised_alpha(rho_inf))
    }

    pub(super) fn with_scheme(
        rods: Vec<Rod>,
        scheme: Scheme,
        flight: Option<Scheme>,
    ) -> Result<Self, RodError> {
        let invalid = |what, why| Err(RodError::Invalid { what, why });
        if rods.is_empty() || rods.len() > Self::MAX_FIBERS {
            return invalid("rods", "a batch has 1 to 8 rods");
        }
        let n = rods[0].fiber.segments();
        if n < 2 || rods.iter().any(|rod| rod.fiber.segments() != n) {
            return invalid("rods", "all need the same number of segments, at least 2");
        }
        if rods.iter().any(|rod| !(rod.damping_time >= 0.0 && rod.damping_time.is_finite())) {
            return invalid("damping time", "must be finite and not negative (s)");
        }
        rods.iter().try_for_each(check_laws)?;
        let engine = build(&rods, scheme, flight);
        let (fresh, fresh_before) = ([true; LANES], [true; LANES]);
        let mut batch = Self {
            engine,
            rods,
            time: 0.0,
            predicted: 0.0,
            is_linearized: true,
            scheme,
            flight,
            fresh,
            fresh_before,
            ledgers: None,
        };
        for fiber in 0..batch.rods.len() {
            let state = natural_state(&batch.rods[fiber]);
            batch.set_state(fiber, &state)?;
        }
        Ok(batch)
    }

    /// The rods of the batch.
    #[must_use]
    pub fn rods(&self) -> &[Rod] {
        &self.rods
    }

    /// Current time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// State of one fibre. Forces are those at the end of the last step, zero before the first.
    #[must_use]
    pub fn state(&self, fiber: usize) -> RodState {
        self.engine.state(fiber, &self.rods[fiber], self.time)
    }

    /// Appends the positions of all nodes of one fibre, m, world frame: those of
    /// [`StaggeredBatch::state`], for a small part of its cost.
    pub fn node_positions(&self, fiber: usize, into: &mut Vec<Point3<f64>>) {
        self.engine.node_positions(fiber, into);
    }

    /// Appends the values of a quantity at all nodes of one fibre.
    pub fn node_values(&self, fiber: usize, of: NodeQuantity, into: &mut Vec<f64>) {
        self.engine.node_values(fiber, &self.rods[fiber], of, into);
    }

    /// Position (m) and velocity (m/s) of one node, world frame.
    #[must_use]
    pub fn node(&self, fiber: usize, node: usize) -> (Point3<f64>, Vector3<f64>) {
        self.engine.node(fiber, node)
    }

    /// Directors d1 and d2 of one segment, where a step under way has been solved to, world frame.
    #[must_use]
    pub fn section(&self, fiber: usize, segment: usize) -> [Vector3<f64>; 2] {
        self.engine.section(fiber, segment)
    }

    /// Energy of one fibre in the given gravity (m/s^2).
    #[must_use]
    pub fn energy(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy {
        self.engine.energies(gravity)[fiber]
    }

    /// Energies of all fibres in the given gravity (m/s^2); zero beyond the last. Costs as much as
    /// that of one.
    #[must_use]
    pub fn energies(&self, gravity: &Vector3<f64>) -> [Energy; Self::MAX_FIBERS] {
        self.engine.energies(gravity)
    }

    /// Momentum of one fibre.
    #[must_use]
    pub fn momentum(&self, fiber: usize) -> Momentum {
        self.engine.momentum(fiber)
    }

    /// Keeps ledgers of the steps from now on, or stops keeping them. They cost a pass over the
    /// rods in each step, and do not change the motion.
    pub fn keep_ledgers(&mut self, keep: bool) {
        self.ledgers = keep.then(Default::default);
    }

    /// Energy ledger of one fibre in the last step that was taken, `None` if ledgers are not kept.
    #[must_use]
    pub fn ledger(&self, fiber: usize) -> Option<Ledger> {
        self.ledgers.map(|ledgers| ledgers[fiber])
    }

    /// Restarts one fibre from `state`; the batch takes over its time.
    ///
    /// # Errors
    /// As [`crate::RodIntegrator::set_state`].
    pub fn set_state(&mut self, fiber: usize, state: &RodState) -> Result<(), RodError> {
        check_state(&self.rods[fiber], state)?;
        self.engine.set_state(fiber, &self.rods[fiber], state);
        self.time = state.time;
        self.fresh[fiber] = true;
        Ok(())
    }

    /// Replaces the section laws of one fibre, for example when the climate has changed; the memory
    /// of the sections is kept.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless the new laws remember as much as those before, and
    /// [`RodError::Length`] unless they are one a node.
    pub fn set_laws(&mut self, fiber: usize, laws: SectionLaws) -> Result<(), RodError> {
        let rod = &mut self.rods[fiber];
        let memories = |laws: &SectionLaws, node| laws.at(node).map(|law| law.memory());
        let mut nodes = 0..=rod.fiber.segments();
        if nodes.any(|node| memories(&laws, node) != memories(&rod.laws, node)) {
            let why = "must remember as many vectors in each section as those before";
            return Err(RodError::Invalid { what: "laws", why });
        }
        rod.laws = laws;
        check_laws(rod)?;
        self.engine.set_laws(fiber, rod);
        Ok(())
    }

    /// Lets a fibre of a [hybrid](Self::hybrid) batch bear impulses from the next step on, or
    /// nothing; other batches have one method for ever. Told before the step is accepted after
    /// which the fibre bears nothing any more, it costs nothing; later, the acceleration of the
    /// fibre is found anew, as at the start.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    pub fn set_bearing(&mut self, fiber: usize, bearing: bool) {
        self.set_methods(fiber, bearing);
        if self.predicted == 0.0 {
            self.take_methods();
        }
    }

    /// Sets the method of the next step of a fibre, and of the spare lanes behind the last one,
    /// which repeat it.
    fn set_methods(&mut self, fiber: usize, bearing: bool) {
        let end = if fiber + 1 == self.rods.len() { LANES } else { fiber + 1 };
        (fiber..end).for_each(|lane| self.engine.set_bearing(lane, bearing));
    }

    /// Lets fibres move by the methods of the next step.
    pub(super) fn take_methods(&mut self) {
        let unknown = self.engine.take_methods();
        let used = self.fresh.iter_mut().zip(unknown).take(self.rods.len());
        used.for_each(|(fresh, unknown)| *fresh |= unknown);
    }

    /// Whether a fibre moves by backward Euler in the next step, as one that bears impulses does.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn bears(&self, fiber: usize) -> bool {
        !self.engine.remembers(fiber)
    }

    /// Sets additional forces on the nodes of one fibre, N, world, constant until set again.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is one per node.
    pub fn set_node_forces(
        &mut self,
        fiber: usize,
        forces: &[Vector3<f64>],
    ) -> Result<(), RodError> {
        let expected = self.rods[fiber].fiber.segments() + 1;
        if forces.len() != expected {
            return Err(RodError::Length { what: "forces", expected, found: forces.len() });
        }
        if forces.iter().flatten().any(|x| !x.is_finite()) {
            return Err(RodError::Invalid { what: "forces", why: "must be finite (N)" });
        }
        for (node, force) in forces.iter().enumerate() {
            self.engine.set_node_force(fiber, node, force);
        }
        Ok(())
    }

    /// Holds a node of one fibre by a spring to a place (m, world) from the next step on, by its
    /// force at the end of each step, until it is set again; a stiffness (N/m) of zero lets it go.
    /// Its work is that of supports. It is no part of the state that is saved.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless the node is an inner one, the stiffness not negative, and all
    /// numbers are finite.
    pub fn set_node_spring(
        &mut self,
        fiber: usize,
        node: usize,
        stiffness: f64,
        place: &Point3<f64>,
    ) -> Result<(), RodError> {
        let inner = node > 0 && node < self.rods[fiber].fiber.segments();
        let finite = stiffness.is_finite() && place.iter().all(|x| x.is_finite());
        if !(inner && finite && stiffness >= 0.0) {
            let why = "needs an inner node, a stiffness that is not negative, and finite numbers";
            return Err(RodError::Invalid { what: "node spring", why });
        }
        self.engine.set_node_spring(fiber, node, stiffness, &place.coords);
        Ok(())
    }

    /// Appends all numbers that determine the further motion.
    pub fn save(&self, numbers: &mut Vec<f64>) {
        numbers.reserve_exact(self.numbers());
        numbers.push(self.time);
        (0..self.rods.len()).for_each(|fiber| self.save_fiber(fiber, numbers));
    }

    /// Appends the numbers of one fibre.
    pub(super) fn save_fiber(&self, fiber: usize, numbers: &mut Vec<f64>) {
        numbers.push(f64::from(self.fresh[fiber]));
        numbers.extend(self.flight.map(|_| f64::from(self.bears(fiber))));
        self.engine.save(fiber, numbers);
    }

    /// Number of scalars that [`StaggeredBatch::save`] appends.
    fn numbers(&self) -> usize {
        1 + (0..self.rods.len()).map(|fiber| self.numbers_of(fiber)).sum::<usize>()
    }

    /// Number of scalars of one fibre.
    pub(super) fn numbers_of(&self, fiber: usize) -> usize {
        1 + usize::from(self.flight.is_some()) + self.engine.numbers(fiber)
    }

    /// Restores the state from the numbers that [`StaggeredBatch::save`] wrote.
    ///
    /// # Errors
    /// [`RodError::Length`] when the count is not that of these rods.
    pub fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        let expected = self.numbers();
        let Some((time, mut rest)) = numbers.split_first().filter(|_| numbers.len() == expected)
        else {
            return Err(RodError::Length { what: "numbers", expected, found: numbers.len() });
        };
        self.time = *time;
        for fiber in 0..self.rods.len() {
            rest = self.restore_fiber(fiber, rest);
        }
        Ok(())
    }

    /// Restores one fibre from the front of `numbers`, and returns the rest.
    pub(super) fn restore_fiber<'a>(&mut self, fiber: usize, numbers: &'a [f64]) -> &'a [f64] {
        let (fresh, mut rest) = (numbers[0] > 0.0, &numbers[1..]);
        self.fresh[fiber] = fresh;
        if self.flight.is_some() {
            // What is saved of accelerations is what the fibre goes on with.
            self.set_methods(fiber, rest[0] > 0.0);
            self.engine.take_methods();
            rest = &rest[1..];
        }
        self.engine.restore(fiber, rest)
    }
}

/// State of a rod at rest in its natural shape, in which no joint has a moment.
fn natural_state(rod: &Rod) -> RodState {
    let fiber = &rod.fiber;
    let n = fiber.segments();
    let mut frame = fiber.root().rotation.to_rotation_matrix();
    let mut position = Point3::from(fiber.root().translation.vector);
    let (mut positions, mut frames) = (vec![position], Vec::with_capacity(n));
    for (e, h) in fiber.segment_lengths().iter().enumerate() {
        frame *= so3::exp(&Joint::new(fiber, e).rest);
        position += *h * frame.matrix().column(2);
        frames.push(frame);
        positions.push(position);
    }
    RodState {
        time: 0.0,
        positions,
        velocities: vec![Vector3::zeros(); n + 1],
        frames,
        angular_velocities: vec![Vector3::zeros(); n],
        forces: vec![Vector3::zeros(); n],
        curvatures: fiber.nodes().iter().map(|node| node.natural_curvature).collect(),
    }
}
