//! What is asked of a case: a length, the equilibria along the way of a parameter, a critical load;
//! and where the search starts.

use crate::{Allowed, Check};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A length to be found: the shortest for which a condition holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wish {
    /// The condition on the rod.
    pub so_that: Wished,
    /// The longest length that is tried, m.
    pub longest: f64,
}

/// Condition on a rod of the length that is sought; the result is the shortest length that meets
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Wished {
    /// Largest curvature of the rod, 1/m.
    Curvature(f64),
    /// Sag below the lower one of its ends, m.
    Sag(f64),
    /// Largest force on the clamp, N.
    ClampForce(f64),
    /// Largest moment on the clamp, N m.
    ClampMoment(f64),
}

/// A shape from which the search for an equilibrium starts; its length must be that of the rod to
/// 1 %. The equilibrium near it is found, stable or not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CaseStart {
    /// A curve through the points in a file, relative to the folder of the case: a `.txt` with the
    /// three coordinates of a point in every line, m, world frame, from the root to the far end.
    Curve(PathBuf),
    /// A table of an earlier answer, `rod-0.csv` of its folder, relative to the folder of the case.
    Answer(PathBuf),
}

/// A parameter of a case that changes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Parameter {
    /// A factor of all loads of the case: gravity, forces, and force and moment on the end.
    Loads,
    /// A factor of gravity.
    Gravity,
    /// A factor of the force on a free end or one that slides: newtons, if that is 1 N.
    EndForce,
    /// A factor of the moment on a free end.
    EndMoment,
    /// A factor of one of the forces along the rod, counted from 0.
    Force(usize),
    /// Where the far end is held: a way in the direction of the vector, in its length, m.
    EndMove([f64; 3]),
    /// How the held direction or frame of the far end is turned about an axis through it, degrees.
    EndTurn([f64; 3]),
    /// How the clamped far end, or that of a ring, is turned about its own tangent, degrees.
    EndTwist,
    /// Length of the rod, m.
    Length,
}

impl Parameter {
    /// Unit of its values; nothing for a factor.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Loads | Self::Gravity | Self::EndForce | Self::EndMoment | Self::Force(_) => "",
            Self::EndMove(_) | Self::Length => "m",
            Self::EndTurn(_) | Self::EndTwist => "degrees",
        }
    }
}

/// The equilibria along the way of a parameter, from the one that is found at its first value:
/// followed past folds, where the parameter turns back, until it leaves the range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseSweep {
    /// The parameter.
    pub of: Parameter,
    /// Its first value.
    pub from: f64,
    /// Its last value.
    pub to: f64,
    /// Number of steps from one to the other, at least; where shapes change fast there are more.
    pub steps: usize,
    /// Number of equilibria along the way that are given as shapes, at most; the first and the last
    /// are among them.
    #[serde(default = "ten")]
    pub shapes: usize,
    /// A bifurcation at which the way goes over to the other branch; left out, it goes straight on.
    #[serde(default)]
    pub switch: Option<BranchSwitch>,
}

/// Where a way of equilibria goes over to the other branch that crosses it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchSwitch {
    /// The bifurcation, counted from 0 among those on the way.
    pub at: usize,
    /// Whether it goes to the other side: a branch leaves a bifurcation to two sides, to mirrored
    /// shapes or to other ones.
    #[serde(default)]
    pub other_side: bool,
}

fn ten() -> usize {
    10
}

/// The least value of a parameter at which the equilibrium that is followed from its first value
/// loses its stability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Critical {
    /// The parameter.
    pub of: Parameter,
    /// Its first value, at which the rod is stable; left out, zero, or the length of the case.
    #[serde(default)]
    pub from: Option<f64>,
    /// The largest value that is tried.
    pub up_to: f64,
}

impl Critical {
    /// The first value, of a rod of a `length`, m.
    #[must_use]
    pub fn first(&self, length: f64) -> f64 {
        let own = if self.of == Parameter::Length { length } else { 0.0 };
        self.from.unwrap_or(own)
    }
}

impl Wish {
    pub(crate) fn check(&self, check: &mut Check, length: f64) {
        check.number("longest", self.longest, Allowed::Within(length, 1e3), "m");
        let (value, unit) = match self.so_that {
            Wished::Curvature(x) => (x, "1/m"),
            Wished::Sag(x) => (x, "m"),
            Wished::ClampForce(x) => (x, "N"),
            Wished::ClampMoment(x) => (x, "N m"),
        };
        check.number("so_that", value, Allowed::Positive, unit);
    }
}
