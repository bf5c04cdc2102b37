//! Elastic moduli of a hair in a climate.
//!
//! Base values are those of table 2.9 (or 2.6, 2.10); ratios carry them to other climates, as the
//! spread between studies exceeds the effect of humidity. The curves between are described in the
//! thesis by figures without values; taken here, with `R` the regain:
//!
//! - from 65 % to 100 % humidity, `ln E` falls in proportion to `R`, by the ratio of table 2.9;
//! - from 60 % to 65 % it is constant, as table 2.9 holds for both;
//! - below, `ln E` rises with falling `R` as fast as between 6 % and 53 % in table 2.5 (sound in
//!   human hair), and `ln G` such that it reaches 1.70 GPa in dry air (line 610, a composite like
//!   wool: assumed);
//! - with temperature, `ln E` is constant from 20 to 25 C, reaches what line 468 says of wet hair
//!   at 40 C and at 90 C (the two values exchanged, see [`crate::inconsistencies`]) and is linear
//!   between. For hair in air it is the same factor, refused or marked outside of 20 to 30 C; the
//!   moduli in bending and torsion are assumed to have it too.

use crate::climate::{Climate, Humidity, MeasuredValue, Standing};
use crate::hair::{Hair, Thickness, Treatment};
use crate::tables::{Modulus, Source, number, range, tables};
use crate::{KeratinError, water};
use nalgebra::Vector3;
use rapunzel_fiber::NodeProperties;
use std::f64::consts::PI;
use std::sync::LazyLock;

const GIGA: f64 = 1e9;
/// Row of the modulus in tension in table 2.9.
const STRETCHING: usize = 0;
/// Row of the modulus in bending in table 2.9.
const BENDING: usize = 1;
/// Row of the modulus in torsion in table 2.9.
const TORSION: usize = 2;

/// Parameters of the curves, computed once.
struct Anchors {
    /// Regain at 60, 65 and 100 % humidity.
    regain: [f64; 3],
    /// `d ln E / dR` below 60 % humidity, of Young's modulus and of the shear modulus; positive.
    steepness: [f64; 2],
    /// Pairs of temperature (20, 25, 40 and 90 C) and logarithm of the temperature factor.
    warmth: [[f64; 2]; 4],
    /// Mean modulus of thin hairs in table 2.6, Pa.
    thin: f64,
    /// Mean modulus of thick hairs in table 2.6, Pa.
    thick: f64,
}

static ANCHORS: LazyLock<Anchors> = LazyLock::new(|| {
    let at = |h: f64| water::value_at(&Climate { humidity: humidity(h), ..Climate::STANDARD });
    let regain = [at(0.60), at(0.65), at(1.0)];
    let [damp, moist] = [&tables().sound.rows[0], &tables().sound.rows[1]];
    let stretching = (damp.e / moist.e).ln() / (at(moist.rh / 100.0) - at(damp.rh / 100.0));
    let [torsion, tension] = [TORSION, STRETCHING].map(|row| &tables().moduli.rows[row]);
    let ([_, dry], _) = range("g_longitudinal_initial");
    let wet = tension.modulus / tension.ratio_65_100;
    // The two values in water are exchanged.
    let (warm, hot) = (number("e_water_90c").0, number("e_water_40c").0);
    let rows = &tables().nikiforidis.rows;
    let mean = |e: fn(&crate::tables::Nikiforidis) -> f64| {
        GIGA * rows.iter().map(e).sum::<f64>() / rows.len() as f64
    };
    Anchors {
        regain,
        steepness: [stretching, (dry / torsion.modulus).ln() / regain[0]],
        warmth: [[20.0, 0.0], [25.0, 0.0], [40.0, (warm / wet).ln()], [90.0, (hot / wet).ln()]],
        thin: mean(|row| row.e_thin),
        thick: mean(|row| row.e_thick),
    }
});

/// A humidity from a constant of this file.
fn humidity(fraction: f64) -> Humidity {
    Humidity::new(fraction).unwrap_or(Humidity::STANDARD)
}

/// A modulus at 65 % humidity and its dependence on humidity.
struct ModulusCurve {
    quantity: &'static str,
    at_standard: f64,
    /// Ratio by which the modulus falls from 65 % to 100 % humidity.
    drop: f64,
    /// Index of the steepness that holds below 60 % humidity, and the standing of values there.
    dry: (usize, Standing),
    sources: Vec<Source>,
}

impl ModulusCurve {
    fn of(quantity: &'static str, row: usize, dry: (usize, Standing)) -> Self {
        let Modulus { modulus, ratio_65_100, .. } = tables().moduli.rows[row];
        let sources = vec![tables().moduli.row_source(row)];
        Self { quantity, at_standard: GIGA * modulus, drop: ratio_65_100, dry, sources }
    }

