//! Free oscillations: period and decrement of a record, and the oscillating rod (thesis, lines 618
//! to 640), which gives storage and loss modulus in bending.

use crate::KeratinError;
use crate::error::positive;
use std::f64::consts::PI;

/// The first zero of `1 + cos x cosh x`: a cantilever's `L sqrt(omega) (rho A / E I)^(1/4)`.
const CANTILEVER: f64 = 1.875_104_068_711_961;

/// Period and logarithmic decrement of a free oscillation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillation {
    /// Period of the oscillation, s.
    pub period: f64,
    /// Logarithmic decrement (2.14), `ln(a_1 / a_n) / n` with `n` oscillations between.
    pub log_decrement: f64,
}

impl Oscillation {
    /// Reads a record of `(time, deflection)` that swings about `rest`: periods between passages in
    /// the same direction, amplitudes at the extremes between them, by parabolas.
    ///
    /// # Errors
    /// [`KeratinError::Readings`] for fewer than three maxima.
    pub fn of(record: &[(f64, f64)], rest: f64) -> Result<Self, KeratinError> {
        let maxima: Vec<(f64, f64)> = record
            .windows(3)
            .filter(|w| w[1].1 > rest && w[1].1 >= w[0].1 && w[1].1 > w[2].1)
            .map(|w| vertex(w[0], w[1], w[2]))
            .collect();
        let count = maxima.len();
        let (Some(first), Some(last), true) = (maxima.first(), maxima.last(), count > 2) else {
            let protocol = "a free oscillation";
            return Err(KeratinError::Readings { protocol, needed: 3, found: count });
        };
        let oscillations = (count - 1) as f64;
        Ok(Self {
            period: (last.0 - first.0) / oscillations,
            log_decrement: ((first.1 - rest) / (last.1 - rest)).ln() / oscillations,
        })
    }

    /// Angular frequency without damping, rad/s, which is higher than the measured one.
    #[must_use]
    pub fn natural_frequency(&self) -> f64 {
        (4.0 * PI * PI + self.log_decrement.powi(2)).sqrt() / self.period
    }

    /// Loss over storage modulus, `tan delta = G2 / G1`, at the natural frequency.
    ///
    /// `2 d / sqrt(4 pi^2 + d^2)`; for small decrements `d / pi`, as the thesis has it.
    #[must_use]
    pub fn loss_tangent(&self) -> f64 {
        2.0 * self.log_decrement / (4.0 * PI * PI + self.log_decrement.powi(2)).sqrt()
    }
}

/// Vertex of the parabola through three points.
fn vertex(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> (f64, f64) {
    let (h0, h1) = (b.0 - a.0, c.0 - b.0);
    let (s0, s1) = ((b.1 - a.1) / h0, (c.1 - b.1) / h1);
    let bend = (s1 - s0) / (h0 + h1);
    let slope = s0 + bend * h0;
    let shift = -0.5 * slope / bend;
    (b.0 + shift, b.1 + 0.5 * slope * shift)
}

/// Storage and loss modulus in bending, Pa, of a clamped rod of `length` (m), `linear_density`
/// (kg/m) and second moment of area (m^4) that swings in its lowest mode.
///
/// # Errors
/// [`KeratinError::NotPositive`] for a length, density or moment that is not positive and finite.
pub fn moduli(
    reading: &Oscillation,
    length: f64,
    linear_density: f64,
    second_moment: f64,
) -> Result<[f64; 2], KeratinError> {
    positive("length (m)", length)?;
    positive("linear density (kg/m)", linear_density)?;
    positive("second moment of area (m^4)", second_moment)?;
    let scaled = reading.natural_frequency() * (length / CANTILEVER).powi(2);
    let storage = linear_density * scaled * scaled / second_moment;
    Ok([storage, storage * reading.loss_tangent()])
}

/// Retardation time, s, of a Kelvin-Voigt rod with the given loss tangent at an angular frequency,
/// rad/s.
#[must_use]
pub fn damping_time(loss_tangent: f64, frequency: f64) -> f64 {
    loss_tangent / frequency
}
