use super::{MaxwellElement, Relaxation};
use crate::KeratinError;
use crate::tables::number;

/// Ages of Chapman's classes, s: 10, 100 and 1000 minutes, and one decade more for his class
/// "highly aged".
const CLASSES: [f64; 4] = [600.0, 6e3, 6e4, 6e5];

/// A keratin that stiffens with its age, the time since it was last soaked (thesis, lines 566 to
/// 587): the relaxation function is shifted up by the same modulus for each decade.
///
/// Between classes it is interpolated in the logarithm of the age; below and above, the nearest
/// class is taken. With the state of the material, time is no longer invariant, and Boltzmann's
/// principle is replaced by Chapman's modified superposition, [`Aging::stress`].
#[derive(Debug, Clone, PartialEq)]
pub struct Aging {
    /// Relaxation function `G` at an age of 10 minutes, Pa.
    young: Relaxation,
    /// Shift of the relaxation function per decade of age, Pa.
    shift: f64,
}

impl Aging {
    /// A material whose relaxation function at an age of ten minutes is `young`, Pa, shifted up by
    /// `shift`, Pa, per decade of age.
    ///
    /// # Errors
    /// [`KeratinError::Negative`] for a negative shift.
    pub fn new(young: Relaxation, shift: f64) -> Result<Self, KeratinError> {
        crate::error::not_negative("shift of the modulus per decade of age (Pa)", shift)?;
        Ok(Self { young, shift })
    }

    /// Chapman's merino wool: 4.0 GPa after a minute (line 558) when it is highly aged, 0.3 GPa
    /// less for each class below (line 575, printed without its factor 1e5). The loss per decade of
    /// time is only drawn (figure 2.6); assumed is that it equals the shift, over 0.1 to 1000
    /// minutes.
    ///
    /// # Errors
    /// Never fails: the numbers are those of the tables.
    pub fn wool() -> Result<Self, KeratinError> {
        let shift = 1e9 * number("relaxation_modulus_shift_per_ageing_class").0;
        let aged = 1e9 * number("relaxation_modulus_bending_1min").0;
        let classes = (CLASSES.len() - 1) as f64;
        let young = Relaxation::logarithmic(aged - classes * shift, 60.0, shift, [6.0, 6e4])?;
        Self::new(young, shift)
    }

    /// The relaxation function (Pa) at an age, s.
    #[must_use]
    pub fn at_age(&self, age: f64) -> Relaxation {
        let more = self.shift * decades(age);
        let branches: Vec<MaxwellElement> = self.young.branches().to_vec();
        // Larger than the equilibrium modulus of the young material, which is valid.
        Relaxation::new(self.young.equilibrium() + more, branches)
            .unwrap_or_else(|_| self.young.clone())
    }

    /// The modified superposition `sigma(t) = sum_i dE_i G(t_A, t - tau_i)`: the age at the time of
    /// observation selects the relaxation function. `steps` are `(time, strain increment)`, s, and
    /// `age_at_start` is the age at time 0.
    #[must_use]
    pub fn stress(&self, steps: &[(f64, f64)], t: f64, age_at_start: f64) -> f64 {
        self.at_age(age_at_start + t).stress(steps, t)
    }
}

/// Number of decades from the age of the youngest class to `age`, limited to the range of the
/// classes.
fn decades(age: f64) -> f64 {
    (age.clamp(CLASSES[0], CLASSES[3]) / CLASSES[0]).log10()
}
