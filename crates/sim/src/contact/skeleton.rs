//! What the surface of an object is seen as by the distance field of another.

use crate::scene::ObjectShape;
use nalgebra::Point3;
use rapunzel_collision::Capsule;
use rapunzel_collision::field::Soup;

/// Radius of the edges of a box, in its smallest side. On the surface of another box the nearest face
/// is told by chance where edges lie on edges; an axis within the box stays clear of that, as long as
/// things are in each other by less than this.
const ROUNDING: f64 = 1e-3;

/// Capsules in the frame of an object that together with the other's field tell all places of
/// contact: a round shape as it is, else all edges. A plane has none.
pub(super) fn skeleton(shape: &ObjectShape, surface: &Soup) -> Vec<Capsule> {
    match shape {
        ObjectShape::Plane { .. } => Vec::new(),
        ObjectShape::Ball { radius } => bars(&[Point3::origin()], &[[0, 0]], *radius),
        ObjectShape::Capsule { length, radius } => {
            let ends = [-0.5, 0.5].map(|share| Point3::new(0.0, 0.0, share * length));
            bars(&ends, &[[0, 1]], *radius)
        }
        ObjectShape::Cuboid { sides } => {
            let radius = ROUNDING * sides.iter().copied().fold(f64::INFINITY, f64::min);
            let corner = |c: usize| {
                let side = |k: usize| (0.5 * sides[k] - radius) * [-1.0, 1.0][c >> k & 1];
                Point3::new(side(0), side(1), side(2))
            };
            let corners: [_; 8] = std::array::from_fn(corner);
            // Corners whose numbers differ by one bit.
            let from = |c: usize| [1, 2, 4].map(|bit| [c, c | bit]);
            let edges: Vec<_> = (0..8).flat_map(from).filter(|[a, b]| a != b).collect();
            bars(&corners, &edges, radius)
        }
        ObjectShape::HeightField { .. } | ObjectShape::Mesh { .. } => {
            let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
            let sorted = |[a, b]: [u32; 2]| [a.min(b) as usize, a.max(b) as usize];
            let mut edges: Vec<_> = surface.triangles.iter().flat_map(sides).map(sorted).collect();
            edges.sort_unstable();
            edges.dedup();
            bars(&surface.vertices, &edges, 0.0)
        }
    }
}

fn bars(points: &[Point3<f64>], pairs: &[[usize; 2]], radius: f64) -> Vec<Capsule> {
    let bar = |&[a, b]: &[usize; 2]| Capsule { start: points[a], end: points[b], radius };
    pairs.iter().map(bar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rapunzel_collision::field::{Cuboid, DistanceField, shapes};

    #[test]
    fn a_box_has_twelve_edges_and_its_mesh_six_diagonals_more() {
        let half = Vector3::new(0.01, 0.02, 0.03);
        let (surface, shape) =
            (shapes::cuboid(half), ObjectShape::Cuboid { sides: (2.0 * half).into() });
        let edges = skeleton(&shape, &surface);
        assert_eq!(edges.len(), 12);
        let field = Cuboid { half };
        for edge in edges {
            for end in [edge.start, edge.end] {
                // As deep below two or three faces as it is thick.
                assert!((field.value(&end) + edge.radius).abs() < 1e-15, "{edge:?}");
            }
        }
        let mesh = ObjectShape::Mesh { file: "box.ply".into(), spacing: 1e-3 };
        assert_eq!(skeleton(&mesh, &surface).len(), 12 + 6);
    }
}
