//! The laboratory: the instruments of chapter 2, run on simulated hairs.
//!
//! Each instrument builds a fibre or a tress of a [`LabSample`], moves it, and evaluates what it
//! reads by the formula of [`rapunzel_keratin::lab`]. Where the reading is a number that was put
//! into the hair, both are told.

mod bending;
mod curls;
mod friction;
mod sample;
mod tension;
mod torsion;
mod tress;

pub use sample::{LabSample, Number, Reading, Record};

use crate::SimError;
use rapunzel_keratin::lab::Instrument;

/// Measures a sample. Costs milliseconds (tensile test) to some ten seconds (combing).
///
/// # Errors
/// [`SimError::Laboratory`] where the sample is not known in the climate; [`SimError::Coupling`]
/// and others if its hair cannot be moved.
pub fn measure(instrument: Instrument, sample: &LabSample) -> Result<Reading, SimError> {
    match instrument {
        Instrument::Tensile => tension::tensile(sample),
        Instrument::Hysteresis => tension::hysteresis(sample),
        Instrument::Hook => bending::hook(sample),
        Instrument::Oscillation => bending::oscillation(sample),
        Instrument::Pendulum => torsion::pendulum(sample),
        Instrument::Capstan => friction::capstan(sample),
        Instrument::Waviness => curls::waviness(sample),
        Instrument::CurlRetention => curls::retention(sample),
        Instrument::TressVolume => tress::volume(sample),
        Instrument::Combing => tress::combing(sample),
    }
}
