use crate::CouplingError;
use crate::contact_report::Unresolved;
use rapunzel_collision::CollisionError;
use rapunzel_contact::ContactError;
use rapunzel_rod_dynamic::StepError;

/// Why a part of a step was not taken.
pub(super) enum SubstepFailure {
    /// A rod did not converge.
    Rod(StepError),
    /// Contacts did not converge, and where they were worst.
    Contacts(Option<Unresolved>),
    /// Shorter parts will not help.
    Fatal(CouplingError),
}

impl From<CollisionError> for SubstepFailure {
    fn from(error: CollisionError) -> Self {
        Self::Fatal(error.into())
    }
}

impl From<ContactError> for SubstepFailure {
    fn from(error: ContactError) -> Self {
        Self::Fatal(error.into())
    }
}

impl From<StepError> for SubstepFailure {
    fn from(error: StepError) -> Self {
        Self::Rod(error)
    }
}

/// Whether rods have gone nowhere or bodies turn too far, which a shorter part of a step may spare
/// them.
pub(super) fn lost(error: &CouplingError) -> bool {
    matches!(
        error,
        CouplingError::Collision(CollisionError::Position { .. })
            | CouplingError::Contact(ContactError::Invalid { .. })
    )
}
