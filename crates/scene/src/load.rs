use super::check::{Allowed, Check};
use nalgebra::Vector3;
use rapunzel_rod_dynamic as rod;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A force or a moment over time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedLoad {
    /// Components in the given frame, N or N m.
    pub value: [f64; 3],
    /// The frame of the components.
    #[serde(default)]
    pub frame: LoadFrame,
    /// Factor of the load over time.
    #[serde(default)]
    pub profile: Profile,
}

/// The frame of a load's components.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum LoadFrame {
    /// The world frame: the direction is constant.
    #[default]
    World,
    /// The material frame at the end (d1, d2, tangent): the direction follows the fibre.
    Follower,
}

/// A factor over time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Profile {
    /// Constantly 1.
    #[default]
    Constant,
    /// A ramp from 0 to 1 at constant rate, then 1.
    Ramp {
        /// Time at which it reaches 1, s.
        until: f64,
    },
    /// A pulse: 1, then 0.
    Pulse {
        /// Time at which it becomes 0, s.
        until: f64,
    },
    /// `sin(2 pi frequency t + phase)`.
    Sine {
        /// Frequency, Hz.
        frequency: f64,
        /// Phase, degrees.
        #[serde(default)]
        phase: f64,
    },
    /// Piecewise linear between points; constant before the first and after the last.
    Linear {
        /// Pairs of time (s) and factor, in the order of time.
        points: Vec<(f64, f64)>,
    },
}

impl Profile {
    /// The factor at time `t`, s.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Ramp { until } => (t / until).clamp(0.0, 1.0),
            Self::Pulse { until } => f64::from(t < *until),
            Self::Sine { frequency, phase } => (TAU * frequency * t + phase.to_radians()).sin(),
            Self::Linear { points } => {
                let after = points.partition_point(|p| p.0 <= t);
                match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
                    (Some((t0, y0)), Some((t1, y1))) => y0 + (y1 - y0) * (t - t0) / (t1 - t0),
                    (Some((_, y)), None) | (None, Some(&(_, y))) => y,
                    (None, None) => 0.0,
                }
            }
        }
    }

    pub(crate) fn check(&self, check: &mut Check) {
        match self {
            Self::Constant => {}
            Self::Ramp { until } => check.number("until", *until, Allowed::Positive, "s"),
            Self::Pulse { until } => check.number("until", *until, Allowed::NonNegative, "s"),
            Self::Sine { frequency, phase } => {
                check.number("frequency", *frequency, Allowed::NonNegative, "Hz");
                check.number("phase", *phase, Allowed::Finite, "degrees");
            }
            Self::Linear { points } => {
                if points.is_empty() {
                    check.refuse("points", "is empty, but must have at least one entry".into());
                }
                for (i, &(time, factor)) in points.iter().enumerate() {
                    check.number(&format!("points[{i}][0]"), time, Allowed::Finite, "s");
                    check.number(&format!("points[{i}][1]"), factor, Allowed::Finite, "");
                }
                for i in 1..points.len() {
                    if points[i].0 <= points[i - 1].0 {
                        let message = format!("is {:?}, but times must increase", points[i].0);
                        check.refuse(&format!("points[{i}][0]"), message);
                    }
                }
            }
        }
    }
}

impl TimedLoad {
    /// The load at time `t`, s.
    #[must_use]
    pub fn at(&self, t: f64) -> rod::Load {
        let value = Vector3::from(self.value) * self.profile.at(t);
        match self.frame {
            LoadFrame::World => rod::Load::World(value),
            LoadFrame::Follower => rod::Load::Follower(value),
        }
    }

    pub(crate) fn check(&self, check: &mut Check, unit: &str) {
        check.vector("value", &self.value, unit);
        check.within("profile", |c| self.profile.check(c));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_have_their_values() {
        let linear = Profile::Linear { points: vec![(1.0, 2.0), (3.0, -2.0)] };
        let sine = Profile::Sine { frequency: 0.25, phase: 90.0 };
        for (profile, t, y) in [
            (&Profile::Constant, 5.0, 1.0),
            (&Profile::Ramp { until: 2.0 }, 0.5, 0.25),
            (&Profile::Ramp { until: 2.0 }, 3.0, 1.0),
            (&Profile::Pulse { until: 0.1 }, 0.099, 1.0),
            (&Profile::Pulse { until: 0.1 }, 0.1, 0.0),
            (&sine, 0.0, 1.0),
            (&sine, 2.0, -1.0),
            (&linear, 0.0, 2.0),
            (&linear, 1.5, 1.0),
            (&linear, 3.0, -2.0),
            (&linear, 9.0, -2.0),
        ] {
            assert!((profile.at(t) - y).abs() < 1e-15, "{profile:?} at {t}: {}", profile.at(t));
        }
    }
}
