//! The rotation group SO(3): exponential, logarithm and their differentials.
//!
//! Rotation vectors are in radians. All maps are smooth through zero (series below a small
//! angle), and [`log`] is accurate up to and at an angle of pi. Cost: a sine, a cosine and some
//! thirty multiplications.
//!
//! `exp(u + du) = exp(u) exp(right_jacobian(u) du)` to first order in `du`.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Below this squared angle the series (to the fourth power of the angle) are exact in `f64`.
const SMALL_SQUARED: f64 = 1e-4;

/// The skew matrix of `u`: `hat(u) w = u x w`.
#[must_use]
pub fn hat(u: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -u.z, u.y, u.z, 0.0, -u.x, -u.y, u.x, 0.0)
}

/// The vector of the skew part of `m`: `vee(hat(u)) = u`.
#[must_use]
pub fn vee(m: &Matrix3<f64>) -> Vector3<f64> {
    0.5 * Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)])
}

/// `(sin a / a, (1 - cos a) / a^2, (a - sin a) / a^3)` for `a^2 = squared`.
pub(crate) fn coefficients(squared: f64) -> (f64, f64, f64) {
    if squared < SMALL_SQUARED {
        let x = squared;
        (
            1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0)),
            0.5 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0))),
            (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0))) / 6.0,
        )
    } else {
        let a = squared.sqrt();
        let half = (0.5 * a).sin();
        let sinc = a.sin() / a;
        (sinc, 2.0 * half * half / squared, (1.0 - sinc) / squared)
    }
}

/// Rodrigues' formula, `E + sin(a) hat(e) + (1 - cos a) hat(e)^2` for `u = a e`
/// (thesis (3.162), which misplaces the square; corrected).
#[must_use]
pub fn exp(u: &Vector3<f64>) -> Rotation3<f64> {
    let (s, c, _) = coefficients(u.norm_squared());
    let h = hat(u);
    Rotation3::from_matrix_unchecked(Matrix3::identity() + s * h + c * h * h)
}

/// The rotation vector of `r`, of length at most pi.
///
/// Goes through the quaternion with the largest component first (Shepperd), so it keeps full
/// accuracy near pi, where the skew part of the matrix vanishes. At exactly pi either axis is
/// right; the one with a positive leading component is not guaranteed.
#[must_use]
pub fn log(r: &Rotation3<f64>) -> Vector3<f64> {
    let q = quaternion(r);
    let (w, v) = (q.w, q.vector());
    let norm = v.norm();
    if norm < 1e-8 {
        // atan2(n, w) / n for small n, with w = +-1.
        return v * (2.0 / w);
    }
    v * (2.0 * (norm.copysign(w)).atan2(w.abs()) / norm)
}

/// The unit quaternion of `r` (Shepperd's method; the largest component is positive).
#[must_use]
pub fn quaternion(r: &Rotation3<f64>) -> UnitQuaternion<f64> {
    let m = r.matrix();
    let (a, b, c) = (m[(0, 0)], m[(1, 1)], m[(2, 2)]);
    let trace = a + b + c;
    let q = if trace >= a.max(b).max(c) {
        let w = 1.0 + trace;
        Quaternion::new(w, m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)])
    } else if a >= b && a >= c {
        let x = 1.0 + a - b - c;
        Quaternion::new(m[(2, 1)] - m[(1, 2)], x, m[(0, 1)] + m[(1, 0)], m[(0, 2)] + m[(2, 0)])
    } else if b >= c {
        let y = 1.0 - a + b - c;
        Quaternion::new(m[(0, 2)] - m[(2, 0)], m[(0, 1)] + m[(1, 0)], y, m[(1, 2)] + m[(2, 1)])
    } else {
        let z = 1.0 - a - b + c;
        Quaternion::new(m[(1, 0)] - m[(0, 1)], m[(0, 2)] + m[(2, 0)], m[(1, 2)] + m[(2, 1)], z)
    };
    UnitQuaternion::from_quaternion(q)
}

/// The smallest rotation that takes the direction of `a` to that of `b`. `None` where no rotation
/// is smallest: for opposite directions, and for vectors without one.
#[must_use]
pub fn between(a: &Vector3<f64>, b: &Vector3<f64>) -> Option<Rotation3<f64>> {
    let (cross, dot) = (a.cross(b), a.dot(b));
    let sine = cross.norm();
    if sine > 0.0 {
        Some(exp(&(cross * (sine.atan2(dot) / sine))))
    } else {
        (dot > 0.0).then(Rotation3::identity)
    }
}

/// The right Jacobian `J`: `exp(u + du) = exp(u) exp(J du)` to first order. Body rates are
/// `J(u) du/dt`.
#[must_use]
pub fn right_jacobian(u: &Vector3<f64>) -> Matrix3<f64> {
    let (_, c, d) = coefficients(u.norm_squared());
    let h = hat(u);
    Matrix3::identity() - c * h + d * h * h
}

/// The inverse of [`right_jacobian`]: `log(exp(u) exp(dw)) = u + J^-1 dw` to first order.
/// Singular at an angle of `2 pi`.
#[must_use]
pub fn right_jacobian_inverse(u: &Vector3<f64>) -> Matrix3<f64> {
    let h = hat(u);
    Matrix3::identity() + 0.5 * h + inverse_coefficient(u.norm_squared()) * h * h
}

