use super::{MaxwellElement, MaxwellModel, Viscoelastic};
use crate::climate::{Climate, Temperature};
use crate::hair::Hair;
use crate::tables::number;
use crate::{KeratinError, water};

/// Transition temperature of dry hair, K: 144 C, Wortmann, Stapels, Elliott, Chandra, Biopolymers
/// 81 (2006) 371, who find that Fox's equation holds for hair.
const DRY: f64 = 417.15;
/// Relaxation time at a transition, s: assumed, the usual one of a glass.
const AT_TRANSITION: f64 = 100.0;
/// Temperature change, K, that changes a relaxation time tenfold: assumed.
const PER_DECADE: f64 = 10.0;
/// Decades from the relaxation time at the transition to those of the five elements of the
/// component of `T_c^l`: wool's are evenly distributed over 0.1 to 1000 minutes (thesis, line 562).
const SPREAD: [f64; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0];
/// Largest number of decades from the relaxation time at the transition: beyond, solid is solid and
/// fluid is fluid.
const MOST_DECADES: f64 = 12.0;
/// Relaxation time of the helices, s: assumed.
const HELICES: f64 = 3600.0;
/// Number of steps of a release.
const STEPS: i32 = 64;

/// The temperatures `T_c^l` and `T_c^h` at which the two components of Nagase's model change from
/// solid to plastic.
///
/// In water they are 0 and 70 C (thesis, line 718). They move with the moisture content M; the
/// thesis says upward in line 718 and downward in line 740, which is what lets a water wave hold
/// and is taken here. `T_c^l` follows Fox's equation `1/T = (1 - M)/T_dry + M/T_w` with `T_dry` =
/// 144 C (Wortmann 2006) and `T_w` = 127 K such that it is 0 C at saturation; `T_c^h` is assumed to
/// stay 70 K above.
#[must_use]
pub fn transitions(climate: &Climate) -> [Temperature; 2] {
    let [low, high] = ["transition_temperature_low_wet", "transition_temperature_high_wet"]
        .map(|key| number(key).0);
    let wet = Temperature::ROOM.kelvin() - Temperature::ROOM.celsius() + low;
    let saturated = water::content(water::saturation());
    let of_water = saturated / (1.0 / wet - (1.0 - saturated) / DRY);
    let content = water::content(water::value_at(climate));
    let kelvin = 1.0 / ((1.0 - content) / DRY + content / of_water);
    let celsius = kelvin - wet + low;
    // Finite and above absolute zero for any content in [0, 1].
    [celsius, celsius + high - low].map(|t| Temperature::new(t).unwrap_or(Temperature::ROOM))
}

/// Nagase's model of a bent hair (thesis 2.4.6, figure 2.15): side by side, a component that is
/// plastic above `T_c^l`, one that is plastic above `T_c^h`, and the helices, a Maxwell element.
///
/// The thesis draws the first as a dashpot and the second as a spring, which are there below their
/// temperatures and gone above. Here both are Maxwell elements whose relaxation time changes
/// tenfold for every 10 K, 100 s at the transition (assumed): so each is the spring of a solid far
/// below and nothing far above, and remembers, when it becomes solid, the shape in which it did.
/// The first is five elements in equal parts, each ten times slower than the one before: four
/// decades, as in wool.
///
/// Moduli are those in bending: what is lost from 65 % to 100 % humidity belongs to the first; of
/// the rest, 1.2 parts to the spring and 0.2 to the helices, as line 699 divides it.
///
/// The model is passive: the climate changes relaxation times, not moduli.
#[derive(Debug, Clone, PartialEq)]
pub struct ThreeElement {
    strand: MaxwellModel,
    climate: Climate,
}

impl ThreeElement {
    /// A hair in its natural shape, in a climate.
    ///
    /// # Errors
    /// Never fails: the moduli are evaluated where they are measured.
    pub fn new(hair: &Hair, climate: Climate) -> Result<Self, KeratinError> {
        Ok(Self { strand: MaxwellModel::of(0.0, elements(hair, &climate)?), climate })
    }

