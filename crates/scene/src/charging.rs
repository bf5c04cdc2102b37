//! Electric charge of a scene.

use super::Object;
use super::check::{Allowed, Check};
use crate::{Motion, Moves};
use rapunzel_electrostatics::{self as electrostatics, FieldGrid, units};
use rapunzel_keratin::surface::resistance;
use rapunzel_keratin::{Climate, KeratinError, Outside};
use serde::{Deserialize, Serialize};

/// Largest number of portions; more is a typing error.
const MOST_PORTIONS: usize = 100_000;
/// Largest number of points of a grid, some 10 GB.
const MOST_POINTS: usize = 100_000_000;
/// Length of the hair whose resistance is known, m.
const MEASURED: f64 = 0.01;

/// The charge of a bundle; it stays where it is put unless the scene has charge flow.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Charge {
    /// Amount of charge of the fibres.
    pub amount: Amount,
    /// Distribution along each fibre: pairs of the arc length as a fraction of the length, 0 at the
    /// root and 1 at the tip, and a weight, with straight lines between them; left out, even.
    #[serde(default)]
    pub along: Vec<(f64, f64)>,
}

/// Amount of charge of the fibres of a bundle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Amount {
    /// Charge of each fibre, C.
    Fiber(f64),
    /// Charge of all fibres together, C, divided evenly.
    Bundle(f64),
    /// Charge of every fibre, C, in the order of the fibres.
    Fibers(Vec<f64>),
    /// Charge per length, C/m.
    CoulombPerMeter(f64),
    /// Charge per length in Gaussian units, statC/cm; the thesis's value is -7.7e-4.
    StatcoulombPerCentimeter(f64),
}

impl Default for Amount {
    fn default() -> Self {
        Self::Fiber(0.0)
    }
}

/// Charging of fibres in portions, with the fibres at rest after each portion (thesis, Algorithm
/// 2).
///
/// Every step adds a portion, as long as there are any, and lasts `stepper.dt`; in it charge flows,
/// if flow is on. Each step gives a frame. Before the first step the fibres are at rest without
/// charge. There are no contacts: fibres and objects are kept apart by charge alone, or not at all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Charging {
    /// Portions in which the charge is added, and with it the charge or the potential of the head.
    #[serde(default)]
    pub dealing: Dealing,
    /// Other sequences of portions that are computed from the start too, after the first; the
    /// result says whether they reach the same equilibrium. Not where charge flows or the humidity
    /// changes, since they take other times.
    #[serde(default)]
    pub compared: Vec<Dealing>,
    /// The head, as far as charge is concerned.
    #[serde(default)]
    pub head: Head,
    /// Uniform electric field, V/m, world; it acts from the first step on, and on fibres alone.
    #[serde(default)]
    pub field: [f64; 3],
    /// Flow of charge along the fibres; left out, the charge is frozen, as on dry hair.
    #[serde(default)]
    pub flow: Option<Flow>,
    /// Tolerance of a step: the largest difference between the electric forces on the nodes and the
    /// forces that hold the fibres there, relative to the former (root of the sum of squares).
    #[serde(default = "tolerance")]
    pub tolerance: f64,
    /// Largest number of evaluations of the electric forces in a step.
    #[serde(default = "evaluations")]
    pub evaluations: usize,
    /// Grid of points at which the field is written with every frame.
    #[serde(default)]
    pub grid: Option<FieldGridSpec>,
}

fn tolerance() -> f64 {
    1e-4
}

fn evaluations() -> usize {
    200
}

/// Sequence of portions in which charge is added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Dealing {
    /// All charge at once.
    #[default]
    Once,
    /// Equal portions, as many as given.
    Equal(usize),
    /// Portions that fall as the differences of a logarithm, as many as given.
    Falling(usize),
}

/// The head under the fibres, as far as charge is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Head {
    /// No head.
    #[default]
    None,
    /// An object of the scene as a conductor: a ball by its exact images, any other bounded object
    /// by boundary elements on its triangles.
    Conductor {
        /// Index of the object among the objects of the scene.
        object: usize,
        /// Prescribed potential or charge of the conductor.
        #[serde(default)]
        held: ConductorHold,
    },
    /// The thesis's repulsion by the distance to an object (4.13), with Coulomb's constant and a
    /// signed distance: for comparison only.
    Thesis {
        /// Index of the object among the objects of the scene.
        object: usize,
        /// Charge of the object, C.
        charge: f64,
    },
}

