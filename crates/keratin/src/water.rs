//! Water content and swelling of hair.
//!
//! The thesis gives two numbers of the isotherm, 30 % at saturation and 15 % at ordinary humidity,
//! both read as regain (water by dry mass), and a figure (2.11) without values. The curve between
//! is that of Guggenheim, Anderson and de Boer, `R(a) = m C k a / ((1 - k a)(1 - k a + C k a))`,
//! with `C = 10` assumed, as for wool, and `m` and `k` such that `R(0.65) = 0.15` and `R(1) =
//! 0.30`. "Ordinary humidity" is taken to be 65 %.
//!
//! On the desorption branch hair holds more water. By how much is only drawn in the thesis; assumed
//! is `0.02 * 4 a (1 - a)`, 2 % of the dry mass at most.

use crate::climate::{Climate, Humidity, MeasuredValue, SorptionBranch, Standing};
use crate::tables::number;
use std::sync::LazyLock;

/// Constant `C` of the isotherm: ratio of the binding of the first layer of water to that of the
/// next.
const FIRST_LAYER: f64 = 10.0;
/// Largest additional regain on the desorption branch.
const HYSTERESIS: f64 = 0.02;

/// Parameters of the isotherm, and the swelling at saturation.
struct Isotherm {
    monolayer: f64,
    multilayer: f64,
    saturation: f64,
    swelling: [f64; 2],
}

static ISOTHERM: LazyLock<Isotherm> = LazyLock::new(|| {
    let part = |key| number(key).0 / 100.0;
    let (saturated, ordinary) = (part("water_at_saturation"), part("moisture_content_normal"));
    // R(1) / R(0.65) rises with k.
    let ratio = |k: f64| shape(1.0, k) / shape(Humidity::STANDARD.fraction(), k);
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle.max(f64::MIN_POSITIVE)) < saturated / ordinary {
            low = middle;
        } else {
            high = middle;
        }
    }
    Isotherm {
        monolayer: saturated / shape(1.0, high),
        multilayer: high,
        saturation: saturated,
        swelling: ["diameter_swelling_max", "length_swelling_100rh"].map(part),
    }
});

fn shape(activity: f64, k: f64) -> f64 {
    let x = k * activity;
    FIRST_LAYER * x / ((1.0 - x) * (1.0 - x + FIRST_LAYER * x))
}

/// Regain at saturation, a fraction.
pub(crate) fn saturation() -> f64 {
    ISOTHERM.saturation
}

/// The regain (2.7): mass of water over that of dry hair, a fraction. Below it is `R`.
///
/// Measured at 65 % and 100 %, assumed elsewhere. Cost: tens of nanoseconds.
#[must_use]
pub fn regain(climate: &Climate) -> MeasuredValue {
    let (saturated, at_saturation) = number("water_at_saturation");
    let (ordinary, at_ordinary) = number("moisture_content_normal");
    let a = climate.humidity.fraction();
    let absorbing = climate.branch == SorptionBranch::Absorption;
    let (value, standing) = if a == 1.0 {
        (saturated / 100.0, Standing::Measured)
    } else if climate.humidity == Humidity::STANDARD && absorbing {
        (ordinary / 100.0, Standing::Measured)
    } else {
        (value_at(climate), Standing::Assumed)
    };
    MeasuredValue::new(value, standing, &[at_saturation, at_ordinary])
}

/// Regain of hair in a climate, a fraction, without its standing.
pub(crate) fn value_at(climate: &Climate) -> f64 {
    let a = climate.humidity.fraction();
    let more = match climate.branch {
        SorptionBranch::Absorption => 0.0,
        SorptionBranch::Desorption => HYSTERESIS * 4.0 * a * (1.0 - a),
    };
    ISOTHERM.monolayer * shape(a, ISOTHERM.multilayer) + more
}

/// Moisture content (2.8) for a regain, both fractions: `M = R / (1 + R)`.
#[must_use]
pub fn content(regain: f64) -> f64 {
    regain / (1.0 + regain)
}

/// Thickness and length of hair over those of dry hair: up to 16 % and 2 % more at saturation, in
/// proportion to the regain (the proportion is assumed; with it volume grows as water comes in).
#[must_use]
pub fn swelling(climate: &Climate) -> [f64; 2] {
    let part = value_at(climate) / saturation();
    ISOTHERM.swelling.map(|most| 1.0 + part * most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn at(humidity: f64, branch: SorptionBranch) -> Climate {
        Climate { branch, ..Climate::new(humidity, 23.0).expect("a climate") }
    }

    #[test]
    fn the_isotherm_passes_through_its_anchors() {
        for (humidity, expected) in [(0.0, 0.0), (0.65, 0.15), (1.0, 0.30)] {
            let climate = at(humidity, SorptionBranch::Absorption);
            assert_relative_eq!(value_at(&climate), expected, max_relative = 1e-12);
            assert_relative_eq!(regain(&climate).value, expected, max_relative = 1e-15);
        }
        assert_relative_eq!(content(0.30), 0.30 / 1.30);
    }

    #[test]
    fn saturated_hair_is_16_percent_thicker_and_2_percent_longer() {
        assert_eq!(swelling(&Climate::WET), [1.16, 1.02]);
        assert_eq!(swelling(&at(0.0, SorptionBranch::Absorption)), [1.0, 1.0]);
    }

    proptest! {
        #[test]
        fn more_humidity_is_more_water_and_desorption_holds_more(a in 0.0..1.0, b in 0.0..1.0) {
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            for branch in [SorptionBranch::Absorption, SorptionBranch::Desorption] {
                let (low, high) = (value_at(&at(low, branch)), value_at(&at(high, branch)));
                prop_assert!(low <= high);
            }
            prop_assert!(value_at(&at(a, SorptionBranch::Desorption)) >= value_at(&at(a, SorptionBranch::Absorption)));
        }
    }
}
