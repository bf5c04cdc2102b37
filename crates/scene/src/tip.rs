use super::check::{Allowed, Check};
use super::freedom::{Freedom, Freedoms, SupportAxes};
use super::load::TimedLoad;
use super::motion::Motion;
use super::speed::check_velocity;
use nalgebra::{Isometry3, Point3};
use rapunzel_rod_dynamic as rod;
use serde::{Deserialize, Serialize};

/// Boundary condition at the tips of a bundle. Times are from the start of the run; a change of
/// kind takes effect at the nearest step.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Tip {
    /// Free, without load.
    #[default]
    Free,
    /// A force and a moment that may change with time.
    Loaded {
        /// Force on the tip, N.
        #[serde(default)]
        force: TimedLoad,
        /// Moment on the tip, N m.
        #[serde(default)]
        moment: TimedLoad,
    },
    /// Clamped and pulled at constant velocity, then released (thesis 3.4.9.6).
    Pulled {
        /// Velocity, m/s, world frame.
        velocity: [f64; 3],
        /// Time of the release, s.
        until: f64,
    },
    /// Clamped at its pose at the start.
    Held,
    /// Driven at constant velocity, then held there; with a root that moves the other way,
    /// buckling (thesis 3.4.9.5).
    Driven {
        /// Velocity, m/s, world frame.
        velocity: [f64; 3],
        /// Time in which the velocity grows linearly from zero, s; 0 for at once.
        #[serde(default)]
        ramp: f64,
        /// Time at which the motion ends, s.
        until: f64,
        /// Boundary condition of the tip's frame.
        #[serde(default)]
        joint: JointKind,
        /// Angle by which a clamp rotates about the tangent during the motion, degrees.
        #[serde(default)]
        twist: f64,
    },
    /// Led by any motion, also one by keyframes, which moves and turns it from its pose at the
    /// start as it does a root.
    Led {
        /// Motion of the tip; it turns about the place of each tip at the start.
        #[serde(default)]
        motion: Motion,
        /// Boundary condition of the tip's frame.
        #[serde(default)]
        joint: JointKind,
    },
}

/// Boundary condition of an end: what of its pose is prescribed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum JointKind {
    /// Clamped: the frame is prescribed too.
    #[default]
    Clamped,
    /// A ball joint: the frame is free, under a moment.
    Ball {
        /// Moment on the fibre, N m.
        #[serde(default)]
        moment: TimedLoad,
    },
    /// Free: the position is not held either. Only for roots without a prescribed motion.
    Free,
    /// Free, under a force and a moment that may change with time. Only for roots without a
    /// prescribed motion; a tip has its own `Loaded`.
    Loaded {
        /// Force on the fibre, N.
        #[serde(default)]
        force: TimedLoad,
        /// Moment on the fibre, N m.
        #[serde(default)]
        moment: TimedLoad,
    },
    /// Each of the six freedoms is free, held or sprung by itself: a hinge, a slider, an elastic
    /// support, or the machine that turns an end under a constant tension. A rotation that a spring
    /// resists stays below half a turn. In a ledger the work of the springs is that of supports.
    Supported {
        /// The axes of the freedoms.
        #[serde(default)]
        axes: SupportAxes,
        /// Displacements along the axes.
        #[serde(default)]
        translations: [Freedom; 3],
        /// Rotations about the axes: the components of the rotation vector from where the end would
        /// be if it were clamped.
        #[serde(default)]
        rotations: [Freedom; 3],
        /// Force on the fibre, N, along translations that are not held.
        #[serde(default)]
        force: TimedLoad,
        /// Moment on the fibre, N m, about rotations that are not held.
        #[serde(default)]
        moment: TimedLoad,
    },
}

impl JointKind {
    /// The boundary condition at time `t` (s), for a tip with the given prescribed pose.
    pub fn end(&self, t: f64, pose: Isometry3<f64>) -> rod::End {
        match self {
            Self::Clamped => rod::End::Held(pose),
            Self::Ball { moment } => {
                let position = Point3::from(pose.translation.vector);
                rod::End::Pinned { position, moment: moment.at(t) }
            }
            Self::Free => rod::End::FREE,
            Self::Loaded { force, moment } => {
                rod::End::Loaded { force: force.at(t), moment: moment.at(t) }
            }
            Self::Supported { axes, translations, rotations, force, moment } => {
                let (axes, translations, rotations) = (*axes, *translations, *rotations);
                Freedoms { axes, translations, rotations }.end(t, pose, [force, moment])
            }
        }
    }

    /// Whether it holds the frame of the end, if it holds anything.
    #[must_use]
    pub fn clamps(&self) -> Option<bool> {
        match self {
            Self::Clamped => Some(true),
            Self::Ball { .. } => Some(false),
            Self::Free | Self::Loaded { .. } => None,
            Self::Supported { rotations, .. } => {
                Some(rotations.iter().all(|one| *one == Freedom::Held))
            }
        }
    }

    /// Whether it leaves an end where the fibre takes it.
    #[must_use]
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free | Self::Loaded { .. })
    }

    pub(crate) fn check(&self, check: &mut Check) {
        if let Self::Loaded { force, .. } | Self::Supported { force, .. } = self {
            check.within("force", |c| force.check(c, "N"));
        }
        if let Self::Ball { moment }
        | Self::Loaded { moment, .. }
        | Self::Supported { moment, .. } = self
        {
            check.within("moment", |c| moment.check(c, "N m"));
        }
        if let Self::Supported { axes, translations, rotations, force, moment } = self {
            let (axes, translations, rotations) = (*axes, *translations, *rotations);
            Freedoms { axes, translations, rotations }.check(check, [force, moment]);
        }
    }

    /// Reports problems of the joint of a tip whose place is prescribed.
    fn check_of_tip(&self, check: &mut Check) {
        check.within("joint", |c| self.check(c));
        if self.is_free() {
            check
                .refuse("joint", "is free, but drives nothing; make the tip Free or Loaded".into());
        }
    }
}

impl Tip {
    /// Reports problems of the tip.
    pub(crate) fn check(&self, check: &mut Check) {
        match self {
            Self::Free | Self::Held => {}
            Self::Loaded { force, moment } => {
                check.within("force", |c| force.check(c, "N"));
                check.within("moment", |c| moment.check(c, "N m"));
            }
            Self::Pulled { velocity, until } => {
                check_velocity(check, velocity);
                check.number("until", *until, Allowed::NonNegative, "s");
            }
            Self::Driven { velocity, ramp, until, joint, twist } => {
                check_velocity(check, velocity);
                check.number("ramp", *ramp, Allowed::NonNegative, "s");
                check.number("until", *until, Allowed::Positive, "s");
                joint.check_of_tip(check);
                check.number("twist", *twist, Allowed::Finite, "degrees");
                if *joint != JointKind::Clamped && *twist != 0.0 {
                    let message = format!(
                        "is {twist:?}, but only a clamp turns the fibre; give a ball joint a moment"
                    );
                    check.refuse("twist", message);
                }
            }
            Self::Led { motion, joint } => {
                check.within("motion", |c| motion.check(c));
                joint.check_of_tip(check);
            }
        }
    }
}
