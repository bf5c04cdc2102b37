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
    /// A scan that is no head in meters, centimeters or millimeters.
    #[error(
        "the scan is {size} units large, which is no head in meters, centimeters or millimeters; \
         give `meters_per_unit`"
    )]
    Units {
        /// Its largest extent, units of the scan.
        size: f64,
    },
    /// A scan in which no face was found.
    #[error(
        "the head finds no face in the scan: off by {rms} m; turn the scan so that y is up and the \
         face looks along z"
    )]
    NoFace {
        /// Root mean square of the distances that were kept, m.
        rms: f64,
    },
    /// Equations of a surface without a solution.
    #[error("the equations of the surface: {0}")]
    Equations(#[from] rapunzel_linalg::LinalgError),
}
