//! Boxes along the axes of the world.

use super::{Axis, BoundingVolume, enlarged_radius};
use crate::Capsule;
use nalgebra::{Point3, Vector3};

/// An axis-aligned bounding box (thesis, 7.3.7.1). A tree of them is the same wrapped and layered
/// (lemma 7.3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Aabb {
    /// The corner with the least coordinates (world), m.
    #[must_use]
    pub fn low(&self) -> Point3<f64> {
        self.low
    }

    /// The corner with the largest coordinates (world), m.
    #[must_use]
    pub fn high(&self) -> Point3<f64> {
        self.high
    }
}

impl BoundingVolume for Aabb {
    type Shared = ();

    fn of_capsule((): &(), capsule: &Capsule) -> Self {
        let radius = Vector3::repeat(enlarged_radius(capsule));
        let Capsule { start, end, .. } = capsule;
        Self { low: start.inf(end) - radius, high: start.sup(end) + radius }
    }

    fn span((): &(), capsules: impl Iterator<Item = Capsule> + Clone) -> (Self, Vec<u32>) {
        let all = Self::wrap(&(), capsules.clone());
        let mut basis = [0; 6];
        for (place, capsule) in (0..).zip(capsules) {
            let leaf = Self::of_capsule(&(), &capsule);
            for d in 0..3 {
                if leaf.low[d] <= all.low[d] {
                    basis[d] = place;
                }
                if leaf.high[d] >= all.high[d] {
                    basis[3 + d] = place;
                }
            }
        }
        let mut basis = basis.to_vec();
        basis.sort_unstable();
        basis.dedup();
        (all, basis)
    }

    fn wrap((): &(), capsules: impl Iterator<Item = Capsule> + Clone) -> Self {
        let none = Self {
            low: Vector3::repeat(f64::INFINITY).into(),
            high: Vector3::repeat(f64::NEG_INFINITY).into(),
        };
        capsules.fold(none, |all, capsule| all.merge(&Self::of_capsule(&(), &capsule)))
    }

    fn merge(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|d| self.low[d] <= other.high[d] && other.low[d] <= self.high[d])
    }

    fn contains(&self, other: &Self) -> bool {
        (0..3).all(|d| self.low[d] <= other.low[d] && other.high[d] <= self.high[d])
    }

    fn volume(&self) -> f64 {
        (self.high - self.low).product()
    }

    fn axes(&self, (): &(), _: impl Iterator<Item = Capsule> + Clone) -> [Axis; 3] {
        let mut axes = [0, 1, 2].map(|d| Axis {
            direction: Vector3::ith(d, 1.0),
            middle: 0.5 * self.low[d] + 0.5 * self.high[d],
            length: self.high[d] - self.low[d],
        });
        axes.sort_by(|a, b| b.length.total_cmp(&a.length));
        axes
    }
}
