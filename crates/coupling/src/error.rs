use crate::{BodyRef, Unresolved};
use rapunzel_collision::CollisionError;
use rapunzel_contact::ContactError;
use rapunzel_linalg::LinalgError;
use rapunzel_rod_dynamic::{RodError, StepError};
use thiserror::Error;

/// Why fibres cannot start or be moved.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CouplingError {
    /// A step could not be taken.
    #[error("the run stopped at t = {time} s: {source}")]
    Step {
        /// Start of the step, s.
        time: f64,
        /// Which fibre and why.
        source: StepError,
    },
    /// Fibres or objects start inside each other.
    #[error(
        "{} starts {depth:.2e} m deep in {}{}; move them apart, or leave `contact` out",
        sides[0], sides[1], along(*segment)
    )]
    Overlap {
        /// The two; fibres are counted over all bundles.
        sides: [BodyRef; 2],
        /// Where along the first, from the root, if that is a fibre.
        segment: Option<usize>,
        /// How deep, m.
        depth: f64,
    },
    /// An object moves so fast that fibres could not get out of its way, or that it could pass
    /// through another.
    #[error(
        "objects[{object}] moves by {way:.2e} m in the step at t = {time} s, and at most {most:.2e} \
         m, its smallest side or a segment, or near other objects half a side or what a mesh tells of \
         its distance, are allowed; set stepper.dt to at most {dt:.2e} s, or move it more slowly"
    )]
    Leap {
        /// Index of the object in the scene.
        object: usize,
        /// Start of the step, s.
        time: f64,
        /// How far a point of it would move, as seen from the other object if there is one, m.
        way: f64,
        /// How far it may, m.
        most: f64,
        /// The longest step that would do, s.
        dt: f64,
    },
    /// Contacts throw fibres about even in the shortest part of a step.
    #[error(
        "the run stopped at t = {time} s: contacts do not converge in a part of a step, {dt:.2e} s{}; set \
         stepper.dt to less, or let things meet more gently",
        meeting(worst.as_ref())
    )]
    Lost {
        /// Start of the part, s.
        time: f64,
        /// Length of the part, s.
        dt: f64,
        /// Where contacts were farthest from their law, or deepest.
        worst: Option<Unresolved>,
    },
    /// A joint of nodes that do not meet at the start.
    #[error(
        "{joint} starts open by {gap:.2e} m, between {:?} and {:?} (m), and at most {most:.1e} m are \
         allowed; let its two ends start at the same place",
        places[0], places[1]
    )]
    JointOpen {
        /// What it is called.
        joint: String,
        /// Distance of its nodes, m.
        gap: f64,
        /// The largest distance allowed, m.
        most: f64,
        /// Its nodes, m.
        places: [[f64; 3]; 2],
    },
    /// A joint of nodes that are joined already.
    #[error(
        "{joint} joins what {other} joins already, alone or with others; leave one of them out"
    )]
    JointTwice {
        /// What it is called.
        joint: String,
        /// The other one.
        other: String,
    },
    /// Joints could not be solved.
    #[error(
        "the run stopped at t = {time} s: joints hold parts of fibres that cannot move against each \
         other, or fibres are torn: {source}; take joints away, or set stepper.dt to less"
    )]
    Joints {
        /// Start of the part of a step, s.
        time: f64,
        /// What the equations lack.
        source: LinalgError,
    },
    /// Contacts could not be looked for.
    #[error("contacts cannot be found: {0}")]
    Collision(#[from] CollisionError),
    /// Contacts could not be solved.
    #[error("contacts cannot be solved: {0}")]
    Contact(#[from] ContactError),
    /// Saved numbers are not those of these fibres.
    #[error("the saved state belongs to other fibres: {0}")]
    Restore(#[from] RodError),
}

fn along(segment: Option<usize>) -> String {
    segment.map(|segment| format!(", at its segment {segment}")).unwrap_or_default()
}

fn meeting(worst: Option<&Unresolved>) -> String {
    let tell = |Unresolved { sides: [first, second], segment, .. }: &Unresolved| {
        format!(", worst where {second} meets {first}{}", along(*segment))
    };
    worst.map(tell).unwrap_or_default()
}
