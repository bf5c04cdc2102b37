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
    /// A measure that no head and no hair has.
    #[error("{what} of {value} m is no measure of a head or its hair; give meters")]
    Measure {
        /// Which measure.
        what: &'static str,
        /// Its value, m.
        value: f64,
    },
    /// A hairline that bounds no part of a head.
    #[error("the hairline {problem}")]
    Hairline {
        /// What must be changed.
        problem: &'static str,
    },
    /// Too few cells for a disc.
    #[error("{around} sectors and {rings} rings make no disc; give at least 3 and 1")]
    Resolution {
        /// Sectors that were asked for.
        around: u32,
        /// Rings that were asked for.
        rings: u32,
    },
}
