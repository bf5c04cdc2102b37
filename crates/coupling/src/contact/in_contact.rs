use super::ball_joints::ContactJoints;
use super::contact_work::ContactWork;
use super::stepper::ContactStepper;
use super::system::CoupledSystem;
use super::warm_start::{ActiveContact, WarmStart};
use crate::body_ref::BodyRef;
use crate::contact_report::ContactReport;
use crate::phase_times::Stopwatch;
use crate::{CouplingError, Fibers, StepReport, Surroundings};
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{Energy, RodError, StaggeredBatch};
use rapunzel_scene::ContactSettings;

/// Fibres with all contacts among them and with objects.
pub struct FibersInContact {
    fibers: Fibers<StaggeredBatch>,
    stepper: ContactStepper,
}

impl FibersInContact {
    /// Fibres that are to touch each other and the objects around them, with joints.
    ///
    /// # Errors
    /// [`CouplingError::Overlap`] for what starts too deep in each other,
    /// [`CouplingError::JointOpen`] for joints that start open, [`CouplingError::JointTwice`] for
    /// those between nodes that others join already, and errors of detection and of settings.
    ///
    /// # Panics
    /// If a joint is of a node or an object that is not there, as indexing does.
    pub fn new(
        settings: ContactSettings,
        mut fibers: Fibers<StaggeredBatch>,
        around: &mut Surroundings,
        joints: ContactJoints,
    ) -> Result<Self, CouplingError> {
        let system = CoupledSystem::new(&mut fibers, around);
        let stepper = ContactStepper::new(settings, &system, joints)?;
        Ok(Self { fibers, stepper })
    }

    /// The fibres.
    #[must_use]
    pub fn fibers(&self) -> &Fibers<StaggeredBatch> {
        &self.fibers
    }

    /// The fibres, to be changed between steps.
    pub fn fibers_mut(&mut self) -> &mut Fibers<StaggeredBatch> {
        &mut self.fibers
    }

    /// Begins the search for the impulses of the first step at those that contacts of `others`
    /// bear. Their fibres have here the `numbers`, which rise, and objects the same ones. Where
    /// bonds hold, the search begins at these.
    ///
    /// # Panics
    /// If there is no number for one of the others.
    pub fn expect_impulses_of(&mut self, others: &Self, numbers: &[u32]) {
        self.stepper.expect(&others.stepper.memory, numbers);
    }

    /// Moves fibres and free objects by `dt`, s. The result does not depend on the number of
    /// threads.
    ///
    /// # Errors
    /// [`CouplingError`]; all of them may have been moved by a part of the step then:
    /// [restore](Self::restore) what was saved before going on.
    pub fn step(
        &mut self,
        around: &mut Surroundings,
        dt: f64,
    ) -> Result<StepReport, CouplingError> {
        let mut system = CoupledSystem::new(&mut self.fibers, around);
        // A step has thousands of parallel loops: a thread outside the pool would sleep at each.
        rayon::scope(|_| self.stepper.step_in_substeps(&mut system, dt))
    }

    /// Energy of all fibres and of what bends between those that are joined, J, in a gravity,
    /// m/s^2.
    #[must_use]
    pub fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let mut sum = self.fibers.energy(gravity);
        sum.elastic += self.stepper.detector.joints.junctions.stored(&self.fibers);
        sum
    }

    /// What touched in the last part of a step, with what force: by its two sides, fibres first,
    /// then by place.
    pub fn contacts(&self) -> impl Iterator<Item = ActiveContact> {
        self.stepper.memory.bearings()
    }

    /// Mean force of all contacts on each node of the fibres over the last part of a step, N,
    /// world: the ends of a segment share what acts on it as the lever does. Cost: a look at all
    /// contacts.
    #[must_use]
    pub fn contact_forces(&self) -> Vec<Vector3<f64>> {
        let layout = self.fibers.assembly().layout();
        let mut forces = vec![Vector3::zeros(); layout.nodes()];
        for contact in self.contacts() {
            let sides = contact.sides.into_iter().zip(contact.at);
            for ((side, at), force) in sides.zip([contact.force, -contact.force]) {
                let BodyRef::Fiber(fiber) = side else { continue };
                let nodes = &mut forces[layout.node_range(fiber as usize)];
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "few")]
                let segment = (at.max(0.0) as usize).min(nodes.len() - 2);
                let fraction = at - segment as f64;
                nodes[segment] += (1.0 - fraction) * force;
                nodes[segment + 1] += fraction * force;
            }
        }
        forces
    }

    /// Mean force of all fibres and other objects on an object over the last part of a step, N,
    /// world. Cost: that of looking at all contacts.
    #[must_use]
    pub fn force_on(&self, object: usize) -> Vector3<f64> {
        let of = |side| matches!(side, BodyRef::Object(number) if number as usize == object);
        let forces = self.contacts().flat_map(|contact| {
            let forces = contact.sides.into_iter().zip([contact.force, -contact.force]);
            forces.filter(|(side, _)| of(*side)).map(|(_, force)| force)
        });
        forces.sum()
    }

    /// Work that contacts have done on fibres and free objects since the start.
    #[must_use]
    pub fn contact_work(&self) -> ContactWork {
        self.stepper.memory.work
    }

    /// What the contacts of the last step were and cost.
    #[must_use]
    pub fn contact_report(&self) -> ContactReport {
        self.stepper.memory.report
    }

    /// Sets what tells how long phases of steps take; `None`, as at first, for not at all.
    pub fn set_stopwatch(&mut self, stopwatch: Option<Stopwatch>) {
        self.stepper.stopwatch = stopwatch;
    }

    /// All numbers that change, of fibres and contacts: lists that are made one at a time.
    pub fn save(&self) -> impl Iterator<Item = Vec<f64>> {
        let order = self.fibers.order().map(|fiber| fiber as f64).collect();
        std::iter::once(order).chain(self.fibers.save()).chain(self.stepper.memory.save())
    }

    /// Number of the lists that [`save`](Self::save) makes.
    #[must_use]
    pub fn saved(&self) -> usize {
        1 + self.fibers.save().len() + self.stepper.memory.save().len()
    }

    /// Goes back to saved numbers.
    ///
    /// # Errors
    /// [`CouplingError::Restore`] if they are those of other fibres.
    pub fn restore(&mut self, saved: &[Vec<f64>]) -> Result<(), CouplingError> {
        let expected = self.fibers.save().len();
        let (what, found) = ("saved lists", saved.len());
        let wrong = RodError::Length { what, expected: 1 + expected, found };
        let [order, saved @ ..] = saved else { return Err(wrong.into()) };
        let (fibers, contacts) = saved.split_at_checked(expected).ok_or(wrong.clone())?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "if it is one")]
        let order: Vec<_> = order.iter().map(|fiber| *fiber as usize).collect();
        self.fibers.arrange(&order)?;
        self.fibers.restore(fibers)?;
        let joints = self.stepper.memory.joints.len();
        self.stepper.memory = WarmStart::restored(contacts).ok_or(wrong)?;
        self.stepper.memory.joints.resize(joints, Vector3::zeros());
        Ok(())
    }
}
