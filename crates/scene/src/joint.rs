//! Joints between fibres.

use super::check::{Allowed, Check};
use super::fibers::Bundle;
use super::joint_node::JointNode;
use super::material::Law;
use super::tip::Tip;
use super::{Motion, Scene};
use serde::{Deserialize, Serialize};

/// A joint that holds two nodes together from the start on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FiberJoint {
    /// What it holds beside the nodes.
    pub hold: JointHold,
    /// The first node; the tip of a `Spliced` joint.
    pub first: JointPlace,
    /// The second node, which starts at the same place; the root of a `Spliced` joint.
    pub second: JointPlace,
}

/// What a joint holds beside two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum JointHold {
    /// Nothing: a ball joint, about which both turn freely.
    Ball,
    /// The angle at which the fibres meet at the start: what is between the middles of the segments
    /// before the two nodes, at a root of the first one, bends and twists as the fibres do.
    Stiff,
    /// A tip and a root as one fibre: what is between bends and twists as within a fibre, from the
    /// natural shape of both ends.
    Spliced,
}

/// A ball joint that holds a node where it is on an object at the start: what hangs on fibres, a
/// bead at a tip. The segments beside it do not touch the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectJoint {
    /// Index of the fibre, counted over all bundles.
    pub fiber: usize,
    /// The node.
    pub at: JointNode,
    /// Index of the object among `objects`.
    pub object: usize,
}

/// A node that is joined. It must be free to move: no root or tip that is held or led.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointPlace {
    /// Index of the fibre, counted over all bundles.
    pub fiber: usize,
    /// The node.
    pub at: JointNode,
}

impl Scene {
    /// Whether fibres are joined to each other or to objects, or closed.
    #[must_use]
    pub fn has_joints(&self) -> bool {
        let listed = !self.joints.is_empty() || !self.object_joints.is_empty();
        listed || self.fibers.iter().any(|bundle| bundle.closed.is_some())
    }

    /// Reports a place that cannot be joined.
    fn check_joined(&self, check: &mut Check, field: &str, place: JointPlace) {
        match self.bundle_of(place.fiber) {
            Some(bundle) if bundle.groom.is_none() => check_place(check, field, bundle, place.at),
            Some(_) => check.refuse(
                &joined(field, "fiber"),
                "is of a groom, whose hairs cannot be joined".into(),
            ),
            None => {
                let message = format!("is {}, but there is no such fibre", place.fiber);
                check.refuse(&joined(field, "fiber"), message);
            }
        }
    }

    /// Reports problems of joints.
    pub(super) fn check_joints(&self, check: &mut Check) {
        if !self.has_joints() {
            return;
        }
        let mut refuse = |given: bool, field: &str, why: &str| {
            if given {
                check.refuse(field, why.into());
            }
        };
        let alone =
            "cannot be given where fibres are joined or closed: leave it out, or the joints";
        let objects = !self.object_joints.is_empty() && self.contact.is_none();
        refuse(objects, "object_joints", "needs `contact`, by which objects move: give it, too");
        refuse(self.charging.is_some(), "charging", alone);
        refuse(self.mass_spring.is_some(), "mass_spring", alone);
        let method = "must be Staggered, BackwardEuler or left out, and without a tolerance where \
                      fibres are joined or closed";
        refuse(!self.stepper.keeps_ledgers(), "stepper.method", method);
        for (i, bundle) in self.fibers.iter().enumerate() {
            let Some(closing) = &bundle.closed else { continue };
            check.within(&format!("fibers[{i}]"), |c| {
                c.within("closed", |c| {
                    c.number("turns", closing.turns, Allowed::Finite, "");
                    for end in [JointNode::Root, JointNode::Tip] {
                        check_place(c, "", bundle, end);
                    }
                });
            });
        }
        check.each("object_joints", &self.object_joints, |c, joint| {
            self.check_joined(c, "", JointPlace { fiber: joint.fiber, at: joint.at });
            if joint.object >= self.objects.len() {
                let message = format!("is {}, but there is no such object", joint.object);
                c.refuse("object", message);
            }
        });
        check.each("joints", &self.joints, |c, joint| {
            for (field, place) in [("first", joint.first), ("second", joint.second)] {
                self.check_joined(c, field, place);
            }
            let ends = joint.first.at == JointNode::Tip && joint.second.at == JointNode::Root;
            if joint.hold == JointHold::Spliced && !ends {
                let message = "is Spliced, but that needs a Tip as the first node and a Root as the \
                               second; exchange them, or take Stiff";
                c.refuse("hold", message.into());
            }
            if joint.first == joint.second {
                c.refuse("second", "is the same node as the first".into());
            }
        });
    }
}

/// Reports a node that cannot be joined.
fn check_place(check: &mut Check, field: &str, bundle: &Bundle, at: JointNode) {
    let (number, last) = (at.number(bundle.segments), bundle.segments);
    if number > last {
        let message = format!("is {number}, but the nodes are numbered 0 to {last}");
        check.refuse(&joined(field, "at"), message);
    }
    let held = if number == 0 {
        !bundle.root_joint.is_free() || bundle.motion != Motion::Fixed
    } else {
        number == last && !matches!(bundle.tip, Tip::Free | Tip::Loaded { .. })
    };
    if held {
        let (end, free) =
            if number == 0 { ("root", "root_joint: Free") } else { ("tip", "tip: Free") };
        let message = format!(
            "is a {end} that is held or led where it is, so that a joint could not move it; let it go \
             with `{free}`, or hold there what is to be joined"
        );
        check.refuse(field, message);
    }
    if bundle.law() != Law::Elastic {
        let message = "is of a fibre whose law is not elastic, which cannot be joined; take `law: \
                       Elastic`";
        check.refuse(field, message.into());
    }
}

fn joined(field: &str, inner: &str) -> String {
    if field.is_empty() { inner.into() } else { format!("{field}.{inner}") }
}
