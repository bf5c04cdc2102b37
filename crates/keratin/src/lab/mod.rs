//! The instruments of chapter 2: their readings as numbers, and the fibres for them.
//!
//! Each module is one instrument. It evaluates readings by the formula of the thesis, with the bias
//! of that formula where it has one, and builds the fibre for a simulation that gives the readings.
//! Motion is simulated elsewhere: `rapunzel-sim` runs all [`Instrument`]s, also those that need
//! contacts, and the tests of this crate run some with rods at rest and in motion.

use crate::KeratinError;
use crate::error::named;
use crate::hair::names;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

pub mod curl;
pub mod hook;
pub mod oscillation;
pub mod pendulum;
pub mod tensile;
pub mod tress;

names! {
    /// The instruments of the laboratory.
    Instrument, "instrument" {
        /// Stress over strain until the fibre breaks: Young's modulus in tension.
        Tensile = "tensile",
        /// Stress over strain to 30 % and back: the hysteresis ratio.
        Hysteresis = "hysteresis",
        /// A balanced fibre over a thin hook: Young's modulus in bending.
        Hook = "hook",
        /// A torsion pendulum: shear modulus and logarithmic decrement.
        Pendulum = "pendulum",
        /// A swinging rod: storage and loss modulus in bending.
        Oscillation = "oscillation",
        /// A fibre drawn over a cylinder: the coefficient of friction.
        Capstan = "capstan",
        /// Waves and their stretch: Robbins and Reich's waviness.
        Waviness = "waviness",
        /// A water wave after three hours: the curl retention index.
        CurlRetention = "curl-retention",
        /// The volume that the hairs of a tress occupy.
        TressVolume = "tress-volume",
        /// A comb drawn through a tress: its force.
        Combing = "combing",
    }
}
