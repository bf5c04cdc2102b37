//! Joints of the staggered rod: bending and torsion of the rod between two segment midpoints.

use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_fiber::{Fiber, so3};

/// Length, stiffness and natural rotation of one joint.
pub(crate) struct Joint {
    /// Length of rod that the joint stands for, m: half a segment at the two ends.
    pub(crate) length: f64,
    /// Stiffness about the material axes divided by `length`, N m.
    pub(crate) stiffness: Vector3<f64>,
    /// Natural rotation vector from one segment to the next, rad, material frame.
    pub(crate) rest: Vector3<f64>,
}

impl Joint {
    /// Joint `j` of `0..=n`, with properties interpolated to the middle of its length.
    pub(crate) fn new(fiber: &Fiber, j: usize) -> Self {
        let (nodes, h, n) = (fiber.nodes(), fiber.segment_lengths(), fiber.segments());
        let (length, inner) = match j {
            0 => (0.5 * h[0], 1),
            j if j == n => (0.5 * h[n - 1], n - 1),
            j => (0.5 * (h[j - 1] + h[j]), j),
        };
        let weighted = |a: &Vector3<f64>, b: &Vector3<f64>| 0.75 * a + 0.25 * b;
        let (a, b) = (&nodes[j], &nodes[inner]);
        Self {
            length,
            stiffness: weighted(&a.stiffness, &b.stiffness) / length,
            rest: weighted(&a.natural_curvature, &b.natural_curvature) * length,
        }
    }
}

/// Moment and second derivative of an elastic joint, world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointAction {
    /// Moment on the segment before the joint, N m; on that behind it acts the opposite one.
    pub moment: Vector3<f64>,
    /// Second derivative of the energy by a rotation of the segment behind the joint, N m, of the
    /// rotation vector in the world.
    pub hessian: Matrix3<f64>,
}

impl JointAction {
    /// The action between the frames `a` and `b` of an energy of their rotation vector
    /// `phi = log(a^T b)`, whose derivatives there are `m` (N m) and `tangent` (N m). It is
    /// differentiated twice by `b -> exp(hat(x)) b`: `phi` changes by `J^-1 y + ...` with
    /// `y = b^T x`.
    #[must_use]
    pub fn new(
        a: &Rotation3<f64>,
        b: &Rotation3<f64>,
        m: &Vector3<f64>,
        tangent: &Matrix3<f64>,
    ) -> Self {
        let phi = so3::log(&(a.inverse() * b));
        let inverse = so3::right_jacobian_inverse(&phi);
        let elastic = inverse.transpose() * tangent * inverse;
        // The derivative of J^-T m at constant m; the order of two rotations makes it unsymmetric,
        // which is no part of the energy's second derivative.
        let squared = phi.norm_squared();
        let c = so3::inverse_coefficient(squared);
        let slope = so3::inverse_coefficient_slope(squared);
        let along = phi.dot(m);
        let varied = 0.5 * so3::hat(m)
            + c * (Matrix3::from_diagonal_element(along) + phi * m.transpose()
                - 2.0 * m * phi.transpose())
            + 2.0 * slope * phi.cross(&phi.cross(m)) * phi.transpose();
        let geometric = varied * inverse;
        let local = elastic + 0.5 * (geometric + geometric.transpose());
        Self {
            moment: b * (inverse.transpose() * m),
            hessian: b.matrix() * local * b.matrix().transpose(),
        }
    }
}
