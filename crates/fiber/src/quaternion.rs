//! Curvature from quaternions: the thesis's Euler parameters.
//!
//! The thesis writes `q = (q1, q2, q3, q4)` with `q4` the scalar part,
//! `q_j = Omega_j sin(a/2)`, `q4 = cos(a/2)` (thesis (3.47), (3.48)). That is the order in which
//! nalgebra stores a quaternion, `coords = (i, j, k, w)`, and the same rotation matrix.
//! [`crate::so3::quaternion`] goes from a rotation matrix to its quaternion.

use nalgebra::{Quaternion, Vector3};

/// The Darboux vector in the material frame of the frame `R(q)` with derivative `q'`:
/// `kappa_j = 2 (B_j q)^T q' / (q^T q)`, in the unit of `q'`
/// (thesis (3.49), which drops the transpose; corrected).
///
/// `q` need not have unit length: the part of `q'` along `q` drops out. Not finite for `q = 0`,
/// which is no rotation.
#[must_use]
pub fn darboux(q: &Quaternion<f64>, derivative: &Quaternion<f64>) -> Vector3<f64> {
    // (B_j q)^T q' is the j-th imaginary part of conj(q) q'.
    (q.conjugate() * derivative).imag() * (2.0 / q.norm_squared())
}

/// The derivative of the quaternion `q` for the Darboux vector `kappa` (material frame):
/// `q' = q kappa / 2`. It keeps the length of `q`.
#[must_use]
pub fn derivative(q: &Quaternion<f64>, kappa: &Vector3<f64>) -> Quaternion<f64> {
    q * Quaternion::from_imag(*kappa) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::so3;
    use nalgebra::{Matrix4, UnitQuaternion, Vector4};
    use proptest::prelude::*;

    /// The matrices (3.50) of the thesis.
    fn printed() -> [Matrix4<f64>; 3] {
        [
            [[0, 0, 0, 1], [0, 0, 1, 0], [0, -1, 0, 0], [-1, 0, 0, 0]],
            [[0, 0, -1, 0], [0, 0, 0, 1], [1, 0, 0, 0], [0, -1, 0, 0]],
            [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1], [0, 0, -1, 0]],
        ]
        .map(|rows| Matrix4::from_fn(|i, j| f64::from(rows[i][j])))
    }

    fn quaternion() -> impl Strategy<Value = Quaternion<f64>> {
        prop::array::uniform4(-2.0..2.0_f64)
            .prop_map(|q| Quaternion::from_vector(Vector4::from(q)))
            .prop_filter("not zero", |q| q.norm() > 1e-2)
    }

    proptest! {
        #[test]
        fn agrees_with_the_printed_matrices(q in quaternion(), dq in quaternion()) {
            let kappa = darboux(&q, &dq);
            for (j, b) in printed().iter().enumerate() {
                let expected = 2.0 / q.norm_squared() * (b * q.coords).dot(&dq.coords);
                prop_assert!((kappa[j] - expected).abs() < 1e-14 * (1.0 + dq.norm() / q.norm()));
            }
        }

        #[test]
        fn is_the_derivative_of_the_frame(q in quaternion(), dq in quaternion()) {
            let h = 1e-6 * q.norm();
            let at = |t: f64| UnitQuaternion::from_quaternion(q + dq * t).to_rotation_matrix();
            let numeric = so3::log(&(at(-h).inverse() * at(h))) / (2.0 * h);
            prop_assert!((darboux(&q, &dq) - numeric).norm() < 1e-7 * (1.0 + (dq.norm() / q.norm()).powi(3)));
        }

        #[test]
        fn derivative_inverts_darboux(q in quaternion(), k in prop::array::uniform3(-5.0..5.0_f64)) {
            let kappa = Vector3::from(k);
            let dq = derivative(&q, &kappa);
            prop_assert!((darboux(&q, &dq) - kappa).norm() < 1e-14 * (1.0 + kappa.norm()));
            prop_assert!(dq.dot(&q).abs() < 1e-14 * (1.0 + kappa.norm()) * q.norm_squared());
        }
    }
}
