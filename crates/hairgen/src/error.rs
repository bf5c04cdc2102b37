use thiserror::Error;

/// What can be wrong with what a hairstyle is made of.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum HairgenError {
    /// A surface that is no solid, or a grid that cannot be made.
    #[error("{what}: {source}")]
    Surface {
        /// Which surface.
        what: &'static str,
        /// What is wrong with it.
        source: rapunzel_collision::CollisionError,
    },
    /// A pore out of which no hair can grow.
    #[error("pore {pore}: {problem}")]
    Pore {
        /// Number of the pore, counted from 0.
        pore: usize,
        /// What is wrong with it, and what to do.
        problem: &'static str,
    },
    /// A hair of a pore that is no rod.
    #[error("the rod of pore {pore}: {source}")]
    Rod {
        /// Number of the pore, counted from 0.
        pore: usize,
        /// What is wrong with it.
        source: rapunzel_rod_static::StaticError,
    },
    /// An option outside of its range.
    #[error("{option} is {value}, but must be {range}")]
    Choice {
        /// Name of the option, with its unit.
        option: &'static str,
        /// The value that was given.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A list of another length than the pores.
    #[error("{what} are {given}, but must be {wanted}, one for each pore")]
    Count {
        /// Which list.
        what: &'static str,
        /// Number of its entries.
        given: usize,
        /// Number that is needed.
        wanted: usize,
    },
    /// Nothing to make hairs from.
    #[error("there are no {what}; {remedy}")]
    Nothing {
        /// What is missing.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Voxels of hair density that cannot be made.
    #[error("the voxels of hair density: {problem}")]
    Voxels {
        /// What is wrong, and what to do.
        problem: &'static str,
    },
}

/// Checks that an option is in its range; NaN is in none.
pub(crate) fn choice(
    option: &'static str,
    value: f64,
    range: &'static str,
    allowed: impl Fn(f64) -> bool,
) -> Result<(), HairgenError> {
    if value.is_finite() && allowed(value) {
        Ok(())
    } else {
        Err(HairgenError::Choice { option, value, range })
    }
}
