use super::check::{Allowed, Check};
use super::speed::{check_rate, check_speed, check_velocity};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Motion of the roots of a bundle: all of them rigidly, as one body.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Motion {
    /// At rest.
    #[default]
    Fixed,
    /// A swing to and fro on an arc, as hair on a turning head (thesis 3.4.9.8). The bundle turns
    /// with the arc.
    Swing {
        /// Angle of the arc, degrees.
        angle: f64,
        /// Radius of the arc, m.
        radius: f64,
        /// Time to go along the arc and back, s.
        period: f64,
        /// Axis of the turn, world frame, any length.
        #[serde(default = "y_axis")]
        axis: [f64; 3],
        /// Direction from the bundle to the center of the arc, world frame, any length; only its
        /// part across the axis counts.
        #[serde(default = "z_axis")]
        center: [f64; 3],
        /// Time dependence of the angle.
        #[serde(default)]
        pace: Pace,
    },
    /// Along a line at constant velocity, then at rest.
    Translate {
        /// Velocity, m/s, world frame.
        velocity: [f64; 3],
        /// Time in which the velocity grows linearly from zero, s; 0 for at once.
        #[serde(default)]
        ramp: f64,
        /// End of the motion, s.
        until: f64,
    },
    /// An oscillation along a line, `amplitude sin(2 pi frequency t)`.
    Shake {
        /// Largest displacement, m, world frame.
        amplitude: [f64; 3],
        /// Frequency, Hz.
        frequency: f64,
    },
    /// Rotation about an axis through the position of the bundle at constant rate, then rest.
    Rotate {
        /// Axis of the turn, world frame, any length.
        axis: [f64; 3],
        /// Angular speed, degrees per second.
        rate: f64,
        /// End of the motion, s.
        until: f64,
    },
    /// Motion through given poses, at constant velocity and rate between them; at rest after the
    /// last. Between parallel rotation vectors the angle goes from one value to the other, whole
    /// turns included; other rotations may be half a turn apart, and are joined by the smallest
    /// rotation.
    Keyframes {
        /// The poses, in the order of time; the first is at time 0 and moves nothing.
        points: Vec<Keyframe>,
    },
}

/// Time dependence of a swing along its arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Pace {
    /// A cosine in time: it starts and turns around smoothly.
    #[default]
    Smooth,
    /// Constant speed, as in the thesis; the velocity jumps at the ends of the arc.
    Constant,
}

/// A displacement of a bundle at an instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Time of the displacement, s.
    pub time: f64,
    /// Translation from where the bundle started, m, world frame.
    #[serde(default)]
    pub translation: [f64; 3],
    /// Rotation about the position of the bundle, as a rotation vector in degrees, world frame.
    #[serde(default)]
    pub rotation: [f64; 3],
}

fn y_axis() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn z_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

impl Motion {
    /// The rigid displacement at time `t` (s) of a bundle that started at `start`, as a map from
    /// the world to the world; the identity at `t = 0`.
    #[must_use]
    pub fn displacement(&self, t: f64, start: &Point3<f64>) -> Isometry3<f64> {
        match self {
            Self::Fixed => Isometry3::identity(),
            Self::Swing { angle, radius, period, axis, center, pace } => {
                let phase = match pace {
                    Pace::Smooth => 0.5 * (1.0 - (TAU * t / period).cos()),
                    Pace::Constant => 1.0 - (1.0 - 2.0 * (t / period).rem_euclid(1.0)).abs(),
                };
                let axis = Vector3::from(*axis).normalize();
                let center = across(&Vector3::from(*center), &axis).normalize();
                turn(&(start + *radius * center), axis * (angle.to_radians() * phase))
            }
            Self::Translate { velocity, ramp, until } => {
                Translation3::from(Vector3::from(*velocity) * ramped(t.min(*until), *ramp)).into()
            }
            Self::Shake { amplitude, frequency } => {
                Translation3::from(Vector3::from(*amplitude) * (TAU * frequency * t).sin()).into()
            }
            Self::Rotate { axis, rate, until } => {
                let angle = rate.to_radians() * t.min(*until);
                turn(start, Vector3::from(*axis).normalize() * angle)
            }
            Self::Keyframes { points } => between(points, t, start),
        }
    }

