use super::LimitCurve;
use crate::ContactError;

/// Friction of a contact that sticks and of one that slides.
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Curve that must be overcome to make the contact slide, thesis (8.45).
    pub resting: LimitCurve,
    /// Curve that resists the slip while the contact slides, thesis (8.46).
    pub sliding: LimitCurve,
}

impl Friction {
    /// Curve for a contact that stuck, or did not, at the end of the last step. One that is
    /// new slides.
    #[must_use]
    pub fn curve(&self, stuck: bool) -> &LimitCurve {
        if stuck { &self.resting } else { &self.sliding }
    }

    /// Friction between two surfaces: [`LimitCurve::between`] of both pairs of curves.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] where [`LimitCurve::between`] refuses.
    pub fn between(first: &Self, second: &Self, angle: f64) -> Result<Self, ContactError> {
        Ok(Self {
            resting: LimitCurve::between(&first.resting, &second.resting, angle)?,
            sliding: LimitCurve::between(&first.sliding, &second.sliding, angle)?,
        })
    }
}
