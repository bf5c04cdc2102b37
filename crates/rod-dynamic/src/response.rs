use crate::RodError;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Impulses on points of the fibres of a batch at the start of a step, as many as points. Impulses
/// on the same point add up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impulses<'a> {
    /// Where they act.
    pub points: &'a [Point],
    /// The impulses, N s, world.
    pub impulses: &'a [Vector3<f64>],
}

impl Impulses<'_> {
    /// No impulses.
    pub const NONE: Impulses<'static> = Impulses { points: &[], impulses: &[] };

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// A point that moves with a segment of a fibre, or a couple on one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Index of the fibre in its batch.
    pub fiber: u32,
    /// Index of the segment.
    pub segment: u32,
    /// What an impulse does to the segment.
    pub action: PointAction,
}

/// What an impulse on a point does to its segment, and which velocity of it is meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointAction {
    /// It acts at a place, and the velocity is that of the place.
    Force {
        /// Position on the segment, 0 at its root end and 1 at its tip end.
        fraction: f64,
        /// From the axis to the place, m, world; zero for a place on the axis.
        arm: Vector3<f64>,
    },
    /// An impulse `P` is the moment `lever P` of an impulse, without a force, and the velocity is
    /// `lever^T w` for the mean angular velocity `w` of the segment.
    Couple {
        /// m, world.
        lever: Matrix3<f64>,
    },
}

impl Point {
    /// A point on the axis of a fibre.
    #[must_use]
    pub fn on_axis(fiber: u32, segment: u32, fraction: f64) -> Self {
        Self::beside_axis(fiber, segment, fraction, Vector3::zeros())
    }

    /// A point at an arm, m, world, from the axis of a fibre.
    #[must_use]
    pub fn beside_axis(fiber: u32, segment: u32, fraction: f64, arm: Vector3<f64>) -> Self {
        Self { fiber, segment, action: PointAction::Force { fraction, arm } }
    }

    /// Parts of an impulse on the nodes before and behind the segment; none of a couple.
    #[must_use]
    pub fn shares(&self) -> [f64; 2] {
        match self.action {
            PointAction::Force { fraction, .. } => [1.0 - fraction, fraction],
            PointAction::Couple { .. } => [0.0; 2],
        }
    }

    /// Moment of an impulse (N s) about the axis of the segment, N m s.
    #[must_use]
    pub fn moment(&self, impulse: &Vector3<f64>) -> Vector3<f64> {
        match &self.action {
            PointAction::Force { arm, .. } => arm.cross(impulse),
            PointAction::Couple { lever } => lever * impulse,
        }
    }

    /// What an angular velocity of the segment, rad/s, adds to the velocity, m/s.
    #[must_use]
    pub fn turned(&self, spin: &Vector3<f64>) -> Vector3<f64> {
        match &self.action {
            PointAction::Force { arm, .. } => spin.cross(arm),
            PointAction::Couple { lever } => lever.tr_mul(spin),
        }
    }
}

/// Response of points on one fibre to impulses on each other.
#[derive(Debug, Clone, PartialEq)]
pub struct PointResponses {
    /// Indices of the points in the caller's list, sorted from root to tip.
    pub points: Vec<usize>,
    /// Change of the mean velocities (m/s) per impulse (N s), 1/kg: symmetric, three rows and three
    /// columns per point in the order of `points`.
    pub matrix: DMatrix<f64>,
}

/// Response to impulses of fibres whose step has been solved, but not committed.
///
/// An impulse is a jump of velocity at the start of the step, the response the change of the mean
/// velocity over the step: the map is symmetric and positive semidefinite. An impulse `P` at the
/// fraction `f` of a segment is `(1 - f) P` on the node before and `f P` on the node behind, and
/// the velocity there is interpolated alike; beside the axis, at an arm `a`, the impulse has the
/// moment `a x P` about it too, and the velocity the part `w x a` of the segment's mean angular
/// velocity `w`. A couple is the moment alone. Vectors are in the world frame; arrays hold the
/// nodes of the first fibre, then those of the second, and so on.
pub trait ImpulseResponse {
    /// Number of nodes of all fibres together: the length of the arrays.
    fn nodes(&self) -> usize;

    /// Writes the change of the mean velocities (m/s) that `impulses` (N s) cause to first order.
    /// One forward and one backward pass over the fibres.
    ///
    /// # Errors
    /// [`RodError::Length`] for arrays of the wrong length, [`RodError::Invalid`] if no step is
    /// under way.
    fn respond(
        &mut self,
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError>;

    /// Writes the change of the mean velocities (m/s) at points that `impulses` (N s) on these
    /// points cause to first order; both arrays have one entry per point.
    ///
    /// # Errors
    /// [`RodError::Length`] for arrays that do not fit, [`RodError::Invalid`] for a point that is
    /// not on a fibre or if no step is under way.
    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError>;

    /// Writes the response at points like [`ImpulseResponse::respond_at`], for the fibres with the
    /// masses of [`ImpulseResponse::set_weights`] added.
    ///
    /// # Errors
    /// As [`ImpulseResponse::respond_at`].
    fn weighted_respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError>;

    /// Response matrices of the points of every fibre that has any, in the order of the fibres. One
    /// pass over the fibre per point, three columns at once: worth it for a few points whose
    /// response is needed often.
    ///
    /// # Errors
    /// [`RodError::Invalid`] for a point that is not on a fibre or if no step is under way.
    fn write_out(&mut self, points: &[Point]) -> Result<Vec<PointResponses>, RodError>;

    /// Writes the 3 x 3 response of every node to an impulse on itself (1/kg), and of the mean
    /// angular velocity of every segment to a moment on itself (1/(kg m^2)), by selected inversion.
    ///
    /// # Errors
    /// [`RodError::Length`] for an array of the wrong length, [`RodError::Invalid`] if no step is
    /// under way.
    fn diagonal_blocks(
        &mut self,
        nodes: &mut [Matrix3<f64>],
        segments: &mut [Matrix3<f64>],
    ) -> Result<(), RodError>;

    /// Adds masses (kg, that is impulse per velocity) at points, in place of all masses added
    /// before, and factorises again for [`ImpulseResponse::weighted_respond_at`], whose response is
    /// the inverse of `W^-1 + H^T M H`: `W` the response without them, `H` the interpolation to the
    /// points. To be called after each solve.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is a mass for each point, [`RodError::Invalid`] for a
    /// point that is not on a fibre, a mass that is negative or not finite, or if no step is under
    /// way.
    fn set_weights(&mut self, points: &[Point], masses: &[f64]) -> Result<(), RodError>;
}
