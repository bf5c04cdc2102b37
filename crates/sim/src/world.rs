use crate::charging::{ChargeReport, Electric};
use crate::contact::{Bearing, ContactWork, Memory, Object, Partner, Stopwatch, Way};
use crate::energy::EnergyBudget;
use crate::group::Group;
use crate::mass_spring::Springs;
use crate::{SimError, Works, scene::Environment};
use nalgebra::{Point3, Vector3};
use rapunzel_contact::RigidBody;
use rapunzel_electrostatics::Fields;
use rapunzel_export::surface::Placed;
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{Energy, Ledger, Momentum, RodError, RodState};
use serde::{Deserialize, Serialize, Serializer};

/// All fibres of a scene at one instant, and what acts on them.
pub struct World {
    environment: Environment,
    assembly: Assembly,
    pub(crate) groups: Vec<Group>,
    /// Group and lane of every fibre.
    lanes: Vec<(usize, usize)>,
    clock: Clock,
    /// What fibres touched in the last step.
    pub(crate) contacts: Memory,
    /// Since the start, if they are kept.
    works: Option<Works>,
    /// By which energy is watched, if it can be.
    budget: Option<EnergyBudget>,
    /// What fibres touch beside each other.
    pub(crate) objects: Vec<Object>,
    /// In place of fibres.
    pub(crate) springs: Option<Box<dyn Springs>>,
    /// What charge does, in a scene with charge.
    pub(crate) electric: Option<Electric>,
    /// What tells steps how long their phases take.
    pub(crate) stopwatch: Option<Stopwatch>,
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

/// The raw numbers of a world, from which it goes on bit for bit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Snapshot {
    clock: Clock,
    groups: Vec<Vec<f64>>,
    contacts: Memory,
    works: Option<Works>,
    budget: Option<EnergyBudget>,
    objects: Vec<f64>,
    springs: Vec<f64>,
}

/// A snapshot that is being taken: written, it is one.
#[derive(Serialize)]
pub(crate) struct Present<'a> {
    clock: Clock,
    groups: Batches<'a>,
    contacts: &'a Memory,
    works: Option<Works>,
    budget: Option<EnergyBudget>,
    objects: Vec<f64>,
    springs: Vec<f64>,
}

struct Batches<'a>(&'a [Group]);

impl Batches<'_> {
    /// Of one group after another.
    fn numbers(&self) -> impl ExactSizeIterator<Item = Vec<f64>> {
        self.0.iter().map(|group| {
            let mut numbers = Vec::new();
            group.batch.save(&mut numbers);
            numbers
        })
    }
}

impl Serialize for Batches<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.numbers())
    }
}

impl World {
    /// The groups must be those of the assembly, in its order.
    pub(crate) fn new(environment: Environment, assembly: Assembly, groups: Vec<Group>) -> Self {
        let mut lanes = vec![(0, 0); assembly.fibers().len()];
        for (g, group) in groups.iter().enumerate() {
            for (lane, &fiber) in group.fibers.iter().enumerate() {
                lanes[fiber] = (g, lane);
            }
        }
        let clock = Clock::default();
        let contacts = Memory::default();
        Self {
            environment,
            assembly,
            groups,
            lanes,
            clock,
            contacts,
            works: None,
            budget: None,
            objects: Vec::new(),
            springs: None,
            electric: None,
            stopwatch: None,
        }
    }

