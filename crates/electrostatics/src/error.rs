use rayon::prelude::*;
use thiserror::Error;

/// Errors in charges, in where they are, or in what is asked of them.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ElectrostaticsError {
    /// A position is no place, or so far away that its square overflows.
    #[error(
        "{what} {index} is at ({}, {}, {}), but coordinates must be finite and below 1e75 m",
        position[0], position[1], position[2]
    )]
    Position {
        /// Kind of the position: source, target, node, vertex or center.
        what: &'static str,
        /// Index of the position.
        index: usize,
        /// Position that was given (world), m.
        position: [f64; 3],
    },
    /// A charge is no number.
    #[error("charge {index} is {charge} C, but charges must be finite")]
    Charge {
        /// Index of the source.
        index: usize,
        /// Charge that was given, C.
        charge: f64,
    },
    /// Two arrays do not fit each other.
    #[error("{what}: {given} were given, but {needed} are needed")]
    Count {
        /// Name of the array.
        what: &'static str,
        /// Length of the array.
        given: usize,
        /// Length that the array must have.
        needed: usize,
    },
    /// A setting is outside of its range.
    #[error("{what} is {value}, but must be {range}")]
    Setting {
        /// Name of the setting.
        what: &'static str,
        /// Value that was given.
        value: f64,
        /// Range of the setting.
        range: &'static str,
    },
    /// The tolerance was not reached by the highest order.
    #[error(
        "the relative force error is {reached:e} with expansions of degree {order}, not \
         {tolerance:e}; ask for less, or take the direct sum"
    )]
    OutOfReach {
        /// Relative error that was asked for.
        tolerance: f64,
        /// Relative error that was reached at sampled targets.
        reached: f64,
        /// Highest degree that was tried.
        order: usize,
    },
    /// A grid was not written.
    #[error("the grid could not be written: {0}")]
    Write(String),
    /// The charges of a conductor were not found.
    #[error(
        "the charges of the conductor have a relative residual of {residual:e} after {iterations} \
         iterations; its triangles are too uneven"
    )]
    NoConvergence {
        /// Number of iterations that were made.
        iterations: usize,
        /// Relative residual of the potentials.
        residual: f64,
    },
    /// The mesh of a conductor has no inside that could be found.
    #[error("the mesh of the conductor: {0}")]
    Mesh(rapunzel_collision::CollisionError),
    /// A fibre is where only the conductor can be.
    #[error(
        "point {index} is inside of the conductor, at least {depth} m below its surface; \
         move it out"
    )]
    Inside {
        /// Index of the point.
        index: usize,
        /// Depth below the surface at least, m.
        depth: f64,
    },
}

/// Refuses positions that are no places.
pub(crate) fn check_positions(
    what: &'static str,
    positions: &[nalgebra::Point3<f64>],
) -> Result<(), ElectrostaticsError> {
    let place = |position: &nalgebra::Point3<f64>| position.iter().all(|x| x.abs() < 1e75);
    match first_not(positions, place) {
        Some(index) => {
            let position = positions[index].into();
            Err(ElectrostaticsError::Position { what, index, position })
        }
        None => Ok(()),
    }
}

/// Index of the first of `items` that is not `right`.
fn first_not<T: Sync>(items: &[T], right: impl Fn(&T) -> bool + Sync) -> Option<usize> {
    const PART: usize = 4096;
    let wrong =
        |(k, part): (usize, &[T])| part.iter().position(|item| !right(item)).map(|i| k * PART + i);
    items.par_chunks(PART).enumerate().find_map_first(wrong)
}

/// Refuses charges that are no numbers, or not as many as `needed`.
pub(crate) fn check_charges(charges: &[f64], needed: usize) -> Result<(), ElectrostaticsError> {
    check_count("charges", charges.len(), needed)?;
    match first_not(charges, |charge| charge.is_finite()) {
        Some(index) => Err(ElectrostaticsError::Charge { index, charge: charges[index] }),
        None => Ok(()),
    }
}

/// Refuses an array of the wrong length.
pub(crate) fn check_count(
    what: &'static str,
    given: usize,
    needed: usize,
) -> Result<(), ElectrostaticsError> {
    if given == needed {
        return Ok(());
    }
    Err(ElectrostaticsError::Count { what, given, needed })
}

/// Refuses a setting that is not positive and finite.
pub(crate) fn check_positive(what: &'static str, value: f64) -> Result<(), ElectrostaticsError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ElectrostaticsError::Setting { what, value, range: "positive and finite" })
}
