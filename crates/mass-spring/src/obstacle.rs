use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::field::{DistanceField, Sample};

/// A body that nodes do not enter, at the end of a step. Nodes do not move it.
pub struct Obstacle<'a> {
    /// Distance field of its surface, in the body's own frame.
    pub field: &'a dyn DistanceField,
    /// Poses at the start and at the end of the step, from the body's own frame to the world.
    pub poses: [Isometry3<f64>; 2],
    /// Step size, s.
    pub dt: f64,
}

impl<'a> Obstacle<'a> {
    /// An obstacle at rest whose own frame is the world.
    #[must_use]
    pub fn at_rest(field: &'a dyn DistanceField) -> Self {
        Self { field, poses: [Isometry3::identity(); 2], dt: 1.0 }
    }

    /// The field and its gradient at a point (world).
    pub(crate) fn touch(&self, place: &Point3<f64>) -> Sample {
        let sample = self.field.sample(&self.poses[1].inverse_transform_point(place));
        Sample { gradient: self.poses[1] * sample.gradient, ..sample }
    }

    /// Mean velocity in the step of the material point that is at `place` at its end (world), m/s.
    pub(crate) fn velocity(&self, place: &Point3<f64>) -> Vector3<f64> {
        let [before, now] = &self.poses;
        if before == now {
            return Vector3::zeros();
        }
        (place - before * now.inverse_transform_point(place)) / self.dt
    }
}
