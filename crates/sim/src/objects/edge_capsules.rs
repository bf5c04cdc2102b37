//! What the surface of an object is seen as by the distance field of another.

use crate::scene::ObjectShape;
use nalgebra::{Matrix3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::Soup;
use rapunzel_coupling::extents;

/// Radius of edges at most, in the smallest extent.
const ROUNDEST: f64 = 0.05;
/// Cosine of the angle up to which two triangles lie in one plane.
const FLAT: f64 = 1.0 - 1e-9;
/// Smallest eigenvalue, of those that sum up to the number of triangles at a vertex, that is a
/// direction in which their planes bend.
const BENDS: f64 = 1e-2;
/// How far a vertex is moved at most, in the radius: in the corner of a box by the root of 3.
const FARTHEST: f64 = 2.0;

/// Capsules in the frame of an object that together with the other's field tell all places of
/// contact: a round shape as it is, else all edges. A plane has none.
///
/// Edges get a `radius`, m, or less if the object is thin, and lie by as much within the surface,
/// so that faces are where they were. The field of the other is asked on their axes, and so on its
/// outside as long as things are in each other by less than the radius: inside, the nearest face is
/// told by chance where edge lies on edge.
pub(super) fn edge_capsules(shape: &ObjectShape, surface: &Soup, radius: f64) -> Vec<Capsule> {
    match shape {
        ObjectShape::Plane { .. } => Vec::new(),
        ObjectShape::Ball { radius } => {
            vec![Capsule { start: Point3::origin(), end: Point3::origin(), radius: *radius }]
        }
        ObjectShape::Capsule { length, radius } => {
            let end = Point3::new(0.0, 0.0, 0.5 * length);
            vec![Capsule { start: -end, end, radius: *radius }]
        }
        _ => {
            let sides = extents(surface).map(|[low, high]| high - low);
            edges(surface, radius.min(ROUNDEST * sides.into_iter().fold(f64::INFINITY, f64::min)))
        }
    }
}

/// All edges between triangles that do not lie in one plane.
fn edges(surface: &Soup, radius: f64) -> Vec<Capsule> {
    let normal = |&corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| surface.vertices[v as usize]);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
    };
    let normals: Vec<_> = surface.triangles.iter().map(normal).collect();
    let mut planes = vec![(Matrix3::zeros(), Vector3::zeros()); surface.vertices.len()];
    let mut sides = Vec::with_capacity(3 * normals.len());
    for (triangle, n) in surface.triangles.iter().zip(&normals) {
        for k in 0..3 {
            let [from, to] = [triangle[k], triangle[(k + 1) % 3]];
            let (squares, sum) = &mut planes[from as usize];
            *squares += n * n.transpose();
            *sum += n;
            sides.push(([from.min(to), from.max(to)], *n));
        }
    }
    // The sort is stable: the triangles of an edge stay in their order.
    sides.sort_by_key(|(ends, _)| *ends);
    // The point that is below all planes of a vertex by the radius, or nearly so.
    let within = |v: u32| {
        let (squares, sum) = planes[v as usize];
        let way = squares.pseudo_inverse(BENDS).unwrap_or_default() * sum;
        surface.vertices[v as usize] - radius * way.cap_magnitude(FARTHEST)
    };
    let bends = |faces: &&[([u32; 2], Vector3<f64>)]| match faces {
        [(_, one), (_, other)] => one.dot(other) < FLAT,
        _ => true,
    };
    let of_edge = sides.chunk_by(|(ends, _), (others, _)| ends == others).filter(bends);
    let edge = of_edge.map(|faces| faces[0].0.map(within));
    edge.map(|[start, end]| Capsule { start, end, radius }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapunzel_collision::field::{Cuboid, DistanceField, shapes};

    #[test]
    fn a_box_has_twelve_edges_that_leave_its_faces_where_they_are() {
        let half = Vector3::new(0.01, 0.02, 0.03);
        let shape = ObjectShape::Cuboid { sides: [0.02, 0.04, 0.06] };
        let edges = edge_capsules(&shape, &shapes::cuboid(half), 1e-4);
        assert_eq!(edges.len(), 12);
        for edge in edges {
            assert_eq!(edge.radius, 1e-4);
            for end in [edge.start, edge.end] {
                // As deep below each of three faces as it is thick.
                let beyond = end.coords.abs() - half;
                assert!((beyond.add_scalar(edge.radius)).amax() < 1e-15, "{edge:?}");
            }
            assert!((Cuboid { half }.value(&edge.at(0.3)) + edge.radius).abs() < 1e-15);
        }
    }

    /// On a ball of triangles every vertex goes toward the center, by hardly more than the radius.
    #[test]
    fn what_is_nearly_round_shrinks() {
        let (file, scale, repair) = ("ball.ply".into(), 1.0, false);
        let shape = ObjectShape::Mesh { file, spacing: 1e-3, scale, repair };
        let (ball, radius) = (shapes::sphere(0.01, 10), 1e-4);
        for edge in edge_capsules(&shape, &ball, radius) {
            let depth = 0.01 - edge.start.coords.norm();
            // Triangles turn by about a tenth of a right angle from one to the next.
            assert!((depth / radius - 1.0).abs() < 0.05, "{edge:?}");
        }
    }
}
