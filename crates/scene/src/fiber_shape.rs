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

fn one() -> f64 {
    1.0
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
    /// Along an open curve in a file, in the world's axes, whose first point is put at the position
    /// of the root; the root's frame is the one along the curve's begin. Prestressed where the
    /// natural shape is another. The length must be that of the curve to a hundredth.
    Curve {
        /// The file, relative to the folder of the scene: a `.txt` with the three coordinates of a
        /// point in every line, in their order, an `.obj` with one line of points, or a `.csv` of
        /// `rapunzel solve`, whose frames count too.
        file: PathBuf,
        /// Metres for a unit of the file.
        #[serde(default = "one")]
        scale: f64,
        /// Angle by which the section turns about the tangent from root to tip, degrees, evenly,
        /// beside the frames of a `.csv` or a frame that is carried along without a twist.
        #[serde(default)]
        twist: f64,
    },
    /// As an equilibrium that `rapunzel solve` has found, and at rest there under the gravity and
    /// the ends of this scene: the chain of segments settles from the curve first. The root's
    /// frame and position are those of the file.
    Solved {
        /// A table `rod-0.csv`, relative to the folder of the scene.
        file: PathBuf,
    },
    /// Straight along the direction of the root, and from there at rest under the gravity and the
    /// ends at the start: stretched by the load of its tip it starts in equilibrium.
    Taut,
    /// Wound around a capsule, straight before and after that and without a corner, with segments
    /// that touch it. Prestressed where the natural shape is another: with `contact` it starts at
    /// rest, within a diameter, if its ends, the capsule and friction hold it there, and the run
    /// tells if they do not.
    Wrapped {
        /// Index of the object, a kinematic capsule.
        object: usize,
        /// Number of turns about its axis.
        turns: f64,
        /// Advance along the axis in one turn, m.
        #[serde(default)]
        pitch: f64,
        /// Handedness of the helix.
        #[serde(default = "right")]
        handedness: Handedness,
        /// Length of the straight part from the root to where it touches, m; what is left beyond
        /// the winding is straight too.
        #[serde(default)]
        lead: f64,
        /// Where it touches first: angle about the axis of the capsule from its x axis, degrees.
        #[serde(default)]
        angle: f64,
        /// Place of the middle of the winding along the axis of the capsule from its middle, m.
        #[serde(default)]
        along: f64,
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
            Self::Natural | Self::Straight | Self::Taut | Self::Solved { .. } => {}
            Self::Curve { scale, twist, .. } => {
                check.number("scale", *scale, Allowed::Positive, "");
                check.number("twist", *twist, Allowed::Finite, "degrees");
            }
            Self::Wrapped { turns, pitch, lead, angle, along, .. } => {
                check.number("turns", *turns, Allowed::Within(1e-6, 1e5), "");
                check.number("pitch", *pitch, Allowed::NonNegative, "m");
                check.number("lead", *lead, Allowed::NonNegative, "m");
                check.number("angle", *angle, Allowed::Finite, "degrees");
                check.number("along", *along, Allowed::Finite, "m");
            }
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

    /// Whether it gives the pose of the root too, of one fibre.
    pub(super) fn places_root(&self) -> bool {
        matches!(self, Self::Curve { .. } | Self::Solved { .. } | Self::Wrapped { .. })
    }

    /// Path of the file that holds the curve, if there is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Knot { curve: ClosedCurve::File(file), .. }
            | Self::Curve { file, .. }
            | Self::Solved { file } => Some(file),
            _ => None,
        }
    }

    /// Makes a path relative to the folder of the scene.
    pub(super) fn seen_from(&mut self, folder: &Path) {
        if let Self::Knot { curve: ClosedCurve::File(file), .. }
        | Self::Curve { file, .. }
        | Self::Solved { file } = self
        {
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
