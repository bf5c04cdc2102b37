//! Spheres.

use super::minimal_sphere::{Sphere, minimal_sphere};
use super::{Aabb, Axis, BoundingVolume, enlarged_radius, rounding};
use crate::Capsule;
use nalgebra::Point3;

impl Sphere {
    /// Its middle (world), m.
    #[must_use]
    pub fn center(&self) -> Point3<f64> {
        self.center
    }

    /// Its radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Enlarged by rounding; all of space where its lengths are no numbers.
    fn enlarged(self) -> Self {
        let radius = self.radius + rounding(&self.center, self.radius);
        if radius.is_finite() && self.center.iter().all(|x| x.is_finite()) {
            Self { radius, ..self }
        } else {
            Self { center: Point3::origin(), radius: f64::INFINITY }
        }
    }
}

impl BoundingVolume for Sphere {
    type Shared = ();

    fn of_capsule((): &(), capsule: &Capsule) -> Self {
        let center = Point3::from(0.5 * capsule.start.coords + 0.5 * capsule.end.coords);
        let half = 0.5 * (capsule.end - capsule.start).norm();
        Self { center, radius: half + enlarged_radius(capsule) }.enlarged()
    }

    fn span((): &(), capsules: impl Iterator<Item = Capsule> + Clone) -> (Self, Vec<u32>) {
        let leaves: Vec<_> = capsules.map(|c| Self::of_capsule(&(), &c)).collect();
        let (sphere, basis) = minimal_sphere(&leaves);
        (sphere.enlarged(), basis)
    }

    fn merge(&self, other: &Self) -> Self {
        let offset = other.center - self.center;
        let distance = offset.norm();
        if distance + other.radius <= self.radius {
            return *self;
        }
        if distance + self.radius <= other.radius {
            return *other;
        }
        let radius = 0.5 * (distance + self.radius + other.radius);
        let center = self.center + offset * ((radius - self.radius) / distance);
        Self { center, radius }.enlarged()
    }

    fn overlaps(&self, other: &Self) -> bool {
        let apart = (other.center - self.center).norm_squared();
        let reach = self.radius + other.radius;
        // An infinite distance is no proof.
        apart <= reach * reach || apart.is_infinite()
    }

    fn contains(&self, other: &Self) -> bool {
        (other.center - self.center).norm() + other.radius <= self.radius
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3)
    }

    /// Those of the box around the capsules: a sphere has none.
    fn axes(&self, (): &(), capsules: impl Iterator<Item = Capsule> + Clone) -> [Axis; 3] {
        Aabb::wrap(&(), capsules.clone()).axes(&(), capsules)
    }
}
