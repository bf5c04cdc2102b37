use super::check::{Allowed, Check};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_fiber::FiberError;
use rapunzel_fiber::generate::{Ellipse, root_pose};
use serde::{Deserialize, Serialize};

/// Largest number of fibres of a bundle; more is a typing error.
pub(super) const MOST_FIBERS: usize = 1_000_000;

/// Number and placement of the fibres of a bundle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Arrangement {
    /// One fibre.
    #[default]
    Single,
    /// Parallel copies with their roots spread over an ellipse across the direction of the root.
    Ellipse {
        /// Semi-axes along d1 and d2 of the root, m.
        semi_axes: [f64; 2],
        /// Number of fibres.
        count: usize,
    },
    /// Parallel copies with their roots spread over an ellipse across the direction of the root,
    /// with a number of fibres per area.
    EllipseAtDensity {
        /// Semi-axes along d1 and d2 of the root, m.
        semi_axes: [f64; 2],
        /// Fibres per area, 1/m^2; a scalp has about 2.5e6.
        density: f64,
    },
    /// A lock: a guide fibre and others around it that follow its shape.
    Lock {
        /// Number of fibres beside the guide, which is the first.
        count: usize,
        /// Radius of the disc on which the roots stand, m.
        radius: f64,
        /// Relative variation of the natural curvature, 0 to 1.
        #[serde(default)]
        curvature_variation: f64,
        /// Fraction by which the tips draw together, 0 (parallel) to 1 (all at the guide's tip).
        #[serde(default)]
        clumping: f64,
    },
    /// Fibres on a part of an ellipsoid about the root's position, with the axes of the root's
    /// frame, along the outward normals. They are spread evenly over the unit sphere that is
    /// stretched to the ellipsoid.
    Scalp {
        /// Semi-axes along d1, d2 and the tangent of the root, m.
        semi_axes: [f64; 3],
        /// Number of fibres.
        count: usize,
        /// Range of the angle from the tangent of the root, degrees.
        #[serde(default = "whole")]
        polar: [f64; 2],
        /// Range of the angle from d1 toward d2, degrees.
        #[serde(default = "around")]
        azimuth: [f64; 2],
    },
}

fn whole() -> [f64; 2] {
    [0.0, 180.0]
}

fn around() -> [f64; 2] {
    [0.0, 360.0]
}

impl Arrangement {
    /// Number of fibres of the bundle.
    #[must_use]
    pub fn fibers(&self) -> usize {
        match *self {
            Self::Single => 1,
            Self::Ellipse { count, .. } | Self::Scalp { count, .. } => count,
            Self::EllipseAtDensity { semi_axes: [a, b], density } => {
                let patch = Ellipse { pose: Isometry3::identity(), a, b };
                patch.count(density).unwrap_or(0)
            }
            Self::Lock { count, .. } => 1 + count,
        }
    }

    pub(super) fn check(&self, check: &mut Check) {
        match self {
            Self::Single => {}
            Self::Ellipse { semi_axes, count } => {
                check_axes(check, semi_axes);
                check.count("count", *count, 1, MOST_FIBERS);
            }
            Self::EllipseAtDensity { semi_axes, density } => {
                check_axes(check, semi_axes);
                check.number("density", *density, Allowed::Positive, "1/m^2");
                let count = self.fibers();
                if *density > 0.0 && !(1..=MOST_FIBERS).contains(&count) {
                    let message =
                        format!("makes {count} fibres, but must make between 1 and {MOST_FIBERS}");
                    check.refuse("density", message);
                }
            }
            Self::Lock { count, radius, curvature_variation, clumping } => {
                check.count("count", *count, 1, MOST_FIBERS);
                check.number("radius", *radius, Allowed::Positive, "m");
                let fraction = Allowed::Within(0.0, 1.0);
                check.number("curvature_variation", *curvature_variation, fraction, "");
                check.number("clumping", *clumping, fraction, "");
            }
            Self::Scalp { semi_axes, count, polar, azimuth } => {
                check_axes(check, semi_axes);
                check.count("count", *count, 1, MOST_FIBERS);
                for (field, [from, to], most) in
                    [("polar", polar, 180.0), ("azimuth", azimuth, 360.0)]
                {
                    check.number(
                        &format!("{field}[0]"),
                        *from,
                        Allowed::Within(-most, most),
                        "degrees",
                    );
                    let allowed = Allowed::Within(*from, from + most);
                    check.number(&format!("{field}[1]"), *to, allowed, "degrees");
                }
                check.number("polar[0]", polar[0], Allowed::NonNegative, "degrees");
                check.number("polar[1]", polar[1], Allowed::Within(0.0, 180.0), "degrees");
            }
        }
    }
}

fn check_axes(check: &mut Check, semi_axes: &[f64]) {
    for (i, &x) in semi_axes.iter().enumerate() {
        check.number(&format!("semi_axes[{i}]"), x, Allowed::Positive, "m");
    }
}

/// The poses of roots on an ellipsoid about the origin, each with its z axis along the outward
/// normal.
///
/// The roots are evenly spaced in height, which on a sphere is even in area, and each is rotated
/// from the one before by the golden ratio of a full turn.
pub fn scalp(
    semi_axes: [f64; 3],
    count: usize,
    polar: [f64; 2],
    azimuth: [f64; 2],
) -> Result<Vec<Isometry3<f64>>, FiberError> {
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    let [top, bottom] = polar.map(|angle| angle.to_radians().cos());
    let [first, last] = azimuth.map(f64::to_radians);
    let pose = |k: usize| {
        let height = top + (bottom - top) * (k as f64 + 0.5) / count as f64;
        let angle = first + (last - first) * (golden * k as f64).fract();
        let ring = (1.0 - height * height).max(0.0).sqrt();
        let direction = Vector3::new(ring * angle.cos(), ring * angle.sin(), height);
        let axes = Vector3::from(semi_axes);
        let place = Point3::from(direction.component_mul(&axes));
        root_pose(place, &direction.component_div(&axes))
    };
    (0..count).map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_on_the_ellipsoid_along_its_normals_and_apart() {
        let axes = [0.07, 0.1, 0.08];
        let poses = scalp(axes, 400, [20.0, 100.0], [0.0, 180.0]).expect("directions");
        for pose in &poses {
            let (x, n) = (pose.translation.vector, pose.rotation * Vector3::z());
            let on = x.component_div(&Vector3::from(axes)).norm_squared();
            assert!((on - 1.0).abs() < 1e-12 && x.y > -1e-12, "{x}");
            let gradient = x.component_div(&Vector3::from(axes).map(|a| a * a));
            assert!(gradient.normalize().cross(&n).norm() < 1e-12 && n.dot(&x) > 0.0, "{n}");
        }
        let apart = |k: usize| {
            let distances =
                poses.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, other)| {
                    (other.translation.vector - poses[k].translation.vector).norm()
                });
            distances.fold(f64::INFINITY, f64::min)
        };
        // Half an ellipsoid's belt of some 0.03 m^2: the mean spacing is 8 mm.
        let least = (0..400).map(apart).fold(f64::INFINITY, f64::min);
        assert!(least > 2.5e-3, "{least} m");
    }
}
