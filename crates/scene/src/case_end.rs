//! What holds the two ends of the rod of a case.

use crate::{Check, Orientation, Pose};
use serde::{Deserialize, Serialize};

/// What holds the rod of a case at its root.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CaseRoot {
    /// A clamp.
    #[default]
    Clamped,
    /// A ball joint, which takes no moment; searches start from the pose of the clamp.
    Joint,
    /// Nothing: the rod lies on what it touches; searches start from the pose of the clamp.
    Free,
}

/// Boundary condition at the far end of a rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CaseEnd {
    /// A free end, on which a dead force and moment may act, which keep their directions.
    Free {
        /// Force on the end, N, world frame.
        #[serde(default)]
        force: [f64; 3],
        /// Moment on the end, N m, world frame.
        #[serde(default)]
        moment: [f64; 3],
    },
    /// A ball joint, which takes no moment.
    Joint {
        /// Position of the joint, m.
        position: [f64; 3],
    },
    /// A bearing along a tangent, in which the rod turns freely about itself.
    Bearing {
        /// Position of the bearing, m.
        position: [f64; 3],
        /// Tangent of the bearing, away from the clamp; any length.
        direction: [f64; 3],
    },
    /// A clamp at the far end.
    Clamped {
        /// Position of the clamped end, m.
        position: [f64; 3],
        /// Frame of the clamped end; its tangent is along the rod, away from the first clamp.
        orientation: Orientation,
    },
    /// An end that slides without friction along a line, under a dead force along it.
    Sliding {
        /// A point of the line, m.
        position: [f64; 3],
        /// Direction of the line; any length.
        direction: [f64; 3],
        /// Force on the end in that direction, N.
        force: f64,
        /// What holds the rotation of the end.
        #[serde(default)]
        hold: SlidingHold,
    },
    /// A closed ring: the end is clamped to the root, turned about the tangent.
    Ring {
        /// Angle from the frame of the root to that of the end about the tangent, degrees: a flat
        /// ring of a rod without natural curvature has so much twist, and a whole turn of it for
        /// each unit of its linking number.
        #[serde(default)]
        twist: f64,
    },
}

/// What holds the rotation of an end that slides.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum SlidingHold {
    /// A ball joint, which takes no moment.
    #[default]
    Joint,
    /// A bearing along a tangent, in which the rod turns freely about itself.
    Bearing {
        /// Tangent of the bearing, away from the clamp; any length.
        direction: [f64; 3],
    },
    /// A clamp.
    Clamped {
        /// Frame of the end; its tangent is along the rod, away from the root.
        orientation: Orientation,
    },
}

impl Default for CaseEnd {
    fn default() -> Self {
        Self::Free { force: [0.0; 3], moment: [0.0; 3] }
    }
}

impl CaseEnd {
    /// Prescribed position of the end, m; `None` for a free end, one that slides, and a ring.
    #[must_use]
    pub fn position(&self) -> Option<[f64; 3]> {
        match self {
            Self::Free { .. } | Self::Sliding { .. } | Self::Ring { .. } => None,
            Self::Joint { position }
            | Self::Bearing { position, .. }
            | Self::Clamped { position, .. } => Some(*position),
        }
    }

    pub(crate) fn check(&self, check: &mut Check) {
        match self {
            Self::Free { force, moment } => {
                check.vector("force", force, "N");
                check.vector("moment", moment, "N m");
            }
            Self::Joint { position } => check.vector("position", position, "m"),
            Self::Bearing { position, direction } => {
                check.vector("position", position, "m");
                check.direction("direction", direction);
            }
            Self::Clamped { position, orientation } => {
                Pose { position: *position, orientation: *orientation }.check(check);
            }
            Self::Sliding { position, direction, force, hold } => {
                check.vector("position", position, "m");
                check.direction("direction", direction);
                check.number("force", *force, crate::Allowed::Finite, "N");
                check.within("hold", |c| match hold {
                    SlidingHold::Joint => {}
                    SlidingHold::Bearing { direction } => c.direction("direction", direction),
                    SlidingHold::Clamped { orientation } => {
                        Pose { position: *position, orientation: *orientation }.check(c);
                    }
                });
            }
            Self::Ring { twist } => check.number("twist", *twist, TURNS, "degrees"),
        }
    }
}

/// Angles that are understood, degrees: a thousand turns.
pub(crate) const TURNS: crate::Allowed = crate::Allowed::Within(-3.6e5, 3.6e5);
