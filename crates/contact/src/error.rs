use thiserror::Error;

/// Reason why contacts could not be solved.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// A number makes no sense.
    #[error("{what} is {value}: {why}")]
    Invalid {
        /// Name of the number.
        what: &'static str,
        /// Value of the number.
        value: f64,
        /// Condition that the number must meet.
        why: &'static str,
    },
    /// A contact is at a point that there is not, or its numbers make no sense.
    #[error("contact {contact}: {why}")]
    Contact {
        /// Index of the contact.
        contact: usize,
        /// Condition that is not met.
        why: &'static str,
    },
    /// An array does not have the length that the bodies or contacts need.
    #[error("{what}: {found} were given, {expected} are needed")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Length that the array must have.
        expected: usize,
        /// Length of the array.
        found: usize,
    },
    /// A body could not answer.
    #[error("body {body} cannot answer impulses: {why}")]
    Body {
        /// Index of the body.
        body: usize,
        /// Reason that the body gives.
        why: String,
    },
    /// A small convex program of Alg. 6 was not solved.
    #[error(
        "a convex program with {variables} variables and {constraints} constraints was not \
         solved ({why}): check the contacts' data for numbers that are not finite"
    )]
    Program {
        /// Number of variables.
        variables: usize,
        /// Number of constraints.
        constraints: usize,
        /// Reason that the solver gives.
        why: String,
    },
    /// The impulses that hold a chain together were not found.
    #[error(
        "joint {joint} of chain {chain} is open by {gap:e} m after {iterations} iterations: \
             take a shorter step"
    )]
    Joint {
        /// Index of the chain.
        chain: usize,
        /// Index of its joint with the widest gap.
        joint: usize,
        /// The gap, m; infinite where the equations were singular or numbers overflowed.
        gap: f64,
        /// Iterations done.
        iterations: usize,
    },
}
