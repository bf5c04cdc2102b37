//! Discretely oriented polytopes with any number of faces.

use super::{Axis, BoundingVolume, enlarged_radius};
use crate::thesis::packing;
use crate::{Capsule, CollisionError};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// The face normals that all k-DOPs of a tree share: k/2 directions and their opposites.
#[derive(Debug, Clone, PartialEq)]
pub struct Directions(Arc<[Vector3<f64>]>);

impl Directions {
    /// Directions as far from each other as k/2 lines can be: [`packing::lines`]. Cost: see there;
    /// make them once and clone them.
    ///
    /// # Errors
    /// [`CollisionError::Directions`] if `k` is odd or less than 6.
    pub fn new(k: usize) -> Result<Self, CollisionError> {
        if k < 6 || !k.is_multiple_of(2) {
            return Err(CollisionError::Directions { k });
        }
        Ok(Self(packing::lines(k / 2).into()))
    }

    /// Number of faces k.
    #[must_use]
    pub fn k(&self) -> usize {
        2 * self.0.len()
    }

    /// The k/2 unit vectors (world).
    #[must_use]
    pub fn vectors(&self) -> &[Vector3<f64>] {
        &self.0
    }
}

/// A k-DOP: the intersection of k/2 slabs of the shared [`Directions`] (thesis, 7.3.7.2, (7.6)). A
/// tree of them is the same wrapped and layered, as for boxes.
#[derive(Debug, Clone, PartialEq)]
pub struct Dop {
    /// Least and largest coordinate along every direction, m.
    slabs: Box<[[f64; 2]]>,
}

impl Dop {
    /// The least and the largest coordinate along every direction, m.
    #[must_use]
    pub fn slabs(&self) -> &[[f64; 2]] {
        &self.slabs
    }
}

/// The slab of a capsule: (7.9), with the radius (erratum 7.3.7.2).
fn slab(direction: &Vector3<f64>, capsule: &Capsule, radius: f64) -> [f64; 2] {
    let [a, b] = [capsule.start, capsule.end].map(|p| direction.dot(&p.coords));
    [a.min(b) - radius, a.max(b) + radius]
}

impl BoundingVolume for Dop {
    type Shared = Directions;

    fn of_capsule(shared: &Directions, capsule: &Capsule) -> Self {
        let radius = enlarged_radius(capsule);
        Self { slabs: shared.0.iter().map(|n| slab(n, capsule, radius)).collect() }
    }

    fn span(
        shared: &Directions,
        capsules: impl Iterator<Item = Capsule> + Clone,
    ) -> (Self, Vec<u32>) {
        let all = Self::wrap(shared, capsules.clone());
        let mut basis = vec![[0; 2]; all.slabs.len()];
        for (place, capsule) in (0..).zip(capsules) {
            let leaf = Self::of_capsule(shared, &capsule);
            for ((determines, [low, high]), own) in
                basis.iter_mut().zip(&all.slabs).zip(&leaf.slabs)
            {
                if own[0] <= *low {
                    determines[0] = place;
                }
                if own[1] >= *high {
                    determines[1] = place;
                }
            }
        }
        let mut basis: Vec<u32> = basis.into_iter().flatten().collect();
        basis.sort_unstable();
        basis.dedup();
        (all, basis)
    }

    fn wrap(shared: &Directions, capsules: impl Iterator<Item = Capsule> + Clone) -> Self {
        let mut slabs = vec![[f64::INFINITY, f64::NEG_INFINITY]; shared.0.len()];
        for capsule in capsules {
            let radius = enlarged_radius(&capsule);
            for ([low, high], n) in slabs.iter_mut().zip(shared.0.iter()) {
                let own = slab(n, &capsule, radius);
                *low = low.min(own[0]);
                *high = high.max(own[1]);
            }
        }
        Self { slabs: slabs.into() }
    }

    fn merge(&self, other: &Self) -> Self {
        let both = self.slabs.iter().zip(&other.slabs);
        Self { slabs: both.map(|(a, b)| [a[0].min(b[0]), a[1].max(b[1])]).collect() }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.slabs.iter().zip(&other.slabs).all(|(a, b)| a[0] <= b[1] && b[0] <= a[1])
    }

    fn contains(&self, other: &Self) -> bool {
        self.slabs.iter().zip(&other.slabs).all(|(a, b)| a[0] <= b[0] && b[1] <= a[1])
    }

    /// That of the ball with the same mean width over the directions: an estimate from above, since
    /// no convex body has more volume at a given mean width (Urysohn).
    fn volume(&self) -> f64 {
        let width: f64 = self.slabs.iter().map(|[low, high]| high - low).sum();
        PI / 6.0 * (width / self.slabs.len() as f64).powi(3)
    }

    fn axes(&self, shared: &Directions, _: impl Iterator<Item = Capsule> + Clone) -> [Axis; 3] {
        let axis = |(direction, [low, high]): (&Vector3<f64>, &[f64; 2])| Axis {
            direction: *direction,
            middle: 0.5 * low + 0.5 * high,
            length: high - low,
        };
        let mut axes: Vec<Axis> = shared.0.iter().zip(&self.slabs).map(axis).collect();
        axes.sort_by(|a, b| b.length.total_cmp(&a.length));
        // There are at least three directions.
        [axes[0], axes[1], axes[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_come_in_pairs() {
        for k in [0, 2, 4, 5, 7, 15] {
            assert_eq!(Directions::new(k).expect_err("refused"), CollisionError::Directions { k });
        }
        assert_eq!(Directions::new(10).expect("valid").k(), 10);
    }

    /// The offset of a face is that of the farther end, and the radius (erratum 7.3.7.2).
    #[test]
    fn faces_touch_the_capsule() {
        let directions = Directions(vec![Vector3::z(), Vector3::x(), Vector3::y()].into());
        let capsule =
            Capsule { start: [0.0, 0.0, 3.0].into(), end: [0.0, 1.0, 1.0].into(), radius: 0.5 };
        let slabs = Dop::of_capsule(&directions, &capsule).slabs;
        for (slab, expected) in slabs.iter().zip([[0.5, 3.5], [-0.5, 0.5], [-0.5, 1.5]]) {
            assert!((0..2).all(|i| (slab[i] - expected[i]).abs() < 1e-13), "{slabs:?}");
        }
    }
}
