use crate::KeratinError;
use crate::climate::Climate;
use crate::error::positive;
use crate::hair::Hair;
use crate::tables::{Value, fact, number};

/// A fibre in tension beyond Hooke's law: a Hookean region, a yield region and a post-yield region
/// (thesis 2.4.1.2), and unloading along a lower path, as in water, where 30 % and more are fully
/// recovered (figure 2.10).
///
/// The stress follows strain with the Hookean modulus between two paths: the upper one, with slopes
/// in the ratio 100:1:10, and the lower one, `recovery` times the upper. The stress is independent
/// of rate, and the law passive: slopes of the paths are at most the Hookean modulus. Compression
/// is Hookean. Not included is the residual strain that a dry fibre keeps for hours after a strain
/// beyond yield.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tension {
    modulus: f64,
    /// Strains at the ends of the Hookean and of the yield region, and at break.
    limits: [f64; 3],
    /// Slopes of the three regions, Pa.
    slopes: [f64; 3],
    recovery: f64,
    strain: f64,
    stress: f64,
}

impl Tension {
    /// A fibre of the given modulus, Pa; `recovery` in `[0, 1]` is the ratio of the stress on
    /// unloading to the stress on loading, 1 for an elastic fibre.
    ///
    /// Limits are those of the thesis: 2 % and 30 % more (line 472), 50 % at break (line 664).
    ///
    /// # Errors
    /// [`KeratinError::NotPositive`] for the modulus, [`KeratinError::Part`] for the recovery.
    pub fn new(modulus: f64, recovery: f64) -> Result<Self, KeratinError> {
        positive("Young's modulus (Pa)", modulus)?;
        if !(0.0..=1.0).contains(&recovery) {
            let quantity = "stress on the way back, in parts of that on the way up,";
            return Err(KeratinError::Part { quantity, value: recovery });
        }
        let hooke = number("hookean_limit_strain").0 / 100.0;
        let yields = number("yield_region_strain").0 / 100.0;
        let ratios = match fact("slope_ratio_hooke_yield_post").map(|f| &f.value) {
            Some(Value::List(ratios)) => [1.0, ratios[1] / ratios[0], ratios[2] / ratios[0]],
            _ => unreachable!("the ratios of slopes are three numbers"),
        };
        Ok(Self {
            modulus,
            limits: [hooke, hooke + yields, number("break_strain_normal").0 / 100.0],
            slopes: ratios.map(|ratio| ratio * modulus),
            recovery,
            strain: 0.0,
            stress: 0.0,
        })
    }

    /// A hair in a climate: its modulus in tension; in water it breaks at 100 % instead of 50 %
    /// strain, and in between in proportion.
    ///
    /// # Errors
    /// As [`Hair::stretching_modulus`] and [`Tension::new`].
    pub fn of(hair: &Hair, climate: &Climate, recovery: f64) -> Result<Self, KeratinError> {
        let [normal, humid] =
            ["break_strain_normal", "break_strain_humid"].map(|key| number(key).0 / 100.0);
        let standard = Climate::STANDARD.humidity.fraction();
        let more = (climate.humidity.fraction() - standard).max(0.0) / (1.0 - standard);
        let mut tension = Self::new(hair.stretching_modulus(climate)?.value, recovery)?;
        tension.limits[2] = normal + (humid - normal) * more;
        Ok(tension)
    }

    /// The strain at which the fibre breaks.
    #[must_use]
    pub fn break_strain(&self) -> f64 {
        self.limits[2]
    }

    /// Present strain.
    #[must_use]
    pub fn strain(&self) -> f64 {
        self.strain
    }

    /// Present stress, Pa.
    #[must_use]
    pub fn stress(&self) -> f64 {
        self.stress
    }

    /// Stress on first loading at a strain, Pa.
    #[must_use]
    pub fn envelope(&self, strain: f64) -> f64 {
        let [hooke, yields, _] = self.limits;
        let [s0, s1, s2] = self.slopes;
        s0 * strain.min(hooke)
            + s1 * (strain.min(yields) - hooke).max(0.0)
            + s2 * (strain - yields).max(0.0)
    }

    /// Moves to `strain` and returns the stress, Pa; `None` if the fibre would break on the way,
    /// and then nothing changes. A monotonic path may be divided into any number of calls.
    pub fn strain_to(&mut self, strain: f64) -> Option<f64> {
        if !strain.is_finite() || strain > self.limits[2] {
            return None;
        }
        let upper = self.envelope(strain);
        let lower = if strain > 0.0 { self.recovery * upper } else { upper };
        let elastic = self.stress + self.modulus * (strain - self.strain);
        // Both paths rise more slowly than Hooke's line: once on one, it stays until turned.
        self.stress = elastic.clamp(lower, upper);
        self.strain = strain;
        Some(self.stress)
    }

    /// Work per volume, Pa, that the fibre would return if slowly unloaded: the area below the
    /// lower path and Hooke's line down to it.
    #[must_use]
    pub fn available_work(&self) -> f64 {
        if self.strain <= 0.0 {
            return 0.5 * self.modulus * self.strain * self.strain;
        }
        // Where Hooke's line meets the lower path: the difference falls with falling strain.
        let (mut low, mut high) = (0.0, self.strain);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let line = self.stress + self.modulus * (middle - self.strain);
            if line > self.recovery * self.envelope(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let met = self.recovery * self.envelope(high);
        0.5 * (self.stress + met) * (self.strain - high) + self.recovery * self.area(high)
    }

    /// Area below the upper path up to a strain, Pa.
    fn area(&self, strain: f64) -> f64 {
        let [hooke, yields, _] = self.limits;
        let corners = [0.0, strain.min(hooke), strain.min(yields), strain];
        corners
            .windows(2)
            .map(|w| 0.5 * (self.envelope(w[0]) + self.envelope(w[1])) * (w[1] - w[0]))
            .sum()
    }
}
