use nalgebra::{Point2, Point3, Unit, Vector3};

/// A place of the scalp out of which a hair grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pore {
    /// Place (world), m.
    pub position: Point3<f64>,
    /// Outward normal of the scalp there (world).
    pub normal: Unit<Vector3<f64>>,
    /// Direction in which the hair leaves the scalp (world): the tangent of its root.
    pub direction: Unit<Vector3<f64>>,
    /// Length of the hair, m.
    pub length: f64,
    /// Place in the unit disc that the scalp is mapped to.
    pub disc: Point2<f64>,
}
