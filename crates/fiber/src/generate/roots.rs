use super::random::Random;
use crate::FiberError;
use crate::error::positive;
use nalgebra::{Isometry3, Point3};
use std::f64::consts::{PI, TAU};

/// A flat elliptic patch of skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Pose of the patch in the world: it lies in the plane of the pose's x and y axes, z is its
    /// normal.
    pub pose: Isometry3<f64>,
    /// Semi-axis along x, m.
    pub a: f64,
    /// Semi-axis along y, m.
    pub b: f64,
}

impl Ellipse {
    /// Area of the patch, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        PI * self.a * self.b
    }

    /// Number of roots on the patch at `density` roots per m^2, to the nearest integer. A human
    /// scalp has 1.5e6 to 3e6 per m^2.
    ///
    /// # Errors
    /// Refuses what is not positive, and more than a thousand million roots.
    pub fn count(&self, density: f64) -> Result<usize, FiberError> {
        self.validate()?;
        positive("density of roots (1/m^2)", density)?;
        let count = (density * self.area()).round();
        if count > 1e9 {
            return Err(FiberError::OutOfRange {
                quantity: "number of roots",
                value: count,
                range: "[0, 1e9]",
            });
        }
        #[expect(clippy::cast_possible_truncation, reason = "an integer in [0, 1e9]")]
        Ok(count as usize)
    }

    /// `count` roots (world, m), spread evenly without rows or clumps.
    ///
    /// The roots sit on Vogel's spiral, mapped to the ellipse, `r = sqrt(area share)` at multiples
    /// of the golden angle (H. Vogel, A better way to construct the sunflower head, Mathematical
    /// Biosciences 44, 1979): each of `count` rings of equal area holds exactly one root. The place
    /// in the ring and, by a quarter of the mean spacing, along it are random. On a circle no two
    /// roots are closer than half the mean spacing, `sqrt(area / count)`; the map to an ellipse
    /// stretches that by its axes. Cost: linear.
    ///
    /// # Errors
    /// Refuses axes that are not positive.
    pub fn roots(&self, count: usize, seed: u64) -> Result<Vec<Point3<f64>>, FiberError> {
        self.validate()?;
        let golden = PI * (3.0 - 5f64.sqrt());
        let spacing = (PI / count as f64).sqrt();
        let mut random = Random::new(seed);
        let start = TAU * random.unit();
        let root = |i: usize| {
            let r = ((i as f64 + random.unit()) / count as f64).sqrt();
            let jitter = 0.25 * spacing * random.symmetric() / r.max(spacing);
            let (sin, cos) = (start + golden * i as f64 + jitter).sin_cos();
            self.pose * Point3::new(self.a * r * cos, self.b * r * sin, 0.0)
        };
        Ok((0..count).map(root).collect())
    }

    fn validate(&self) -> Result<(), FiberError> {
        positive("semi-axis a of the patch (m)", self.a)?;
        positive("semi-axis b of the patch (m)", self.b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::root_pose;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn patch() -> Ellipse {
        let pose = root_pose(Point3::new(0.0, 0.1, 0.0), &Vector3::y()).expect("a direction");
        Ellipse { pose, a: 0.02, b: 0.015 }
    }

    /// Roots in the coordinates of the unit disc.
    fn on_disc(count: usize, seed: u64) -> Vec<(f64, f64)> {
        let patch = patch();
        let roots = patch.roots(count, seed).expect("a patch");
        let local = |p: &Point3<f64>| patch.pose.inverse() * p;
        roots.iter().map(local).map(|p| (p.x / patch.a, p.y / patch.b)).collect()
    }

    proptest! {
        #[test]
        fn every_ring_of_equal_area_holds_its_share(count in 1..500_usize, seed: u64) {
            let mut shares: Vec<f64> =
                on_disc(count, seed).iter().map(|(x, y)| (x * x + y * y) * count as f64).collect();
            shares.sort_by(f64::total_cmp);
            for (i, share) in shares.iter().enumerate() {
                prop_assert!((i as f64 - 1e-9..=i as f64 + 1.0 + 1e-9).contains(share));
            }
        }

        #[test]
        fn no_two_roots_meet(count in 2..500_usize, seed: u64) {
            let points = on_disc(count, seed);
            let spacing = (PI / count as f64).sqrt();
            for (i, p) in points.iter().enumerate() {
                for q in &points[..i] {
                    let distance = (p.0 - q.0).hypot(p.1 - q.1);
                    prop_assert!(distance > 0.5 * spacing, "{distance} of {spacing}");
                }
            }
        }
    }

    #[test]
    fn sectors_hold_their_share() {
        let points = on_disc(12_000, 3);
        let mut sectors = [0_i32; 12];
        for (x, y) in points {
            let turn = (y.atan2(x) / TAU).rem_euclid(1.0);
            let sector =
                (0..12).rfind(|&k| turn >= f64::from(k) / 12.0).expect("turn is not negative");
            sectors[usize::try_from(sector).expect("a sector")] += 1;
        }
        // The golden angle has bounded discrepancy: far fewer than sqrt(1000) off.
        assert!(sectors.iter().all(|n| (n - 1000).abs() <= 5), "{sectors:?}");
    }

    #[test]
    fn density_times_area_is_the_count() {
        assert_eq!(patch().count(2e6), Ok(1885));
        assert_eq!(patch().count(1.0), Ok(0));
        assert_eq!(patch().roots(0, 1), Ok(vec![]));
        assert!(matches!(patch().count(-1.0), Err(FiberError::NotPositive { .. })));
        assert!(matches!(patch().count(1e30), Err(FiberError::OutOfRange { .. })));
        let flat = Ellipse { b: 0.0, ..patch() };
        assert!(matches!(flat.roots(5, 1), Err(FiberError::NotPositive { .. })));
    }

    #[test]
    fn a_seed_is_a_seed() {
        assert_eq!(patch().roots(200, 7), patch().roots(200, 7));
        assert_ne!(patch().roots(200, 7), patch().roots(200, 8));
    }
}
