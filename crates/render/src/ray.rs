use nalgebra::{Point3, Vector3};

/// A half line along which light is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it begins (world), m.
    pub origin: Point3<f64>,
    /// Its direction (world), of unit length.
    pub direction: Vector3<f64>,
    /// When in the time of exposure it is there, in `[0, 1]`.
    pub time: f64,
}

impl Ray {
    /// The point at a distance, m.
    #[must_use]
    pub fn at(&self, distance: f64) -> Point3<f64> {
        self.origin + distance * self.direction
    }
}
