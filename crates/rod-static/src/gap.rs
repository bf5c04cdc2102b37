//! What rods may touch, as seen by a search for their equilibrium.

use nalgebra::{DMatrix, Point3, Vector3};

/// The gap between a rod and something else, as a function of the positions of stations
/// of the rods: the root, the middles of the segments, and the tip, counted from the root.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// What is apart: a body and a part of it, and the other body and a part of that. The gap of
    /// the same two parts has the same numbers in every shape.
    pub between: [usize; 4],
    /// Distance of the two surfaces, m; negative where they are in each other.
    pub value: f64,
    /// Stations that it depends on, and its derivatives by their positions.
    pub terms: Vec<GapTerm>,
    /// Second derivatives by the positions of these stations, 1/m: three rows and columns for each,
    /// in the order of the terms.
    pub curvature: DMatrix<f64>,
}

/// A station that a gap depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapTerm {
    /// Index of the rod.
    pub rod: usize,
    /// Index of its station.
    pub station: usize,
    /// Derivative of the gap by the station's position, world frame.
    pub derivative: Vector3<f64>,
}

/// The gaps between rods, and between rods and what stands around them.
pub trait GapFunctions {
    /// The gaps that are below a margin of the implementation's choice, at these positions (m,
    /// world frame) of the stations of all rods, in an order that depends on the positions only.
    fn gaps(&self, positions: &[Vec<Point3<f64>>]) -> Vec<Gap>;

    /// Whether rods may pass through something on the straight ways between two sets of positions
    /// (m, world frame).
    fn is_crossed(&self, from: &[Vec<Point3<f64>>], to: &[Vec<Point3<f64>>]) -> bool;

    /// The smallest radius or thickness of what rods may pass through, m; infinite where there is
    /// no such thing.
    fn thinnest(&self) -> f64;
}
