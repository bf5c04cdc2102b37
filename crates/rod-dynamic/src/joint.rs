//! The joints of the staggered rod: bending and torsion of what lies between two middles.

use nalgebra::Vector3;
use rapunzel_fiber::Fiber;

/// What a joint stands for.
pub(crate) struct Joint {
    /// Length of that, m: half a segment at the ends.
    pub(crate) length: f64,
    /// Stiffness over length, N m.
    pub(crate) stiffness: Vector3<f64>,
    /// Rotation vector at rest, rad.
    pub(crate) rest: Vector3<f64>,
}

impl Joint {
    /// Joint `j` of `0..=n`, with the properties at the middle of what it stands for.
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
