//! Waves and curls.

use super::sample::{GRAVITY, LabSample, Number, Reading, Record, natural, straight};
use crate::SimError;
use nalgebra::Vector3;
use rapunzel_fiber::generate::{Handedness, Helix, Sine};
use rapunzel_keratin::KeratinError;
use rapunzel_keratin::lab::curl::{self, WaterWave};
use rapunzel_rod_dynamic::{End, Instant, Load, Rod, equilibrium};
use rapunzel_rod_static::{EndCondition as StaticEnd, Piece, Problem, Properties};

/// The wave that is measured: length of the hair, amplitude and wavelength, m, and segments.
const WAVE_HAIR: f64 = 0.254;
const WAVE: Sine = Sine { amplitude: 0.002, wavelength: 0.02 };
const WAVE_SEGMENTS: usize = 600;
/// Mass that stretches it, kg.
const GRAM: f64 = 1e-3;
/// The curl: length of the hair, m, mandrel, and segments.
const CURL: f64 = 0.15;
const MANDREL: Helix = Helix { radius: 0.006, pitch: 0.003, handedness: Handedness::Right };
const CURL_SEGMENTS: usize = 60;

/// Counts the waves of a hair of 254 mm, and stretches it with one gram.
pub(super) fn waviness(sample: &LabSample) -> Result<Reading, SimError> {
    let fiber = straight(sample.node()?, Vector3::z(), WAVE_HAIR, WAVE_SEGMENTS)?;
    let wavy = WAVE.bend(fiber).map_err(KeratinError::from)?;
    let (curve, _) = wavy.rest_shape();
    let natural_length = (curve[WAVE_SEGMENTS] - curve[0]).norm();
    let waves = curl::maxima(&curve, &Vector3::x());
    let mut loaded = Instant::clamped(*wavy.root(), Vector3::zeros());
    let force = Load::World(GRAM * GRAVITY * Vector3::z());
    loaded.tip = End::Loaded { force, moment: Load::ZERO };
    let rest = natural(&wavy)?;
    let (pulled, _) = equilibrium(&Rod::new(wavy), &loaded, &rest)?;
    let stretched = (pulled.positions[WAVE_SEGMENTS] - pulled.positions[0]).norm();
    let numbers = vec![
        Number::new("waviness", "", curl::waviness(waves, stretched, natural_length)?)
            .of(waves as f64 * WAVE_HAIR / natural_length),
        Number::new("waves", "", waves as f64),
        Number::new("stretched length", "m", stretched),
        Number::new("natural length", "m", natural_length),
    ];
    let points = curve.iter().map(|p| [1e3 * p.z, 1e3 * p.x]).collect();
    Ok(Reading { numbers, record: Record { axes: ["along (mm)", "across (mm)"], points } })
}

/// Makes a water wave, hangs it in the climate of the sample, and reads how far it unwinds.
pub(super) fn retention(sample: &LabSample) -> Result<Reading, SimError> {
    let hair = sample.hair()?;
    let wave = WaterWave::on(MANDREL)?;
    let fiber = wave.curl(&hair, sample.climate, CURL, CURL_SEGMENTS)?;
    let node = fiber.nodes()[0];
    let properties = Properties {
        stiffness: node.stiffness,
        natural_curvature: node.natural_curvature,
        load: -node.linear_density * GRAVITY * Vector3::z(),
    };
    let end = StaticEnd::Free { force: Vector3::zeros(), moment: Vector3::zeros() };
    let piece = Piece::uniform(CURL, properties);
    let found = Problem::new(fiber.root(), vec![piece], end)?.solve()?;
    let curve: Vec<_> = (0..=300).map(|i| found.at(CURL * f64::from(i) / 300.0).position).collect();
    let depth = curve.iter().map(|p| -p.z).fold(0.0, f64::max);
    let numbers = vec![
        Number::new("curl retention index", "", curl::retention(CURL, depth)?),
        Number::new("part of the winding kept", "", wave.set(&hair, sample.climate)?),
        Number::new("hanging length", "m", depth),
    ];
    let points = curve.iter().map(|p| [1e3 * p.x, 1e3 * p.z]).collect();
    Ok(Reading { numbers, record: Record { axes: ["across (mm)", "height (mm)"], points } })
}
