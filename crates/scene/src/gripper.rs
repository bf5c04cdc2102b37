use super::check::{Allowed, Check};
use super::joint_node::JointNode;
use super::load::TimedLoad;
use super::motion::Motion;
use super::tip::JointKind;
use nalgebra::{Isometry3, Point3};
use rapunzel_rod_dynamic as rod;
use serde::{Deserialize, Serialize};

/// A gripper that takes a node of each fibre of a bundle at a time, as it is then, and lets it go
/// at another: it is rigid, where a hand of `grips` is a spring. Until it takes and after it lets
/// go tips are as `tip` says, and roots, which must be free, as `root_joint` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gripper {
    /// The node that it takes; left out, the tip. An inner one is held by its place alone, by a
    /// spring that gives way to a force as the node with ten thousand times its mass would in a
    /// step.
    #[serde(default = "tip")]
    pub node: JointNode,
    /// Time at which it takes, s; it takes effect at the nearest step.
    pub from: f64,
    /// Time at which it lets go, s; left out, it never does.
    #[serde(default)]
    pub until: Option<f64>,
    /// Motion of the nodes while they are held, from the time at which they are taken; they turn
    /// about their places then.
    #[serde(default)]
    pub motion: Motion,
    /// What it holds of the pose; `Ball()` of an inner node.
    #[serde(default)]
    pub joint: JointKind,
}

fn tip() -> JointNode {
    JointNode::Tip
}

/// What grippers need to know of the fibres that they take.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GrippedFibers {
    /// Number of segments of each, unless they are of a groom.
    pub(crate) segments: usize,
    /// Whether nothing holds their roots.
    pub(crate) root_is_free: bool,
    /// Whether they are hairs of a groom.
    pub(crate) are_groomed: bool,
}

impl Gripper {
    /// Whether it holds at time `t`, s.
    #[must_use]
    pub fn holds(&self, t: f64) -> bool {
        self.from <= t && self.until.is_none_or(|until| t < until)
    }

    /// Its inner node in a fibre of so many segments; `None` if it is an end.
    #[must_use]
    pub fn inner_node(&self, segments: usize) -> Option<usize> {
        Some(self.node.number(segments)).filter(|number| (1..segments).contains(number))
    }

    /// The place at time `t`, s, of a node that was at `taken` when it was taken.
    #[must_use]
    pub fn place(&self, t: f64, taken: &Isometry3<f64>) -> Point3<f64> {
        Point3::from(self.moved(t, taken).translation.vector)
    }

    /// The end at time `t`, s, of a tip or root that was at `taken` when it was taken.
    #[must_use]
    pub fn end(&self, t: f64, taken: &Isometry3<f64>) -> rod::End {
        self.joint.end(t, self.moved(t, taken))
    }

    /// The pose at time `t`, s, to which what was at `taken` has been moved.
    fn moved(&self, t: f64, taken: &Isometry3<f64>) -> Isometry3<f64> {
        let place = Point3::from(taken.translation.vector);
        self.motion.displacement((t - self.from).max(0.0), &place) * taken
    }

    /// Reports problems of grippers of one bundle.
    pub(crate) fn check(grippers: &[Self], fibers: GrippedFibers, check: &mut Check) {
        let segments = fibers.segments;
        check.each("grippers", grippers, |c, gripper| {
            gripper.check_node(c, fibers);
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
        for (i, gripper) in grippers.iter().enumerate() {
            let same = |one: &&Self| one.node.number(segments) == gripper.node.number(segments);
            let Some(before) = grippers[..i].iter().rfind(same) else { continue };
            let free = before.until.unwrap_or(f64::INFINITY);
            if gripper.from < free {
                let message = format!(
                    "is {:?}, but the gripper of this node before lets go at {free:?} (s): take \
                     later, or let go earlier",
                    gripper.from
                );
                check.refuse(&format!("grippers[{i}].from"), message);
            }
        }
    }
}

impl Gripper {
    /// Reports a node that cannot be taken.
    fn check_node(&self, check: &mut Check, fibers: GrippedFibers) {
        let (number, last) = (self.node.number(fibers.segments), fibers.segments);
        if number > last {
            let message = format!("is {number}, but the nodes are numbered 0 to {last}");
            check.refuse("node", message);
        } else if number == 0 && !fibers.root_is_free {
            let message = "is the root, which is held already; let it go with `root_joint: Free`";
            check.refuse("node", message.into());
        } else if self.inner_node(last).is_some() {
            if fibers.are_groomed {
                let message = "is an inner one, but the hairs of a groom have different numbers of \
                               them; take the Tip";
                check.refuse("node", message.into());
            }
            if self.joint != (JointKind::Ball { moment: TimedLoad::default() }) {
                let message =
                    "holds more than the place of an inner node, or loads it; take `Ball()`";
                check.refuse("joint", message.into());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gripper_holds_from_a_time_until_another() {
        let (node, motion, joint) = (JointNode::Tip, Motion::Fixed, JointKind::Clamped);
        let one = Gripper { node, from: 1.0, until: Some(2.0), motion, joint };
        assert_eq!([0.9, 1.0, 1.9, 2.0].map(|t| one.holds(t)), [false, true, true, false]);
        assert_eq!(one.inner_node(5), None);
        let inner = Gripper { node: JointNode::Node(4), ..one };
        assert_eq!([5, 4].map(|segments| inner.inner_node(segments)), [Some(4), None]);
    }
}
