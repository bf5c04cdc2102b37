use crate::error::{not_negative, positive};
use crate::{Fiber, FiberError, so3};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The pose of a root at `position` (world, m) with its z axis along `direction` (any length).
///
/// The other axes are those of the world, rotated by the smallest rotation of z to `direction`.
///
/// # Errors
/// [`FiberError::NoDirection`] for a zero or not finite direction.
pub fn root_pose(
    position: Point3<f64>,
    direction: &Vector3<f64>,
) -> Result<Isometry3<f64>, FiberError> {
    // The largest component first, so that the length of a tiny or huge vector stays in range.
    let scaled = direction / direction.amax();
    if !scaled.iter().all(|x| x.is_finite()) {
        return Err(FiberError::NoDirection { quantity: "direction of the root" });
    }
    // Straight down, every axis is shortest: take x.
    let half_turn = Rotation3::from_axis_angle(&Vector3::x_axis(), PI);
    let turn = so3::between(&Vector3::z(), &scaled).unwrap_or(half_turn);
    Ok(Isometry3::from_parts(Translation3::from(position), so3::quaternion(&turn)))
}

/// Handedness of a helix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Handedness {
    /// Right-handed, as a common screw.
    Right,
    /// Left-handed, the mirror image of a right-handed helix.
    Left,
}

/// A helix: `r = (R cos t, R sin t, p t / 2 pi)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Helix {
    /// Distance `R` of the centerline from the axis, m.
    pub radius: f64,
    /// Advance `p` along the axis per turn, m; zero gives a ring.
    pub pitch: f64,
    /// Handedness of the helix.
    pub handedness: Handedness,
}

impl Helix {
    /// Bends `fiber` into this helix.
    ///
    /// The pose of the root of `fiber` places the helix: it starts at the root, its axis is
    /// parallel to the pose's z axis and passes through `(-R, 0, 0)`. The natural curvature is
    /// constant, `(0, R, q) / (R^2 + q^2)` with `q = p / 2 pi`, negative for a left one; so the
    /// rest shape is exactly the helix, for any segment length. d1 points to the axis.
    ///
    /// # Errors
    /// Refuses a radius that is not positive and a pitch that is negative or not finite.
    pub fn bend(&self, fiber: Fiber) -> Result<Fiber, FiberError> {
        positive("radius of the helix (m)", self.radius)?;
        not_negative("pitch of the helix (m)", self.pitch)?;
        let sign = if self.handedness == Handedness::Right { 1.0 } else { -1.0 };
        // Speed over the angle; curvature R / c^2 about the binormal, torsion +-q / c^2.
        let rise = self.pitch / TAU;
        let speed = self.radius.hypot(rise);
        let (sin, cos) = (self.radius / speed, rise / speed);
        let kappa = Vector3::new(0.0, sin / speed, sign * cos / speed);
        let tangent = Vector3::new(0.0, sign * sin, cos);
        let normal = -Vector3::x();
        let frame = Matrix3::from_columns(&[normal, tangent.cross(&normal), tangent]);
        let root = turned(fiber.root(), &Rotation3::from_matrix_unchecked(frame));
        fiber.with_root(root).with_natural_curvature(|_| kappa)
    }
}

/// A planar wave: `x = A sin(2 pi z / lambda)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Amplitude `A`, m; zero gives a straight fibre.
    pub amplitude: f64,
    /// Wavelength `lambda`, m, measured along the straight middle line.
    pub wavelength: f64,
}

