//! Convex weights of the neighbors of a vertex.

use super::scalp::ScalpMesh;
use nalgebra::{Point3, Vector2};
use std::f64::consts::TAU;

/// How a vertex inside is a convex combination of its neighbors, `p_i = sum_j w_ij p_j`. Both have
/// positive weights, and both reproduce a flat mesh whose border is kept.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ConvexWeights {
    /// Shape-preserving weights (M. S. Floater, Parametrization and smooth approximation of
    /// surface triangulations, Computer Aided Geometric Design 14, 1997), those of the thesis: the
    /// ring of neighbors is laid into the plane with its lengths and the proportions of its
    /// angles, and the weights are the mean over the neighbors of the barycentric coordinates in
    /// the triangle that each makes with the side of the ring beyond the vertex.
    ShapePreserving,
    /// Mean-value weights `(tan(a / 2) + tan(b / 2)) / length`, of the angles on both sides of an
    /// edge (M. S. Floater, Mean value coordinates, Computer Aided Geometric Design 20, 2003);
    /// they depend smoothly on the vertices.
    #[default]
    MeanValue,
}

impl ConvexWeights {
    /// The weights of the neighbors of a vertex that is not at the border, in the order of its
    /// ring; their sum is 1.
    pub(super) fn of(self, mesh: &ScalpMesh, vertex: u32) -> Vec<f64> {
        let at = |v: u32| mesh.vertices()[v as usize];
        let ring: Vec<_> = mesh.rings().of(vertex).iter().map(|&v| at(v)).collect();
        let mut weights = match self {
            Self::ShapePreserving => shape_preserving(&at(vertex), &ring),
            Self::MeanValue => mean_value(&at(vertex), &ring),
        };
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        weights
    }
}

/// Lengths of the edges to the neighbors, and the angle at the center from each to the next.
fn polar(center: &Point3<f64>, ring: &[Point3<f64>]) -> Vec<(f64, f64)> {
    let next = |k: usize| ring[(k + 1) % ring.len()] - center;
    let edges = ring.iter().map(|p| p - center).enumerate();
    edges.map(|(k, edge)| (edge.norm(), edge.angle(&next(k)))).collect()
}

fn mean_value(center: &Point3<f64>, ring: &[Point3<f64>]) -> Vec<f64> {
    let polar = polar(center, ring);
    let half_tangent = |k: usize| (0.5 * polar[k].1).tan();
    let before = |k: usize| (k + ring.len() - 1) % ring.len();
    (0..ring.len()).map(|k| (half_tangent(k) + half_tangent(before(k))) / polar[k].0).collect()
}

fn shape_preserving(center: &Point3<f64>, ring: &[Point3<f64>]) -> Vec<f64> {
    let polar = polar(center, ring);
    let scale = TAU / polar.iter().map(|(_, angle)| angle).sum::<f64>();
    let (mut flat, mut angles, mut sum) = (Vec::new(), Vec::new(), 0.0);
    for (length, angle) in polar {
        let (sin, cos) = f64::sin_cos(sum);
        flat.push(length * Vector2::new(cos, sin));
        angles.push(sum);
        sum += scale * angle;
    }
    let mut weights = vec![0.0; ring.len()];
    for (l, &angle) in angles.iter().enumerate() {
        // The side of the ring that the ray from the neighbor through the center meets.
        let beyond = (angle + 0.5 * TAU).rem_euclid(TAU);
        let k = angles.partition_point(|&a| a <= beyond).max(1) - 1;
        let next = (k + 1) % ring.len();
        let corners = [l, k, next];
        let parts = [[k, next], [next, l], [l, k]]
            .map(|[a, b]: [usize; 2]| flat[a].perp(&flat[b]).max(0.0));
        let area: f64 = parts.iter().sum();
        if area > 0.0 {
            for (corner, part) in corners.into_iter().zip(parts) {
                weights[corner] += part / area;
            }
        }
    }
    weights
}
