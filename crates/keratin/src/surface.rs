//! Surface properties of hair: friction, electric resistance, waviness, and bonds of hair spray.

use crate::climate::{Climate, Humidity, MeasuredValue, Outside, Standing, Temperature};
use crate::error::named;
use crate::hair::names;
use crate::tables::{FrictionRow, Source, number, range, tables};
use crate::{KeratinError, water};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

names! {
    /// Direction of sliding, table 2.11.
    Direction, "direction" {
        /// Sliding with the scales: from root to tip of the hair that slides.
        WithScales = "with the scales",
        /// Sliding against the scales: from tip to root of the hair that slides.
        AgainstScales = "against the scales",
        /// Between fibres that point in the same direction, sliding either way.
        SameWay = "same way",
    }
}

/// Whether the surfaces in contact are wet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wetness {
    /// Dry: in air.
    Dry,
    /// Wet: with water on the surfaces.
    Wet,
}

/// Coefficients of friction, table 2.11.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionCoefficients {
    /// Static coefficient of friction. For hair it was not measured: it is then the least possible
    /// value, the kinetic coefficient, marked as [`Standing::Assumed`].
    pub stick: MeasuredValue,
    /// Kinetic coefficient of friction.
    pub slip: MeasuredValue,
}

/// The coefficients of friction of two partners, as "hair/nylon", after a treatment (none: ""), all
/// as in table 2.11.
///
/// The four rows that are washed with ABS have a static coefficient below the kinetic one; that
/// number is read as the kinetic one of dry hair, and marked as assumed.
///
/// # Errors
/// [`KeratinError::Unknown`] for partners that the table lacks, with the nearest;
/// [`KeratinError::NotMeasured`] for a treatment, a direction or a wetness that it lacks.
pub fn friction(
    pair: &str,
    treatment: &str,
    direction: Direction,
    wetness: Wetness,
) -> Result<FrictionCoefficients, KeratinError> {
    let rows = &tables().friction.rows;
    let missing = || KeratinError::NotMeasured {
        quantity: "coefficient of friction",
        of: format!("{wetness:?} {pair} {treatment} {}", direction.name()),
    };
    let asked = |r: &&FrictionRow| {
        usize::from(r.direction) == direction as usize + 1
            && r.pair.eq_ignore_ascii_case(pair)
            && r.treatment.eq_ignore_ascii_case(treatment)
    };
    let Some(row) = rows.iter().find(asked) else {
        // Misspelt, or not measured?
        named("pair of partners", pair, rows.iter().map(|r| (r.pair, ())))?;
        named("treatment", treatment, rows.iter().map(|r| (r.treatment, ())))?;
        return Err(missing());
    };
    let source = Source { place: "2.11", line: row.line, study: tables().friction.source };
    let quantity = |value, standing| MeasuredValue::new(value, standing, &[source]);
    let shifted = is_shifted(row);
    let slip = match wetness {
        Wetness::Dry if shifted => row.mu_s_wet.map(|mu| quantity(mu, Standing::Assumed)),
        Wetness::Dry => row.mu_k_dry.map(|mu| quantity(mu, Standing::Measured)),
        Wetness::Wet => row.mu_k_wet.map(|mu| quantity(mu, Standing::Measured)),
    };
    let slip = slip.ok_or_else(missing)?;
    let stick = match wetness {
        Wetness::Dry => row.mu_s_dry,
        Wetness::Wet if shifted => None,
        Wetness::Wet => row.mu_s_wet,
    };
    let stick = stick
        .map_or(quantity(slip.value, Standing::Assumed), |mu| quantity(mu, Standing::Measured));
    Ok(FrictionCoefficients { stick, slip })
}

/// Whether the static coefficient of a row is below the kinetic one, which is impossible.
fn is_shifted(row: &FrictionRow) -> bool {
    row.mu_s_wet.zip(row.mu_k_wet).is_some_and(|(stick, slip)| stick < slip)
}

/// Exponent of the dependence of resistance on the moisture content M: `M^-15.8`, as for wool.
const RESISTANCE_EXPONENT: f64 = 15.8;

