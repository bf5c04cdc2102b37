//! The trees of table 7.1.

use super::{Hierarchy, HierarchyKind, VolumeTree};
use crate::Capsules;
use crate::thesis::volume::{Aabb, BoundingVolume, Directions, Dop, Obb, Sphere};

/// The names of table 7.1 of the thesis: the volume (axis-aligned box, k-DOP, oriented box,
/// sphere), then the tree (spatial, wrapped, layered). Wrapped trees of boxes along the axes and of
/// k-DOPs are missing because they are the layered ones (lemma 7.3.1).
#[derive(Debug, Clone, PartialEq)]
pub enum Variant {
    /// Axis-aligned boxes, spatial.
    As,
    /// k-DOPs, spatial.
    Ds(Directions),
    /// Oriented boxes, spatial.
    Os,
    /// Spheres, spatial.
    Ss,
    /// Oriented boxes, wrapped.
    Ow,
    /// Spheres, wrapped.
    Sw,
    /// Axis-aligned boxes, layered.
    Al,
    /// k-DOPs, layered.
    Dl(Directions),
    /// Oriented boxes, layered.
    Ol,
    /// Spheres, layered.
    Sl,
}

impl Variant {
    /// All of them, with these directions for the k-DOPs.
    #[must_use]
    pub fn all(directions: &Directions) -> [Self; 10] {
        let [ds, dl] = [Self::Ds(directions.clone()), Self::Dl(directions.clone())];
        use Variant::{Al, As, Ol, Os, Ow, Sl, Ss, Sw};
        [As, ds, Os, Ss, Ow, Sw, Al, dl, Ol, Sl]
    }

    /// The name in table 7.1, such as `AS`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::As => "AS",
            Self::Ds(_) => "DS",
            Self::Os => "OS",
            Self::Ss => "SS",
            Self::Ow => "OW",
            Self::Sw => "SW",
            Self::Al => "AL",
            Self::Dl(_) => "DL",
            Self::Ol => "OL",
            Self::Sl => "SL",
        }
    }

    /// Which segments come together in a node.
    #[must_use]
    pub fn kind(&self) -> HierarchyKind {
        match self {
            Self::As | Self::Ds(_) | Self::Os | Self::Ss => HierarchyKind::Spatial,
            Self::Ow | Self::Sw => HierarchyKind::Wrapped,
            Self::Al | Self::Dl(_) | Self::Ol | Self::Sl => HierarchyKind::Layered,
        }
    }

    /// Builds the tree; cost as of [`Hierarchy::rebuild`].
    #[must_use]
    pub fn build(&self, capsules: &Capsules) -> Box<dyn Hierarchy> {
        fn tree<V: BoundingVolume>(
            kind: HierarchyKind,
            shared: V::Shared,
            capsules: &Capsules,
        ) -> Box<dyn Hierarchy> {
            Box::new(VolumeTree::<V>::new(kind, shared, capsules))
        }
        let kind = self.kind();
        match self {
            Self::As | Self::Al => tree::<Aabb>(kind, (), capsules),
            Self::Ds(directions) | Self::Dl(directions) => {
                tree::<Dop>(kind, directions.clone(), capsules)
            }
            Self::Os | Self::Ow | Self::Ol => tree::<Obb>(kind, (), capsules),
            Self::Ss | Self::Sw | Self::Sl => tree::<Sphere>(kind, (), capsules),
        }
    }
}
