use super::Ellipse;
use super::random::Random;
use crate::error::{fraction, positive};
use crate::{Fiber, FiberError, so3};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// `count` copies of `fiber`, translated without rotation, with their roots on `patch`.
///
/// # Errors
/// As [`Ellipse::roots`].
pub fn bundle(
    fiber: &Fiber,
    patch: &Ellipse,
    count: usize,
    seed: u64,
) -> Result<Vec<Fiber>, FiberError> {
    let rotation = fiber.root().rotation;
    let moved = |root: Point3<f64>| {
        fiber.clone().with_root(Isometry3::from_parts(Translation3::from(root), rotation))
    };
    Ok(patch.roots(count, seed)?.into_iter().map(moved).collect())
}

/// A lock: fibres that follow a guide (thesis 3.4.4: one guide and 180 of them).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lock {
    /// Number of fibres beside the guide.
    pub count: usize,
    /// Radius of the disc on which the roots stand, m, around the guide's root and normal to it.
    pub radius: f64,
    /// Relative variation of the natural curvature: each of its three components is the guide's
    /// times a random factor, one per fibre, from `1 - variation` to `1 + variation`. In `[0, 1]`.
    pub curvature_variation: f64,
    /// Fraction by which the tips draw together, in `[0, 1]`: 0 keeps the fibres parallel, 1 aims
    /// all at the guide's tip.
    pub clumping: f64,
}

impl Lock {
    /// Grows the lock: the guide first, unchanged, then `count` fibres.
    ///
    /// A fibre is the guide with its own natural curvature, moved to its root and turned about it
    /// so that the line from root to tip aims at a point that lies by the fraction `clumping` of
    /// the way from its own tip to the guide's. Where that line has no length (a closed ring) the
    /// fibre is not turned.
    ///
    /// # Errors
    /// Refuses a radius that is not positive and fractions outside of `[0, 1]`.
    pub fn grow(&self, guide: &Fiber, seed: u64) -> Result<Vec<Fiber>, FiberError> {
        positive("radius of the lock (m)", self.radius)?;
        fraction("curvature variation", self.curvature_variation)?;
        fraction("clumping", self.clumping)?;
        let patch = Ellipse { pose: *guide.root(), a: self.radius, b: self.radius };
        let roots = patch.roots(self.count, seed)?;
        // Another stream than that of the roots, so that the variation does not move them.
        let mut random = Random::new(!seed);
        let mut fibers = vec![guide.clone()];
        for root in roots {
            let factors =
                Vector3::from_fn(|_, _| 1.0 + self.curvature_variation * random.symmetric());
            fibers.push(self.follow(guide, root, &factors)?);
        }
        Ok(fibers)
    }

    fn follow(
        &self,
        guide: &Fiber,
        root: Point3<f64>,
        factors: &Vector3<f64>,
    ) -> Result<Fiber, FiberError> {
        let curvatures: Vec<_> =
            guide.nodes().iter().map(|n| n.natural_curvature.component_mul(factors)).collect();
        let fiber = guide.clone().with_node_curvatures(&curvatures)?;
        let base = guide.root();
        let (tip, own_tip) = (tip(guide), tip(&fiber));
        let chord = own_tip.coords - base.translation.vector;
        let aim = chord.lerp(&(tip - root), self.clumping);
        let turn = so3::between(&chord, &aim)
            .map_or_else(UnitQuaternion::identity, |r| so3::quaternion(&r));
        Ok(fiber.with_root(Isometry3::from_parts(Translation3::from(root), turn * base.rotation)))
    }
}

