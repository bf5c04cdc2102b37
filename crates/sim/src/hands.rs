//! Hands on what moves: nodes that are pulled at and moved while a world runs.

use crate::scene::{Grip, Hold, Object};
use crate::stepper::NodePull;
use crate::{SimError, World};
use nalgebra::{Isometry3, Vector3};

impl World {
    /// Puts other hands in place of those before: they pull from the next step on.
    ///
    /// A hand's force is that of its spring at the start of a step, and constant during the step.
    ///
    /// # Errors
    /// [`SimError::Grip`] for a hand at a node that is not there, [`SimError::NoHands`] where
    /// nothing can be pulled.
    pub fn set_grips(&mut self, grips: Vec<Grip>) -> Result<(), SimError> {
        let nodes = self.gripped_nodes();
        for (grip, &Grip { fiber, node, .. }) in grips.iter().enumerate() {
            let of = nodes.get(fiber).copied().unwrap_or(0);
            if node >= of {
                return Err(SimError::Grip { grip, fiber, nodes: of });
            }
        }
        self.grips = grips;
        self.pull()
    }

    /// The hands that pull.
    #[must_use]
    pub fn grips(&self) -> &[Grip] {
        &self.grips
    }

    /// Moves, fixes or releases a node of a mass-spring system as a hold of its scene does.
    ///
    /// # Errors
    /// [`SimError::NoHands`] for fibres, [`SimError::MassSpring`] for a node that is not there.
    pub fn add_hold(&mut self, hold: Hold) -> Result<(), SimError> {
        self.stepper_mut().hold(hold)
    }

    /// Leads a kinematic object from now on as `scene` says, by its motion and by what hands did to
    /// it. It must be where it was, or what touches it is torn.
    ///
    /// # Errors
    /// [`SimError::Unled`] for an object that moves freely or is not there.
    pub fn lead(&mut self, object: usize, scene: &Object) -> Result<(), SimError> {
        let led = self.objects_mut().get_mut(object).map(|of| of.lead(Box::new(scene.led_pose())));
        if led == Some(true) { Ok(()) } else { Err(SimError::Unled(object)) }
    }

    /// Poses of all objects now, in the order of [`surfaces`](Self::surfaces).
    pub fn poses(&self) -> impl Iterator<Item = Isometry3<f64>> {
        self.objects().iter().map(|object| object.pose(self.time()))
    }

    /// Lets all hands pull with their forces at this instant, if there are any.
    pub(crate) fn pull(&mut self) -> Result<(), SimError> {
        if self.grips.is_empty() {
            return Ok(());
        }
        let time = self.time();
        let of = |grip: &Grip| {
            let place = grip.at(time)?;
            let (position, velocity) = self.node(grip.fiber, Some(grip.node));
            let spring = grip.stiffness * (Vector3::from(place) - position.coords);
            let force = (spring - grip.damping * velocity).cap_magnitude(grip.most);
            Some(NodePull { strand: grip.fiber, node: grip.node, force })
        };
        let pulls: Vec<_> = self.grips.iter().filter_map(of).collect();
        self.stepper_mut().pull(&pulls)
    }

    /// Numbers of nodes that hands can be at: of each fibre, or of all that moves.
    fn gripped_nodes(&self) -> Vec<usize> {
        match self.stepper().fibers() {
            Some(_) => self.stepper().strand_nodes(),
            None => vec![self.nodes()],
        }
    }
}
