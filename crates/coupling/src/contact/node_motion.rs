//! The motion whose contact points are looked for.

use super::sections::OrientedSections;
use crate::TimeInterval;
use nalgebra::Point3;
use rapunzel_collision::{Capsules, CollisionError};
use rapunzel_fiber::Layout;

/// All nodes before and after a step.
pub(crate) struct NodeMotion<'a> {
    pub(crate) layout: &'a Layout,
    pub(crate) sections: OrientedSections<'a>,
    pub(crate) start: &'a [Point3<f64>],
    pub(crate) end: &'a [Point3<f64>],
    pub(crate) step: TimeInterval,
    /// By fibre, whether its contact points are looked for; all are if there is nothing here.
    pub(crate) sought: Option<&'a [bool]>,
}

impl NodeMotion<'_> {
    /// Radii of the tubes that all segments are seen as, m.
    pub(super) fn radii(&self) -> &[f64] {
        &self.sections.shapes.radii
    }

    /// All segments at its start, or at its end.
    pub(super) fn capsules<'a>(
        &'a self,
        at: &'a [Point3<f64>],
    ) -> Result<Capsules<'a>, CollisionError> {
        Capsules::new(self.layout, at, self.radii())
    }
}
