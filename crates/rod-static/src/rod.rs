use crate::StaticError;
use crate::error::{finite, positive};
use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use std::fmt;
use std::sync::Arc;

/// Properties and load of a rod at one arc length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Properties {
    /// Bending stiffnesses about d1 and d2 and torsion stiffness, N m^2.
    pub stiffness: Vector3<f64>,
    /// Natural curvature in the material frame, rad/m.
    pub natural_curvature: Vector3<f64>,
    /// Load per length, N/m, world frame; a dead load: it keeps its direction.
    pub load: Vector3<f64>,
}

/// A part of a rod whose properties are smooth in the arc length.
#[derive(Clone)]
pub struct Piece {
    length: f64,
    properties: Arc<dyn Fn(f64) -> Properties + Send + Sync>,
    end_load: Vector3<f64>,
}

impl fmt::Debug for Piece {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (length, end_load) = (self.length, self.end_load);
        f.debug_struct("Piece")
            .field("length", &length)
            .field("end_load", &end_load)
            .finish_non_exhaustive()
    }
}

impl Piece {
    /// A piece of the same `properties` all along its `length`, m.
    #[must_use]
    pub fn uniform(length: f64, properties: Properties) -> Self {
        Self::varying(length, move |_| properties)
    }

    /// A piece of `length`, m, with properties that depend on the arc length from the clamp, m.
    #[must_use]
    pub fn varying(
        length: f64,
        properties: impl Fn(f64) -> Properties + Send + Sync + 'static,
    ) -> Self {
        Self { length, properties: Arc::new(properties), end_load: Vector3::zeros() }
    }

    /// The piece with the dead force `load`, N, world frame, on its far end: the weight of a mass.
    #[must_use]
    pub fn with_end_load(mut self, load: Vector3<f64>) -> Self {
        self.end_load = load;
        self
    }

    /// Length of the piece, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Dead force on the far end of the piece, N, world frame.
    pub(crate) fn end_load(&self) -> Vector3<f64> {
        self.end_load
    }

    /// The properties at the arc length `s` from the clamp.
    pub(crate) fn at(&self, s: f64) -> Properties {
        (self.properties)(s)
    }

    /// Checks the length, and the properties at both ends and in between.
    pub(crate) fn validate(&self, from: f64) -> Result<(), StaticError> {
        positive("the length of a piece (m)", self.length)?;
        finite("the load on the end of a piece (N)", self.end_load.as_slice())?;
        for part in 0..=8 {
            let p = self.at(from + self.length * f64::from(part) / 8.0);
            finite("the natural curvature (rad/m)", p.natural_curvature.as_slice())?;
            finite("the load per length (N/m)", p.load.as_slice())?;
            for stiffness in p.stiffness.iter() {
                positive("the stiffness (N m^2)", *stiffness)?;
            }
        }
        Ok(())
    }
}

/// Boundary condition at the far end of the rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EndCondition {
    /// A free end, on which a given force (N) and moment (N m) act, both dead, world frame.
    Free {
        /// Force on the end, N, world frame.
        force: Vector3<f64>,
        /// Moment on the end, N m, world frame.
        moment: Vector3<f64>,
    },
    /// A ball joint at this position (m, world frame), which takes no moment.
    Position(Point3<f64>),
    /// A bearing at this position along this tangent, in which the rod turns freely about itself.
    Tangent(Point3<f64>, Unit<Vector3<f64>>),
    /// A clamp with this pose of the end.
    Held(Isometry3<f64>),
    /// An end that slides without friction along a line, m, world frame.
    Sliding {
        /// A point of the line.
        point: Point3<f64>,
        /// Direction of the line.
        along: Unit<Vector3<f64>>,
        /// Dead force on the end along the line, N.
        force: f64,
        /// What holds the rotation of the end.
        hold: EndHold,
    },
}

/// What holds the rotation of an end that slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EndHold {
    /// A ball joint, which takes no moment.
    Joint,
    /// A bearing along this tangent, in which the rod turns freely about itself.
    Tangent(Unit<Vector3<f64>>),
    /// A clamp with this frame.
    Frame(UnitQuaternion<f64>),
}

impl EndCondition {
    /// A free end without load.
    pub const FREE: Self =
        Self::Free { force: Vector3::new(0.0, 0.0, 0.0), moment: Vector3::new(0.0, 0.0, 0.0) };

    /// Prescribed position of the end, m, world frame; `None` for a free end.
    pub(crate) fn position(&self) -> Option<Point3<f64>> {
        match self {
            Self::Free { .. } | Self::Sliding { .. } => None,
            Self::Position(p) | Self::Tangent(p, _) => Some(*p),
            Self::Held(pose) => Some(Point3::from(pose.translation.vector)),
        }
    }

    /// Checks that all numbers are finite.
    pub(crate) fn validate(&self) -> Result<(), StaticError> {
        match self {
            Self::Free { force, moment } => {
                finite("the force on the end (N)", force.as_slice())?;
                finite("the moment on the end (N m)", moment.as_slice())
            }
            Self::Position(p) => finite("the position of the end (m)", p.coords.as_slice()),
            Self::Tangent(p, t) => {
                finite("the position of the end (m)", p.coords.as_slice())?;
                finite("the tangent at the end", t.as_slice())
            }
            Self::Held(pose) => {
                finite("the position of the end (m)", pose.translation.vector.as_slice())?;
                finite("the frame of the end", pose.rotation.coords.as_slice())
            }
            Self::Sliding { point, along, force, hold } => {
                finite("the point of the line of the end (m)", point.coords.as_slice())?;
                finite("the line of the end", along.as_slice())?;
                finite("the force on the end (N)", &[*force])?;
                match hold {
                    EndHold::Joint => Ok(()),
                    EndHold::Tangent(t) => finite("the tangent at the end", t.as_slice()),
                    EndHold::Frame(q) => finite("the frame of the end", q.coords.as_slice()),
                }
            }
        }
    }
}
