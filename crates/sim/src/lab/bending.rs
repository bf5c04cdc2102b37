//! Bending: the fibre over a hook, and the rod that swings.

use super::sample::{GRAVITY, LabSample, Number, Reading, Record, natural, record, root, straight};
use crate::SimError;
use nalgebra::Vector3;
use rapunzel_keratin::lab::hook;
use rapunzel_keratin::lab::oscillation::{self, Oscillation};
use rapunzel_keratin::moduli::oscillating_moduli;
use rapunzel_rod_dynamic::{Instant, Rod, RodState, Steady};
use rapunzel_rod_static::{EndCondition, Piece, Problem, Properties};
use std::f64::consts::TAU;

/// Mass of the weight at each leg of the hook, kg, and length of a leg, m.
const BENDING_WEIGHT: f64 = 1e-4;
const BENDING_LEG: f64 = 0.03;
/// Length of the rod that swings, m, and its segments.
const BENDING_LENGTH: f64 = 0.02;
const BENDING_SEGMENTS: usize = 40;
/// The first zero of `1 + cos x cosh x`.
const CANTILEVER: f64 = 1.875_104_068_711_961;
/// Tip deflection at the start, in lengths.
const SWING: f64 = 0.05;
/// Steps of a period, and periods: after the first two the higher modes are gone.
const BENDING_STEPS: f64 = 400.0;
const PERIODS: f64 = 8.2;
const SKIPPED: usize = 800;

/// Lays a hair over a thin hook, with a weight at each end, and reads the distance of its legs. It
/// bends about its long axis: a flat hair lies flat.
pub(super) fn hook(sample: &LabSample) -> Result<Reading, SimError> {
    let (hair, climate) = (sample.hair()?, &sample.climate);
    let node = hair.node(climate)?;
    let tension = BENDING_WEIGHT * GRAVITY;
    // Half of it, from the top.
    let properties = Properties {
        stiffness: Vector3::new(node.stiffness.x, node.stiffness.x, node.stiffness.z),
        natural_curvature: Vector3::zeros(),
        load: -node.linear_density * GRAVITY * Vector3::z(),
    };
    let end = EndCondition::Free { force: -tension * Vector3::z(), moment: Vector3::zeros() };
    let piece = Piece::uniform(BENDING_LEG, properties);
    let top = root(Vector3::x())?;
    let found = Problem::new(&top, vec![piece], end)?.solve()?;
    let distance = 2.0 * found.tip().position.x;
    let section = hair.section(climate);
    let put_in = hair.bending_modulus(climate)?.value;
    let modulus = hook::bending_modulus(tension, distance, section.area())?;
    let numbers = vec![
        Number::new("Young's modulus in bending", "Pa", modulus)
            .of(hook::section_bias(&section) * put_in),
        Number::new("distance of the legs", "m", distance),
        Number::new("bias of the formula for the section", "", hook::section_bias(&section)),
    ];
    let half: Vec<_> = (0..=100)
        .map(|i| found.at(BENDING_LEG * f64::from(i) / 100.0).position)
        .map(|p| [1e3 * p.x, 1e3 * p.z])
        .collect();
    let left = half.iter().rev().map(|[x, z]| [-x, *z]);
    let points = left.chain(half.iter().copied()).collect();
    Ok(Reading { numbers, record: Record { axes: ["across (mm)", "height (mm)"], points } })
}

/// Lets a clamped hair swing in its lowest mode, about its long axis, with the loss tangent that
/// was measured so (line 638 of the thesis).
pub(super) fn oscillation(sample: &LabSample) -> Result<Reading, SimError> {
    let mut node = sample.node()?;
    node.stiffness.y = node.stiffness.x;
    let storage = sample.hair()?.bending_modulus(&sample.climate)?.value;
    let [measured, lost] = oscillating_moduli().map(|quantity| quantity.value);
    let tangent = lost / measured;
    let frequency =
        (CANTILEVER / BENDING_LENGTH).powi(2) * (node.stiffness.x / node.linear_density).sqrt();
    let fiber = straight(node, Vector3::z(), BENDING_LENGTH, BENDING_SEGMENTS)?;
    // The shape under a force at the tip has a curvature that falls linearly.
    let most = 3.0 * SWING / BENDING_LENGTH;
    let bent = fiber
        .clone()
        .with_natural_curvature(|s| most * (1.0 - s / BENDING_LENGTH) * Vector3::y())
        .map_err(rapunzel_keratin::KeratinError::from)?;
    let start = natural(&bent)?;
    let rod = Rod::damped(fiber, oscillation::damping_time(tangent, frequency));
    let hold = Steady(Instant::clamped(*rod.fiber.root(), Vector3::zeros()));
    let period = TAU / frequency;
    let (dt, end) = (period / BENDING_STEPS, PERIODS * period);
    let tip = |state: &RodState| state.positions[BENDING_SEGMENTS].x;
    let readings = record(rod, &start, &hold, dt, end, tip)?;
    let found = Oscillation::of(&readings[SKIPPED..], 0.0)?;
    let second = node.stiffness.x / storage;
    let [g1, g2] = oscillation::moduli(&found, BENDING_LENGTH, node.linear_density, second)?;
    let numbers = vec![
        Number::new("storage modulus", "Pa", g1).of(storage),
        Number::new("loss modulus", "Pa", g2).of(tangent * storage),
        Number::new("logarithmic decrement", "", found.log_decrement),
        Number::new("frequency", "Hz", 1.0 / found.period),
    ];
    let points = readings.iter().map(|(t, x)| [1e3 * t, 1e3 * x]).collect();
    Ok(Reading { numbers, record: Record { axes: ["time (ms)", "deflection (mm)"], points } })
}