/// Electric resistance of hair, ohm.
///
/// Measured is one humidity, 85 % (line 949, here the geometric mean of the range), and that ten
/// degrees more divide it by five. The dependence on humidity is assumed: `M^-15.8` with the
/// moisture content M, as Hearle found for wool; the temperature of the measurement is taken to be
/// 23 C.
///
/// # Errors
/// [`KeratinError::Outside`] below 30 % humidity, where the power law has no hold, unless marked.
pub fn resistance(climate: &Climate, outside: Outside) -> Result<MeasuredValue, KeratinError> {
    let ([low, high], measured) = range("resistance_85rh");
    let (factor, by_temperature) = number("resistance_factor_per_10k");
    let reference = Climate { humidity: Humidity::new(0.85)?, ..Climate::STANDARD };
    let content = |climate: &Climate| water::content(water::value_at(climate));
    let h = climate.humidity.fraction();
    let warmer = climate.temperature.celsius() - Temperature::ROOM.celsius();
    let exact = climate.humidity == reference.humidity && warmer == 0.0;
    let inside = if exact { Standing::Measured } else { Standing::Assumed };
    let standing = outside.judge("electric resistance", "humidity", h, [0.3, 1.0], inside)?;
    // Dry hair does not conduct at all: no number.
    let moisture = content(climate).max(1e-3) / content(&reference);
    let value =
        (low * high).sqrt() * moisture.powf(-RESISTANCE_EXPONENT) * factor.powf(warmer / 10.0);
    Ok(MeasuredValue::new(value, standing, &[measured, by_temperature]))
}

names! {
    /// Classes of hair spray, table 2.12.
    Spray, "class of hair spray" {
        /// Ultra-high hold, the strongest class.
        UltraHighHold = "ultra-high hold",
        /// Hard to hold, a strong class.
        HardToHold = "hard-to-hold",
        /// Regular hold, the usual class.
        RegularHold = "regular hold",
        /// Light hold, the weakest class.
        LightHold = "light hold",
    }
}

/// Least and greatest tension that a bond of hair spray between two hairs bears, N (table 2.12).
#[must_use]
pub fn bond_strength(spray: Spray) -> [MeasuredValue; 2] {
    let table = &tables().sprays;
    let (least, most) = table.rows[spray as usize].force;
    let source = table.row_source(spray as usize);
    [least, most].map(|force| MeasuredValue::new(force, Standing::Measured, &[source]))
}

/// The waviness C of strands, table 2.3: hair as "oriental", treatment as "P" or "SAC, SLS, BL".
///
/// # Errors
/// [`KeratinError::Unknown`] with the nearest names, [`KeratinError::NotMeasured`] for wet hair
/// where only dry is listed.
pub fn waviness(
    hair: &str,
    treatment: &str,
    wetness: Wetness,
) -> Result<MeasuredValue, KeratinError> {
    let table = &tables().waviness;
    let hair = named("hair", hair, table.rows.iter().map(|r| (r.hair, r.hair)))?;
    let of_hair = table.rows.iter().enumerate().filter(|(_, r)| r.hair == hair);
    let index = named("treatment", treatment, of_hair.map(|(i, r)| (r.treatment, i)))?;
    let row = &table.rows[index];
    let value = match wetness {
        Wetness::Dry => Some(row.dry),
        Wetness::Wet => row.wet,
    };
    let of = || format!("wet {hair} hair after {treatment}");
    value
        .map(|c| MeasuredValue::new(c, Standing::Measured, &[table.row_source(index)]))
        .ok_or_else(|| KeratinError::NotMeasured { quantity: "waviness", of: of() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn ten_degrees_more_divide_the_resistance_by_five() {
        let at = |celsius| {
            let climate = Climate::new(0.85, celsius).expect("a climate");
            resistance(&climate, Outside::Refuse).expect("measured").value
        };
        assert_relative_eq!(at(23.0), 1.7e26_f64.sqrt(), max_relative = 1e-12);
        assert_relative_eq!(at(13.0) / at(23.0), 5.0, max_relative = 1e-12);
        assert_relative_eq!(at(23.0) / at(33.0), 5.0, max_relative = 1e-12);
    }

    #[test]
    fn sticking_never_needs_less_than_slipping() {
        for row in &tables().friction.rows {
            for wetness in [Wetness::Dry, Wetness::Wet] {
                let direction = Direction::ALL[usize::from(row.direction) - 1];
                if let Ok(found) = friction(row.pair, row.treatment, direction, wetness) {
                    assert!(found.stick.value >= found.slip.value, "{row:?}");
                }
            }
        }
    }

    #[test]
    fn what_the_table_lacks_is_said() {
        let error = friction("hair/nilon", "", Direction::WithScales, Wetness::Dry);
        assert!(error.expect_err("misspelt").to_string().contains("hair/nylon"));
        let error = friction("hair/nylon", "", Direction::AgainstScales, Wetness::Dry);
        assert!(matches!(error, Err(KeratinError::NotMeasured { .. })));
        assert!(waviness("curly II", "P, SAC, SLS, BL", Wetness::Wet).is_err());
    }
}
