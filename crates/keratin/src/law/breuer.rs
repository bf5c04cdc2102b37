use crate::climate::{Humidity, Temperature};
use crate::tables::number;

/// The gas constant, J / (mol K).
const GAS_CONSTANT: f64 = 8.314_462_618;

/// Breuer's equation (2.10): the force at equilibrium of a stretched network that melts,
/// `f = dH/dL (1 - T / T_S) + R T / dL ln((1 + K1 a) / (1 + K2 a))`.
///
/// The thesis gives `dH` and `dL` per gram and the `K` per mole; here all is per gram, with the
/// molar mass of a residue. It gives no melting temperature. `K1` and `K2` are probably exchanged
/// in print: with them as printed the force rises with humidity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breuer {
    /// Enthalpy `dH`, J/kg.
    pub enthalpy: f64,
    /// Length `dL`, m/kg.
    pub length: f64,
    /// Melting temperature `T_S` of dry hair.
    pub melting: Temperature,
    /// Binding constants of water, `K1` at a crystalline and `K2` at an amorphous residue.
    pub binding: [f64; 2],
    /// Mean molar mass of a residue, kg/mol.
    pub residue: f64,
}

impl Breuer {
    /// Breuer's equation for hair that melts dry at the given temperature, with the numbers of line
    /// 695, the binding constants exchanged, and 0.11 kg/mol for a residue.
    #[must_use]
    pub fn hair(melting: Temperature) -> Self {
        Self {
            enthalpy: 1e3 * number("melt_enthalpy").0,
            length: 10.0 * number("melt_length_change").0,
            melting,
            binding: [number("k2_amorphous").0, number("k1_crystalline").0],
            residue: 0.11,
        }
    }

    /// Equilibrium force, N, at a temperature and a humidity, which is the activity of the water.
    #[must_use]
    pub fn force(&self, temperature: Temperature, humidity: Humidity) -> f64 {
        let (t, a) = (temperature.kelvin(), humidity.fraction());
        let [k1, k2] = self.binding;
        let melting = self.enthalpy / self.length * (1.0 - t / self.melting.kelvin());
        let mixing = GAS_CONSTANT / self.residue * t / self.length;
        melting + mixing * ((1.0 + k1 * a) / (1.0 + k2 * a)).ln()
    }
}
