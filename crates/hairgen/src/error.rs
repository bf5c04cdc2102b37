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
}
