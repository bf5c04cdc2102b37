use nalgebra::SVector;
use rapunzel_collision::CollisionError;
#[cfg(feature = "modes")]
use rapunzel_linalg::LinalgError;
use thiserror::Error;

/// Errors of a mass-spring system, or of a step of it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SpringError {
    /// A parameter out of its range.
    #[error("{what} is {value:?}, but must be {allowed}")]
    Parameter {
        /// Name of the parameter.
        what: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Allowed values, as text.
        allowed: &'static str,
    },
    /// A count out of its range.
    #[error("{what}: {found}, but there must be {expected}")]
    Count {
        /// Name of what is counted.
        what: &'static str,
        /// Count that was found.
        found: usize,
        /// Allowed counts, as text.
        expected: String,
    },
    /// A mass that is not positive and finite.
    #[error("the mass of node {node} is {mass:?} kg, but must be positive and finite")]
    Mass {
        /// Index of the node.
        node: usize,
        /// Mass of the node, kg.
        mass: f64,
    },
    /// A position or velocity that is not finite.
    #[error("the {what} of node {node} is not finite; give finite numbers")]
    NotFinite {
        /// Whether it is a position or a velocity, as text.
        what: &'static str,
        /// Index of the node.
        node: usize,
    },
    /// A node that does not exist.
    #[error("{what} {index} names node {node}, but the nodes are numbered 0 to {}", nodes - 1)]
    MissingNode {
        /// Name of the thing that refers to the node.
        what: &'static str,
        /// Index of the thing that refers to the node.
        index: usize,
        /// Index of the missing node.
        node: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// A spring between a node and itself.
    #[error("spring {spring} has both ends at node {node}; connect two different nodes")]
    Loop {
        /// Index of the spring.
        spring: usize,
        /// Index of the node at both ends of the spring.
        node: usize,
    },
    /// A parameter of a spring out of its range.
    #[error("spring {spring}: {what} is {value:?}, but must be {allowed}")]
    Spring {
        /// Index of the spring.
        spring: usize,
        /// Name of the parameter.
        what: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Allowed values, as text.
        allowed: &'static str,
    },
    /// A place matrix whose rows differ in length, or that is smaller than 2 x 2.
    #[error(
        "the place matrix has {found} letters in row {row}, but needs {expected} in every row and \
         at least two rows"
    )]
    PlaceShape {
        /// Index of the row, from 0.
        row: usize,
        /// Number of letters in the row.
        found: usize,
        /// Number of letters in the first row, at least two.
        expected: usize,
    },
    /// A letter without a meaning in a place matrix.
    #[error(
        "the place matrix has '{letter}' in row {row}, column {column}; the letters are \
         f m t b l r 1 2 3 4 h v"
    )]
    PlaceLetter {
        /// Index of the row, from 0.
        row: usize,
        /// Index of the column, from 0.
        column: usize,
        /// The letter without a meaning.
        letter: char,
    },
    /// A letter that needs a neighbor which is missing or has no spring on that side.
    #[error(
        "the place matrix has '{letter}' in row {row}, column {column}, which needs a neighbor \
         {side} that pulls back; choose letters that agree"
    )]
    PlaceNeighbor {
        /// Index of the row, from 0.
        row: usize,
        /// Index of the column, from 0.
        column: usize,
        /// The letter that needs the neighbor.
        letter: char,
        /// Side of the missing neighbor, as text.
        side: &'static str,
    },
    /// The state of a run has grown beyond all bounds.
    #[error(
        "node {node} left all bounds in step {step}: the run has blown up; use a step below the stability limit, \
         an implicit integrator, or softer springs"
    )]
    BlownUp {
        /// Number of the step within the call, from 1.
        step: usize,
        /// The first node beyond all bounds.
        node: usize,
    },
    /// Newton's method did not converge.
    #[error(
        "{what} was not found in {} iterations; the steps of Newton's method were [{}] m. \
         Use a smaller time step or start closer",
        steps.len(),
        brief(steps)
    )]
    NotConverged {
        /// Name of what was sought.
        what: &'static str,
        /// Largest component of every step of Newton's method, m.
        steps: Vec<f64>,
    },
    /// A search for contacts refused its input.
    #[error("contacts: {0}")]
    Collision(#[from] CollisionError),
    /// The eigenvalue problem of the small vibrations could not be solved.
    #[cfg(feature = "modes")]
    #[error("small motions: {0}")]
    Vibration(#[from] LinalgError),
}

/// Formats the last few of many numbers.
fn brief(steps: &[f64]) -> String {
    let shown = &steps[steps.len().saturating_sub(5)..];
    let dots = if shown.len() < steps.len() { "..., " } else { "" };
    dots.to_owned() + &shown.iter().map(|s| format!("{s:.2e}")).collect::<Vec<_>>().join(", ")
}

/// Refuses a parameter that is not positive and finite.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), SpringError> {
    let allowed = "positive and finite";
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(SpringError::Parameter { what, value, allowed })
    }
}

/// Refuses a parameter that is negative or not finite.
pub(crate) fn non_negative(what: &'static str, value: f64) -> Result<(), SpringError> {
    let allowed = "zero or positive, and finite";
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(SpringError::Parameter { what, value, allowed })
    }
}

/// Refuses a vector with a component that is no number, or infinite.
pub(crate) fn finite<const N: usize>(
    what: &'static str,
    vector: &SVector<f64, N>,
) -> Result<(), SpringError> {
    match vector.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(SpringError::Parameter { what, value, allowed: "finite" }),
        None => Ok(()),
    }
}