    /// Time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.origin + self.clock.steps_since as f64 * self.clock.dt
    }

    /// Number of steps since the start.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.clock.steps
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

    /// Number of nodes of all fibres, or of the mass-spring system.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.springs.as_ref().map_or_else(|| self.assembly.layout().nodes(), |s| s.nodes())
    }

    /// Position (m) and velocity (m/s) of a node of a fibre, or of the mass-spring system (world);
    /// without a number, of the last.
    ///
    /// # Panics
    /// If there is no such fibre or node, as indexing does.
    #[must_use]
    pub fn node(&self, fiber: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        if let Some(springs) = &self.springs {
            return springs.node(node.unwrap_or(springs.nodes() - 1));
        }
        let state = self.state(fiber);
        let node = node.unwrap_or(state.positions.len() - 1);
        (state.positions[node], state.velocities[node])
    }

    /// Gravity now, m/s^2.
    pub(crate) fn gravity(&self) -> Vector3<f64> {
        self.gravity_at(self.time())
    }

    /// Gravity at a time (s), m/s^2.
    pub(crate) fn gravity_at(&self, t: f64) -> Vector3<f64> {
        self.environment.gravity_at(t)
    }

    /// All objects where they are now (world), as far as they are shown: of a plane a square of twice
    /// the longest fibre, or the length of a mass-spring system. Copies their surfaces.
    pub fn surfaces(&self) -> impl Iterator<Item = Placed> {
        self.objects.iter().map(|object| object.placed(self.time()))
    }

    /// Object `i` of the scene as a rigid body, if it is one that moves freely.
    #[must_use]
    pub fn body(&self, i: usize) -> Option<&RigidBody> {
        match &self.objects.get(i)?.way {
            Way::Free(body) => Some(body.body()),
            Way::Led(_) => None,
        }
    }

    /// Where fibre `i` is and how it moves. Allocates; costs one pass over its nodes.
    ///
    /// # Panics
    /// If there is no such fibre.
    #[must_use]
    pub fn state(&self, i: usize) -> RodState {
        let (group, lane) = self.lanes[i];
        self.groups[group].batch.state(lane)
    }

    /// What speaks against steps of `dt` (s): the stability limit of an explicit mass-spring system
    /// below it. Costs some hundred passes over the springs.
    #[must_use]
    pub fn warning(&self, dt: f64) -> Option<String> {
        Some(self.springs.as_ref()?.warning(dt)?.to_string())
    }

    /// Energy of all fibres and free objects, J, in the gravity of the instant. Costs one pass over all nodes.
    #[must_use]
    pub fn energy(&self) -> Energy {
        let gravity = self.gravity();
        if let Some(springs) = &self.springs {
            return springs.energy(&gravity);
        }
        let mut sum = Energy::default();
        let mut add = |energy: Energy| {
            sum.kinetic += energy.kinetic;
            sum.elastic += energy.elastic;
            sum.gravitational += energy.gravitational;
        };
        for group in &self.groups {
            (0..group.fibers.len()).for_each(|lane| add(group.batch.energy(lane, &gravity)));
        }
        for object in &self.objects {
            if let Way::Free(body) = &object.way {
                add(body.energy(&gravity));
            }
        }
        sum
    }

    /// Energy of fibre `i`, J.
    pub(crate) fn fiber_energy(&self, i: usize, gravity: &Vector3<f64>) -> Energy {
        let (group, lane) = self.lanes[i];
        self.groups[group].batch.energy(lane, gravity)
    }

    /// Momentum of all fibres and free objects, if the method is `Staggered` or `BackwardEuler` without a
    /// tolerance. Costs one pass over all nodes.
    #[must_use]
    pub fn momentum(&self) -> Option<Momentum> {
        let mut sum = Momentum::default();
        for group in &self.groups {
            let batch = group.batch.as_coupled()?;
            (0..group.fibers.len()).for_each(|lane| sum += batch.momentum(lane));
        }
        for body in (0..self.objects.len()).filter_map(|i| self.body(i)) {
            let angular = body.angular_momentum_about(&Point3::origin());
            sum += Momentum { linear: body.mass() * body.velocity, angular };
        }
        Some(sum)
    }

    /// Potentials (V) and fields (V/m, world) of all charges at `targets` (world, m), fibres being points
    /// on their axes and conductors without a field inside; nothing in a scene without charge. Cost: a call of the multipole method.
    ///
    /// # Errors
    /// [`SimError::Electrostatics`] for targets that are nowhere, [`SimError::InHead`] for fibres there.
    pub fn electric_fields(&self, targets: &[Point3<f64>]) -> Result<Fields, SimError> {
        match &self.electric {
            Some(electric) => electric.fields(self, targets),
            None => Ok(Fields::default()),
        }
    }

    /// How fibres with charge came to rest in the last step, if the scene has any.
    #[must_use]
    pub fn charge_report(&self) -> Option<ChargeReport> {
        Some(self.electric.as_ref()?.report)
    }

    /// What touched in the last part of a step, with what force: by its two sides, fibres first, then
    /// by place.
    pub fn contacts(&self) -> impl Iterator<Item = Bearing> {
        self.contacts.bearings()
    }

    /// Mean force of all fibres and other objects on an object over the last part of a step, N, world.
    /// Cost: that of looking at all contacts.
    #[must_use]
    pub fn force_on(&self, object: usize) -> Vector3<f64> {
        let of = |side| matches!(side, Partner::Object(number) if number as usize == object);
        let forces = self.contacts().flat_map(|contact| {
            let forces = contact.sides.into_iter().zip([contact.force, -contact.force]);
            forces.filter(|(side, _)| of(*side)).map(|(_, force)| force)
        });
        forces.sum()
    }

    /// Work that contacts have done on fibres and free objects since the start.
    #[must_use]
    pub fn contact_work(&self) -> ContactWork {
        self.contacts.work
    }

    /// All other work done on fibres and free objects since the start, if the scene's output asks for
    /// the ledger, or its method may create energy.
    #[must_use]
    pub fn works(&self) -> Option<Works> {
        self.works
    }

    /// By what the reports of steps tell how long their phases took; `None`, as at first, for not at all.
    pub fn set_stopwatch(&mut self, stopwatch: Option<Stopwatch>) {
        self.stopwatch = stopwatch;
    }

    /// Keeps the ledger from now on.
    pub(crate) fn keep_works(&mut self) {
        self.works = Some(Works::default());
        self.groups.iter_mut().for_each(|group| group.batch.keep_ledgers());
    }

    /// Watches the energy from now on, against the ledger if that is kept.
    pub(crate) fn keep_budget(&mut self) {
        self.budget = Some(EnergyBudget::new(self));
    }

    /// Looks whether the energy is a number, and has come from somewhere if that is watched.
    ///
    /// # Errors
    /// [`SimError::NotFinite`] or [`SimError::Created`].
    pub(crate) fn watch_energy(&mut self) -> Result<(), SimError> {
        if !self.energy().total().is_finite() {
            return Err(SimError::NotFinite { time: self.time() });
        }
        let Some(mut budget) = self.budget else { return Ok(()) };
        budget.watch(self, self.works.as_ref())?;
        self.budget = Some(budget);
        Ok(())
    }

    /// Books the step, or part of one, that all groups and the free objects have taken.
    pub(crate) fn book(&mut self, objects: &Ledger) {
        let Some(works) = &mut self.works else { return };
        works.book(objects);
        for group in &self.groups {
            let lanes = (0..group.fibers.len()).filter_map(|lane| group.batch.ledger(lane));
            lanes.for_each(|ledger| works.book(&ledger));
        }
    }

    /// All numbers that determine what follows.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let Present { clock, groups, contacts, works, budget, objects, springs } = self.present();
        let (groups, contacts) = (groups.numbers().collect(), contacts.clone());
        Snapshot { clock, groups, contacts, works, budget, objects, springs }
    }

    /// The same to be written, without a copy of what is large.
    pub(crate) fn present(&self) -> Present<'_> {
        let mut objects = Vec::new();
        for object in &self.objects {
            if let Way::Free(body) = &object.way {
                body.save(&mut objects);
            }
        }
        let springs = self.springs.as_ref().map(|springs| springs.save()).unwrap_or_default();
        let Self { clock, works, budget, .. } = *self;
        let (groups, contacts) = (Batches(&self.groups), &self.contacts);
        Present { clock, groups, contacts, works, budget, objects, springs }
    }

    /// Goes back to a snapshot of this world.
    ///
    /// # Errors
    /// [`SimError::Rod`] if it is one of another scene.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SimError> {
        let error = |source| SimError::Rod { bundle: 0, source };
        if snapshot.groups.len() != self.groups.len() {
            let (expected, found) = (self.groups.len(), snapshot.groups.len());
            return Err(error(RodError::Length { what: "groups of fibers", expected, found }));
        }
        for (group, numbers) in self.groups.iter_mut().zip(&snapshot.groups) {
            group.batch.restore(numbers).map_err(error)?;
        }
        if let Some(springs) = &mut self.springs
            && !springs.restore(&snapshot.springs)
        {
            let (expected, found) = (springs.save().len(), snapshot.springs.len());
            return Err(error(RodError::Length { what: "springs", expected, found }));
        }
        let found = snapshot.objects.len();
        let short =
            RodError::Length { what: "numbers of free objects", expected: found + 1, found };
        let mut numbers = &snapshot.objects[..];
        for object in &mut self.objects {
            if let Way::Free(body) = &mut object.way {
                numbers = body.restore(numbers).ok_or_else(|| error(short.clone()))?;
            }
        }
        self.clock = snapshot.clock;
        self.contacts = snapshot.contacts.clone();
        self.works = snapshot.works;
        self.budget = snapshot.budget;
        Ok(())
    }

    /// Notes that a step of `dt` seconds has been taken.
    pub(crate) fn advance_clock(&mut self, dt: f64) {
        if dt != self.clock.dt {
            let (origin, steps) = (self.time(), self.clock.steps);
            self.clock = Clock { origin, dt, steps_since: 0, steps };
        }
        self.clock.steps_since += 1;
        self.clock.steps += 1;
    }
}
