use super::{RigidBody, angular, linear, stack};
use crate::{Body, ContactError};
use nalgebra::{Cholesky, Const, Matrix3, Matrix6, Point3, Vector3, Vector6};
use rapunzel_fiber::so3::hat;

/// Points fixed on a [`RigidBody`], as a solver sees them. `H` is `v + omega x r`, `A` is the mass
/// matrix of (8.74) at the pose that the body had.
///
/// An answer costs O(points), weights one factorization of a 6 x 6 matrix.
#[derive(Debug, Clone)]
pub struct RigidPoints {
    /// Points relative to the center of mass, world, m.
    levers: Vec<Vector3<f64>>,
    /// Mass matrix for velocity and angular velocity, world.
    mass: Matrix6<f64>,
    /// Factors of the mass matrix.
    factor: Cholesky<f64, Const<6>>,
    /// Factors of the mass matrix with the added masses of the points.
    weighted: Cholesky<f64, Const<6>>,
}

impl RigidBody {
    /// The body with `points` (world) fixed on it.
    ///
    /// # Errors
    /// [`ContactError::Body`] if the mass matrix cannot be factorized.
    pub fn with_points(&self, points: &[Point3<f64>]) -> Result<RigidPoints, ContactError> {
        let mut mass = Matrix6::from_diagonal_element(self.mass);
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.inertia());
        let levers = points.iter().map(|point| point - self.center()).collect();
        let factor = factorize(mass)?;
        Ok(RigidPoints { levers, mass, weighted: factor, factor })
    }
}

impl RigidPoints {
    /// Sum of `impulses` (N s, at the points): the impulse at the center of mass and the moment
    /// about it, in this order. To be given to [`RigidBody::apply_wrench`].
    #[must_use]
    pub fn wrench(&self, impulses: &[Vector3<f64>]) -> Vector6<f64> {
        self.levers
            .iter()
            .zip(impulses)
            .map(|(lever, impulse)| stack(impulse, &lever.cross(impulse)))
            .sum()
    }

    /// The velocities of the points in a rigid motion.
    fn twist(&self, twist: &Vector6<f64>, velocities: &mut [Vector3<f64>]) {
        let (velocity, omega) = (linear(twist), angular(twist));
        for (lever, out) in self.levers.iter().zip(velocities) {
            *out = velocity + omega.cross(lever);
        }
    }
}

impl RigidBody {
    /// Lets an impulse (N s) and an angular impulse (N m s) act at the center of mass: (8.71).
    pub fn apply_wrench(&mut self, wrench: &Vector6<f64>) {
        self.velocity += linear(wrench) / self.mass;
        self.angular_momentum += angular(wrench);
    }
}

impl Body for RigidPoints {
    fn points(&self) -> usize {
        self.levers.len()
    }

    fn set_weights(&mut self, weights: &[f64]) -> Result<(), ContactError> {
        if weights.len() != self.levers.len() {
            return Err(ContactError::Length {
                what: "weights of points",
                expected: self.levers.len(),
                found: weights.len(),
            });
        }
        let mut weighted = self.mass;
        for (lever, &weight) in self.levers.iter().zip(weights) {
            let skew = hat(lever);
            let mut block = Matrix6::zeros();
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
            block.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew);
            block.fixed_view_mut::<3, 3>(3, 0).copy_from(&skew);
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(&(-skew * skew));
            weighted += weight * block;
        }
        self.weighted = factorize(weighted)?;
        Ok(())
    }

    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        self.twist(&self.factor.solve(&self.wrench(impulses)), velocities);
    }

    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        self.twist(&self.weighted.solve(&self.wrench(impulses)), velocities);
    }

    fn free_mass(&self) -> Option<f64> {
        Some(self.mass[(0, 0)])
    }

    fn own_traces(&mut self, traces: &mut [f64]) {
        let inverse = self.factor.inverse();
        for (lever, trace) in self.levers.iter().zip(traces) {
            *trace = (0..3)
                .map(|axis| {
                    let unit = Vector3::ith(axis, 1.0);
                    let row = stack(&unit, &lever.cross(&unit));
                    row.dot(&(inverse * row))
                })
                .sum();
        }
    }
}

fn factorize(matrix: Matrix6<f64>) -> Result<Cholesky<f64, Const<6>>, ContactError> {
    Cholesky::new(matrix).ok_or_else(|| ContactError::Body {
        body: 0,
        why: "its mass matrix is not positive definite (weights must be finite and >= 0)".into(),
    })
}
