//! Places on a mesh of triangles.

use rapunzel_collision::field::NearestPoint;
use std::ops::{Add, Mul};

/// A point of a mesh of triangles: a face and the weights of its corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    face: u32,
    weights: [f64; 3],
}

impl SurfacePoint {
    /// The point of `face` with these weights, not negative and of sum 1.
    pub(super) fn new(face: u32, weights: [f64; 3]) -> Self {
        Self { face, weights }
    }

    /// Index of the triangle.
    #[must_use]
    pub fn face(&self) -> u32 {
        self.face
    }

    /// Weights of its corners (barycentric coordinates): not negative, of sum 1.
    #[must_use]
    pub fn weights(&self) -> [f64; 3] {
        self.weights
    }

    /// The value here of what is linear in the triangle and has these values at its corners.
    #[must_use]
    pub fn mix<T: Mul<f64, Output = T> + Add<Output = T>>(&self, [a, b, c]: [T; 3]) -> T {
        let [u, v, w] = self.weights;
        a * u + b * v + c * w
    }
}

impl From<NearestPoint> for SurfacePoint {
    fn from(nearest: NearestPoint) -> Self {
        // A face has a number of 32 bits in its mesh.
        let face = u32::try_from(nearest.face).unwrap_or(u32::MAX);
        Self { face, weights: nearest.weights }
    }
}