    /// Reports problems of the motion.
    pub(crate) fn check(&self, check: &mut Check) {
        match self {
            Self::Fixed => {}
            Self::Swing { angle, radius, period, axis, center, .. } => {
                check.number("angle", *angle, Allowed::Within(-360.0, 360.0), "degrees");
                check.number("radius", *radius, Allowed::NonNegative, "m");
                check.number("period", *period, Allowed::Positive, "s");
                check.direction("axis", axis);
                check.direction("center", center);
                let (axis, center) = (Vector3::from(*axis), Vector3::from(*center));
                if across(&center, &axis.normalize()).norm() < 1e-9 * center.norm() {
                    check.refuse("center", "must not be parallel to the axis".into());
                }
                if *period > 0.0 {
                    // The fastest pace is the smooth one's in the middle of the arc.
                    let rate = PI * angle.abs() / period;
                    check_speed(check, "period", rate.to_radians() * radius);
                    check_rate(check, "period", rate);
                }
            }
            Self::Translate { velocity, ramp, until } => {
                check_velocity(check, velocity);
                check.number("ramp", *ramp, Allowed::NonNegative, "s");
                check.number("until", *until, Allowed::NonNegative, "s");
            }
            Self::Shake { amplitude, frequency } => {
                check.vector("amplitude", amplitude, "m");
                check.number("frequency", *frequency, Allowed::NonNegative, "Hz");
                check_speed(check, "frequency", TAU * frequency * Vector3::from(*amplitude).norm());
            }
            Self::Rotate { axis, rate, until } => {
                check.direction("axis", axis);
                check.number("rate", *rate, Allowed::Finite, "degrees/s");
                check_rate(check, "rate", rate.abs());
                check.number("until", *until, Allowed::NonNegative, "s");
            }
            Self::Keyframes { points } => check_keyframes(points, check),
        }
    }
}

/// Distance covered by the time `t` at a speed that grows linearly from 0 to 1 within `ramp`.
pub fn ramped(t: f64, ramp: f64) -> f64 {
    if t < ramp { 0.5 * t * t / ramp } else { t - 0.5 * ramp }
}

fn across(v: &Vector3<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
    v - axis * v.dot(axis)
}

/// The rotation by a rotation vector about a point.
fn turn(about: &Point3<f64>, rotation: Vector3<f64>) -> Isometry3<f64> {
    Isometry3::rotation_wrt_point(UnitQuaternion::from_scaled_axis(rotation), *about)
}

fn orientation(keyframe: &Keyframe) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::from(keyframe.rotation.map(f64::to_radians)))
}

/// The rotation vector from one keyframe to the next, rad, in the frame of the first: its direction
/// is constant, so that the rate is constant.
fn turned(from: &Keyframe, to: &Keyframe) -> Vector3<f64> {
    if are_parallel(from, to) {
        return asked_turn(from, to);
    }
    (orientation(from).inverse() * orientation(to)).scaled_axis()
}

/// Difference of two rotation vectors, rad, which may be more than a turn for parallel ones.
fn asked_turn(from: &Keyframe, to: &Keyframe) -> Vector3<f64> {
    let [from, to] = [from, to].map(|k| Vector3::from(k.rotation.map(f64::to_radians)));
    to - from
}

/// Whether both rotations have one axis, up to the rounding of decimal numbers.
fn are_parallel(a: &Keyframe, b: &Keyframe) -> bool {
    let [a, b] = [a, b].map(|k| Vector3::from(k.rotation));
    a.cross(&b).norm() <= 1e-9 * a.norm() * b.norm()
}

fn between(points: &[Keyframe], t: f64, start: &Point3<f64>) -> Isometry3<f64> {
    let after = points.partition_point(|k| k.time <= t);
    let Some(last) = points.get(after.saturating_sub(1)) else { return Isometry3::identity() };
    let next = points.get(after).unwrap_or(last);
    let x = if next.time > last.time { (t - last.time) / (next.time - last.time) } else { 0.0 };
    let turned = orientation(last) * UnitQuaternion::from_scaled_axis(turned(last, next) * x);
    let moved = if last.translation == next.translation {
        // At rest to the last bit, as before there was a next pose.
        last.translation.into()
    } else {
        Vector3::from(last.translation).lerp(&next.translation.into(), x)
    };
    Translation3::from(moved) * Isometry3::rotation_wrt_point(turned, *start)
}

