//! The group SE(3) of rigid motions (thesis A.6.2): exponential, logarithm, differentials,
//! adjoint.
//!
//! A pose is a rotation and a translation, `x -> R x + d`. A twist is a vector of six: the rotation
//! vector `u` (radians) in rows 0..3, the translation part `v` (metres) in rows 3..6; its matrix is
//! `[hat(u) v; 0 0]` (thesis (A.38) prints a 1 in the lower right corner; corrected to 0). A fibre
//! of constant curvature `kappa` advances over the length `h` by `exp(h (kappa, e3))`.
//!
//! `exp(xi + dxi) = exp(xi) exp(right_jacobian(xi) dxi)` to first order in `dxi`. All maps are
//! smooth through zero and accurate at an angle of pi.

use crate::so3;
use nalgebra::{IsometryMatrix3, Matrix3, Matrix6, Translation3, Vector3, Vector6};

/// Rotation and translation part of a twist.
fn split(xi: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (xi.fixed_rows::<3>(0).into_owned(), xi.fixed_rows::<3>(3).into_owned())
}

/// The pose reached from the identity after unit time along the twist `xi`:
/// `(exp(u), J(-u) v)` with `J` the right Jacobian of SO(3).
#[must_use]
pub fn exp(xi: &Vector6<f64>) -> IsometryMatrix3<f64> {
    let (u, v) = split(xi);
    let translation = so3::right_jacobian(&-u) * v;
    IsometryMatrix3::from_parts(Translation3::from(translation), so3::exp(&u))
}

/// The twist of `pose`, its rotation vector of length at most pi; see [`so3::log`] for the choice
/// at exactly pi.
#[must_use]
pub fn log(pose: &IsometryMatrix3<f64>) -> Vector6<f64> {
    let u = so3::log(&pose.rotation);
    let v = so3::right_jacobian_inverse(&-u) * pose.translation.vector;
    Vector6::new(u.x, u.y, u.z, v.x, v.y, v.z)
}

/// The adjoint of `pose`: `pose exp(xi) pose^-1 = exp(adjoint(pose) xi)`.
#[must_use]
pub fn adjoint(pose: &IsometryMatrix3<f64>) -> Matrix6<f64> {
    let r = pose.rotation.matrix();
    blocks(r, &(so3::hat(&pose.translation.vector) * r))
}

/// The right Jacobian `J`: `exp(xi + dxi) = exp(xi) exp(J dxi)` to first order.
///
/// The lower left block of `J` is the derivative of the Jacobian of SO(3) at `u` along `v`, because
/// the power series of the two share their coefficients.
#[must_use]
pub fn right_jacobian(xi: &Vector6<f64>) -> Matrix6<f64> {
    let (u, v) = split(xi);
    blocks(&so3::right_jacobian(&u), &jacobian_derivative(&u, &v))
}

/// The inverse of [`right_jacobian`]. Singular at an angle of `2 pi`.
#[must_use]
pub fn right_jacobian_inverse(xi: &Vector6<f64>) -> Matrix6<f64> {
    let (u, v) = split(xi);
    let inverse = so3::right_jacobian_inverse(&u);
    blocks(&inverse, &(-inverse * jacobian_derivative(&u, &v) * inverse))
}

/// The block matrix `[diagonal 0; lower diagonal]`.
fn blocks(diagonal: &Matrix3<f64>, lower: &Matrix3<f64>) -> Matrix6<f64> {
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(diagonal);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(diagonal);
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(lower);
    m
}

/// The derivative of `so3::right_jacobian(u) = E - c hat(u) + d hat(u)^2` along `v`.
fn jacobian_derivative(u: &Vector3<f64>, v: &Vector3<f64>) -> Matrix3<f64> {
    let squared = u.norm_squared();
    let (_, c, d) = so3::coefficients(squared);
    let (c1, d1) = coefficient_slopes(squared);
    let (hu, hv) = (so3::hat(u), so3::hat(v));
    let along = 2.0 * u.dot(v);
    d * (hu * hv + hv * hu) - c * hv + along * (d1 * hu * hu - c1 * hu)
}

