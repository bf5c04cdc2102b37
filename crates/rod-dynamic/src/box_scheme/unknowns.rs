//! Unknowns and known terms of a node, and the scales of residuals.

use nalgebra::Vector3;

/// The unknowns of a node at the stage of a step, in its material frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unknowns {
    pub(super) v: Vector3<f64>,
    pub(super) omega: Vector3<f64>,
    pub(super) kappa: Vector3<f64>,
    pub(super) n: Vector3<f64>,
}

impl Unknowns {
    pub(super) fn zero() -> Self {
        let o = Vector3::zeros();
        Self { v: o, omega: o, kappa: o, n: o }
    }

    /// `self + mu increment`.
    pub(super) fn plus(&self, mu: f64, increment: &[f64; 12]) -> Self {
        let part = |i: usize| mu * Vector3::from_column_slice(&increment[i..i + 3]);
        Self {
            v: self.v + part(0),
            omega: self.omega + part(3),
            kappa: self.kappa + part(6),
            n: self.n + part(9),
        }
    }
}

/// Known terms at a node: time derivatives at the stage are `c y + b` with these `b`, and the
/// moment is `stiffness kappa + offset`, the Kelvin-Voigt term included.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeLaw {
    pub(super) b_v: Vector3<f64>,
    pub(super) b_omega: Vector3<f64>,
    pub(super) b_kappa: Vector3<f64>,
    pub(super) stiffness: Vector3<f64>,
    pub(super) offset: Vector3<f64>,
}

impl NodeLaw {
    pub(super) fn moment(&self, kappa: &Vector3<f64>) -> Vector3<f64> {
        self.stiffness.component_mul(kappa) + self.offset
    }
}

/// Magnitudes that residuals are divided by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    /// Scales of the equations of a segment: force, moment, curvature rate and velocity per length.
    pub(super) segment: [f64; 4],
    /// Scale of the velocity conditions at the ends.
    pub(super) end_velocity: f64,
    /// Scale of the force and moment conditions at the ends.
    pub(super) end_load: f64,
}