    /// Humidity factor of the modulus at a regain, 1 at 65 % humidity.
    fn factor(&self, regain: f64) -> f64 {
        let Anchors { regain: [low, standard, wet], steepness, .. } = &*ANCHORS;
        if regain >= *wet {
            1.0 / self.drop
        } else if regain > *standard {
            self.drop.powf((standard - regain) / (wet - standard))
        } else if regain < *low {
            (steepness[self.dry.0] * (low - regain)).exp()
        } else {
            1.0
        }
    }

    fn at(self, hair: &Hair, climate: &Climate) -> Result<MeasuredValue, KeratinError> {
        let h = climate.humidity.fraction();
        let by_humidity = if h == 1.0 || (0.60..=0.65).contains(&h) {
            Standing::Measured
        } else if h > 0.65 {
            Standing::Interpolated
        } else {
            hair.outside.judge(self.quantity, "humidity", h, [0.06, 1.0], self.dry.1)?
        };
        let (warmth, by_warmth) = warmth(hair, climate, self.quantity)?;
        let value = self.at_standard * self.factor(water::value_at(climate)) * warmth;
        let mut sources = self.sources;
        if h < 0.60 {
            let wool = range("g_longitudinal_initial").1;
            sources.push(if self.dry.0 == 0 { tables().sound.row_source(0) } else { wool });
        }
        if warmth != 1.0 {
            sources.push(number("e_water_40c").1);
        }
        Ok(MeasuredValue { value, standing: by_humidity.max(by_warmth), sources })
    }
}

/// Temperature factor of a modulus.
fn warmth(
    hair: &Hair,
    climate: &Climate,
    quantity: &'static str,
) -> Result<(f64, Standing), KeratinError> {
    let t = climate.temperature.celsius();
    let wet = climate.humidity == Humidity::SATURATED;
    let range = if wet { [20.0, 90.0] } else { [20.0, 30.0] };
    let curved = t > 25.0;
    let inside = if curved { Standing::Assumed } else { Standing::Measured };
    let standing = hair.outside.judge(quantity, "temperature (C)", t, range, inside)?;
    let anchors = &ANCHORS.warmth;
    let last = anchors.len() - 2;
    let i = anchors[1..].iter().position(|[end, _]| t < *end).unwrap_or(last).min(last);
    let ([t0, y0], [t1, y1]) = (anchors[i], anchors[i + 1]);
    Ok(((y0 + (y1 - y0) * (t - t0) / (t1 - t0)).exp(), standing))
}

impl Hair {
    /// Young's modulus in tension, Pa.
    ///
    /// # Errors
    /// [`KeratinError::Outside`] outside the measured range, unless the hair's values are marked.
    pub fn stretching_modulus(&self, climate: &Climate) -> Result<MeasuredValue, KeratinError> {
        let mut curve =
            ModulusCurve::of("Young's modulus in tension", STRETCHING, (0, Standing::Interpolated));
        let class = match self.thickness {
            Thickness::Any => None,
            Thickness::Thin => Some(ANCHORS.thin),
            Thickness::Thick => Some(ANCHORS.thick),
        };
        if let Some(mean) = class {
            let at = Climate { humidity: humidity(0.45), ..Climate::STANDARD };
            curve.at_standard = mean / curve.factor(water::value_at(&at));
            curve.sources.push(tables().nikiforidis.row_source(0));
        }
        curve.at(self, climate)
    }

    /// Young's modulus in bending, Pa; for a class of diameter, in the same ratio to the modulus in
    /// tension as for any hair.
    ///
    /// # Errors
    /// As [`Hair::stretching_modulus`].
    pub fn bending_modulus(&self, climate: &Climate) -> Result<MeasuredValue, KeratinError> {
        let mut bending =
            ModulusCurve::of("Young's modulus in bending", BENDING, (0, Standing::Assumed))
                .at(self, climate)?;
        if self.thickness != Thickness::Any {
            let any = self.of_thickness(Thickness::Any).stretching_modulus(climate)?;
            let own = self.stretching_modulus(climate)?;
            bending.value *= own.value / any.value;
            bending.standing = Standing::Assumed;
            bending.sources.extend(own.sources);
        }
        Ok(bending)
    }

    /// Shear modulus, Pa. It is not computed from Young's modulus, since hair is not isotropic.
    ///
    /// Treated hair: table 2.10 gives the rigidity `G A^2` at 100 % over that at 65 %, and the
    /// section swells as [`water::swelling`] has it.
    ///
    /// # Errors
    /// As [`Hair::stretching_modulus`].
    pub fn shear_modulus(&self, climate: &Climate) -> Result<MeasuredValue, KeratinError> {
        let mut curve = ModulusCurve::of("shear modulus", TORSION, (1, Standing::Assumed));
        if let Some(index) = self.treatment.row() {
            let row = &tables().torsion.rows[index];
            let wider =
                self.section(&Climate::WET).area() / self.section(&Climate::STANDARD).area();
            curve.at_standard = GIGA * row.g;
            curve.drop = wider * wider / row.rigidity_ratio;
            curve.sources = vec![tables().torsion.row_source(index)];
        }
        curve.at(self, climate)
    }