/// The coefficient `(1 - (a/2) cot(a/2)) / a^2` of the inverse right Jacobian, for `a^2 = squared`.
#[must_use]
pub fn inverse_coefficient(squared: f64) -> f64 {
    if squared < SMALL_SQUARED {
        let x = squared;
        (1.0 + x / 60.0 * (1.0 + x / 42.0 * (1.0 + x / 40.0))) / 12.0
    } else {
        let half = 0.5 * squared.sqrt();
        (1.0 - half / half.tan()) / squared
    }
}

/// The derivative of [`inverse_coefficient`] by the square of the angle.
#[must_use]
pub fn inverse_coefficient_slope(squared: f64) -> f64 {
    // (k - 1) |B_2k| / (2k)!, the series in powers of a^2: at 1/4 it leaves out 6e-11 of the slope.
    const SERIES: [f64; 5] = [
        1.0 / 720.0,
        2.0 / 30_240.0,
        3.0 / 1_209_600.0,
        4.0 / 47_900_160.0,
        5.0 * 691.0 / 1_307_674_368_000.0,
    ];
    let x = squared;
    if x < 0.25 {
        SERIES.iter().rev().fold(0.0, |sum, c| c + x * sum)
    } else {
        let half = 0.5 * x.sqrt();
        let (sin, cot) = (half.sin(), 1.0 / half.tan());
        ((half / (sin * sin) - cot) / (8.0 * half) - inverse_coefficient(x)) / x
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    /// Rotation vectors of any axis with angles from far below the series' threshold to pi.
    pub(crate) fn rotation_vector() -> impl Strategy<Value = Vector3<f64>> {
        let axis = prop::array::uniform3(-1.0..1.0_f64)
            .prop_map(Vector3::from)
            .prop_filter("axis", |v| v.norm() > 1e-3);
        let angle =
            prop_oneof![Just(0.0), Just(1e-2), Just(PI - 1e-9), Just(PI), -12.0..-1.0_f64, 0.0..PI]
                .prop_map(|a| if a < 0.0 { 10f64.powf(a) } else { a });
        (axis, angle).prop_map(|(v, a)| v.normalize() * a)
    }

    proptest! {
        #[test]
        fn exp_is_orthogonal(u in rotation_vector()) {
            let r = exp(&u);
            prop_assert!((r.matrix().transpose() * r.matrix() - Matrix3::identity()).norm() < 4e-15);
            prop_assert!((r.matrix().determinant() - 1.0).abs() < 4e-15);
        }

        #[test]
        fn log_inverts_exp(u in rotation_vector()) {
            let v = log(&exp(&u));
            let error = (v - u).norm().min((v + u).norm() + (PI - u.norm()).abs());
            prop_assert!(error < 1e-14 * (1.0 + 1.0 / (1.0 + u.norm())), "{u:?} {v:?}");
        }

        #[test]
        fn right_jacobian_is_the_differential(u in rotation_vector(), d in prop::array::uniform3(-1.0..1.0_f64)) {
            let (d, h) = (Vector3::from(d), 1e-6);
            let numeric = log(&(exp(&(u - h * d)).inverse() * exp(&(u + h * d)))) / (2.0 * h);
            prop_assert!((right_jacobian(&u) * d - numeric).norm() < 1e-8);
        }

        #[test]
        fn jacobians_are_inverse(u in rotation_vector()) {
            let product = right_jacobian(&u) * right_jacobian_inverse(&u);
            prop_assert!((product - Matrix3::identity()).norm() < 1e-13);
        }
    }

    proptest! {
        #[test]
        fn between_turns_one_direction_into_the_other(u in rotation_vector(), w in rotation_vector()) {
            let (a, b) = (exp(&u) * Vector3::x(), exp(&w) * Vector3::y());
            prop_assume!(a.dot(&b) > -0.999);
            let r = between(&(3.0 * a), &(0.1 * b)).expect("not opposite");
            prop_assert!((r * a - b).norm() < 1e-14);
        }
    }

    #[test]
    fn opposite_directions_have_no_smallest_rotation() {
        assert_eq!(between(&Vector3::x(), &-Vector3::x()), None);
        assert_eq!(between(&Vector3::x(), &Vector3::zeros()), None);
    }

    #[test]
    fn log_at_pi_finds_the_axis() {
        let axis = Vector3::new(1.0, -2.0, 0.5).normalize();
        let v = log(&exp(&(PI * axis)));
        assert_relative_eq!(v.norm(), PI, max_relative = 1e-15);
        assert_relative_eq!(v.normalize().dot(&axis).abs(), 1.0, max_relative = 1e-15);
    }

    #[test]
    fn slope_of_the_inverse_coefficient_is_its_derivative() {
        let (below, above) = (0.25 * (1.0 - 1e-12), 0.25);
        let [below, above] = [below, above].map(inverse_coefficient_slope);
        assert_relative_eq!(below, above, epsilon = 1e-12);
        for x in [0.1, 0.2, 0.3, 2.0, 9.0] {
            let (h, c) = (1e-4, inverse_coefficient);
            let difference = (c(x + h) - c(x - h)) / (2.0 * h);
            assert_relative_eq!(inverse_coefficient_slope(x), difference, epsilon = 1e-10);
        }
    }

    #[test]
    fn series_meet_the_closed_form() {
        let (a, b) = (coefficients(SMALL_SQUARED * (1.0 - 1e-15)), coefficients(SMALL_SQUARED));
        assert_relative_eq!(a.0, b.0, max_relative = 4e-16);
        assert_relative_eq!(a.1, b.1, max_relative = 4e-16);
        // The closed form subtracts 1 - O(a^2 / 6) from 1.
        assert_relative_eq!(a.2, b.2, max_relative = 10.0 * f64::EPSILON / SMALL_SQUARED);
    }
}
