//! Between the space of a system, which may be flat, and the world.

use nalgebra::{Point, Point3, SVector, Vector3};

/// A vector of the world in the space of a system: all of it, or x and z.
pub(crate) fn flat<const D: usize>(vector: &[f64; 3]) -> SVector<f64, D> {
    SVector::from_fn(|axis, _| if axis + 1 == D { vector[2] } else { vector[axis] })
}

/// A point of a system in the world.
pub(crate) fn in_world<const D: usize>(point: &Point<f64, D>) -> Point3<f64> {
    spatial(&point.coords).into()
}

/// The other way.
pub(crate) fn spatial<const D: usize>(vector: &SVector<f64, D>) -> Vector3<f64> {
    let mut result = Vector3::zeros();
    for axis in 0..D {
        result[if axis + 1 == D { 2 } else { axis }] = vector[axis];
    }
    result
}
