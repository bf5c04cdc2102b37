//! Joints of the staggered rod: bending and torsion of the rod between two segment midpoints.

use nalgebra::Vector3;
use rapunzel_fiber::Fiber;

/// Length, stiffness and natural rotation of one joint.
pub(crate) struct Joint {
    /// Length of rod that the joint stands for, m: half a segment at the two ends.
    pub(crate) length: f64,
    /// Stiffness about the material axes divided by `length`, N m.
    pub(crate) stiffness: Vector3<f64>,
    /// Natural rotation vector from one segment to the next, rad, material frame.
    pub(crate) rest: Vector3<f64>,
}

impl Joint {
    /// Joint `j` of `0..=n`, with properties interpolated to the middle of its length.
    pub(crate) fn new(fiber: &Fiber, j: usize) -> Self {
        let (nodes, h, n) = (fiber.nodes(), fiber.segment_lengths(), fiber.segments());
        let (length, inner) = match j {
            0 => (0.5 * h[0], 1),
            j if j == n => (0.5 * h[n - 1], n - 1),
            j => (0.5 * (h[j - 1] + h[j]), j),
        };
        let weighted = |a: &Vector3<f64>, b: &Vector3<f64>| 0.75 * a + 0.25 * b;
        let (a, b) = (&nodes[j], &nodes[inner]);
        Self {
            length,
            stiffness: weighted(&a.stiffness, &b.stiffness) / length,
            rest: weighted(&a.natural_curvature, &b.natural_curvature) * length,
        }
    }
}
