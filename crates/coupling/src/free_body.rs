//! Objects that move freely: rigid bodies on SE(3) (thesis 8.4.1) within the step of the fibres.
//!
//! A body has no stiffness, so that its step is explicit in the impulses: what gravity and contacts
//! give it changes its momenta, and its new velocities move it, as backward Euler does for fibres.
//! To a solver it is one more body, whose points are where something touches it.
//!
//! Fibres touch on their axes, and so they do here: the lever of an impulse ends on the axis, so
//! that what the body gets of angular momentum is what the fibre loses. Between two bodies the
//! levers of both end in the middle of the gap.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3, Vector6};
use rapunzel_contact::{ContactError, RigidBody};
use rapunzel_rod_dynamic::{Energy, Ledger};

/// Numbers of a saved body.
const BODY_NUMBERS: usize = 13;

/// A free body, between steps and within one.
#[derive(Debug)]
pub struct FreeBody {
    /// At the start of the step.
    pub(crate) state: RigidBody,
    /// At its end, as it has been solved so far.
    pub(crate) solved: RigidBody,
    /// From the object's frame to the body's, whose origin is the center of mass.
    to_body: Translation3<f64>,
}

impl FreeBody {
    /// A body whose center of mass is at `center` in the frame of its object.
    pub fn new(body: RigidBody, center: Vector3<f64>) -> Self {
        Self { solved: body.clone(), state: body, to_body: Translation3::from(-center) }
    }

    /// At the start of the step and, as solved so far, at its end.
    pub(crate) fn bodies(&self) -> [&RigidBody; 2] {
        [&self.state, &self.solved]
    }

    /// Poses of the object at the start and, as solved so far, at the end of the step.
    pub(crate) fn poses(&self) -> [Isometry3<f64>; 2] {
        [&self.state, &self.solved].map(|body| body.pose * self.to_body)
    }

    /// Centers of mass at the start and, as solved so far, at the end of the step, world, m.
    pub(crate) fn centers(&self) -> [Point3<f64>; 2] {
        [&self.state, &self.solved].map(RigidBody::center)
    }

    /// Poses of the object now and after `dt`, s, in free fall.
    pub(crate) fn fall(
        &self,
        dt: f64,
        gravity: &Vector3<f64>,
    ) -> Result<[Isometry3<f64>; 2], ContactError> {
        let fallen = moved(&self.state, &Vector6::zeros(), dt, gravity)?;
        Ok([&self.state, &fallen].map(|body| body.pose * self.to_body))
    }

    /// Energy, J, with that in `gravity` zero at the world's origin.
    pub(crate) fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        Energy {
            kinetic: self.state.kinetic_energy(),
            elastic: 0.0,
            gravitational: -self.state.mass() * gravity.dot(&self.state.center().coords),
        }
    }

    /// Works of gravity and of the integrator in the step as it has been solved. Contacts act on
    /// the velocity at its end with the inertia at its start, as the solver has it: what is left is
    /// half the mass times the squared change of velocity, the same of the rotation, and what
    /// turning the inertia changes.
    pub(crate) fn works(&self, gravity: &Vector3<f64>) -> Ledger {
        let (before, after) = (&self.state, &self.solved);
        let mass = after.mass();
        let change = after.velocity - before.velocity;
        let (turned, turn) =
            (after.angular_momentum, after.angular_momentum - before.angular_momentum);
        let (inverse, inverse_after) = (before.inverse_inertia(), after.inverse_inertia());
        let turning =
            turn.dot(&(inverse * turn)) + turned.dot(&((inverse - inverse_after) * turned));
        let integrator = -0.5 * (mass * change.norm_squared() + turning);
        let gravity = mass * gravity.dot(&(after.center() - before.center()));
        Ledger { gravity, integrator, ..Ledger::default() }
    }

    /// The body as it is between steps.
    pub(crate) fn body(&self) -> &RigidBody {
        &self.state
    }

    /// All numbers that change.
    pub(crate) fn save(&self, numbers: &mut Vec<f64>) {
        let RigidBody { pose, velocity, angular_momentum, .. } = &self.state;
        numbers.extend(pose.translation.vector.iter());
        numbers.extend(pose.rotation.coords.iter());
        numbers.extend(velocity.iter().chain(angular_momentum));
    }

    /// Goes back to saved numbers and returns what is left of them; `None` if there are too few.
    pub(crate) fn restore<'a>(&mut self, numbers: &'a [f64]) -> Option<&'a [f64]> {
        let (&[x, y, z, i, j, k, w, u, v, n, l, m, o], rest) =
            numbers.split_first_chunk::<BODY_NUMBERS>()?;
        // Not normalized again: the same bits must come back.
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
        self.state.pose = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
        self.state.velocity = Vector3::new(u, v, n);
        self.state.angular_momentum = Vector3::new(l, m, o);
        self.solved = self.state.clone();
        Some(rest)
    }
}

/// A body after a step of `dt`, s, in which it got a wrench (N s, N m s, about its center of mass).
pub(crate) fn moved(
    body: &RigidBody,
    wrench: &Vector6<f64>,
    dt: f64,
    gravity: &Vector3<f64>,
) -> Result<RigidBody, ContactError> {
    let mut body = body.clone();
    body.velocity += dt * gravity;
    body.apply_wrench(wrench);
    body.step(&Vector3::zeros(), &Vector3::zeros(), dt)?;
    Ok(body)
}
