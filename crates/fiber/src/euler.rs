//! Euler angles in the thesis's y-convention: `R = Rz(phi) Ry(theta) Rz(psi)` (thesis (3.40)).
//!
//! They are singular where the tangent is along the world's z axis, `theta = 0` and `pi`: only
//! `phi + psi` or `phi - psi` counts there. Going from a rotation to angles and back is exact to
//! rounding everywhere, also at the poles; the rates of the angles are not defined there.

use nalgebra::{Rotation3, Vector3};

/// Precession, nutation and spin, in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EulerAngles {
    /// Precession about the world's z axis, rad.
    pub phi: f64,
    /// Nutation, rad: the angle from the world's z axis to the tangent d3.
    pub theta: f64,
    /// Spin about the tangent, rad.
    pub psi: f64,
}

impl EulerAngles {
    /// The angles of `r`: `theta` in `[0, pi]`, the others in `[-pi, pi]`; `phi = 0` at the poles.
    #[must_use]
    pub fn from_rotation(r: &Rotation3<f64>) -> Self {
        let m = r.matrix();
        let phi = m[(1, 2)].atan2(m[(0, 2)]);
        // With phi taken out, the second row is (sin psi, cos psi, 0): no loss near the poles.
        let (s, c) = if m[(0, 2)] == 0.0 && m[(1, 2)] == 0.0 { (0.0, 1.0) } else { phi.sin_cos() };
        let row = |j: usize| c * m[(1, j)] - s * m[(0, j)];
        let theta = (c * m[(0, 2)] + s * m[(1, 2)]).atan2(m[(2, 2)]);
        Self { phi: s.atan2(c), theta, psi: row(0).atan2(row(1)) }
    }

    /// The rotation matrix (3.40); its columns are d1, d2, d3.
    #[must_use]
    pub fn to_rotation(self) -> Rotation3<f64> {
        let z = |angle| Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        z(self.phi) * Rotation3::from_axis_angle(&Vector3::y_axis(), self.theta) * z(self.psi)
    }

    /// The Darboux vector in the material frame for the derivatives
    /// `rates = (phi', theta', psi')` (thesis (3.44) to (3.46)), in the unit of the rates.
    #[must_use]
    pub fn darboux(self, rates: &Vector3<f64>) -> Vector3<f64> {
        let ((sin_t, cos_t), (sin_p, cos_p)) = (self.theta.sin_cos(), self.psi.sin_cos());
        let (phi, theta, psi) = (rates.x, rates.y, rates.z);
        Vector3::new(
            theta * sin_p - phi * sin_t * cos_p,
            theta * cos_p + phi * sin_t * sin_p,
            psi + phi * cos_t,
        )
    }

    /// The derivatives `(phi', theta', psi')` of the angles for the Darboux vector `kappa`, the
    /// inverse of [`EulerAngles::darboux`]. `None` at the poles, where `sin theta = 0`.
    #[must_use]
    pub fn rates(self, kappa: &Vector3<f64>) -> Option<Vector3<f64>> {
        let ((sin_t, cos_t), (sin_p, cos_p)) = (self.theta.sin_cos(), self.psi.sin_cos());
        let phi = (kappa.y * sin_p - kappa.x * cos_p) / sin_t;
        let theta = kappa.x * sin_p + kappa.y * cos_p;
        phi.is_finite().then(|| Vector3::new(phi, theta, kappa.z - phi * cos_t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::so3;
    use crate::so3::tests::rotation_vector;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    /// Angles with nutations at, near and far from both poles.
    fn angles() -> impl Strategy<Value = EulerAngles> {
        let near = prop_oneof![Just(0.0), -16.0..-1.0_f64]
            .prop_map(|e| if e < 0.0 { 10f64.powf(e) } else { 0.0 });
        let theta = prop_oneof![near.clone(), near.prop_map(|t| PI - t), 0.0..PI];
        (-PI..PI, theta, -PI..PI).prop_map(|(phi, theta, psi)| EulerAngles { phi, theta, psi })
    }

    /// Angles away from the poles: `sin theta > 1e-3`.
    fn regular_angles() -> impl Strategy<Value = EulerAngles> {
        (-PI..PI, 2e-3..PI - 2e-3, -PI..PI).prop_map(|(phi, theta, psi)| EulerAngles {
            phi,
            theta,
            psi,
        })
    }

    proptest! {
        #[test]
        fn rotation_survives_also_at_the_poles(angles in angles()) {
            let r = angles.to_rotation();
            let back = EulerAngles::from_rotation(&r).to_rotation();
            prop_assert!((r.matrix() - back.matrix()).norm() < 4e-15, "{angles:?}");
        }

        #[test]
        fn any_rotation_survives(u in rotation_vector()) {
            let r = so3::exp(&u);
            let back = EulerAngles::from_rotation(&r).to_rotation();
            prop_assert!((r.matrix() - back.matrix()).norm() < 1e-14);
        }

        #[test]
        fn angles_survive_away_from_the_poles(angles in regular_angles()) {
            let back = EulerAngles::from_rotation(&angles.to_rotation());
            // An angle is known to eps / sin(theta); both ends of (-pi, pi] are one angle.
            let off = |a: f64, b: f64| (0.5 * (a - b)).sin().abs();
            prop_assert!(off(angles.phi, back.phi) < 1e-12);
            prop_assert!(off(angles.psi, back.psi) < 1e-12);
            prop_assert!((angles.theta - back.theta).abs() < 4e-15);
        }

        #[test]
        fn darboux_is_the_derivative_of_the_frame(angles in angles(), rates in prop::array::uniform3(-1.0..1.0_f64)) {
            let h = 1e-6;
            let at = |t: f64| EulerAngles {
                phi: angles.phi + t * rates[0],
                theta: angles.theta + t * rates[1],
                psi: angles.psi + t * rates[2],
            }.to_rotation();
            let numeric = so3::log(&(at(-h).inverse() * at(h))) / (2.0 * h);
            prop_assert!((angles.darboux(&Vector3::from(rates)) - numeric).norm() < 1e-9);
        }

        #[test]
        fn rates_invert_darboux(angles in regular_angles(), rates in prop::array::uniform3(-1.0..1.0_f64)) {
            let rates = Vector3::from(rates);
            let back = angles.rates(&angles.darboux(&rates)).expect("away from the poles");
            prop_assert!((back - rates).norm() < 1e-11);
        }
    }

    #[test]
    fn poles_are_handled() {
        let up = EulerAngles { phi: 0.3, theta: 0.0, psi: 0.4 };
        assert_eq!(up.rates(&Vector3::new(1.0, 1.0, 1.0)), None);
        let found = EulerAngles::from_rotation(&up.to_rotation());
        assert_eq!((found.phi, found.theta), (0.0, 0.0));
        assert!((found.psi - 0.7).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn the_printed_matrix() {
        let (phi, theta, psi) = (0.7_f64, 1.1_f64, -2.3_f64);
        let r = EulerAngles { phi, theta, psi }.to_rotation();
        assert!((r[(0, 2)] - phi.cos() * theta.sin()).abs() < 1e-15);
        assert!((r[(2, 0)] + theta.sin() * psi.cos()).abs() < 1e-15);
        let r21 = phi.sin() * theta.cos() * psi.cos() + phi.cos() * psi.sin();
        assert!((r[(1, 0)] - r21).abs() < 1e-15);
    }
}
