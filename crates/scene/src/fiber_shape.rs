use super::check::{Allowed, Check};
use rapunzel_fiber::generate::Handedness;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The natural shape of a fibre, without load.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum FiberShape {
    /// A straight fibre.
    #[default]
    Straight,
    /// A helix whose axis is along the direction of the root.
    Helix {
        /// Radius of the cylinder, m.
        radius: f64,
        /// Advance along the axis in one turn, m; zero makes a ring.
        pitch: f64,
        /// Handedness of the helix.
        #[serde(default = "right")]
        handedness: Handedness,
    },
    /// A plane sine along the direction of the root.
    Sine {
        /// Amplitude, m: half of the whole height.
        amplitude: f64,
        /// Length of a period along the axis, m.
        wavelength: f64,
    },
    /// A fibre of constant curvature and twist.
    Curved {
        /// Darboux vector in the material frame (about d1, d2, tangent), 1/m.
        curvature: [f64; 3],
    },
}

fn right() -> Handedness {
    Handedness::Right
}

/// The shape of a fibre at the start.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Initial {
    /// The natural shape.
    #[default]
    Natural,
    /// Straight and untwisted along the direction of the root, so that a curved fibre is
    /// prestressed.
    Straight,
    /// Wound to a helix whose axis is along the direction of the root: prestressed where the shape
    /// is another.
    Helix {
        /// Radius of the cylinder, m.
        radius: f64,
        /// Advance along the axis in one turn, m; zero makes a ring.
        pitch: f64,
        /// Handedness of the helix.
        #[serde(default = "right")]
        handedness: Handedness,
    },
    /// Untwisted with an overhand knot in the middle, the ends along the direction of the root on
    /// one line; the loop stands out along d1. Prestressed.
    Overhand {
        /// Radius of the loop, m.
        radius: f64,
        /// Distance of the axes of the strands that wind about each other, m: more than a diameter,
        /// at most a tenth of the radius.
        spacing: f64,
    },
    /// Untwisted along a closed curve that is cut where it is farthest from its middle: the ends
    /// pass each other there and go on along the direction of the root; the knot stands out along
    /// d1. Prestressed.
    Knot {
        /// The closed curve.
        curve: ClosedCurve,
        /// Metres for a unit of the curve.
        scale: f64,
        /// Distance at which the ends pass each other, m: more than two diameters.
        spacing: f64,
    },
}

/// A closed curve that may be knotted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ClosedCurve {
    /// A figure-eight knot, of radius 1.
    FigureEight,
    /// A curve through the points in a file, relative to the folder of the scene, with rounded
    /// corners: an `.obj` with points and lines in one ring, or a `.txt` with the three coordinates
    /// of a point in every line, in their order.
    File(PathBuf),
}

/// The closing of fibres to rings: the tip of each is spliced to its own root, where it must start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Closing {
    /// Turns of twist that are put in, spread evenly, beside those of the shape at the start; not
    /// only whole ones.
    pub turns: f64,
}

impl Initial {
    pub(super) fn check(&self, check: &mut Check) {
        match self {
            Self::Natural | Self::Straight => {}
            Self::Helix { radius, pitch, .. } => {
                check.number("radius", *radius, Allowed::Positive, "m");
                check.number("pitch", *pitch, Allowed::NonNegative, "m");
            }
            Self::Overhand { radius, spacing } => {
                check.number("radius", *radius, Allowed::Positive, "m");
                check.number("spacing", *spacing, Allowed::Positive, "m");
            }
            Self::Knot { scale, spacing, .. } => {
                check.number("scale", *scale, Allowed::Positive, "m");
                check.number("spacing", *spacing, Allowed::Positive, "m");
            }
        }
    }

    /// Path of the file that holds the curve, if there is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Knot { curve: ClosedCurve::File(file), .. } => Some(file),
            _ => None,
        }
    }

    /// Makes a path relative to the folder of the scene.
    pub(super) fn seen_from(&mut self, folder: &Path) {
        if let Self::Knot { curve: ClosedCurve::File(file), .. } = self {
            *file = folder.join(&*file);
        }
    }
}

impl FiberShape {
    pub(super) fn check(&self, check: &mut Check) {
        match self {
            Self::Straight => {}
            Self::Helix { radius, pitch, .. } => {
                check.number("radius", *radius, Allowed::Positive, "m");
                check.number("pitch", *pitch, Allowed::NonNegative, "m");
            }
            Self::Sine { amplitude, wavelength } => {
                check.number("amplitude", *amplitude, Allowed::NonNegative, "m");
                check.number("wavelength", *wavelength, Allowed::Positive, "m");
            }
            Self::Curved { curvature } => check.vector("curvature", curvature, "1/m"),
        }
    }
}