    /// The law of a hair's section in a climate, for a rod: stiffnesses as at 65 % humidity, all
    /// three with the fractions of the modulus in bending. The memory of sections stays valid when
    /// the law is replaced by the law of another climate.
    ///
    /// # Errors
    /// Never fails, as [`ThreeElement::new`].
    pub fn section(hair: &Hair, climate: &Climate) -> Result<Viscoelastic, KeratinError> {
        let mut parts = elements(hair, climate)?;
        let whole = hair.bending_modulus(&Climate::STANDARD)?.value;
        parts.iter_mut().for_each(|element| element.modulus /= whole);
        Ok(Viscoelastic::of(hair.stiffness(&Climate::STANDARD)?, parts))
    }

    /// Sets the climate, at once throughout the hair.
    pub fn enter(&mut self, climate: Climate) {
        self.strand.set_times(times(&climate));
        self.climate = climate;
    }

    /// Present climate.
    #[must_use]
    pub fn climate(&self) -> &Climate {
        &self.climate
    }

    /// Present strain, or curvature less the natural one in any unit.
    #[must_use]
    pub fn strain(&self) -> f64 {
        self.strand.strain()
    }

    /// Stored energy per volume, Pa times the square of the unit of strain.
    #[must_use]
    pub fn stored_energy(&self) -> f64 {
        self.strand.stored_energy()
    }

    /// Moves linearly to a strain within `dt` seconds, and returns stress and work.
    pub fn bend_to(&mut self, strain: f64, dt: f64) -> super::RelaxationStep {
        self.strand.strain_to(strain, dt)
    }

    /// Releases the hair for a time, s, and returns the strain at its end. The first step is at
    /// once; the others grow with time, 64 in all, so that the strain is accurate to about one
    /// percent of the strain at the release.
    pub fn release(&mut self, seconds: f64) -> f64 {
        self.strand.stress_to(0.0, 0.0);
        let at = |i: i32| seconds * (f64::from(i) / f64::from(STEPS)).powi(3);
        for i in 0..STEPS {
            self.strand.stress_to(0.0, at(i + 1) - at(i));
        }
        self.strain()
    }

    /// A water wave: wound wet (23 C) to a strain of 1, held for `wet` seconds, dried in `air` for
    /// `drying` seconds, and released. Its strain is then the fraction of the winding that it kept.
    ///
    /// # Errors
    /// As [`ThreeElement::new`].
    pub fn water_wave(
        hair: &Hair,
        wet: f64,
        air: Climate,
        drying: f64,
    ) -> Result<Self, KeratinError> {
        let mut wave = Self::new(hair, Climate::WET)?;
        wave.bend_to(1.0, 1.0);
        wave.bend_to(1.0, wet);
        wave.enter(air);
        wave.bend_to(1.0, drying);
        wave.release(0.0);
        Ok(wave)
    }
}

/// The elements, in a fixed order: those that are soft above `T_c^l`, the one above `T_c^h`, the
/// helices.
fn elements(hair: &Hair, climate: &Climate) -> Result<Vec<MaxwellElement>, KeratinError> {
    let glassy = hair.bending_modulus(&Climate::STANDARD)?.value;
    let wet = hair.bending_modulus(&Climate::WET)?.value;
    let [fibrils, matrix] = ["microfibril_modulus", "matrix_modulus"].map(|key| number(key).0);
    let spring = wet * fibrils / (fibrils + matrix);
    let soft = SPREAD.map(|_| (glassy - wet) / SPREAD.len() as f64);
    let moduli = soft.into_iter().chain([spring, wet - spring]);
    Ok(moduli.zip(times(climate)).map(|(modulus, time)| MaxwellElement { modulus, time }).collect())
}

/// Relaxation times of the elements in a climate, s, in the same order.
fn times(climate: &Climate) -> impl Iterator<Item = f64> {
    let celsius = climate.temperature.celsius();
    let time = move |transition: Temperature, spread: f64| {
        let below = (transition.celsius() - celsius) / PER_DECADE;
        AT_TRANSITION * 10_f64.powf(below.clamp(-MOST_DECADES, MOST_DECADES) + spread)
    };
    let [low, high] = transitions(climate);
    SPREAD.into_iter().map(move |spread| time(low, spread)).chain([time(high, 0.0), HELICES])
}
