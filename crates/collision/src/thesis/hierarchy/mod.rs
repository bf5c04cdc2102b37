//! Trees of bounding volumes over the segments of fibres (thesis, 7.3).
//!
//! Every combination that table 7.1 of the thesis names is a [`Variant`], to be compared with each
//! other on equal terms; all find the same pairs.
//!
//! ```
//! use rapunzel_collision::thesis::hierarchy::{Hierarchy, Variant};
//! use rapunzel_collision::thesis::scenes;
//!
//! let scene = scenes::wavy(20);
//! let mut tree = Variant::Al.build(&scene.capsules()?);
//! let before = tree.all(&scene.capsules()?)?.pairs;
//! let later = scene.advanced(1.0);
//! tree.update(&later.capsules()?)?;
//! let after = tree.all(&later.capsules()?)?;
//! println!("{} pairs, then {}: {:?}", before.len(), after.pairs.len(), after.counts);
//! # Ok::<(), rapunzel_collision::CollisionError>(())
//! ```

mod search;
mod spatial;
mod tree;
mod variant;

pub use tree::{HierarchyKind, VolumeTree};
pub use variant::Variant;

use crate::{Capsules, CollisionError, Pair};
use std::any::Any;

/// A tree over segments, whatever its volumes are.
///
/// What a tree finds is right for the capsules that it was last built, updated, or rebuilt with,
/// and only for these; give the same to the searches.
pub trait Hierarchy: Any + Send + Sync {
    /// Encloses the capsules where they are now, without changing which of them are under which
    /// node: algorithm 5 of the thesis. Cost: one volume a node; wrapped trees verify theirs from
    /// above (algorithm 4).
    ///
    /// # Errors
    /// [`CollisionError::Count`] if there are not as many segments as in the tree.
    fn update(&mut self, capsules: &Capsules) -> Result<(), CollisionError>;

    /// Builds the tree anew. Cost: linear in the segments for layered trees, else about n log n.
    fn rebuild(&mut self, capsules: &Capsules);

    /// All pairs of segments that touch and are not adjacent, in the order of the search.
    ///
    /// # Errors
    /// [`CollisionError::Count`] as for [`Self::update`].
    fn all(&self, capsules: &Capsules) -> Result<SearchResult, CollisionError>;

    /// The first of the pairs of [`Self::all`], if there are any.
    ///
    /// # Errors
    /// [`CollisionError::Count`] as for [`Self::update`].
    fn first(&self, capsules: &Capsules) -> Result<SearchResult, CollisionError>;

    /// All pairs of a segment of this tree and a segment of another assembly's that touch.
    ///
    /// # Errors
    /// [`CollisionError::Count`] as for [`Self::update`], for either tree;
    /// [`CollisionError::Volumes`] if the other tree has other volumes, or other directions.
    fn between(
        &self,
        capsules: &Capsules,
        other: &dyn Hierarchy,
        others: &Capsules,
    ) -> Result<SearchResult, CollisionError>;

    /// Mean volume of the nodes on every level, the root's first, m³ (thesis, figure 7.14).
    fn mean_volumes(&self) -> Vec<f64>;
}

/// What a search found, and what it cost.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SearchResult {
    /// The segments that touch. The smaller index is first, or that of the first tree.
    pub pairs: Vec<Pair>,
    /// What was tested.
    pub counts: Counts,
}

/// Tests of a search (thesis, figures 7.14 and 7.15).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Pairs of volumes that were tested.
    pub volume_tests: u64,
    /// Pairs of volumes that overlap.
    pub overlaps: u64,
    /// Pairs of segments whose distance was computed.
    pub segment_tests: u64,
}
