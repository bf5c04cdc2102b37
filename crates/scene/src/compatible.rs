//! What of a bundle does not go with the rest of its scene.

use super::check::Check;
use super::{
    Bundle, Charging, Initial, JointKind, Law, Motion, Moves, ObjectShape, Plan, RodMethod, Scene,
    Spin, Tip,
};

impl Scene {
    /// Reports motions beside charging, where fibres are at rest and clamped at their roots.
    pub(crate) fn check_charging(&self, charging: &Charging, check: &mut Check) {
        check.within("charging", |c| charging.check(c, &self.objects, Plan::new(self).steps));
        let course = &self.environment.climate.humidity;
        if let Some(flow) = &charging.flow {
            // Humidity goes straight from one of these to the next.
            let refused = course.iter().find_map(|(t, _)| {
                let climate = self.environment.climate.at(*t);
                climate.and_then(|climate| flow.resistance_in(&climate)).err()
            });
            if let Some(error) = refused {
                check.refuse("charging.flow.resistance", error.to_string());
            }
        }
        let waits = charging.flow.is_some() || self.environment.climate.changes();
        if waits && !charging.compared.is_empty() {
            let message =
                "take other times, but charge flows or the humidity changes: leave them out";
            check.refuse("charging.compared", message.into());
        }
        let why = "has no meaning with charging, where fibres lie at rest: leave it out";
        let mut refuse = |given: bool, field: &str| {
            if given {
                check.refuse(field, why.into());
            }
        };
        refuse(self.contact.is_some(), "contact");
        refuse(!self.grips.is_empty(), "grips");
        refuse(self.mass_spring.is_some(), "mass_spring");
        refuse(self.stepper.method.is_some(), "stepper.method");
        refuse(self.stepper.tolerance.is_some(), "stepper.tolerance");
        refuse(self.output.ledger, "output.ledger");
        refuse(self.environment.viscosity != 0.0, "environment.viscosity");
        for (i, bundle) in self.fibers.iter().enumerate() {
            let mut refuse = |given: bool, field: &str| {
                refuse(given, &format!("fibers[{i}].{field}"));
            };
            refuse(bundle.initial != Initial::Natural, "initial");
            refuse(bundle.groom.is_some(), "groom");
            refuse(bundle.motion != Motion::Fixed, "motion");
            refuse(bundle.root_joint != JointKind::Clamped, "root_joint");
            refuse(bundle.tip != Tip::Free, "tip");
            refuse(bundle.velocity != [0.0; 3], "velocity");
            refuse(!bundle.grippers.is_empty(), "grippers");
            refuse(bundle.spin != Spin::default(), "spin");
            refuse(!bundle.velocities.is_empty(), "velocities");
            refuse(bundle.damping_time != 0.0, "damping_time");
            refuse(bundle.law() != Law::Elastic, "material.law");
        }
        for i in (0..self.objects.len()).filter(|i| charging.head.object() != Some(*i)) {
            let message = "is not the head, and nothing else is met by fibres at rest".into();
            check.refuse(&format!("objects[{i}]"), message);
        }
    }

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
