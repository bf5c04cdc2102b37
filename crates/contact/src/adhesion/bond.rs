use super::positive;
use crate::{Contact, ContactError};
use nalgebra::Vector3;

/// A bond of glue at a contact, such as hair spray (thesis Tab. 2.12: 0.1 N to 0.4 N): rigid until
/// it breaks, and then gone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// Tensile force under which the bond breaks, N.
    strength: f64,
    intact: bool,
}

impl Bond {
    /// An intact bond that breaks under the tensile force `strength`, N.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for a strength that is not finite and positive.
    pub fn new(strength: f64) -> Result<Self, ContactError> {
        Ok(Self { strength: positive("strength of a bond", strength)?, intact: true })
    }

    /// Whether the bond still holds.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.intact
    }

    /// Tensile impulse that the bond bears in a step of `dt` seconds, N s: [`Contact::adhesion`].
    #[must_use]
    pub fn adhesion(&self, dt: f64) -> f64 {
        if self.intact { self.strength * dt } else { 0.0 }
    }

    /// Breaks the bond if the solved `contact` opens, by `velocity` (u), against all that the bond
    /// bears: the tensile `impulse` is the adhesion, and the contact opens faster than `tolerance`,
    /// m/s. Tells whether it broke just now.
    pub fn update(
        &mut self,
        contact: &Contact,
        velocity: &Vector3<f64>,
        impulse: &Vector3<f64>,
        tolerance: f64,
    ) -> bool {
        let at_limit = impulse.x <= -contact.adhesion * (1.0 - 1e-9);
        let breaks = self.intact && at_limit && velocity.x > tolerance;
        self.intact &= !breaks;
        breaks
    }
}
