use super::check::{Allowed, Check};
use super::motion::Motion;
use super::tip::JointKind;
use nalgebra::{Isometry3, Point3};
use rapunzel_rod_dynamic as rod;
use serde::{Deserialize, Serialize};

/// A gripper that takes the tips of a bundle at a time, as they are then, and lets them go at
/// another: it is rigid, where a hand of `grips` is a spring. Until it takes and after it lets go
/// the tips are as `tip` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gripper {
    /// Time at which it takes, s; it takes effect at the nearest step.
    pub from: f64,
    /// Time at which it lets go, s; left out, it never does.
    #[serde(default)]
    pub until: Option<f64>,
    /// Motion of the tips while they are held, from the time at which they are taken; they turn
    /// about their places then.
    #[serde(default)]
    pub motion: Motion,
    /// What it holds of the pose.
    #[serde(default)]
    pub joint: JointKind,
}

impl Gripper {
    /// Whether it holds at time `t`, s.
    #[must_use]
    pub fn holds(&self, t: f64) -> bool {
        self.from <= t && self.until.is_none_or(|until| t < until)
    }

    /// The end at time `t`, s, of a tip that was at `taken` when it was taken.
    #[must_use]
    pub fn end(&self, t: f64, taken: &Isometry3<f64>) -> rod::End {
        let place = Point3::from(taken.translation.vector);
        let moved = self.motion.displacement((t - self.from).max(0.0), &place) * taken;
        self.joint.end(t, moved)
    }

    /// Reports problems of grippers of one bundle.
    pub(crate) fn check(grippers: &[Self], check: &mut Check) {
        check.each("grippers", grippers, |c, gripper| {
            c.number("from", gripper.from, Allowed::NonNegative, "s");
            if let Some(until) = gripper.until {
                c.number("until", until, Allowed::Positive, "s");
                if until <= gripper.from {
                    let message = format!(
                        "is {until:?}, but it takes at {:?} (s): let it go later than that",
                        gripper.from
                    );
                    c.refuse("until", message);
                }
            }
            c.within("motion", |c| gripper.motion.check(c));
            c.within("joint", |c| gripper.joint.check(c));
            if gripper.joint.is_free() {
                c.refuse("joint", "is free, but a gripper must hold something".into());
            }
        });
        for (i, pair) in grippers.windows(2).enumerate() {
            let free = pair[0].until.unwrap_or(f64::INFINITY);
            if pair[1].from < free {
                let message = format!(
                    "is {:?}, but the gripper before lets go at {free:?} (s): take later, or let \
                     go earlier",
                    pair[1].from
                );
                check.refuse(&format!("grippers[{}].from", i + 1), message);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grippers_take_before_they_let_go_and_one_at_a_time() {
        let gripper =
            |from, until| Gripper { from, until, motion: Motion::Fixed, joint: JointKind::Clamped };
        let paths = |grippers: &[Gripper]| {
            let mut check = Check::default();
            Gripper::check(grippers, &mut check);
            check.finish(None).into_iter().map(|problem| problem.path).collect::<Vec<_>>()
        };
        assert!(paths(&[gripper(0.0, Some(1.0)), gripper(1.0, None)]).is_empty());
        assert_eq!(paths(&[gripper(2.0, Some(1.0))]), ["grippers[0].until"]);
        assert_eq!(paths(&[gripper(0.0, None), gripper(1.0, None)]), ["grippers[1].from"]);
        let one = gripper(1.0, Some(2.0));
        assert_eq!([0.9, 1.0, 1.9, 2.0].map(|t| one.holds(t)), [false, true, true, false]);
    }
}