impl Sine {
    /// Bends `fiber` into this wave.
    ///
    /// The pose of the root of `fiber` places the wave: it starts at the root on the middle line,
    /// which is the pose's z axis, and swings along its x axis. The natural curvature is that of
    /// the curve at the nodes, about d2. The rest shape meets the curve to second order in the
    /// segment length.
    ///
    /// # Errors
    /// Refuses a negative amplitude, a wavelength that is not positive, and segments longer than a
    /// quarter of the wavelength or than the smallest radius of curvature, `lambda^2 / 4 pi^2 A`.
    pub fn bend(&self, fiber: Fiber) -> Result<Fiber, FiberError> {
        not_negative("amplitude of the wave (m)", self.amplitude)?;
        positive("wavelength of the wave (m)", self.wavelength)?;
        let number = TAU / self.wavelength;
        let finest = (0.25 * self.wavelength).min(1.0 / (self.amplitude * number * number));
        let longest = fiber.segment_lengths().iter().fold(0.0, |a: f64, &l| a.max(l));
        if longest > finest {
            let needed = (fiber.segments() as f64 * longest / finest).ceil();
            return Err(FiberError::Unresolved { segments: fiber.segments(), needed });
        }
        let mut z = 0.0;
        let mut curvatures = vec![self.curvature(z)];
        for &length in fiber.segment_lengths() {
            z = self.advance(z, length);
            curvatures.push(self.curvature(z));
        }
        let start = Rotation3::from_axis_angle(&Vector3::y_axis(), self.slope(0.0).atan());
        let root = turned(fiber.root(), &start);
        fiber.with_root(root).with_node_curvatures(&curvatures)
    }

    fn slope(&self, z: f64) -> f64 {
        let number = TAU / self.wavelength;
        self.amplitude * number * (number * z).cos()
    }

    fn curvature(&self, z: f64) -> Vector3<f64> {
        let number = TAU / self.wavelength;
        let second = -self.amplitude * number * number * (number * z).sin();
        Vector3::new(0.0, second / self.slope(z).hypot(1.0).powi(3), 0.0)
    }

    /// The `z` that lies `length` of arc beyond `z`: `dz/ds = 1 / sqrt(1 + x'^2)` by the classical
    /// Runge-Kutta method, whose error is of higher order than that of the segments themselves.
    fn advance(&self, mut z: f64, length: f64) -> f64 {
        const STEPS: usize = 8;
        let h = length / STEPS as f64;
        let rate = |z: f64| 1.0 / self.slope(z).hypot(1.0);
        for _ in 0..STEPS {
            let k1 = rate(z);
            let k2 = rate(z + 0.5 * h * k1);
            let k3 = rate(z + 0.5 * h * k2);
            let k4 = rate(z + h * k3);
            z += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        }
        z
    }
}

