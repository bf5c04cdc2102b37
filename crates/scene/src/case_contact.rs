//! What the rod of a case touches.

use super::case::{Case, CaseEnd, CaseRod, CaseRoot, CaseStart, Force, PointMass};
use crate::{Check, LoadFrame, Motion, Moves, Pose, TaperPoint};
use serde::{Deserialize, Serialize};

/// A rod that touches the rod of a case, other such rods, or objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TouchingRod {
    /// Length of the rod, m.
    pub length: f64,
    /// Stiffness and mass of the rod; its radius is that of contact.
    pub rod: CaseRod,
    /// Table of sections, stiffness and mass along the rod, from root to end.
    #[serde(default)]
    pub taper: Vec<TaperPoint>,
    /// Darboux vector of the unloaded rod in the material frame (about d1, d2, tangent), 1/m.
    #[serde(default)]
    pub natural_curvature: [f64; 3],
    /// Pose of its root.
    #[serde(default)]
    pub clamp: Pose,
    /// What holds its root.
    #[serde(default)]
    pub root: CaseRoot,
    /// Boundary condition at its end.
    #[serde(default)]
    pub end: CaseEnd,
    /// Point masses along the rod.
    #[serde(default)]
    pub masses: Vec<PointMass>,
    /// Forces along the rod.
    #[serde(default)]
    pub forces: Vec<Force>,
    /// Where the search starts; left out, from the natural shape.
    #[serde(default)]
    pub start: Option<CaseStart>,
}

impl Case {
    /// Whether the rod touches something: objects or other rods.
    #[must_use]
    pub fn is_in_contact(&self) -> bool {
        !self.objects.is_empty() || !self.rods.is_empty()
    }

    /// The rods of the case, its own first, each as a case that touches nothing.
    #[must_use]
    pub fn alone(&self) -> Vec<Self> {
        let own = Self { objects: Vec::new(), rods: Vec::new(), ..self.clone() };
        let others = self.rods.iter().map(|rod| self.other(rod));
        [own].into_iter().chain(others).collect()
    }

    /// Another rod as a case that touches nothing.
    fn other(&self, rod: &TouchingRod) -> Self {
        let TouchingRod { length, natural_curvature, clamp, root, end, .. } = *rod;
        Self {
            length,
            rod: rod.rod,
            taper: rod.taper.clone(),
            natural_curvature,
            joined: Vec::new(),
            clamp,
            root,
            end,
            masses: rod.masses.clone(),
            forces: rod.forces.clone(),
            places: Vec::new(),
            objects: Vec::new(),
            rods: Vec::new(),
            start: rod.start.clone(),
            ..self.clone()
        }
    }

    /// Reports what makes no sense of contacts.
    pub(crate) fn check_contact(&self, check: &mut Check) {
        check.each("rods", &self.rods, |c, rod| {
            self.other(rod).check_rod(c);
            c.each("forces", &rod.forces, check_dead);
            check_ends(c, rod.root, &rod.end);
        });
        check.each("objects", &self.objects, |c, object| {
            object.check(c);
            if object.motion != Motion::Fixed || !object.drag.is_empty() {
                c.refuse("motion", "is given, but at rest objects stay where they are".into());
            }
            if object.moves != Moves::Led {
                let message = "is Free, but at rest objects stay where they are: leave it out, or \
                               run a scene until it is at rest";
                c.refuse("moves", message.into());
            }
            if object.friction.is_some() || object.restitution.is_some() {
                let message = "is given, but rods at rest have no friction here: with friction \
                               they may rest in many shapes; run a scene for one of these";
                c.refuse("friction", message.into());
            }
        });
        let touches = self.is_in_contact();
        if self.root == CaseRoot::Free && !touches {
            let message = "is Free, but nothing is there that the rod could lie on: give `objects`, \
                           or clamp it";
            check.refuse("root", message.into());
        }
        if !touches {
            return;
        }
        check_ends(check, self.root, &self.end);
        check.each("forces", &self.forces, check_dead);
        let with = "does not go together with `objects` and `rods`, which the rod touches";
        for (field, is) in [
            ("wish", self.wish.is_some()),
            ("sweep", self.sweep.is_some()),
            ("critical", self.critical.is_some()),
            ("all_with_turns", self.all_with_turns.is_some()),
            ("joined", !self.joined.is_empty()),
            ("places", self.places.iter().any(|place| place.stiffness.is_some())),
        ] {
            if is {
                check.refuse(field, with.into());
            }
        }
    }
}

/// Reports a force that follows the rod.
fn check_dead(check: &mut Check, force: &Force) {
    if force.frame == LoadFrame::Follower {
        let message = "follows the rod, so it has no energy, which rods in contact need: give a \
                       force in the World";
        check.refuse("frame", message.into());
    }
}

/// Reports ends that rods in contact do not have.
fn check_ends(check: &mut Check, root: CaseRoot, end: &CaseEnd) {
    match end {
        CaseEnd::Free { moment, .. } if *moment != [0.0; 3] => {
            check.refuse("end.moment", "has no energy, which rods in contact need".into());
        }
        CaseEnd::Free { .. } | CaseEnd::Joint { .. } => {}
        CaseEnd::Clamped { .. } if root == CaseRoot::Clamped => {}
        CaseEnd::Clamped { .. } => {
            let message = "is clamped, but the root is not: clamp the root and let the end go";
            check.refuse("end", message.into());
        }
        CaseEnd::Bearing { .. } | CaseEnd::Sliding { .. } | CaseEnd::Ring { .. } => {
            let message = "is not known of rods in contact: let it be Free, Joint or Clamped";
            check.refuse("end", message.into());
        }
    }
}
