//! Moment and second derivative of a joint.

use crate::joint::Joint;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_fiber::so3;

/// Moment and Hessian of a joint, world frame.
pub(super) struct Action {
    /// Moment on the segment before the joint, N m.
    pub(super) moment: Vector3<f64>,
    /// Second derivative of the energy by a rotation of the segment behind the joint, N m.
    pub(super) hessian: Matrix3<f64>,
}

impl Joint {
    /// Moment and Hessian of the energy `(phi - rest)^T K (phi - rest) / 2` with `phi = log(a^T
    /// b)`, differentiated twice by `b -> exp(hat(x)) b`: `phi` changes by `J^-1 y + ...` with `y =
    /// b^T x`.
    pub(super) fn act(&self, a: &Rotation3<f64>, b: &Rotation3<f64>) -> Action {
        let phi = so3::log(&(a.inverse() * b));
        let m = self.stiffness.component_mul(&(phi - self.rest));
        let inverse = so3::right_jacobian_inverse(&phi);
        let elastic = inverse.transpose() * Matrix3::from_diagonal(&self.stiffness) * inverse;
        // The derivative of J^-T m at constant m; the order of two rotations makes it unsymmetric,
        // which is no part of the energy's second derivative.
        let squared = phi.norm_squared();
        let c = so3::inverse_coefficient(squared);
        let slope = so3::inverse_coefficient_slope(squared);
        let along = phi.dot(&m);
        let varied = 0.5 * so3::hat(&m)
            + c * (Matrix3::from_diagonal_element(along) + phi * m.transpose()
                - 2.0 * m * phi.transpose())
            + 2.0 * slope * phi.cross(&phi.cross(&m)) * phi.transpose();
        let geometric = varied * inverse;
        let local = elastic + 0.5 * (geometric + geometric.transpose());
        Action {
            moment: b * (inverse.transpose() * m),
            hessian: b.matrix() * local * b.matrix().transpose(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn hessian_is_the_second_difference_of_the_energy() {
        let joint = Joint {
            length: 1.0,
            stiffness: Vector3::new(1.0, 2.0, 0.7),
            rest: Vector3::new(0.1, -0.2, 0.3),
        };
        for size in [0.1, 0.9, 2.0] {
            let a = so3::exp(&Vector3::new(0.3, -0.7, 0.2));
            let b = a * so3::exp(&(size * Vector3::new(0.6, -0.3, 0.74)));
            let energy = |x: Vector3<f64>| {
                let strain = so3::log(&(a.inverse() * so3::exp(&x) * b)) - joint.rest;
                0.5 * strain.dot(&joint.stiffness.component_mul(&strain))
            };
            let action = joint.act(&a, &b);
            for direction in [Vector3::x(), Vector3::new(0.0, 0.6, 0.8), Vector3::repeat(0.5)] {
                let d = 1e-3 * direction;
                let (plus, here, minus) = (energy(d), energy(Vector3::zeros()), energy(-d));
                let first = (plus - minus) / 2e-3;
                let second = (plus - 2.0 * here + minus) / 1e-6;
                assert_relative_eq!(first, direction.dot(&action.moment), epsilon = 1e-5);
                let exact = direction.dot(&(action.hessian * direction));
                assert_relative_eq!(second, exact, epsilon = 1e-5);
            }
        }
    }
}