/// `pose` followed by a rotation in its own frame.
fn turned(pose: &Isometry3<f64>, by: &Rotation3<f64>) -> Isometry3<f64> {
    let rotation = pose.rotation * so3::quaternion(by);
    Isometry3::from_parts(pose.translation, rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Section};
    use proptest::prelude::*;

    fn straight(length: f64, segments: usize) -> Fiber {
        Fiber::uniform(length, segments, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .expect("valid hair")
    }

    fn somewhere() -> Isometry3<f64> {
        root_pose(Point3::new(0.1, -0.2, 0.3), &Vector3::new(1.0, 2.0, -0.5)).expect("a direction")
    }

    proptest! {
        #[test]
        fn root_pose_points_where_asked(d in prop::array::uniform3(-1.0..1.0_f64), scale in -200.0..200.0_f64) {
            let d = Vector3::from(d);
            prop_assume!(d.norm() > 1e-6);
            let pose = root_pose(Point3::origin(), &(d * 10f64.powf(scale))).expect("a direction");
            prop_assert!((pose * Vector3::z() - d.normalize()).norm() < 1e-14);
        }

        #[test]
        fn rest_shape_is_the_helix(
            radius in 1e-4..0.1_f64,
            pitch in 0.0..0.1_f64,
            right in any::<bool>(),
            segments in 1..60_usize,
        ) {
            let handedness = if right { Handedness::Right } else { Handedness::Left };
            let helix = Helix { radius, pitch, handedness };
            let pose = somewhere();
            let fiber = helix.bend(straight(0.3, segments).with_root(pose)).expect("a helix");
            let (positions, _) = fiber.rest_shape();
            let sign = if right { 1.0 } else { -1.0 };
            for (p, s) in positions.iter().zip(fiber.arc_lengths()) {
                let t = s / radius.hypot(pitch / TAU);
                let expected = pose * Point3::new(
                    radius * (t.cos() - 1.0),
                    sign * radius * t.sin(),
                    pitch * t / TAU,
                );
                // Rounding of a fibre of unit size, and of the angle over hundreds of turns.
                prop_assert!((p - expected).norm() < 1e-14 * (10.0 + segments as f64), "{p} {expected}");
            }
        }
    }

    #[test]
    fn straight_down_is_a_direction() {
        let pose = root_pose(Point3::origin(), &-Vector3::z()).expect("a direction");
        assert!((pose * Vector3::z() + Vector3::z()).norm() < 1e-15);
    }

    /// Largest distance of the rest nodes from the nearest point of arc length `s` on the wave.
    fn sine_error(wave: Sine, segments: usize) -> f64 {
        let pose = somewhere();
        let fiber = wave.bend(straight(0.2, segments).with_root(pose)).expect("resolved");
        let (positions, frames) = fiber.rest_shape();
        // The trapezoidal rule turns by h^2 / 12 times the change of the curvature's slope, which
        // is at most A k^3 (1 + A k) on this curve.
        let (h, number) = (0.2 / segments as f64, TAU / wave.wavelength);
        let steepest = wave.amplitude * number.powi(3) * (1.0 + wave.amplitude * number);
        let turn_error = h * h / 6.0 * steepest;
        let mut z = 0.0;
        let mut worst: f64 = 0.0;
        for (i, p) in positions.iter().enumerate() {
            let on = Vector3::new(wave.amplitude * (TAU * z / wave.wavelength).sin(), 0.0, z);
            worst = worst.max((p - pose * Point3::from(on)).norm());
            let tangent = Vector3::new(wave.slope(z), 0.0, 1.0).normalize();
            let off = (frames[i] * Vector3::z() - pose * tangent).norm();
            assert!(off < turn_error, "{off} at node {i}, allowed {turn_error}");
            // A much finer walk than that of the shape itself.
            for _ in 0..if i < segments { 16 } else { 0 } {
                z = wave.advance(z, h / 16.0);
            }
        }
        worst
    }

    #[test]
    fn rest_shape_meets_the_wave_to_second_order() {
        for (amplitude, wavelength) in [(0.002, 0.05), (0.01, 0.05), (0.0001, 0.01)] {
            let wave = Sine { amplitude, wavelength };
            let errors = [400, 800, 1600].map(|n| sine_error(wave, n));
            for pair in errors.windows(2) {
                let order = (pair[0] / pair[1]).log2();
                assert!((1.95..2.1).contains(&order), "order {order} of {wave:?}, {errors:?}");
            }
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let zero = root_pose(Point3::origin(), &Vector3::zeros());
        assert!(matches!(zero, Err(FiberError::NoDirection { .. })));
        let nan = root_pose(Point3::origin(), &Vector3::new(f64::NAN, 1.0, 0.0));
        assert!(matches!(nan, Err(FiberError::NoDirection { .. })));
        let helix = |radius, pitch| {
            Helix { radius, pitch, handedness: Handedness::Left }.bend(straight(0.1, 10))
        };
        assert!(matches!(helix(0.0, 0.1), Err(FiberError::NotPositive { .. })));
        assert!(matches!(helix(0.1, -0.1), Err(FiberError::OutOfRange { .. })));
        let sine = |amplitude, wavelength| Sine { amplitude, wavelength }.bend(straight(0.1, 10));
        assert!(matches!(sine(0.1, 0.0), Err(FiberError::NotPositive { .. })));
        assert!(matches!(sine(f64::NAN, 0.1), Err(FiberError::OutOfRange { .. })));
        assert!(matches!(sine(0.1, 0.02), Err(FiberError::Unresolved { segments: 10, .. })));
        let flat = sine(0.0, 0.1).expect("a straight fibre");
        assert_eq!(flat.nodes()[3].natural_curvature.norm(), 0.0);
    }
}
