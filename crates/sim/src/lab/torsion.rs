//! The torsion pendulum.

use super::sample::{GRAVITY, LabSample, Number, Reading, Record, natural, record, root};
use crate::SimError;
use crate::scene::{Keratin, Law, fading_power};
use nalgebra::{Rotation3, Vector3};
use rapunzel_fiber::so3;
use rapunzel_keratin::lab::oscillation::Oscillation;
use rapunzel_keratin::lab::pendulum::{self, Bob};
use rapunzel_rod_dynamic::{Instant, Rod, RodState, Steady};
use std::f64::consts::TAU;

/// Length of the hair, m, and its segments.
const PENDULUM_LENGTH: f64 = 0.05;
const PENDULUM_SEGMENTS: usize = 10;
/// Mass of the bob, kg; its inertia is such that the hair swings with 1 rad/s, where the moduli of
/// one that fades are those of the tables.
const MASS: f64 = 1e-4;
const PERIOD: f64 = TAU;
/// Twist at the start, rad.
const TWIST: f64 = 0.5;
/// Length of a step, s.
const STEP: f64 = PERIOD / 400.0;
/// Length of the record, s.
const RECORDED: f64 = 5.2 * PERIOD;

/// Twists a hair with a bob, lets go, and reads period and decrement.
pub(super) fn pendulum(sample: &LabSample) -> Result<Reading, SimError> {
    let (hair, climate) = (sample.hair()?, &sample.climate);
    let fading = Keratin { law: Law::Viscoelastic, ..sample.keratin };
    let (node, laws) = fading.rod(&hair, climate)?;
    let decrement = hair.log_decrement(climate)?.value;
    let inertia = node.stiffness.z / PENDULUM_LENGTH * (PERIOD / TAU).powi(2);
    let fiber =
        pendulum::fiber(node, PENDULUM_LENGTH, PENDULUM_SEGMENTS, Bob { mass: MASS, inertia })?;
    let fiber = fiber.with_root(root(-Vector3::z())?);
    let mut start = natural(&fiber)?;
    let untwisted = start.frames[PENDULUM_SEGMENTS];
    let arcs = fiber.arc_lengths();
    for (i, frame) in start.frames.iter_mut().enumerate() {
        let middle = 0.5 * (arcs[i] + arcs[i + 1]) / PENDULUM_LENGTH;
        *frame *= so3::exp(&(TWIST * middle * Vector3::z()));
    }
    let rod = Rod { laws, ..Rod::new(fiber) };
    let hold = Steady(Instant::clamped(*rod.fiber.root(), -GRAVITY * Vector3::z()));
    let angle = |state: &RodState| {
        let turn: Rotation3<f64> = untwisted.inverse() * state.frames[PENDULUM_SEGMENTS];
        so3::log(&turn).z
    };
    let readings = record(rod, &start, &hold, STEP, RECORDED, angle)?;
    let found = Oscillation::of(&readings, 0.0)?;
    let section = hair.section(climate);
    let rigidity = pendulum::rigidity(inertia, PENDULUM_LENGTH, found.period)?;
    let modulus = pendulum::shear_modulus(rigidity, section.area())?;
    // The formulas take a circle, an elastic hair, and its period. Of a hair that fades with a
    // power of time the modulus is that of 1 rad/s.
    let power = fading_power(decrement);
    let fading =
        (1.0 + (decrement / TAU).powi(2)).powf(0.5 * power - 1.0) / (0.25 * TAU * power).cos();
    let bias = fading * (TAU / found.period).powf(power) * pendulum::section_bias(&section);
    let numbers = vec![
        Number::new("shear modulus", "Pa", modulus).of(bias * hair.shear_modulus(climate)?.value),
        Number::new("logarithmic decrement", "", found.log_decrement).of(decrement),
        Number::new("rigidity", "N m^2", rigidity),
        Number::new("bias of the formula", "", bias),
    ];
    let points = readings.iter().map(|(t, turn)| [*t, turn.to_degrees()]).collect();
    Ok(Reading { numbers, record: Record { axes: ["time (s)", "twist (degrees)"], points } })
}
