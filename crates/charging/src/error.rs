use rapunzel_collision::CollisionError;
use rapunzel_electrostatics::ElectrostaticsError;
use rapunzel_keratin::KeratinError;
use rapunzel_rod_static::StaticError;
use thiserror::Error;

/// Why charged fibres do not come to rest.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ChargingError {
    /// A fibre has no equilibrium that was found.
    #[error("fibre {fiber} does not come to rest: {source}; deal its charge in more portions")]
    Rest {
        /// Index of the fibre, over all bundles.
        fiber: usize,
        /// Why.
        source: StaticError,
    },
    /// A charged fibre is in the head.
    #[error(
        "fibre {fiber} is {depth:.2e} m deep in objects[{object}], the head, at its segment {segment}, \
         t = {time} s; nothing but charge keeps it out: move it, make it shorter, or charge it more"
    )]
    InHead {
        /// Index of the fibre, over all bundles.
        fiber: usize,
        /// Where along it, from the root.
        segment: usize,
        /// Index of the object that is the head.
        object: usize,
        /// How deep at least, m.
        depth: f64,
        /// End of the step, s.
        time: f64,
    },
    /// The forces of charges were not found.
    #[error("charging, t = {time} s: {source}")]
    Electrostatics {
        /// End of the step, s.
        time: f64,
        /// What is wrong.
        source: ElectrostaticsError,
    },
    /// The hair of a bundle is not known in the climate of the scene.
    #[error("fibers[{bundle}]: {source}")]
    Keratin {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// What is not known.
        source: KeratinError,
    },
    /// The surface of the head bounds nothing.
    #[error("objects[{object}]: {source}")]
    Head {
        /// Index of the object in the scene.
        object: usize,
        /// What is wrong with it.
        source: CollisionError,
    },
    /// Saved numbers belong to other fibres.
    #[error("the saved state belongs to other fibres: its list {list} does not fit")]
    Saved {
        /// Number of the list that does not fit.
        list: usize,
    },
}

impl ChargingError {
    /// An [`ChargingError::Electrostatics`] at a time, s.
    pub(crate) fn electric(time: f64) -> impl Fn(ElectrostaticsError) -> Self {
        move |source| Self::Electrostatics { time, source }
    }
}
