//! Loads of joints with other fibres.

use nalgebra::Vector3;

/// Part of a fibre that a load of a joint acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadPlace {
    /// A force (N) on a node, by its index from the root.
    Node(u32),
    /// A moment (N m) on a segment, by its index from the root.
    Segment(u32),
}

/// Where a load of a joint acts in a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadPoint {
    /// Index of the fibre in its batch.
    pub fiber: u32,
    /// What of the fibre is loaded.
    pub place: LoadPlace,
}

/// Loads of joints on a batch, world frame, at the end of a step: forces on nodes (N) and moments
/// on segments (N m), as many as points. Loads at the same point add up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLoads<'a> {
    /// Where the loads act.
    pub points: &'a [LoadPoint],
    /// The loads, N or N m.
    pub loads: &'a [Vector3<f64>],
}

impl LoadPoint {
    /// First node or segment that the load moves directly, counted from the root.
    pub(crate) fn first(&self) -> usize {
        match self.place {
            LoadPlace::Node(index) | LoadPlace::Segment(index) => index as usize,
        }
    }
}
