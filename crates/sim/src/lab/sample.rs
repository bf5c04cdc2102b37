//! What instruments measure, what they read, and what they all do.

use crate::scene::{self, Keratin, Law, MaterialSpec};
use crate::{CouplingError, Scene, SimError};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_fiber::generate::root_pose;
use rapunzel_fiber::{Fiber, NodeProperties};
use rapunzel_keratin::surface::Wetness;
use rapunzel_keratin::{Climate, Hair, Humidity, KeratinError};
use rapunzel_rod_dynamic::{Conditions, Rod, RodError, RodIntegrator, RodState, Staggered};

/// Acceleration of free fall, m/s^2.
pub(super) const GRAVITY: f64 = 9.81;

/// Hair, and the air that it is measured in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabSample {
    /// The hair; its law is that of the instrument.
    pub keratin: Keratin,
    /// The climate.
    pub climate: Climate,
}

/// What an instrument gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The numbers read, the most important first.
    pub numbers: Vec<Number>,
    /// What was recorded.
    pub record: Record,
}

/// A number that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// What it is.
    pub name: &'static str,
    /// Unit of the number; empty if it has none.
    pub unit: &'static str,
    /// What was read.
    pub value: f64,
    /// What the formula should give for what was put into the hair, with the bias that it is known
    /// to have, if it is such a number.
    pub put_in: Option<f64>,
}

/// A curve that was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// What is on the axes, with units.
    pub axes: [&'static str; 2],
    /// The points.
    pub points: Vec<[f64; 2]>,
}

impl Number {
    pub(super) fn new(name: &'static str, unit: &'static str, value: f64) -> Self {
        Self { name, unit, value, put_in: None }
    }

    pub(super) fn of(self, put_in: f64) -> Self {
        Self { put_in: Some(put_in), ..self }
    }
}

impl LabSample {
    /// The hair of the sample.
    ///
    /// # Errors
    /// None in fact: its diameters are those of its type.
    pub fn hair(&self) -> Result<Hair, KeratinError> {
        self.keratin.hair(None)
    }

    /// Whether there is water on the hair: in saturated air.
    pub(super) fn wetness(&self) -> Wetness {
        if self.climate.humidity == Humidity::SATURATED { Wetness::Wet } else { Wetness::Dry }
    }

    /// Makes the fibres of a scene of the sample, elastic, with its section.
    pub(super) fn put_into(&self, scene: &mut Scene) {
        let Keratin { kind, treatment, thickness, extrapolate, .. } = self.keratin;
        let law = Law::Elastic;
        for bundle in &mut scene.fibers {
            bundle.section = None;
            bundle.material =
                MaterialSpec::Keratin { kind, treatment, thickness, law, extrapolate };
        }
        scene.environment.climate = scene::ClimateHistory {
            humidity: vec![(0.0, self.climate.humidity.fraction())],
            temperature: self.climate.temperature.celsius(),
        };
    }

    pub(super) fn node(&self) -> Result<NodeProperties, KeratinError> {
        self.hair()?.node(&self.climate)
    }
}

/// The pose at the origin with its tangent along `direction`.
pub(super) fn root(direction: Vector3<f64>) -> Result<Isometry3<f64>, KeratinError> {
    Ok(root_pose(Point3::origin(), &direction)?)
}

/// A straight fibre from the origin.
pub(super) fn straight(
    node: NodeProperties,
    direction: Vector3<f64>,
    length: f64,
    segments: usize,
) -> Result<Fiber, KeratinError> {
    let lengths = vec![length / segments as f64; segments];
    Ok(Fiber::new(root(direction)?, lengths, vec![node; segments + 1])?)
}

/// Moves a rod from a state and reads it after each step: `(time, reading)`.
pub(super) fn record(
    rod: Rod,
    start: &RodState,
    conditions: &dyn Conditions,
    dt: f64,
    end: f64,
    read: impl Fn(&RodState) -> f64,
) -> Result<Vec<(f64, f64)>, SimError> {
    let refused = |source: RodError| SimError::Rod { bundle: 0, source };
    let mut moving = Staggered::new(rod).map_err(refused)?;
    moving.set_state(start).map_err(refused)?;
    let mut record = vec![(0.0, read(start))];
    while moving.time() < end {
        let time = moving.time();
        moving.step(dt, conditions).map_err(|source| CouplingError::Step { time, source })?;
        record.push((moving.time(), read(&moving.state())));
    }
    Ok(record)
}

/// The natural state of a fibre.
pub(super) fn natural(fiber: &Fiber) -> Result<RodState, SimError> {
    let rod = Staggered::new(Rod::new(fiber.clone()));
    rod.map(|rod| rod.state()).map_err(|source| SimError::Rod { bundle: 0, source })
}