    /// Logarithmic decrement of a torsion pendulum (2.14), table 2.10 at 65 % humidity. It rises
    /// with humidity (line 829), but the thesis does not say by how much: extrapolated values are
    /// the same everywhere.
    ///
    /// # Errors
    /// As [`Hair::stretching_modulus`].
    pub fn log_decrement(&self, climate: &Climate) -> Result<MeasuredValue, KeratinError> {
        let index = self.treatment.row().unwrap_or(0);
        let h = climate.humidity.fraction();
        let standing = self.outside.judge(
            "logarithmic decrement",
            "humidity",
            h,
            [0.65, 0.65],
            Standing::Measured,
        )?;
        let decrement = tables().torsion.rows[index].log_decrement;
        Ok(MeasuredValue::new(decrement, standing, &[tables().torsion.row_source(index)]))
    }

    /// Loss modulus in torsion, Pa: `decrement * G / pi`.
    ///
    /// # Errors
    /// As [`Hair::log_decrement`].
    pub fn torsional_loss_modulus(&self, climate: &Climate) -> Result<MeasuredValue, KeratinError> {
        let (g, decrement) = (self.shear_modulus(climate)?, self.log_decrement(climate)?);
        let sources = [g.sources, decrement.sources].concat();
        let standing = g.standing.max(decrement.standing);
        Ok(MeasuredValue { value: decrement.value * g.value / PI, standing, sources })
    }

    /// Bending stiffnesses about d1 and d2 and torsional stiffness, N m^2: `(E_B I1, E_B I2, G J)`
    /// with the torsion constant J of the ellipse.
    ///
    /// # Errors
    /// As [`Hair::stretching_modulus`].
    pub fn stiffness(&self, climate: &Climate) -> Result<Vector3<f64>, KeratinError> {
        let section = self.section(climate);
        let [i1, i2, _] = section.second_moments();
        let e = self.bending_modulus(climate)?.value;
        let g = self.shear_modulus(climate)?.value;
        Ok(Vector3::new(e * i1, e * i2, g * section.torsion_constant()))
    }

    /// Section, density and stiffness of a straight hair in this climate, as a rod needs them.
    ///
    /// # Errors
    /// As [`Hair::stretching_modulus`].
    pub fn node(&self, climate: &Climate) -> Result<NodeProperties, KeratinError> {
        let section = self.section(climate);
        let [i1, i2, i3] = section.second_moments();
        let density = self.density(climate).value;
        Ok(NodeProperties {
            section,
            linear_density: density * section.area(),
            rotary_inertia: density * Vector3::new(i1, i2, i3),
            stiffness: self.stiffness(climate)?,
            natural_curvature: Vector3::zeros(),
        })
    }
}

impl Treatment {
    /// Row of the treatment in table 2.10, `None` for no treatment.
    fn row(self) -> Option<usize> {
        (self as usize).checked_sub(1)
    }
}

/// Storage and loss modulus in bending, Pa, of an oscillating rod: 25 C, 75 % humidity (line 638).
#[must_use]
pub fn oscillating_moduli() -> [MeasuredValue; 2] {
    ["storage_modulus", "loss_modulus"].map(|key| {
        let (value, source) = number(key);
        MeasuredValue::new(GIGA * value, Standing::Measured, &[source])
    })
}

/// Speed of sound along a hair, m/s, and the modulus that it shows, Pa: table 2.5, 6 to 53 %
/// humidity. At these rates hair is twice as stiff as in a tensile test.
///
/// # Errors
/// [`KeratinError::Outside`] beyond these humidities, unless values are marked.
pub fn sound(
    humidity: Humidity,
    outside: crate::Outside,
) -> Result<[MeasuredValue; 2], KeratinError> {
    let [damp, moist] = [&tables().sound.rows[0], &tables().sound.rows[1]];
    let range = [damp.rh / 100.0, moist.rh / 100.0];
    let h = humidity.fraction();
    let inside = if range.contains(&h) { Standing::Measured } else { Standing::Interpolated };
    let standing = outside.judge("speed of sound", "humidity", h, range, inside)?;
    let at =
        |h: f64| water::value_at(&Climate { humidity: self::humidity(h), ..Climate::STANDARD });
    let part = (at(h) - at(range[0])) / (at(range[1]) - at(range[0]));
    let between =
        |from: f64, to: f64| if h == range[1] { to } else { from * (to / from).powf(part) };
    let sources = [0, 1].map(|row| tables().sound.row_source(row));
    Ok([1e3 * between(damp.v_s, moist.v_s), GIGA * between(damp.e, moist.e)]
        .map(|value| MeasuredValue::new(value, standing, &sources)))
}
