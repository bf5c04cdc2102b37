use crate::HairgenError;
use crate::error::choice;
use nalgebra::{Unit, Vector3};
use serde::{Deserialize, Serialize};

/// Weights of the terms that a guide's end load minimizes (5.7); only their ratios count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuideWeights {
    /// Weight of the deviation from the directions of the pre-guides (5.8).
    pub direction: f64,
    /// Weight of the deviation from the curvatures of the pre-guides (5.9).
    pub curvature: f64,
    /// Weight of the walls, head and hull (5.10).
    pub boundary: f64,
    /// Weight of the density of the hair that is there already (5.11, 5.12).
    pub density: f64,
}

impl Default for GuideWeights {
    fn default() -> Self {
        Self { direction: 0.3, curvature: 0.1, boundary: 0.5, density: 0.1 }
    }
}

impl GuideWeights {
    /// The weights over their sum, which is 1 then, in the order of the terms.
    ///
    /// # Errors
    /// Weights that are negative or not finite, or all zero.
    pub fn normalized(&self) -> Result<[f64; 4], HairgenError> {
        let weights = [self.direction, self.curvature, self.boundary, self.density];
        for weight in weights {
            choice("a weight of the guides", weight, "at least 0", |w| w >= 0.0)?;
        }
        let sum: f64 = weights.iter().sum();
        choice("the sum of the guides' weights", sum, "positive", |sum| sum > 0.0)?;
        Ok(weights.map(|weight| weight / sum))
    }
}

/// How guides are laid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuideOptions {
    /// Number of segments of a guide.
    pub segments: usize,
    /// Torsion stiffness over bending stiffness.
    pub torsion: f64,
    /// Direction in which hair falls (world): to there hair hangs that is too long to be laid
    /// otherwise, and there a hair bends that grows along the scalp's normal.
    pub down: Unit<Vector3<f64>>,
    /// Weights of the terms of the objective.
    pub weights: GuideWeights,
    /// Distance from head and hull at which their walls begin, m.
    pub margin: f64,
    /// Slope of the walls behind the surfaces, in units of their slope at the surfaces.
    pub penalty: f64,
    /// Arc length that a guide may be outside of the hull before it is cut, m.
    pub outside: f64,
    /// Fraction of its pore's length that must be left of a guide after the cut; one with less
    /// finds no place.
    pub least: f64,
    /// Predicted decrease of the objective, relative to it, at which a guide is laid.
    pub tolerance: f64,
    /// Largest number of equilibria of a guide.
    pub equilibria: usize,
    /// Number of guides that are laid at once: they see the density of those before, but not each
    /// other's.
    pub batch: usize,
}

impl Default for GuideOptions {
    fn default() -> Self {
        Self {
            segments: 50,
            torsion: 0.75,
            down: -Vector3::y_axis(),
            weights: GuideWeights::default(),
            margin: 0.003,
            penalty: 10.0,
            outside: 0.005,
            least: 0.05,
            tolerance: 2e-3,
            equilibria: 60,
            batch: 64,
        }
    }
}

impl GuideOptions {
    pub(crate) fn validate(&self) -> Result<(), HairgenError> {
        let positive = |x: f64| x > 0.0;
        let count = |x: f64| (1.0..=1e4).contains(&x);
        let segments = self.segments as f64;
        choice("the number of segments of a guide", segments, "between 1 and 10000", count)?;
        choice("the guides' torsion over bending", self.torsion, "positive", positive)?;
        choice("the margin of the walls (m)", self.margin, "positive", positive)?;
        choice("the penalty of the walls", self.penalty, "at least 0", |x| x >= 0.0)?;
        choice("the length outside of the hull (m)", self.outside, "at least 0", |x| x >= 0.0)?;
        choice("the least part of a guide", self.least, "in [0, 1]", |x| (0.0..=1.0).contains(&x))?;
        let length = self.down.norm();
        choice("the length of the direction down", length, "1", |x| (x - 1.0).abs() < 1e-6)?;
        choice("the tolerance of the guides", self.tolerance, "at least 0", |x| x >= 0.0)?;
        let (most, batch) = (self.equilibria as f64, self.batch as f64);
        choice("the number of equilibria", most, "at least 1", |x| x >= 1.0)?;
        choice("the size of a batch of guides", batch, "at least 1", |x| x >= 1.0)?;
        self.weights.normalized().map(|_| ())
    }
}