/// Derivatives of `c = (1 - cos a) / a^2` and `d = (a - sin a) / a^3` with respect to `a^2`.
fn coefficient_slopes(squared: f64) -> (f64, f64) {
    if squared < 1.0 {
        // c = sum (-x)^k / (2k + 2)!, d = sum (-x)^k / (2k + 3)!; ten terms are exact in f64.
        let (mut c, mut d) = (0.0, 0.0);
        let mut term = -0.5; // (-1)^k x^(k-1) / (2k)!, at k = 1
        for k in 1..=10 {
            let n = f64::from(2 * k);
            let over = term / ((n + 1.0) * (n + 2.0));
            c += f64::from(k) * over;
            d += f64::from(k) * over / (n + 3.0);
            term = -over * squared;
        }
        (c, d)
    } else {
        let (sinc, c, d) = so3::coefficients(squared);
        let cos = squared.sqrt().cos();
        ((0.5 * sinc - c) / squared, ((sinc - cos) / (2.0 * squared) - d) / squared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::so3::tests::rotation_vector;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn twist() -> impl Strategy<Value = Vector6<f64>> {
        (rotation_vector(), prop::array::uniform3(-2.0..2.0_f64))
            .prop_map(|(u, v)| Vector6::new(u.x, u.y, u.z, v[0], v[1], v[2]))
    }

    proptest! {
        #[test]
        fn log_inverts_exp(xi in twist()) {
            // Compared as poses: at exactly pi two rotation vectors are right.
            let pose = exp(&xi);
            let back = exp(&log(&pose));
            prop_assert!((pose.to_homogeneous() - back.to_homogeneous()).norm() < 4e-14);
            if xi.fixed_rows::<3>(0).norm() < PI - 1e-6 {
                prop_assert!((log(&pose) - xi).norm() < 4e-14, "{xi}");
            }
        }

        #[test]
        fn exp_of_parallel_twists_composes(xi in twist(), t in 0.0..1.0_f64) {
            let whole = exp(&xi).to_homogeneous();
            let parts = (exp(&(t * xi)) * exp(&((1.0 - t) * xi))).to_homogeneous();
            prop_assert!((whole - parts).norm() < 2e-14);
        }

        #[test]
        fn right_jacobian_is_the_differential(xi in twist(), d in prop::array::uniform6(-1.0..1.0_f64)) {
            let (d, h) = (Vector6::from(d), 1e-6);
            let numeric = log(&(exp(&(xi - h * d)).inverse() * exp(&(xi + h * d)))) / (2.0 * h);
            prop_assert!((right_jacobian(&xi) * d - numeric).norm() < 1e-8);
        }

        #[test]
        fn jacobians_are_inverse(xi in twist()) {
            let product = right_jacobian(&xi) * right_jacobian_inverse(&xi);
            prop_assert!((product - Matrix6::identity()).norm() < 1e-12);
        }

        #[test]
        fn left_and_right_jacobians_differ_by_the_adjoint(xi in twist()) {
            // J(-xi) is the left Jacobian.
            let left = adjoint(&exp(&xi)) * right_jacobian(&xi);
            prop_assert!((left - right_jacobian(&-xi)).norm() < 1e-13);
        }

        #[test]
        fn adjoint_moves_a_twist(xi in twist(), eta in twist()) {
            let pose = exp(&xi);
            let (a, b) = (pose * exp(&eta) * pose.inverse(), exp(&(adjoint(&pose) * eta)));
            prop_assert!((a.to_homogeneous() - b.to_homogeneous()).norm() < 1e-13);
        }
    }

    #[test]
    fn series_meet_the_closed_form() {
        let (below, above) = (coefficient_slopes(1.0 - 1e-15), coefficient_slopes(1.0));
        assert!((below.0 / above.0 - 1.0).abs() < 1e-14, "{below:?} {above:?}");
        assert!((below.1 / above.1 - 1.0).abs() < 1e-13, "{below:?} {above:?}");
        assert_eq!(coefficient_slopes(0.0), (-1.0 / 24.0, -1.0 / 120.0));
    }

    #[test]
    fn a_quarter_turn_of_a_circle() {
        let radius = 0.7;
        let pose = exp(&Vector6::new(0.0, PI / 2.0, 0.0, 0.0, 0.0, radius * PI / 2.0));
        assert!((pose.translation.vector - Vector3::new(radius, 0.0, radius)).norm() < 1e-15);
    }
}
