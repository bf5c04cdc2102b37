//! What a touch obeys, by the scene, its partner and what it did when the step began.

use super::object::Object;
use super::touch::{Partner, Touch};
use crate::scene::{Adhesion, ContactSettings};
use nalgebra::Vector3;
use rapunzel_contact::{Bond, ContactError, LimitCurve};
use rapunzel_fiber::Assembly;

/// The laws of contact in one part of a step.
pub(super) struct Laws<'a> {
    settings: &'a ContactSettings,
    objects: &'a [Object],
    /// What gravity adds to a velocity in the part, m/s.
    fall: f64,
    /// Length of the part, s.
    dt: f64,
}

impl<'a> Laws<'a> {
    /// Those of a part of `dt` seconds under `gravity`, m/s^2.
    pub(super) fn new(
        settings: &'a ContactSettings,
        objects: &'a [Object],
        gravity: f64,
        dt: f64,
    ) -> Self {
        Self { settings, objects, fall: gravity * dt, dt }
    }

    /// The least normal velocity of a touch is the negative of this, m/s. `gap` is that at the start
    /// over the length of the part, `before` the normal velocity then.
    ///
    /// A touch that would close returns with its share, if there is one, of the velocity of approach
    /// (Newton). Whether it would is told by the start of the part, with what gravity may add, so that
    /// it neither depends on the search nor is a fall stopped at the surface before it bounces. What
    /// comes no faster than gravity drives it in two parts is at rest, and stays so.
    pub(super) fn closing(&self, touch: &Touch, gap: f64, before: f64) -> f64 {
        let own = self.object(touch).and_then(|object| object.restitution);
        let restitution = own.unwrap_or(self.settings.restitution);
        let fast = before < -2.0 * self.fall && gap + before < self.fall;
        let bounces = restitution > 0.0 && fast;
        if bounces { gap.min(restitution * before) } else { gap }
    }

    /// The limit curve of a touch with a relative velocity at the start of the part, m/s, in its
    /// frame. Backward Euler ends with its mean velocity: the slip at the start is that of the part
    /// before.
    pub(super) fn friction(
        &self,
        touch: &Touch,
        before: &Vector3<f64>,
    ) -> Result<LimitCurve, ContactError> {
        let own = self.object(touch).and_then(|object| object.friction);
        let sticks = before.yz().norm() <= self.settings.slip;
        own.unwrap_or(self.settings.friction).of(touch, sticks)
    }

    /// Tensile impulse that a touch bears, N s, where it stands for a `length` of contact, m. `gap`
    /// is as in [`Self::closing`].
    pub(super) fn adhesion(
        &self,
        touch: &Touch,
        gap: f64,
        length: f64,
    ) -> Result<f64, ContactError> {
        match self.settings.adhesion {
            Some(Adhesion::Line { force, range }) if gap * self.dt <= range => {
                Ok(force * length * self.dt)
            }
            Some(Adhesion::Bonds { strength, .. }) if touch.bonded => {
                Ok(Bond::new(strength)?.adhesion(self.dt))
            }
            _ => Ok(0.0),
        }
    }

    fn object(&self, touch: &Touch) -> Option<&Object> {
        match touch.partner {
            Partner::Object(object) => Some(&self.objects[object as usize]),
            Partner::Fiber(_) => None,
        }
    }
}

/// The lengths of contact that some touches stand for, m: to each side half the way to the next of
/// the pair, if that is at most a segment. Sorted by pair and place.
pub(super) fn lengths(assembly: &Assembly, touches: &[Touch]) -> Vec<f64> {
    let mut lengths = vec![0.0; touches.len()];
    for (i, pair) in touches.windows(2).enumerate() {
        let [a, b] = [&pair[0], &pair[1]];
        let way = b.at()[0] - a.at()[0];
        if (a.fiber, a.partner) == (b.fiber, b.partner) && way <= 1.0 + 1e-9 {
            let fiber = &assembly.fibers()[a.fiber as usize];
            let half = 0.5 * way * fiber.length() / fiber.segments() as f64;
            lengths[i] += half;
            lengths[i + 1] += half;
        }
    }
    lengths
}
