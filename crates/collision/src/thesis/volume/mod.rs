//! Bounding volumes: what a tree of capsules is made of (thesis, 7.3.7).
//!
//! Every volume is conservative. It holds its capsules with radii enlarged by 32 units of rounding
//! of their coordinates, which is more than the rounding of [`Capsule::closest`] and of all tests
//! here. So two capsules that touch by `closest` are in volumes that overlap.

mod aabb;
mod dop;
mod minimal_sphere;
mod obb;
mod principal_axes;
mod sphere;

pub use aabb::Aabb;
pub use dop::{Directions, Dop};
pub use minimal_sphere::Sphere;
pub use obb::Obb;

use crate::Capsule;
use nalgebra::{Point3, Vector3};

/// A convex set around capsules that is cheap to test for overlap.
///
/// A volume must be closed and hold what it was made of, also where capsules are points, coincide,
/// or are so far away that lengths overflow; then it may be all of space.
pub trait BoundingVolume: Clone + Send + Sync + 'static {
    /// What all volumes of a tree have in common: the directions of k-DOPs, nothing for others.
    type Shared: Clone + PartialEq + Send + Sync + 'static;

    /// The volume at a leaf.
    fn of_capsule(shared: &Self::Shared, capsule: &Capsule) -> Self;

    /// The volume above two leaves: what [`Self::merge`] gives, unless a tighter one is known.
    fn of_pair(shared: &Self::Shared, first: &Capsule, second: &Capsule) -> Self {
        Self::of_capsule(shared, first).merge(&Self::of_capsule(shared, second))
    }

    /// The volume around the leaves of at least one capsule, and its basis: the places in
    /// `capsules` of the leaves that determine it (thesis, 7.3.4). Cost: a few passes.
    fn span(
        shared: &Self::Shared,
        capsules: impl Iterator<Item = Capsule> + Clone,
    ) -> (Self, Vec<u32>);

    /// The volume of [`Self::span`] alone.
    fn wrap(shared: &Self::Shared, capsules: impl Iterator<Item = Capsule> + Clone) -> Self {
        Self::span(shared, capsules).0
    }

    /// This volume as its basis, moved meanwhile, determines it now.
    fn respan(&self, shared: &Self::Shared, basis: impl Iterator<Item = Capsule> + Clone) -> Self {
        Self::wrap(shared, basis)
    }

    /// A volume around both, not always the smallest.
    #[must_use]
    fn merge(&self, other: &Self) -> Self;

    /// Whether the two have a point in common; may be true where they only nearly have.
    fn overlaps(&self, other: &Self) -> bool;

    /// Whether `other` lies in this one, to the rounding that volumes are enlarged by; may be false
    /// where it just does.
    fn contains(&self, other: &Self) -> bool;

    /// Volume, m³.
    fn volume(&self) -> f64;

    /// The three axes across which to divide the capsules that this volume holds, the longest
    /// first.
    fn axes(
        &self,
        shared: &Self::Shared,
        capsules: impl Iterator<Item = Capsule> + Clone,
    ) -> [Axis; 3];
}

/// A direction in which a volume extends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Unit vector (world).
    pub direction: Vector3<f64>,
    /// Where the middle of the volume is along the direction, m from the origin.
    pub middle: f64,
    /// Extent of the volume along the direction, m.
    pub length: f64,
}

/// Relative enlargement of volumes.
const VOLUME_ROUNDING: f64 = 32.0 * f64::EPSILON;

/// What lengths near `point` may be wrong by, m.
fn rounding(point: &Point3<f64>, length: f64) -> f64 {
    VOLUME_ROUNDING * (point.coords.amax() + length)
}

