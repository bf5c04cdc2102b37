use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{DistanceField, Sample};

/// Where hair may be (thesis 5.3): outside of the head and within the surface of the hair.
#[derive(Clone, Copy)]
pub struct AdmissibleRegion<'a> {
    /// Distance of the head; positive where hair may be.
    pub head: &'a dyn DistanceField,
    /// Distance of the surface of the hair; negative where hair may be.
    pub hull: &'a dyn DistanceField,
}

impl<'a> AdmissibleRegion<'a> {
    /// The region between two surfaces.
    #[must_use]
    pub fn new(head: &'a dyn DistanceField, hull: &'a dyn DistanceField) -> Self {
        Self { head, hull }
    }

    /// Distance from the nearer of the two surfaces, m, positive where hair may be, and its
    /// gradient. Cost: a query of both fields.
    #[must_use]
    pub fn clearance(&self, point: &Point3<f64>) -> Sample {
        let (head, hull) = (self.head.sample(point), self.hull.sample(point));
        if head.value <= -hull.value {
            head
        } else {
            Sample { value: -hull.value, gradient: -hull.gradient }
        }
    }

    /// How deep a point is between both surfaces: 0 at the head and below it, 1 at the surface of
    /// the hair and beyond, and the gradient, 1/m, which is zero where the depth is held at 0 or 1.
    /// Cost: a query of both fields.
    #[must_use]
    pub fn depth(&self, point: &Point3<f64>) -> Sample {
        let (head, hull) = (self.head.sample(point), self.hull.sample(point));
        // Both distances superposed (thesis 5.3.3): `h / (h + d)`.
        let (above, below) = (head.value, -hull.value);
        if above <= 0.0 || below <= 0.0 {
            let value = if above <= 0.0 { 0.0 } else { 1.0 };
            return Sample { value, gradient: Vector3::zeros() };
        }
        let across = above + below;
        let gradient = (head.gradient * below + hull.gradient * above) / (across * across);
        Sample { value: above / across, gradient }
    }
}
