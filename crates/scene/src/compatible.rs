//! What of a bundle does not go with the rest of its scene.

use super::check::Check;
use super::{Bundle, Initial, JointKind, Moves, ObjectShape, RodMethod, Scene, Tip};

impl Scene {
    /// Reports a fibre that is wound around what is no capsule.
    pub(crate) fn check_wrapped(&self, bundle: &Bundle, check: &mut Check) {
        let Initial::Wrapped { object, .. } = bundle.initial else { return };
        let found = self.objects.get(object);
        let message = match found.map(|object| (&object.shape, object.moves)) {
            None => format!("is {object}, but there is no such object"),
            Some((ObjectShape::Capsule { .. }, Moves::Led)) => return,
            Some((ObjectShape::Capsule { .. }, Moves::Free { .. })) => {
                format!("is {object}, but that moves freely; wind the fibre around one that is Led")
            }
            Some(_) => format!("is {object}, but that is no Capsule; wind the fibre around one"),
        };
        check.refuse("initial.object", message);
    }

    /// Reports grippers of inner nodes with a method that holds none.
    pub(crate) fn check_inner_grippers(&self, bundle: &Bundle, check: &mut Check) {
        let inner =
            bundle.grippers.iter().position(|one| one.inner_node(bundle.segments).is_some());
        if let Some(i) = inner.filter(|_| !self.stepper.keeps_ledgers()) {
            let message = "is an inner one, which needs the method Staggered or BackwardEuler without \
                           a tolerance";
            check.refuse(&format!("grippers[{i}].node"), message.into());
        }
    }

    /// Reports ends whose freedoms are held one by one with a method that has no such ends.
    pub(crate) fn check_supports(&self, bundle: &Bundle, check: &mut Check) {
        if !matches!(self.stepper.method(), RodMethod::Box { .. }) {
            return;
        }
        let refuse = |check: &mut Check, field: &str| {
            let message = "is Supported, which the method Box has not; take Staggered";
            check.refuse(field, message.into());
        };
        let supported = |joint: &JointKind| matches!(joint, JointKind::Supported { .. });
        if supported(&bundle.root_joint) {
            refuse(check, "root_joint");
        }
        if let Tip::Driven { joint, .. } | Tip::Led { joint, .. } = &bundle.tip
            && supported(joint)
        {
            refuse(check, "tip.joint");
        }
    }
}
