use super::rod::EndLoad;
use crate::Pore;
use nalgebra::Vector3;
use rapunzel_rod_static::Shape;

/// A pre-guide: a hair bent by a growing force on its end until all of it is deep enough below the
/// hull (thesis 5.3.3), or a shorter one that hangs. Pre-guides tell the main guides where hair
/// flows, and how long it can be.
#[derive(Debug, Clone)]
pub struct PreGuide {
    /// The pore it grows out of, with the length of the pre-guide, which is less than that of the
    /// pore where a hair of that length leaves the region.
    pub pore: Pore,
    /// Its shape: positions and frames of its nodes.
    pub shape: Shape,
    /// Curvatures of its segments times its length, in their own axes.
    pub bends: Vec<Vector3<f64>>,
    /// Load on its end.
    pub load: EndLoad,
    /// Whether it has found a place: all of it is deep enough and none in the head, or the least
    /// part of the pore's length that a guide must have hangs in the region.
    pub placed: bool,
}
