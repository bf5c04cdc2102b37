use crate::SpringError;
use crate::error::{non_negative, positive};
use std::f64::consts::TAU;

/// A mass with its springs, with the parameters of the texts: the natural frequency of one mass on
/// one spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Mass of a node, kg.
    pub mass: f64,
    /// Natural frequency f0 of one mass on one spring, Hz; the spring constant is `m (2 pi f0)^2`.
    pub frequency: f64,
    /// Drag rate of the nodes, 1/s; twice the decay constant delta of the texts.
    pub drag: f64,
    /// Damping ratio zeta of a spring, its damping constant over the critical one: `mu = 2 zeta m 2
    /// pi f0`.
    pub damping_ratio: f64,
}

impl Element {
    /// Masses of 1 kg without drag or dampers, for results that depend on the frequency alone.
    #[must_use]
    pub fn unit(frequency: f64) -> Self {
        Self { mass: 1.0, frequency, drag: 0.0, damping_ratio: 0.0 }
    }

    /// Spring constant of the element, N/m.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        self.mass * (TAU * self.frequency).powi(2)
    }

    /// Damping constant of a spring's damper, N s/m.
    #[must_use]
    pub fn damping(&self) -> f64 {
        2.0 * self.damping_ratio * self.mass * TAU * self.frequency
    }

    pub(crate) fn check(&self) -> Result<(), SpringError> {
        positive("the mass of a node (kg)", self.mass)?;
        positive("the natural frequency (Hz)", self.frequency)?;
        non_negative("the drag rate (1/s)", self.drag)?;
        non_negative("the damping ratio", self.damping_ratio)
    }
}
