use nalgebra::Point3;
use rapunzel_collision::field::{DistanceField, Sample};
use std::fmt;

/// The admissible region of hair (thesis 5.3): outside of the head and inside of the hull, the
/// surface of the hair's volume. Both are signed distance fields, positive outside.
#[derive(Clone, Copy)]
pub struct Region<'a> {
    /// Field of the head with its scalp.
    pub head: &'a dyn DistanceField,
    /// Field of the surface of the hair's volume.
    pub hull: &'a dyn DistanceField,
}

impl fmt::Debug for Region<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Region").finish_non_exhaustive()
    }
}

impl Region<'_> {
    /// Signed depths into the forbidden sides of head and hull at a point (world), m: positive
    /// inside the head and outside of the hull (5.10, with the sign of the head corrected).
    #[must_use]
    pub fn depths(&self, point: &Point3<f64>) -> [f64; 2] {
        [-self.head.value(point), self.hull.value(point)]
    }

    /// The depths of [`Region::depths`] with their gradients.
    #[must_use]
    pub fn walls(&self, point: &Point3<f64>) -> [Sample; 2] {
        let Sample { value, gradient } = self.head.sample(point);
        [Sample { value: -value, gradient: -gradient }, self.hull.sample(point)]
    }
}
