//! Tensile test and hysteresis. Rods do not stretch: the fibre is the law of its tension.

use super::sample::{LabSample, Number, Reading, Record};
use crate::SimError;
use rapunzel_keratin::lab::tensile::{self, CurvePoint};
use rapunzel_keratin::law::Tension;

/// Stress on the way back in parts of that on the way up, as the figures of hair in water show it.
const RECOVERY: f64 = 0.6;
/// How far a hysteresis goes.
const LOOP: f64 = 0.3;
/// Points of a curve.
const PARTS: u32 = 600;

/// Stretches a hair until it breaks: the slope below 1 % strain.
pub(super) fn tensile(sample: &LabSample) -> Result<Reading, SimError> {
    let hair = sample.hair()?;
    let mut fiber = Tension::of(&hair, &sample.climate, RECOVERY)?;
    let end = fiber.break_strain();
    let curve = tensile::stretch(&mut fiber, end, PARTS);
    let put_in = hair.stretching_modulus(&sample.climate)?.value;
    let area = hair.section(&sample.climate).area();
    let numbers = vec![
        Number::new("Young's modulus in tension", "Pa", tensile::modulus(&curve, 0.0, 0.01)?)
            .of(put_in),
        Number::new("strain at break", "", end),
        Number::new("force at break", "N", fiber.stress() * area),
    ];
    Ok(Reading { numbers, record: stress(&curve) })
}

/// Stretches a hair to 30 % and lets it back: work of extension over that of recovery.
pub(super) fn hysteresis(sample: &LabSample) -> Result<Reading, SimError> {
    let mut fiber = Tension::of(&sample.hair()?, &sample.climate, RECOVERY)?;
    let mut curve = tensile::stretch(&mut fiber, LOOP, PARTS);
    let back = tensile::stretch(&mut fiber, 0.0, PARTS);
    let numbers = vec![
        Number::new("hysteresis ratio", "", tensile::hysteresis_ratio(&curve, &back)),
        Number::new("work of extension", "J/m^3", tensile::work(&curve)),
    ];
    curve.extend(back);
    Ok(Reading { numbers, record: stress(&curve) })
}

fn stress(curve: &[CurvePoint]) -> Record {
    let points = curve.iter().map(|[strain, stress]| [*strain, 1e-6 * stress]).collect();
    Record { axes: ["strain", "stress (MPa)"], points }
}
