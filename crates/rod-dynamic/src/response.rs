use crate::RodError;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// A point of a fibre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Index of the fibre in its batch.
    pub fiber: u32,
    /// Index of the segment.
    pub segment: u32,
    /// Where on the segment, 0 at its root end and 1 at its tip end.
    pub fraction: f64,
}

/// How the points of one fibre answer impulses on each other.
#[derive(Debug, Clone, PartialEq)]
pub struct PointResponses {
    /// Indices of the points, from root to tip.
    pub points: Vec<usize>,
    /// The change of the mean velocities (m/s) that impulses of 1 N s cause: symmetric, three rows
    /// and three columns a point.
    pub matrix: DMatrix<f64>,
}

/// How fibres whose step has been solved, but not finished, answer impulses.
///
/// An impulse is a jump of velocity at the start of the step, the answer the change of the mean
/// velocity over the step: the map is symmetric and positive semidefinite. An impulse `P` at the
/// fraction `f` of a segment is `(1 - f) P` on the node before and `f P` on the node behind, and
/// the velocity there is interpolated alike. Vectors are in the world frame; arrays hold the nodes
/// of the first fibre, then those of the second, and so on.
pub trait ImpulseResponse {
    /// Fibres times nodes: the length of the arrays.
    fn nodes(&self) -> usize;

    /// Writes the change of the mean velocities (m/s) that `impulses` (N s) cause to first order.
    /// One forward and one backward pass over the fibres.
    ///
    /// # Errors
    /// [`RodError::Length`] for arrays of the wrong length, [`RodError::Invalid`] if no step is
    /// under way; so of all that follow.
    fn respond(
        &mut self,
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError>;

    /// Writes the change of the mean velocities of points that impulses on them cause.
    ///
    /// # Errors
    /// [`RodError::Length`] for arrays that do not fit, [`RodError::Invalid`] for a point that is
    /// not on a fibre.
    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError>;

    /// The same for the fibres with the masses of [`ImpulseResponse::set_weights`] added.
    ///
    /// # Errors
    /// As [`ImpulseResponse::respond_at`].
    fn weighted_respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError>;

    /// Writes out how points answer impulses on each other, for every fibre with any, in the order
    /// of the fibres. One pass over the fibre a point, three columns at once: worth it for a few
    /// points that are asked often.
    ///
    /// # Errors
    /// [`RodError::Invalid`] for a point that is not on a fibre.
    fn write_out(&mut self, points: &[Point]) -> Result<Vec<PointResponses>, RodError>;

    /// Writes the answer of every node to an impulse on itself (1/kg), by selected inversion.
    ///
    /// # Errors
    /// [`RodError::Length`] for an array of the wrong length.
    fn diagonal_blocks(&mut self, blocks: &mut [Matrix3<f64>]) -> Result<(), RodError>;

    /// Adds masses (kg, that is impulse per velocity) at points, in place of all added before, and
    /// factorises again for [`ImpulseResponse::weighted_respond_at`]: its response is the inverse
    /// of `W^-1 + H^T M H`, `H` the interpolation to the points. To be called after each solve.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is a mass for each point, [`RodError::Invalid`] for a
    /// point that is not on a fibre or a mass that is negative or not finite.
    fn set_weights(&mut self, points: &[Point], masses: &[f64]) -> Result<(), RodError>;
}