/// Radius of `capsule` with what makes volumes conservative, m.
fn enlarged_radius(capsule: &Capsule) -> f64 {
    let Capsule { start, end, radius } = capsule;
    radius + rounding(start, *radius).max(rounding(end, *radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    static DIRECTIONS: LazyLock<[Directions; 3]> =
        LazyLock::new(|| [6, 8, 14].map(|k| Directions::new(k).expect("valid")));

    /// Coordinates that often coincide, and lengths from rounding to astronomy.
    fn capsule() -> impl Strategy<Value = Capsule> {
        let x = || prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64];
        let point = || prop::array::uniform3(x()).prop_map(Point3::from);
        (point(), point(), prop_oneof![Just(0.5), 1e-9..1.0_f64], any::<bool>()).prop_map(
            |(start, end, radius, tiny)| {
                let end = if tiny { start + 1e-200 * (end - start) } else { end };
                Capsule { start, end, radius }
            },
        )
    }

    fn capsules() -> impl Strategy<Value = Vec<Capsule>> {
        prop::collection::vec(capsule(), 1..12)
    }

    /// Every constructor of `V` holds its capsules, by `contains` and by the overlap with the
    /// volumes of small capsules on their surfaces; touching capsules overlap.
    fn is_conservative<V: BoundingVolume>(
        shared: &V::Shared,
        capsules: &[Capsule],
    ) -> Result<(), TestCaseError> {
        let all = capsules.iter().copied();
        let leaves: Vec<V> = capsules.iter().map(|c| V::of_capsule(shared, c)).collect();
        let (spanned, basis) = V::span(shared, all.clone());
        let respanned = spanned.respan(shared, basis.iter().map(|&b| capsules[b as usize]));
        let merged = leaves[1..].iter().fold(leaves[0].clone(), |v, leaf| v.merge(leaf));
        let pair = V::of_pair(shared, &capsules[0], &capsules[capsules.len() - 1]);
        for leaf in &leaves {
            prop_assert!(spanned.contains(leaf));
            // That a volume contains itself may be lost in rounding.
            prop_assert!(merged.contains(leaf) || leaves.len() == 1);
        }
        for &b in &basis {
            prop_assert!(respanned.contains(&leaves[b as usize]));
        }
        let holds = |v: &V, c: &Capsule| {
            let directions =
                [Vector3::x(), Vector3::new(-0.6, 0.0, 0.8), Vector3::new(1.0, -2.0, 2.0) / 3.0];
            directions.into_iter().all(|n| {
                [c.start + c.radius * n, c.end - c.radius * n].into_iter().all(|p| {
                    let dot = Capsule { start: p, end: p, radius: 1e-300 };
                    v.overlaps(&V::of_capsule(shared, &dot))
                })
            })
        };
        for (c, leaf) in capsules.iter().zip(&leaves) {
            prop_assert!(holds(&spanned, c) && holds(&merged, c) && holds(leaf, c));
        }
        prop_assert!(holds(&pair, &capsules[0]) && holds(&pair, &capsules[capsules.len() - 1]));
        for (a, first) in capsules.iter().zip(&leaves) {
            for (b, second) in capsules.iter().zip(&leaves) {
                let touch = a.closest(b).distance() <= a.radius + b.radius;
                let overlap = first.overlaps(second);
                prop_assert!(overlap || !touch);
                prop_assert_eq!(overlap, second.overlaps(first));
            }
        }
        prop_assert!(spanned.volume() > 0.0 && spanned.volume().is_finite());
        let axes = spanned.axes(shared, all);
        prop_assert!(axes[0].length >= axes[1].length && axes[1].length >= axes[2].length);
        for axis in axes {
            prop_assert!((axis.direction.norm() - 1.0).abs() < 1e-12);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn all_volumes_are_conservative(capsules in capsules()) {
            is_conservative::<Aabb>(&(), &capsules)?;
            is_conservative::<Obb>(&(), &capsules)?;
            is_conservative::<Sphere>(&(), &capsules)?;
            for directions in DIRECTIONS.iter() {
                is_conservative::<Dop>(directions, &capsules)?;
            }
        }

        /// Parts of one capsule touch exactly, wherever they are cut.
        #[test]
        fn capsules_that_touch_in_rounding_overlap(c in capsule(), cut in 0.0..1.0_f64) {
            let shift = Vector3::new(2.0 * c.radius, 0.0, 0.0);
            let middle = c.at(cut);
            let first = Capsule { end: middle, ..c };
            let second = Capsule { start: middle + shift, end: c.end + shift, ..c };
            is_conservative::<Aabb>(&(), &[first, second])?;
            is_conservative::<Obb>(&(), &[first, second])?;
            is_conservative::<Sphere>(&(), &[first, second])?;
            is_conservative::<Dop>(&DIRECTIONS[1], &[first, second])?;
        }
    }

    /// Where lengths overflow, volumes are too large but never too small.
    #[test]
    fn astronomic_capsules_overlap() {
        fn check<V: BoundingVolume>(shared: &V::Shared) {
            let far = Point3::new(1e308, -1e308, 1e308);
            let long = Capsule { start: far, end: -far, radius: 1.0 };
            let here = Capsule { start: Point3::origin(), end: Point3::origin(), radius: 1.0 };
            let (spanned, _) = V::span(shared, [long, here, long].into_iter());
            let here = V::of_capsule(shared, &here);
            let long = V::of_capsule(shared, &long);
            assert!(long.overlaps(&here) && spanned.overlaps(&here) && here.overlaps(&spanned));
            assert!(long.merge(&here).overlaps(&here));
        }
        check::<Aabb>(&());
        check::<Obb>(&());
        check::<Sphere>(&());
        check::<Dop>(&DIRECTIONS[1]);
    }
}
