use super::similarity::Similarity;
use nalgebra::{Point3, Unit, Vector3};
use rapunzel_collision::field::{DistanceField, MeshDistance};

/// The fitted head as the template's origin sees it.
pub(super) struct FittedView<'a> {
    pub(super) head: &'a MeshDistance,
    pub(super) similarity: &'a Similarity,
}

/// Farthest a head reaches from its origin, m, before the similarity.
const HEAD_REACH: f64 = 0.3;

impl FittedView<'_> {
    /// The outermost place of the head along a direction of the template's frame.
    pub(super) fn place(&self, direction: &Unit<Vector3<f64>>) -> Point3<f64> {
        let outward = self.similarity.rotation * direction.into_inner();
        let origin = self.similarity.apply(&Point3::origin());
        let mut far = HEAD_REACH * self.similarity.scale;
        // The distance is a way on which nothing is met.
        for _ in 0..200 {
            let free = self.head.value(&(origin + outward * far));
            far -= free;
            if free < 1e-9 || far <= 0.0 {
                break;
            }
        }
        origin + outward * far.max(0.0)
    }

    /// The direction in the template's frame in which a point lies.
    pub(super) fn direction(&self, point: &Point3<f64>) -> Option<Unit<Vector3<f64>>> {
        let origin = self.similarity.apply(&Point3::origin());
        let way = self.similarity.rotation.inverse() * (point - origin);
        Unit::try_new(way, 0.0)
    }
}
