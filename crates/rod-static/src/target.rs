use nalgebra::Point3;

/// A place that a node of a [`Chain`](crate::Chain) is held at or pulled to (thesis Fig. 3.12).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Index of the node, counted from the clamp, which is node 0.
    pub node: usize,
    /// Place at which the node is held or to which it is pulled, m, world frame.
    pub place: Point3<f64>,
    /// Stiffness of the spring between node and place, N/m; infinite for a node that is held.
    pub stiffness: f64,
}

impl Target {
    /// A node that is held at a place, as if by a ball joint.
    #[must_use]
    pub fn held(node: usize, place: Point3<f64>) -> Self {
        Self { node, place, stiffness: f64::INFINITY }
    }

    /// A node that a spring of `stiffness` (N/m) and no length pulls to a place.
    #[must_use]
    pub fn pulled(node: usize, place: Point3<f64>, stiffness: f64) -> Self {
        Self { node, place, stiffness }
    }

    pub(crate) fn is_held(&self) -> bool {
        self.stiffness.is_infinite()
    }
}
