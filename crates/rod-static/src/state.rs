use crate::StaticError;
use crate::error::finite;
use nalgebra::{Point3, Rotation3, Vector3};

/// State of a rod at one arc length: position, frame, force and moment.
///
/// Force and moment are what the part beyond exerts on the part before, in the world frame:
/// `n' + f = 0` and `m' + d3 x n = 0` with the load `f` per length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Position of the center line, m.
    pub position: Point3<f64>,
    /// Material frame `[d1 d2 d3]`, the tangent last.
    pub frame: Rotation3<f64>,
    /// Force n, N, world frame.
    pub force: Vector3<f64>,
    /// Moment m, N m, world frame.
    pub moment: Vector3<f64>,
}

impl State {
    /// Checks that all numbers are finite.
    pub(crate) fn validate(&self) -> Result<(), StaticError> {
        finite("the position (m)", self.position.coords.as_slice())?;
        finite("the frame", self.frame.matrix().as_slice())?;
        finite("the force (N)", self.force.as_slice())?;
        finite("the moment (N m)", self.moment.as_slice())
    }
}
