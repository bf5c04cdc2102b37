//! Moment and second derivative of a joint.

use crate::JointAction;
use crate::joint::Joint;
use nalgebra::{Matrix3, Rotation3};
use rapunzel_fiber::so3;

impl Joint {
    /// Moment and Hessian of the energy `(phi - rest)^T K (phi - rest) / 2`, `phi = log(a^T b)`.
    pub(super) fn act(&self, a: &Rotation3<f64>, b: &Rotation3<f64>) -> JointAction {
        let phi = so3::log(&(a.inverse() * b));
        let m = self.stiffness.component_mul(&(phi - self.rest));
        JointAction::new(a, b, &m, &Matrix3::from_diagonal(&self.stiffness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;

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
