//! A free rigid body on SE(3), thesis 8.4.1: balls, boxes and clips among the hair, and the links
//! of a chain.

mod points;
mod step;

pub use points::RigidPoints;

use crate::ContactError;
use nalgebra::{Cholesky, Isometry3, Matrix3, Point3, Vector3, Vector6};

/// A rigid body: mass, inertia, pose, linear velocity and angular momentum.
///
/// The angular momentum is the state and not the angular velocity, because it is what an impulse
/// changes and what a free body keeps: `omega = I^-1 L` then has the gyroscopic term of Euler's
/// equations, `alpha = I^-1 (l - omega x I omega)`, that (8.80) lacks (erratum).
#[derive(Debug, Clone, PartialEq)]
pub struct RigidBody {
    mass: f64,
    inertia: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
    /// Pose of the body's frame, with its origin at the center of mass, in the world; m.
    pub pose: Isometry3<f64>,
    /// Velocity of the center of mass, world, m/s.
    pub velocity: Vector3<f64>,
    /// Angular momentum about the center of mass, world, kg m^2/s.
    pub angular_momentum: Vector3<f64>,
}

impl RigidBody {
    /// A body at rest of `mass` (kg) and `inertia` about its center of mass, in the body's frame
    /// (kg m^2).
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for a mass that is not positive or an inertia that is not
    /// symmetric and positive definite.
    pub fn new(
        mass: f64,
        inertia: Matrix3<f64>,
        pose: Isometry3<f64>,
    ) -> Result<Self, ContactError> {
        if !(mass > 0.0 && mass.is_finite()) {
            return Err(ContactError::Invalid { what: "mass", value: mass, why: "must be > 0 kg" });
        }
        let asymmetry = (inertia - inertia.transpose()).amax();
        let factor = Cholesky::new(inertia);
        let Some(factor) = factor.filter(|_| asymmetry <= 1e-12 * inertia.amax()) else {
            return Err(ContactError::Invalid {
                what: "inertia's smallest eigenvalue",
                value: inertia.symmetric_eigenvalues().min(),
                why: "an inertia must be symmetric and positive definite, kg m^2",
            });
        };
        Ok(Self {
            mass,
            inertia,
            inverse_inertia: factor.inverse(),
            pose,
            velocity: Vector3::zeros(),
            angular_momentum: Vector3::zeros(),
        })
    }

    /// A solid ball.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] where [`Self::new`] refuses.
    pub fn ball(mass: f64, radius: f64, pose: Isometry3<f64>) -> Result<Self, ContactError> {
        Self::new(mass, Matrix3::from_diagonal_element(0.4 * mass * radius * radius), pose)
    }

    /// A solid box with the given edges along the axes of its frame.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] where [`Self::new`] refuses.
    pub fn cuboid(
        mass: f64,
        edges: Vector3<f64>,
        pose: Isometry3<f64>,
    ) -> Result<Self, ContactError> {
        let squares = edges.component_mul(&edges);
        let moments = (Vector3::repeat(squares.sum()) - squares) * (mass / 12.0);
        Self::new(mass, Matrix3::from_diagonal(&moments), pose)
    }

    /// A solid cylinder about the third axis of its frame, as a fiber's segment is.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] where [`Self::new`] refuses.
    pub fn cylinder(
        mass: f64,
        radius: f64,
        length: f64,
        pose: Isometry3<f64>,
    ) -> Result<Self, ContactError> {
        let across = mass * (3.0 * radius * radius + length * length) / 12.0;
        let moments = Vector3::new(across, across, 0.5 * mass * radius * radius);
        Self::new(mass, Matrix3::from_diagonal(&moments), pose)
    }

    /// Mass, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Center of mass, world, m.
    #[must_use]
    pub fn center(&self) -> Point3<f64> {
        self.pose.translation.vector.into()
    }

    /// Inertia about the center of mass in the world's frame, kg m^2.
    #[must_use]
    pub fn inertia(&self) -> Matrix3<f64> {
        self.to_world(&self.inertia)
    }

    /// Inverse of [`Self::inertia`].
    #[must_use]
    pub fn inverse_inertia(&self) -> Matrix3<f64> {
        self.to_world(&self.inverse_inertia)
    }

    fn to_world(&self, tensor: &Matrix3<f64>) -> Matrix3<f64> {
        let rotation = self.pose.rotation.to_rotation_matrix();
        rotation.matrix() * tensor * rotation.matrix().transpose()
    }

    /// Angular velocity, world, rad/s.
    #[must_use]
    pub fn angular_velocity(&self) -> Vector3<f64> {
        let rotation = &self.pose.rotation;
        rotation
            * (self.inverse_inertia * rotation.inverse_transform_vector(&self.angular_momentum))
    }

    /// Sets the angular velocity (world, rad/s).
    pub fn set_angular_velocity(&mut self, omega: &Vector3<f64>) {
        let rotation = &self.pose.rotation;
        self.angular_momentum =
            rotation * (self.inertia * rotation.inverse_transform_vector(omega));
    }

    /// Linear, then angular velocity in the world's frame: the twist of (8.74).
    #[must_use]
    pub fn twist(&self) -> Vector6<f64> {
        stack(&self.velocity, &self.angular_velocity())
    }

    /// Sets both velocities from a [twist](Self::twist).
    pub fn set_twist(&mut self, twist: &Vector6<f64>) {
        self.velocity = linear(twist);
        self.set_angular_velocity(&angular(twist));
    }

    /// Velocity of the body's point that is at `point` (world), m/s.
    #[must_use]
    pub fn velocity_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.velocity + self.angular_velocity().cross(&(point - self.center()))
    }

    /// Lets `impulse` (N s, world) act at `point` (world): (8.72), (8.74).
    pub fn apply_impulse(&mut self, impulse: &Vector3<f64>, point: &Point3<f64>) {
        self.velocity += impulse / self.mass;
        self.angular_momentum += (point - self.center()).cross(impulse);
    }

    /// Angular momentum about `point` (world), kg m^2/s.
    #[must_use]
    pub fn angular_momentum_about(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.angular_momentum + (self.center() - point).cross(&(self.mass * self.velocity))
    }

    /// Kinetic energy, J.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        0.5 * (self.mass * self.velocity.norm_squared()
            + self.angular_momentum.dot(&self.angular_velocity()))
    }
}

pub(crate) fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

pub(crate) fn linear(twist: &Vector6<f64>) -> Vector3<f64> {
    twist.fixed_rows::<3>(0).into_owned()
}

pub(crate) fn angular(twist: &Vector6<f64>) -> Vector3<f64> {
    twist.fixed_rows::<3>(3).into_owned()
}
