use crate::energy::{CreatedEnergy, EnergyBudget, stored};
use crate::stepper::{FiberStates, Stepper};
use crate::{
    ChargeReport, ContactWork, EnergyLedger, SimError,
    scene::{Environment, Grip},
};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Soup;
use rapunzel_contact::RigidBody;
use rapunzel_coupling::{ActiveContact, CollisionObject, StepReport, Stopwatch, Surroundings};
use rapunzel_electrostatics::Fields;
use rapunzel_export::surface::Placed;
use rapunzel_fiber::{Assembly, Fiber};
use rapunzel_rod_dynamic::{Energy, Momentum, RodState};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Everything in a scene at one instant: a clock, an environment, objects, and what moves among
/// them.
pub struct World {
    clock: Clock,
    environment: Environment,
    /// What may be touched.
    objects: Vec<CollisionObject>,
    stepper: Box<dyn Stepper>,
    /// Budget by which the energy is watched, if it can be.
    budget: Option<EnergyBudget>,
    notes: Vec<String>,
    /// Hands that pull.
    pub(crate) grips: Vec<Grip>,
}

/// Time as a count of equal steps, so that it is exact after any number of them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Clock {
    /// Time when the step last changed, s.
    origin: f64,
    dt: f64,
    steps_since: u64,
    steps: u64,
}

impl Clock {
    fn time(&self) -> f64 {
        self.origin + self.steps_since as f64 * self.dt
    }

    /// The clock after one more step of `dt`, s.
    fn after(self, dt: f64) -> Self {
        let now = if dt == self.dt {
            self
        } else {
            Self { origin: self.time(), dt, steps_since: 0, steps: self.steps }
        };
        Self { steps_since: now.steps_since + 1, steps: now.steps + 1, ..now }
    }
}

/// The raw numbers of a world, from which it goes on bit for bit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Snapshot {
    pub(crate) whole: WholeNumbers,
    pub(crate) stepper: Vec<Vec<f64>>,
}

/// The numbers of a snapshot that are not those of its stepper.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct WholeNumbers {
    clock: Clock,
    budget: Option<EnergyBudget>,
    objects: Vec<f64>,
}

/// What there is of fibres where there are none.
static NO_FIBERS: LazyLock<Assembly> = LazyLock::new(|| Assembly::new(Vec::new()));

impl World {
    /// A world at time zero in which something moves.
    #[must_use]
    pub fn new(
        environment: Environment,
        objects: Vec<CollisionObject>,
        stepper: Box<dyn Stepper>,
    ) -> Self {
        Self {
            clock: Clock::default(),
            environment,
            objects,
            stepper,
            budget: None,
            notes: Vec::new(),
            grips: Vec::new(),
        }
    }

    /// Moves everything by `dt`, s. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`SimError`] names what could not be moved, and why. Some may have been moved then and
    /// others not: [restore](Self::restore) a snapshot before going on.
    pub fn step(&mut self, dt: f64) -> Result<StepReport, SimError> {
        self.pull()?;
        let next = self.clock.after(dt);
        let mut around = Surroundings {
            environment: &self.environment,
            objects: &mut self.objects,
            start: self.clock.time(),
            end: next.time(),
        };
        let report = self.stepper.step(&mut around, dt)?;
        self.clock = next;
        Ok(report)
    }

