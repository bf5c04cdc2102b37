//! Capstan friction: a hair drawn over a cylinder.

use super::sample::{LabSample, Number, Reading, Record};
use crate::scene::FrictionSurface;
use crate::{Scene, SimError, World};
use nalgebra::Vector3;
use rapunzel_keratin::KeratinError;
use rapunzel_keratin::surface::Wetness;
use std::f64::consts::PI;

/// Radius of the cylinder, m; the hair lies over half of it.
const RADIUS: f64 = 5e-3;
/// Segments over the cylinder, and of each leg.
const ARC: usize = 40;
const CAPSTAN_LEG: usize = 12;
/// Weight at the end of the hair, N: its tension bends the hair sharply.
const CAPSTAN_WEIGHT: f64 = 0.05;
/// Velocity with which the other end is drawn, m/s, far above what counts as slip.
const VELOCITY: f64 = 0.01;
/// Length of a step, s, and steps; the first half is not read.
const DT: f64 = 1e-3;
const CAPSTAN_STEPS: usize = 100;

/// Draws a hair by a clamp over a cylinder of nylon, wet where the air is saturated, and reads the
/// tensions of its ends: `mu = ln(T1 / T0) / pi`, Euler's formula.
pub(super) fn capstan(sample: &LabSample) -> Result<Reading, SimError> {
    let on = FrictionSurface::Nylon;
    let wetness = sample.wetness();
    // It lies flat, and bends the way that is easy.
    let (_, height) = sample.hair()?.section(&sample.climate).semi_axes();
    // The segments are chords whose middles touch the cylinder; the legs end half a segment above
    // it.
    let turn = PI / ARC as f64;
    let axis = (RADIUS + height) * (1.0 + turn * turn / 12.0);
    let segment = axis * turn;
    let leg = CAPSTAN_LEG as f64 * segment;
    let wet = if wetness == Wetness::Wet { "Wet" } else { "Dry" };
    let mut scene = Scene::from_ron(&format!(
        "(
            format: 1, duration: 1.0, stepper: (dt: {DT:?}), environment: (gravity: (0, 0, 0)),
            fibers: [(
                length: {:?}, segments: {}, initial: Straight, section: Circle(radius: 1e-5),
                root: (
                    position: ({:?}, 0, {:?}),
                    orientation: Along(direction: (0, 0, 1), roll: 90),
                ),
                motion: Translate(velocity: (0, 0, {:?}), until: 1.0),
                tip: Loaded(force: (value: (0, 0, {:?}))),
            )],
            objects: [(shape: Capsule(length: 0.04, radius: {RADIUS:?}), turn: (90, 0, 0))],
            contact: (friction: Keratin(on: Nylon, wetness: {wet})),
        )",
        2.0 * leg + PI * axis,
        ARC + 2 * CAPSTAN_LEG,
        -axis,
        0.5 * segment - leg,
        -VELOCITY,
        -CAPSTAN_WEIGHT,
    ))?;
    sample.put_into(&mut scene);
    let mut world = World::build(&scene)?;
    // Over the cylinder, and as if it had always been so.
    let over = world.assembly().fibers()[0].clone().with_natural_curvature(|s| {
        let bent = s > leg - 0.5 * segment && s < leg + PI * axis - 0.5 * segment;
        if bent { Vector3::x() / axis } else { Vector3::zeros() }
    });
    let start = super::sample::natural(&over.map_err(KeratinError::from)?)?;
    world.set_state(0, &start)?;
    let mut points = Vec::new();
    for _ in 0..CAPSTAN_STEPS {
        world.step(DT)?;
        points.push([world.time(), world.state(0).forces[0].norm()]);
    }
    let read = &points[CAPSTAN_STEPS / 2..];
    let tension = read.iter().map(|p| p[1]).sum::<f64>() / read.len() as f64;
    let numbers = vec![
        Number::new("coefficient of friction", "", (tension / CAPSTAN_WEIGHT).ln() / PI)
            .of(on.friction(wetness)?),
        Number::new("tension of the end that is drawn", "N", tension),
    ];
    Ok(Reading { numbers, record: Record { axes: ["time (s)", "tension (N)"], points } })
}
