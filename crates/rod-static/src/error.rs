use thiserror::Error;

/// Errors of a static problem, or of its solution.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StaticError {
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite; give it in SI units")]
    NotPositive {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A quantity that must be finite is not.
    #[error("{quantity} is not finite; every number must be finite")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
    },
    /// A rod needs at least one piece.
    #[error("the rod has no pieces; give at least one")]
    NoPieces,
    /// The end is farther from the clamp than the rod is long.
    #[error(
        "the end is {distance} m from the clamp, but the rod is {length} m long; move the end \
         nearer or make the rod longer"
    )]
    OutOfReach {
        /// Distance of the end from the clamp, m.
        distance: f64,
        /// Length of the rod, m.
        length: f64,
    },
    /// A sweep of a parameter needs at least one step.
    #[error("a parameter is to be swept in no steps; give at least one")]
    NoSteps,
    /// A sweep of a parameter ends where it begins.
    #[error("a parameter is to be swept from {value} to the same value; give a range")]
    NoRange {
        /// The value.
        value: f64,
    },
    /// A branch does not meet so many bifurcations.
    #[error(
        "bifurcation {asked} is to be left for another branch, counted from 0, but {met} are met in \
         the range; widen the range, or leave at an earlier one"
    )]
    NoBifurcation {
        /// Index of the bifurcation that was asked for.
        asked: usize,
        /// Number of those that are met.
        met: usize,
    },
    /// The stability of what is not stable cannot be lost.
    #[error(
        "the equilibrium that is followed is unstable from the start, {ways} ways lead down: start \
         from a stable one, or at a smaller load"
    )]
    Unstable {
        /// Number of independent ways.
        ways: usize,
    },
    /// A rod in a joint at its root with a free end has no definite place.
    #[error(
        "the rod is in a joint at its root and its other end is free, so it has no definite place; \
         clamp it, or hold the other end"
    )]
    Loose,
    /// A chain needs at least one segment.
    #[error("the rod is to be cut into no segments; give at least one")]
    NoSegments,
    /// A segment is too long for its curvature.
    #[error(
        "segment {segment} turns by {angle} rad, but must turn by less than pi; cut the rod into \
         more segments"
    )]
    TooCoarse {
        /// Index of the segment, counted from the clamp.
        segment: usize,
        /// Angle by which it turns, rad.
        angle: f64,
    },
    /// A node that a chain does not have, or that is clamped.
    #[error("there is no free node {node}; the nodes behind the clamp are 1 to {last}")]
    NoNode {
        /// Index of the node that was given.
        node: usize,
        /// Index of the last node.
        last: usize,
    },
    /// A list that needs one entry for each node has another length.
    #[error("{quantity} are {given}, but there must be one for each of the {nodes} nodes")]
    WrongCount {
        /// Name of the list, with its unit.
        quantity: &'static str,
        /// Number of entries that were given.
        given: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// Chains and shapes to start from are not of the same number.
    #[error("{given} shapes are given to start from, but there are {chains} chains")]
    NotOneStartEach {
        /// Number of shapes.
        given: usize,
        /// Number of chains.
        chains: usize,
    },
    /// The rod bends or turns too sharply for its length.
    #[error(
        "the rod of {length} m bends or turns within {radius} m, too sharply to be resolved; \
         lessen its natural curvature, its loads or its length"
    )]
    TooFine {
        /// Radius of the sharpest bend or turn, m.
        radius: f64,
        /// Length of the rod, m.
        length: f64,
    },
    /// The iteration ended before it found an equilibrium.
    #[error(
        "no equilibrium was found in {iterations} steps, the last of which would turn a node by \
         {step} rad; start nearer to it, or apply the loads in parts"
    )]
    NotConverged {
        /// Number of Newton steps that were taken.
        iterations: usize,
        /// Largest rotation of a node in the step that would follow, rad.
        step: f64,
    },
    /// Following loads and springs of targets in an assembly.
    #[error(
        "rods that touch something rest where their energy is least, but following loads have none, \
         and targets must hold their nodes: leave them out"
    )]
    NoMinimum,
    /// A rod that nothing holds.
    #[error(
        "nothing holds rod {rod}: it can move away, or be moved, without a force; hold its root or \
         its end, or put something in its way (contacts have no friction)"
    )]
    Adrift {
        /// Index of the rod.
        rod: usize,
    },
    /// The derivatives of an equilibrium by its loads are not defined.
    #[error(
        "the equilibrium has no derivatives by its loads: {reason}; change the loads a little, or \
         take differences"
    )]
    NoDerivative {
        /// Why there are none.
        reason: &'static str,
    },
    /// No start that was tried leads to an equilibrium.
    #[error(
        "no equilibrium was found from any start; give a start near the one that is wanted, or \
         check that the end can be reached"
    )]
    NotFound,
}

/// Checks that `value` is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<(), StaticError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(StaticError::NotPositive { quantity, value })
    }
}

/// Checks that all of `values` are finite.
pub(crate) fn finite(quantity: &'static str, values: &[f64]) -> Result<(), StaticError> {
    if values.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(StaticError::NotFinite { quantity })
    }
}
