use nalgebra::SVector;
use std::f64::consts::TAU;

/// The velocity of the air, the same everywhere: `steady + pulse (1 - cos(2 pi t / period)) / 2`.
///
/// It acts through the drag, as wind does; the texts add an acceleration instead, which for a drag
/// rate `gamma` is `gamma u`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindField<const D: usize> {
    /// Constant velocity (world), m/s.
    pub steady: SVector<f64, D>,
    /// Velocity added at the peak of a pulse (world), m/s.
    pub pulse: SVector<f64, D>,
    /// Time from pulse to pulse, s; positive.
    pub period: f64,
}

impl<const D: usize> Default for WindField<D> {
    fn default() -> Self {
        Self::steady(SVector::zeros())
    }
}

impl<const D: usize> WindField<D> {
    /// Wind of constant velocity, m/s (world).
    #[must_use]
    pub fn steady(velocity: SVector<f64, D>) -> Self {
        Self { steady: velocity, pulse: SVector::zeros(), period: 1.0 }
    }

    /// Velocity at time `t` (s), m/s (world), as the wind rose shows it.
    #[must_use]
    pub fn at(&self, t: f64) -> SVector<f64, D> {
        self.steady + self.pulse * (0.5 * (1.0 - (TAU * t / self.period).cos()))
    }
}
