use crate::RenderError;
use nalgebra::{Point3, Vector3};

/// One fibre to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct FiberCurve {
    /// Nodes of the centerline (world), m; two at least.
    pub nodes: Vec<Point3<f64>>,
    /// Radii at the nodes, m; of an elliptical section the radius of the circle of its area.
    pub radii: Vec<f64>,
    /// First axes of the section at the nodes (world), of any length; needed of elliptical
    /// sections, else empty.
    pub axes: Vec<Vector3<f64>>,
    /// Ways of the nodes during the exposure (world), m; empty if they rest.
    pub ways: Vec<Vector3<f64>>,
}

impl FiberCurve {
    /// A round fibre of one radius, m, at rest.
    #[must_use]
    pub fn round(nodes: Vec<Point3<f64>>, radius: f64) -> Self {
        let radii = vec![radius; nodes.len()];
        Self { nodes, radii, axes: Vec::new(), ways: Vec::new() }
    }

    /// Refuses what no tube can be made of; `fiber` is its index, for errors.
    pub(super) fn check(&self, fiber: usize, elliptical: bool) -> Result<(), RenderError> {
        let count = self.nodes.len();
        let wrong = |what| Err(RenderError::Curve { fiber, what });
        let lists = [(self.axes.len(), elliptical), (self.ways.len(), !self.ways.is_empty())];
        if count < 2 {
            return wrong("has fewer than two nodes");
        }
        if self.radii.len() != count || lists.iter().any(|(len, used)| *used && *len != count) {
            return wrong("has a list that is not as long as its nodes");
        }
        let numbers = self.nodes.iter().map(|p| p.coords).chain(self.ways.iter().copied());
        if numbers.chain(self.axes.iter().copied()).any(|v| !v.iter().all(|x| x.is_finite())) {
            return wrong("has a node, a way or an axis that is not finite");
        }
        if self.radii.iter().any(|r| !(*r >= 0.0 && r.is_finite())) {
            return wrong("has a radius that is negative or not finite");
        }
        if elliptical && self.axes.iter().any(|axis| axis.norm() == 0.0) {
            return wrong("has an axis of its section without length");
        }
        Ok(())
    }
}
