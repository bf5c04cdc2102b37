use crate::{NodeVectors, SpringError};
use nalgebra::{SMatrix, SVector};

/// Bending resistance of a joint between two segments, which the first text lacks in its rope.
///
/// The energy is `k |t2 - t1|^2 / 2 = k (1 - cos phi)`, where `t1` and `t2` are the unit tangents
/// of the two segments that meet in the middle node and `phi` is the angle between them; `k`, N m,
/// is the bending stiffness of the rope, N m^2, divided by the length of a segment. It does not
/// keep lengths: both segments should be springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BendResistance {
    /// Three nodes in line; the middle one is the joint.
    pub nodes: [usize; 3],
    /// Bending constant k, N m.
    pub stiffness: f64,
}

/// Geometry of two segments that meet in a node.
struct Corner<const D: usize> {
    lengths: [f64; 2],
    tangents: [SVector<f64, D>; 2],
}

impl BendResistance {
    pub(crate) fn check(&self, bend: usize, nodes: usize) -> Result<(), SpringError> {
        if let Some(&node) = self.nodes.iter().find(|&&node| node >= nodes) {
            return Err(SpringError::MissingNode { what: "bend", index: bend, node, nodes });
        }
        crate::error::non_negative("the stiffness of a bend (N m)", self.stiffness)
    }

    fn corner<const D: usize>(&self, x: &NodeVectors<D>) -> Corner<D> {
        let [a, b, c] = self.nodes.map(|node| x.get(node));
        let edges = [b - a, c - b];
        let lengths = edges.map(|e| e.norm().max(f64::MIN_POSITIVE));
        Corner { lengths, tangents: [edges[0] / lengths[0], edges[1] / lengths[1]] }
    }

    /// Energy of the bend at the positions `x`, J.
    pub(crate) fn energy<const D: usize>(&self, x: &NodeVectors<D>) -> f64 {
        let [t1, t2] = self.corner(x).tangents;
        0.5 * self.stiffness * (t2 - t1).norm_squared()
    }

    /// Adds the bending forces (N) on the three nodes.
    pub(crate) fn add_forces<const D: usize>(
        &self,
        x: &NodeVectors<D>,
        forces: &mut NodeVectors<D>,
    ) {
        let Corner { lengths, tangents: [t1, t2] } = self.corner(x);
        let cosine = t1.dot(&t2);
        // How the energy grows with the two edge vectors.
        let first = (t2 - t1 * cosine) * (-self.stiffness / lengths[0]);
        let second = (t1 - t2 * cosine) * (-self.stiffness / lengths[1]);
        let [a, b, c] = self.nodes;
        forces.add(a, &first);
        forces.add(b, &(second - first));
        forces.add(c, &-second);
    }

    /// Second derivatives of the energy by the two edge vectors: of the first, mixed (first by
    /// second), of the second. `convex` leaves out the terms that make them indefinite.
    pub(crate) fn hessian<const D: usize>(
        &self,
        x: &NodeVectors<D>,
        convex: bool,
    ) -> [SMatrix<f64, D, D>; 3] {
        let Corner { lengths: [l1, l2], tangents: [t1, t2] } = self.corner(x);
        let across = |t: &SVector<f64, D>| SMatrix::identity() - t * t.transpose();
        let [p1, p2] = [across(&t1), across(&t2)];
        let mixed = -(p1 * p2) / (l1 * l2);
        let [first, second] = if convex {
            [p1, p2]
        } else {
            let cosine = t1.dot(&t2);
            let bent = |t: &SVector<f64, D>, p: SMatrix<f64, D, D>, other: &SVector<f64, D>| {
                let n = p * other;
                p * cosine + t * n.transpose() + n * t.transpose()
            };
            [bent(&t1, p1, &t2), bent(&t2, p2, &t1)]
        };
        [first / (l1 * l1), mixed, second / (l2 * l2)].map(|block| block * self.stiffness)
    }
}