/// Prescribed quantity of a conductor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ConductorHold {
    /// Potential, V: zero for an earthed conductor.
    Potential(f64),
    /// Total charge, C: an insulated conductor.
    Charge(f64),
}

impl Default for ConductorHold {
    fn default() -> Self {
        Self::Potential(0.0)
    }
}

/// Flow of charge along the fibres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// Electric resistance of the fibres.
    #[serde(default)]
    pub resistance: Resistance,
    /// Capacitance per length of one fibre, F/m.
    #[serde(default = "capacity")]
    pub capacity: f64,
    /// Whether the roots are in electric contact with the head, which then must be a conductor of
    /// known potential.
    #[serde(default)]
    pub drained: bool,
}

fn capacity() -> f64 {
    19e-12
}

/// Electric resistance of fibres per length.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Resistance {
    /// Resistance of hair in the climate of the environment by `rapunzel-keratin`, where the
    /// measured resistance is taken for a length of one centimeter: the thesis does not give the
    /// length.
    #[default]
    Climate,
    /// A given resistance per length, ohm/m.
    OhmPerMeter(f64),
}

/// A regular grid of points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldGridSpec {
    /// Position of the first point, m, world.
    pub origin: [f64; 3],
    /// Distance of the points along each axis, m.
    pub spacing: [f64; 3],
    /// Number of points along each axis; one for a plane.
    pub counts: [usize; 3],
}

impl From<FieldGridSpec> for FieldGrid {
    fn from(grid: FieldGridSpec) -> Self {
        Self { origin: grid.origin.into(), spacing: grid.spacing.into(), counts: grid.counts }
    }
}

impl Charge {
    /// Charges of the segments of fibre number `fiber` of a bundle, C, after all portions.
    pub fn of_segments(
        &self,
        fiber: usize,
        fibers: usize,
        length: f64,
        segments: usize,
    ) -> Vec<f64> {
        let total = match &self.amount {
            Amount::Fiber(charge) => *charge,
            Amount::Bundle(charge) => charge / fibers as f64,
            // There is one for each fibre, or the scene has been refused.
            Amount::Fibers(charges) => charges.get(fiber).copied().unwrap_or_default(),
            Amount::CoulombPerMeter(density) => density * length,
            Amount::StatcoulombPerCentimeter(density) => {
                units::statcoulomb_per_centimeter(*density) * length
            }
        };
        let weights = self.weights(segments);
        let sum: f64 = weights.iter().sum();
        weights.iter().map(|weight| total * weight / sum).collect()
    }

    /// Weights of the segments, by the distribution at their middles.
    fn weights(&self, segments: usize) -> Vec<f64> {
        if self.along.is_empty() {
            return vec![1.0; segments];
        }
        let course = super::Profile::Linear { points: self.along.clone() };
        (0..segments).map(|k| course.at((k as f64 + 0.5) / segments as f64)).collect()
    }

    pub(super) fn check(&self, check: &mut Check, fibers: usize, segments: usize) {
        let field = "amount";
        match &self.amount {
            Amount::Fiber(x) | Amount::Bundle(x) => check.number(field, *x, Allowed::Finite, "C"),
            Amount::CoulombPerMeter(x) => check.number(field, *x, Allowed::Finite, "C/m"),
            Amount::StatcoulombPerCentimeter(x) => {
                check.number(field, *x, Allowed::Finite, "statC/cm");
            }
            Amount::Fibers(charges) => {
                for (i, x) in charges.iter().enumerate() {
                    check.number(&format!("{field}[{i}]"), *x, Allowed::Finite, "C");
                }
                if charges.len() != fibers {
                    let message = format!(
                        "has {} charges, but the bundle has {fibers} fibres",
                        charges.len()
                    );
                    check.refuse(field, message);
                }
            }
        }
        if self.along.is_empty() {
            return;
        }
        let unit = Allowed::Within(0.0, 1.0);
        for (i, (at, weight)) in self.along.iter().enumerate() {
            check.number(&format!("along[{i}][0]"), *at, unit, "a part of the length");
            check.number(&format!("along[{i}][1]"), *weight, Allowed::Finite, "");
            if i > 0 && *at <= self.along[i - 1].0 {
                check.refuse(&format!("along[{i}][0]"), format!("is {at:?}, but must increase"));
            }
        }
        let weights = self.weights(segments);
        let (sum, size) = weights.iter().fold((0.0, 0.0), |(s, a), w| (s + w, a + w.abs()));
        if sum.abs() <= 1e-9 * size || sum.is_nan() {
            check.refuse("along", "sums up to nothing, but is to hold the whole charge".into());
        }
    }
}