    /// Time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Number of steps since the start.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.clock.steps
    }

    /// What moves.
    #[must_use]
    pub fn stepper(&self) -> &dyn Stepper {
        &*self.stepper
    }

    pub(crate) fn stepper_mut(&mut self) -> &mut dyn Stepper {
        &mut *self.stepper
    }

    pub(crate) fn objects(&self) -> &[CollisionObject] {
        &self.objects
    }

    pub(crate) fn objects_mut(&mut self) -> &mut [CollisionObject] {
        &mut self.objects
    }

    /// The fibres in their natural state; an assembly of none where something else moves.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        self.stepper.fibers().map_or(&*NO_FIBERS, FiberStates::assembly)
    }

    /// What a user should know of how the world was built: what became of grooms.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    pub(crate) fn set_notes(&mut self, notes: Vec<String>) {
        self.notes = notes;
    }

    /// Number of nodes of everything that moves.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.stepper.nodes()
    }

    /// Position (m) and velocity (m/s) of a node of a fibre or another strand, or of a mass-spring
    /// system (world); without a number, of the last.
    ///
    /// # Panics
    /// If there is no such fibre or node, as indexing does.
    #[must_use]
    pub fn node(&self, fiber: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        self.stepper.node(fiber, node)
    }

    /// Gravity now, m/s^2.
    pub(crate) fn gravity(&self) -> Vector3<f64> {
        self.environment.gravity_at(self.time())
    }

    /// All objects where they are now (world), as far as they are shown: of a plane a square of
    /// twice the longest fibre, or the length of a mass-spring system. Copies their surfaces.
    pub fn surfaces(&self) -> impl Iterator<Item = Placed> {
        self.objects.iter().map(|object| {
            let (pose, Soup { vertices, triangles }) = (object.pose(self.time()), object.surface());
            let vertices = vertices.iter().map(|p| pose * p).collect();
            Placed { pose, surface: Soup { vertices, triangles: triangles.clone() } }
        })
    }

    /// Object `i` of the scene as a rigid body, if it is one that moves freely.
    #[must_use]
    pub fn body(&self, i: usize) -> Option<&RigidBody> {
        self.objects.get(i)?.body()
    }

    /// State of fibre `i`. Allocates; costs one pass over its nodes.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn state(&self, i: usize) -> RodState {
        let fibers = self.stepper.fibers().map(|fibers| fibers.state(i));
        fibers.unwrap_or_else(|| panic!("there is no fibre {i}, nor any other"))
    }

    /// Puts fibre `i` into a state.
    ///
    /// # Errors
    /// [`SimError::State`] for a state of another fibre, [`SimError::NoFibers`] if nothing can be
    /// put so.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    pub fn set_state(&mut self, i: usize, state: &RodState) -> Result<(), SimError> {
        self.stepper.set_state(i, state)
    }

    /// What speaks against steps of `dt` (s): the stability limit of an explicit mass-spring system
    /// below it. Costs some hundred passes over the springs.
    #[must_use]
    pub fn warning(&self, dt: f64) -> Option<String> {
        self.stepper.warning(dt)
    }

    /// Energy of everything that moves, and of free objects, J, in the gravity of the instant.
    /// Costs one pass over all nodes.
    #[must_use]
    pub fn energy(&self) -> Energy {
        let gravity = self.gravity();
        let mut sum = self.stepper.energy(&gravity);
        for energy in self.objects.iter().filter_map(|object| object.energy(&gravity)) {
            sum.kinetic += energy.kinetic;
            sum.elastic += energy.elastic;
            sum.gravitational += energy.gravitational;
        }
        sum
    }

    /// Energy of fibre `i`, J.
    pub(crate) fn fiber_energy(&self, i: usize, gravity: &Vector3<f64>) -> Energy {
        self.stepper.fibers().map(|fibers| fibers.energy_of(i, gravity)).unwrap_or_default()
    }

    /// Momentum of all fibres and free objects, if the method is `Staggered` or `BackwardEuler`
    /// without a tolerance. Costs one pass over all nodes.
    #[must_use]
    pub fn momentum(&self) -> Option<Momentum> {
        let mut sum = self.stepper.fibers()?.momentum()?;
        for body in self.objects.iter().filter_map(CollisionObject::body) {
            let angular = body.angular_momentum_about(&Point3::origin());
            sum += Momentum { linear: body.mass() * body.velocity, angular };
        }
        Some(sum)
    }

    /// Potentials (V) and fields (V/m, world) of all charges at `targets` (world, m), fibres being
    /// points on their axes and conductors without a field inside; nothing in a scene without
    /// charge. Cost: a call of the multipole method.
    ///
    /// # Errors
    /// [`SimError::Charging`] for targets that are nowhere, and for fibres in the head.
    pub fn electric_fields(&self, targets: &[Point3<f64>]) -> Result<Fields, SimError> {
        match self.stepper.charged() {
            Some(charged) => Ok(charged.fields(targets)?),
            None => Ok(Fields::default()),
        }
    }

    /// How fibres with charge came to rest in the last step, if the scene has any.
    #[must_use]
    pub fn charge_report(&self) -> Option<ChargeReport> {
        Some(self.stepper.charged()?.report())
    }

    /// What touched in the last part of a step, with what force: by its two sides, fibres first,
    /// then by place.
    pub fn contacts(&self) -> impl Iterator<Item = ActiveContact> {
        self.stepper.in_contact().into_iter().flat_map(|fibers| fibers.contacts())
    }

    /// Mean force of all fibres and other objects on an object over the last part of a step, N,
    /// world. Cost: that of looking at all contacts.
    #[must_use]
    pub fn force_on(&self, object: usize) -> Vector3<f64> {
        self.stepper.in_contact().map(|fibers| fibers.force_on(object)).unwrap_or_default()
    }

    /// Work that contacts have done on fibres and free objects since the start.
    #[must_use]
    pub fn contact_work(&self) -> ContactWork {
        self.stepper.in_contact().map(|fibers| fibers.contact_work()).unwrap_or_default()
    }

    /// All other work done on fibres and free objects since the start, if the scene's output asks
    /// for the ledger, or its method may create energy.
    #[must_use]
    pub fn ledger(&self) -> Option<EnergyLedger> {
        self.stepper.fibers()?.ledger()
    }

    /// Sets the stopwatch by which the reports of steps tell how long their phases took; `None`, as
    /// at first, for not at all.
    pub fn set_stopwatch(&mut self, stopwatch: Option<Stopwatch>) {
        self.stepper.set_stopwatch(stopwatch);
    }

    /// Watches the energy from now on, against the ledger if that is kept.
    pub(crate) fn keep_budget(&mut self) {
        let bent = |fiber: &Fiber| {
            let stiffest = fiber.nodes().iter().map(|node| node.stiffness.x).fold(0.0, f64::max);
            stiffest / fiber.length()
        };
        let bending = self.assembly().fibers().iter().map(bent).sum();
        self.budget = Some(EnergyBudget::new(&self.energy(), bending));
    }

    /// Looks whether the energy is a number, and has come from somewhere if that is watched.
    ///
    /// # Errors
    /// [`SimError::NotFinite`] or [`SimError::Created`].
    pub(crate) fn watch_energy(&mut self) -> Result<(), SimError> {
        let (energy, time) = (self.energy(), self.time());
        if !energy.total().is_finite() {
            return Err(SimError::NotFinite { time });
        }
        let works = self.ledger().map(|ledger| (ledger, self.contact_work()));
        let Some(budget) = &mut self.budget else { return Ok(()) };
        let watched = budget.watch(&energy, works);
        watched.map_err(|CreatedEnergy { created, supplied }| {
            let gravity = self.gravity();
            let of = |fiber: usize| stored(&self.fiber_energy(fiber, &gravity));
            let fibers = 0..self.assembly().fibers().len();
            let fiber = fibers.max_by(|&a, &b| of(a).total_cmp(&of(b)));
            SimError::Created { time, created, supplied, fiber }
        })
    }

    /// All numbers that determine what follows.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot { whole: self.whole_numbers(), stepper: self.stepper.save().collect() }
    }

    /// The numbers of a snapshot that are not those of its stepper.
    pub(crate) fn whole_numbers(&self) -> WholeNumbers {
        let mut objects = Vec::new();
        self.objects.iter().for_each(|object| object.save(&mut objects));
        WholeNumbers { clock: self.clock, budget: self.budget, objects }
    }

    /// Goes back to a snapshot of this world.
    ///
    /// # Errors
    /// [`SimError::Coupling`], [`SimError::Charging`] and others if it is one of another scene.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SimError> {
        let Snapshot { whole: WholeNumbers { clock, budget, objects }, stepper } = snapshot;
        self.stepper.restore(stepper, clock.time())?;
        let mut numbers = &objects[..];
        for object in &mut self.objects {
            numbers = object.restore(numbers).ok_or(SimError::OtherObjects)?;
        }
        (self.clock, self.budget) = (*clock, *budget);
        Ok(())
    }
}