fn check_keyframes(points: &[Keyframe], check: &mut Check) {
    check.each("points", points, |c, k| {
        c.number("time", k.time, Allowed::NonNegative, "s");
        c.vector("translation", &k.translation, "m");
        c.vector("rotation", &k.rotation, "degrees");
    });
    match points.first() {
        None => check.refuse("points", "is empty, but must have at least one entry".into()),
        Some(first) if first.time != 0.0 => {
            let message = format!("is {:?}, but the first keyframe must be at 0 s", first.time);
            check.refuse("points[0].time", message);
        }
        Some(first) if first.translation != [0.0; 3] || first.rotation != [0.0; 3] => {
            let message = "must not move the bundle: the root would jump at the start; move \
                           `root.position` instead";
            check.refuse("points[0]", message.into());
        }
        Some(_) => {}
    }
    for (i, pair) in points.windows(2).enumerate() {
        let time = pair[1].time - pair[0].time;
        let way = (Vector3::from(pair[1].translation) - Vector3::from(pair[0].translation)).norm();
        if time <= 0.0 {
            let message = format!(
                "is {:?}, but must be later than {:?}, the time of the keyframe before: a root \
                 cannot jump",
                pair[1].time, pair[0].time
            );
            check.refuse(&format!("points[{}].time", i + 1), message);
        } else {
            let field = format!("points[{}]", i + 1);
            check_speed(check, &field, way / time);
            let asked = asked_turn(&pair[0], &pair[1]).norm();
            if asked > PI && !are_parallel(&pair[0], &pair[1]) {
                let message = format!(
                    "turns by {:.1} degrees from another axis: which way is not told; put keyframes \
                     between them that are at most 180 degrees apart",
                    asked.to_degrees()
                );
                check.refuse(&format!("{field}.rotation"), message);
            }
            check_rate(check, &field, turned(&pair[0], &pair[1]).norm().to_degrees() / time);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn start() -> Point3<f64> {
        Point3::new(0.1, 0.2, 0.3)
    }

    fn swing(pace: Pace) -> Motion {
        let (axis, center) = (y_axis(), z_axis());
        Motion::Swing { angle: 45.0, radius: 0.3, period: 2.0, axis, center, pace }
    }

    #[test]
    fn a_swing_stays_on_its_arc() {
        let center: Point3<f64> = start() + 0.3 * Vector3::z();
        for pace in [Pace::Smooth, Pace::Constant] {
            for t in [0.0, 0.3, 1.0, 1.7, 9.1] {
                let moved = swing(pace).displacement(t, &start()) * start();
                assert_relative_eq!((moved - center).norm(), 0.3, max_relative = 1e-14);
            }
            let chord = swing(pace).displacement(1.0, &start()) * start() - start();
            assert_relative_eq!(chord.norm(), 0.6 * 22.5_f64.to_radians().sin(), epsilon = 1e-14);
            let back = swing(pace).displacement(4.0, &start()) * start() - start();
            assert_relative_eq!(back.norm(), 0.0, epsilon = 1e-15);
        }
    }

    #[test]
    fn every_motion_starts_with_the_identity() {
        let key = |time, x| Keyframe { time, translation: [x, 0.0, 0.0], rotation: [0.0; 3] };
        for motion in [
            Motion::Fixed,
            swing(Pace::Smooth),
            Motion::Translate { velocity: [1.0, 2.0, 3.0], ramp: 0.1, until: 1.0 },
            Motion::Shake { amplitude: [1.0, 2.0, 3.0], frequency: 3.0 },
            Motion::Rotate { axis: [1.0, 2.0, 3.0], rate: 90.0, until: 1.0 },
            Motion::Keyframes { points: vec![key(0.0, 0.0), key(1.0, 2.0)] },
        ] {
            let moved = motion.displacement(0.0, &start()).to_homogeneous();
            assert_relative_eq!(moved, nalgebra::Matrix4::identity(), epsilon = 1e-15);
        }
    }

    proptest! {
        /// Also of more than a turn, backwards, and from angles that are not zero.
        #[test]
        fn keyframes_about_one_axis_turn_by_what_is_asked(
            axis in prop::array::uniform3(-1.0..1.0_f64),
            angles in prop::collection::vec(
                prop_oneof![-2000.0..2000.0_f64, Just(0.0), Just(180.0), Just(-360.0)],
                1..5,
            ),
        ) {
            let axis = Vector3::from(axis);
            prop_assume!(axis.norm() > 1e-3);
            let axis = axis.normalize();
            let key = |(i, angle): (usize, f64)| {
                let rotation = (axis * angle).into();
                Keyframe { time: i as f64, translation: [0.0; 3], rotation }
            };
            let angles = [vec![0.0], angles].concat();
            let points: Vec<_> = angles.iter().copied().enumerate().map(key).collect();
            let motion = Motion::Keyframes { points };
            let pose = |t: f64| motion.displacement(t, &start()).rotation;
            for (i, pair) in angles.windows(2).enumerate() {
                // Parts so short that the short way is the way.
                let parts = 64;
                let at = |part: u32| pose(i as f64 + f64::from(part) / f64::from(parts));
                let turns = (0..parts).map(|k| (at(k + 1) * at(k).inverse()).scaled_axis());
                let whole = turns.sum::<Vector3<f64>>().dot(&axis).to_degrees();
                prop_assert!((whole - (pair[1] - pair[0])).abs() < 1e-9, "{whole} {pair:?}");
            }
        }

        #[test]
        fn keyframes_meet_their_poses_at_a_constant_rate(
            a in prop::array::uniform3(-90.0..90.0_f64),
            b in prop::array::uniform3(-90.0..90.0_f64),
        ) {
            let key = |time, rotation| Keyframe { time, translation: [0.0; 3], rotation };
            let points = vec![key(0.0, [0.0; 3]), key(1.0, a), key(2.0, b)];
            let motion = Motion::Keyframes { points: points.clone() };
            let pose = |t: f64| motion.displacement(t, &start()).rotation;
            prop_assert!(pose(1.0).angle_to(&orientation(&points[1])) < 1e-7);
            prop_assert!(pose(2.0).angle_to(&orientation(&points[2])) < 1e-7);
            let rate = |t: f64| (pose(t + 0.1) * pose(t).inverse()).scaled_axis();
            prop_assert!((rate(1.1) - rate(1.8)).norm() < 1e-12);
        }
    }

    #[test]
    fn ways_that_are_not_told_are_refused() {
        let key = |time, rotation| Keyframe { time, translation: [0.0; 3], rotation };
        let points =
            vec![key(0.0, [0.0; 3]), key(1.0, [0.0, 0.0, 350.0]), key(2.0, [90.0, 0.0, 0.0])];
        let mut check = Check::default();
        Motion::Keyframes { points }.check(&mut check);
        let problems = check.finish(None);
        assert!(problems.iter().any(|p| p.path == "points[2].rotation"), "{problems:?}");
        assert_eq!(problems.len(), 1, "{problems:?}");
    }

    #[test]
    fn keyframes_are_linear_between_and_rest_after() {
        let points = vec![
            Keyframe { time: 0.0, translation: [0.0; 3], rotation: [0.0; 3] },
            Keyframe { time: 2.0, translation: [0.4, 0.0, 0.0], rotation: [0.0, 0.0, 80.0] },
        ];
        let motion = Motion::Keyframes { points };
        for (t, x) in [(0.5, 0.25), (2.0, 1.0), (7.0, 1.0)] {
            let moved = motion.displacement(t, &start());
            assert_relative_eq!((moved * start()).x, 0.1 + 0.4 * x, epsilon = 1e-15);
            let angle = (80.0 * x).to_radians();
            assert_relative_eq!(moved.rotation.scaled_axis().z, angle, epsilon = 1e-14);
        }
    }
}