impl Dealing {
    /// Fraction of the charge that each portion adds.
    pub fn shares(self) -> Vec<f64> {
        match self {
            Self::Once => electrostatics::ChargeDealing::Once,
            Self::Equal(portions) => electrostatics::ChargeDealing::Equal(portions),
            Self::Falling(portions) => electrostatics::ChargeDealing::Falling(portions),
        }
        .shares()
    }

    /// Number of portions.
    #[must_use]
    pub fn portions(self) -> usize {
        match self {
            Self::Once => 1,
            Self::Equal(portions) | Self::Falling(portions) => portions,
        }
    }
}

impl Head {
    /// Index of the object that is the head, if there is one.
    #[must_use]
    pub fn object(&self) -> Option<usize> {
        match *self {
            Self::None => None,
            Self::Conductor { object, .. } | Self::Thesis { object, .. } => Some(object),
        }
    }
}

impl Charging {
    /// Reports problems of the charging, given the `objects` of the scene and the number of steps.
    pub(super) fn check(&self, check: &mut Check, objects: &[Object], steps: u64) {
        let portions = self.dealing.portions();
        check.count("dealing", portions, 1, MOST_PORTIONS);
        for (i, other) in self.compared.iter().enumerate() {
            check.count(&format!("compared[{i}]"), other.portions(), 1, MOST_PORTIONS);
        }
        if portions as u64 > steps {
            let message = format!(
                "deals {portions} portions, but the run has {steps} steps of stepper.dt; make the \
                 duration longer"
            );
            check.refuse("dealing", message);
        }
        check.within("head", |c| self.check_head(c, objects));
        check.vector("field", &self.field, "V/m");
        check.number("tolerance", self.tolerance, Allowed::Within(1e-9, 0.1), "");
        check.count("evaluations", self.evaluations, 1, 1_000_000);
        if let Some(flow) = &self.flow {
            check.within("flow", |c| {
                c.number("capacity", flow.capacity, Allowed::Positive, "F/m");
                if let Resistance::OhmPerMeter(x) = flow.resistance {
                    c.number("resistance", x, Allowed::Positive, "ohm/m");
                }
                let known =
                    matches!(self.head, Head::Conductor { held: ConductorHold::Potential(_), .. });
                if flow.drained && !known {
                    let message = "is given, but the head is no Conductor of known Potential";
                    c.refuse("drained", message.into());
                }
            });
        }
        if let Some(grid) = &self.grid {
            check.within("grid", |c| {
                c.vector("origin", &grid.origin, "m");
                for axis in 0..3 {
                    let spacing = format!("spacing[{axis}]");
                    c.number(&spacing, grid.spacing[axis], Allowed::Positive, "m");
                    c.count(&format!("counts[{axis}]"), grid.counts[axis], 1, MOST_POINTS);
                }
                let points = grid.counts.iter().fold(1, |all: usize, n| all.saturating_mul(*n));
                c.count("counts", points, 0, MOST_POINTS);
            });
        }
    }

    fn check_head(&self, check: &mut Check, objects: &[Object]) {
        match self.head {
            Head::None => {}
            Head::Conductor { held: ConductorHold::Potential(x), .. } => {
                check.number("held", x, Allowed::Finite, "V");
            }
            Head::Conductor { held: ConductorHold::Charge(x), .. } => {
                check.number("held", x, Allowed::Finite, "C");
            }
            Head::Thesis { charge, .. } => check.number("charge", charge, Allowed::Finite, "C"),
        }
        let Some(index) = self.head.object() else { return };
        let Some(object) = objects.get(index) else {
            check.refuse("object", format!("is {index}, but there is no such object"));
            return;
        };
        if object.motion != Motion::Fixed || object.moves != Moves::Led {
            check.refuse("object", format!("is {index}, which moves; a head must rest"));
        }
        if object.shape.is_endless() && matches!(self.head, Head::Conductor { .. }) {
            check.refuse("object", format!("is {index}, which has no end; a conductor must end"));
        }
    }
}

impl Flow {
    /// Resistance per length in a climate, ohm/m.
    ///
    /// # Errors
    /// The errors of [`rapunzel_keratin::surface::resistance`].
    pub fn resistance_in(&self, climate: &Climate) -> Result<f64, KeratinError> {
        match self.resistance {
            Resistance::OhmPerMeter(resistance) => Ok(resistance),
            Resistance::Climate => Ok(resistance(climate, Outside::Refuse)?.value / MEASURED),
        }
    }
}
