//! Where things touch, whatever they are.

use crate::World;
use crate::stepper::ContactForce;
use rapunzel_coupling::{ActiveContact, BodyRef};

impl World {
    /// Where things touched in the last step: fibres each other, themselves and objects, objects
    /// each other, nodes of springs each other, objects and the ground. Cost: a look at all
    /// contacts.
    pub fn touches(&self) -> impl Iterator<Item = ContactForce> {
        let nodes = self.stepper().strand_nodes();
        let of_contacts = move |contact: ActiveContact| self.touch(&nodes, &contact);
        self.contacts().filter_map(of_contacts).chain(self.stepper().touches())
    }

    fn touch(&self, nodes: &[usize], contact: &ActiveContact) -> Option<ContactForce> {
        let force = contact.force;
        let axis = match contact.sides[0] {
            BodyRef::Fiber(fiber) => {
                let fiber = fiber as usize;
                let last = nodes.get(fiber)?.checked_sub(2)?;
                let at = contact.at[0].max(0.0);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "few")]
                let segment = (at.floor() as usize).min(last);
                let ends = [segment, segment + 1].map(|node| self.node(fiber, Some(node)).0.coords);
                ends[0].lerp(&ends[1], (at - segment as f64).clamp(0.0, 1.0))
            }
            BodyRef::Object(object) => self.body(object as usize)?.pose.translation.vector,
        };
        Some(ContactForce { place: (axis + contact.lever).into(), force })
    }
}
