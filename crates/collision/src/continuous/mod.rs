//! Continuous detection: whether, and when, moving things touch within a step.
//!
//! What moves does so with constant velocities of its corners, over a step in which the time runs
//! from 0 to 1. The thesis leaves this out (7.6).
//!
//! No contact is ever missed: where the distance falls to `reach` at any time of the step, an
//! [`Impact`] is returned, and its time is not later than that. It is a false alarm only where the
//! least distance lies between `reach` and `reach + tolerance`, or where the search was given up,
//! which [`Impact::resolved`] tells. For capsules, `reach` is the sum of the radii, plus a margin.

mod advance;
mod field;
mod pairs;
mod segments;
mod triangle;

pub use pairs::impacts;
pub use segments::MovingSegment;
pub use triangle::{MovingPoint, MovingTriangle};

use nalgebra::{Point3, Vector3};

/// The first time at which two moving things come within reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact<const N: usize> {
    /// Fraction of the step, in 0..=1; 0 if they are in reach from the start. Never later than the
    /// true first time.
    pub time: f64,
    /// Where they touch at that time. What the coordinates are is said where this is returned.
    pub coordinates: [f64; N],
    /// From the point on the first to the point on the second, at that time (world), m. Its length
    /// is at most `reach + tolerance` if the impact is resolved; its direction is the normal.
    pub offset: Vector3<f64>,
    /// Whether the two are known to come within `reach + tolerance`; else the search was given up
    /// at `time`, up to which nothing touches.
    pub resolved: bool,
    /// How many pairs of closest points were computed.
    pub evaluations: usize,
}

/// A point in uniform motion, relative to an origin that rests.
#[derive(Debug, Clone, Copy)]
struct Path {
    start: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl Path {
    fn new(origin: Point3<f64>, before: Point3<f64>, after: Point3<f64>) -> Self {
        Self { start: before - origin, velocity: after - before }
    }

    fn minus(&self, other: &Self) -> Self {
        Self { start: self.start - other.start, velocity: self.velocity - other.velocity }
    }

    fn at(&self, time: f64) -> Vector3<f64> {
        self.start + time * self.velocity
    }

    fn middle(&self, other: &Self) -> Self {
        Self {
            start: 0.5 * (self.start + other.start),
            velocity: 0.5 * (self.velocity + other.velocity),
        }
    }

    /// Bounds all coordinates that occur in the step; not finite if they are not.
    fn scale(&self) -> f64 {
        self.start.lp_norm(1) + self.velocity.lp_norm(1)
    }
}