/// Position of the tip of the unloaded fibre (world).
fn tip(fiber: &Fiber) -> Point3<f64> {
    fiber.rest_shape().0[fiber.segments()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Handedness, Helix, root_pose};
    use crate::{Material, Section};

    fn guide() -> Fiber {
        let pose = root_pose(Point3::new(0.0, 0.0, 0.25), &-Vector3::z()).expect("a direction");
        let helix = Helix { radius: 0.005, pitch: 0.05, handedness: Handedness::Right };
        let section = Section::Circle { radius: 35e-6 };
        let straight = Fiber::uniform(0.25, 40, section, &Material::HAIR).expect("valid hair");
        helix.bend(straight.with_root(pose)).expect("a helix")
    }

    const LOCK: Lock = Lock { count: 180, radius: 0.01, curvature_variation: 0.1, clumping: 0.0 };

    #[test]
    fn the_lock_of_the_thesis() {
        let fibers = LOCK.grow(&guide(), 1).expect("a lock");
        assert_eq!(fibers.len(), 181);
        assert_eq!(fibers[0], guide());
        for fiber in &fibers {
            let offset = guide().root().inverse() * Point3::from(fiber.root().translation.vector);
            assert!(offset.z.abs() < 1e-15 && offset.coords.norm() < LOCK.radius, "{offset}");
            let (own, first) = (fiber.nodes()[7], guide().nodes()[7]);
            for k in 1..3 {
                let ratio = own.natural_curvature[k] / first.natural_curvature[k];
                assert!((0.9..=1.1).contains(&ratio), "variation {ratio}");
            }
        }
    }

    #[test]
    fn clumping_draws_the_tips_together() {
        let still = Lock { curvature_variation: 0.0, ..LOCK };
        for clumping in [0.0, 0.5, 1.0] {
            for fiber in (Lock { clumping, ..still }).grow(&guide(), 2).expect("a lock") {
                let offset = fiber.root().translation.vector - guide().root().translation.vector;
                let (left, goal) = (tip(&fiber) - tip(&guide()), (1.0 - clumping) * offset);
                // A turn keeps the length of the chord, which to aim would have to change.
                let chord = (tip(&guide()).coords - guide().root().translation.vector).norm();
                let aim =
                    (tip(&guide()).coords + goal - guide().root().translation.vector - offset)
                        .norm();
                assert!((left - goal).norm() < (aim - chord).abs() + 1e-15, "{left} {goal}");
            }
        }
    }

    #[test]
    fn full_clumping_aims_at_the_tip_of_the_guide() {
        let wild = Lock { curvature_variation: 0.3, clumping: 1.0, ..LOCK };
        for fiber in wild.grow(&guide(), 3).expect("a lock") {
            let root = Point3::from(fiber.root().translation.vector);
            let (own, aim) = (tip(&fiber) - root, tip(&guide()) - root);
            assert!(own.normalize().cross(&aim.normalize()).norm() < 1e-13);
        }
    }

    #[test]
    fn without_spread_the_fibers_are_copies() {
        let still = Lock { curvature_variation: 0.0, ..LOCK };
        let fibers = still.grow(&guide(), 1).expect("a lock");
        let patch = Ellipse { pose: *guide().root(), a: LOCK.radius, b: LOCK.radius };
        assert_eq!(fibers[1..], bundle(&guide(), &patch, 180, 1).expect("a bundle"));
    }

    #[test]
    fn a_seed_is_a_seed() {
        let lock = Lock { clumping: 0.7, ..LOCK };
        assert_eq!(lock.grow(&guide(), 5), lock.grow(&guide(), 5));
        let (a, b) = (lock.grow(&guide(), 5), lock.grow(&guide(), 6));
        assert_ne!(a, b);
        // The variation does not move the roots.
        let other = Lock { curvature_variation: 0.3, clumping: 0.0, ..LOCK };
        for (f, g) in a.expect("a lock").iter().zip(other.grow(&guide(), 5).expect("a lock")) {
            assert_eq!(f.root().translation, g.root().translation);
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let grow = |lock: Lock| lock.grow(&guide(), 1).expect_err("nonsense");
        assert!(matches!(grow(Lock { radius: 0.0, ..LOCK }), FiberError::NotPositive { .. }));
        assert!(matches!(grow(Lock { clumping: 1.5, ..LOCK }), FiberError::OutOfRange { .. }));
        let wild = Lock { curvature_variation: f64::NAN, ..LOCK };
        assert!(matches!(grow(wild), FiberError::OutOfRange { .. }));
    }
}
