//! Exact distances of triangles, through a hierarchy.

use super::mesh::index;
use super::nearest::{NearestPoint, SurfaceTree};
use super::{DistanceField, Mesh, Sample, Soup};
use crate::CollisionError;
use nalgebra::{Point3, Vector3};

/// The exact signed distance of a closed mesh.
///
/// The side of a point follows from the normal at its nearest place, weighted by angles at vertices
/// (Baerentzen and Aanaes 2005). Exact to rounding at any distance; a query costs some
/// microseconds, where a [`Grid`](super::Grid) takes some ten nanoseconds.
#[derive(Debug, Clone)]
pub struct MeshDistance {
    tree: SurfaceTree,
    /// Normals of each face: its own, at its edges (first to second corner, and so on) and at its
    /// corners; not of unit length.
    normals: Vec<[Vector3<f64>; 7]>,
}

impl MeshDistance {
    /// The distance of a mesh. Cost: `n log n` for `n` triangles.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let soup =
            Soup { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() };
        let faces = 0..index(mesh.triangles().len());
        let own: Vec<_> = faces
            .map(|face| {
                let [a, b, c] = mesh.corners(face);
                (b - a).cross(&(c - a)).normalize()
            })
            .collect();
        let mut at_vertices = vec![Vector3::zeros(); soup.vertices.len()];
        for (triangle, normal) in soup.triangles.iter().zip(&own) {
            for k in 0..3 {
                let [p, q, r] = [0, 1, 2].map(|i| soup.vertices[triangle[(k + i) % 3] as usize]);
                at_vertices[triangle[k] as usize] += (q - p).angle(&(r - p)) * normal;
            }
        }
        let mut normals: Vec<_> = soup
            .triangles
            .iter()
            .zip(&own)
            .map(|(triangle, normal)| {
                let [a, b, c] = triangle.map(|v| at_vertices[v as usize]);
                [*normal, *normal, *normal, *normal, a, b, c]
            })
            .collect();
        for edge in mesh.edges() {
            let [first, second] = edge.faces.map(|f| f as usize);
            for (face, other) in [(first, second), (second, first)] {
                let corners = soup.triangles[face];
                let side = (0..3).find(|&k| {
                    let ends = [corners[k], corners[(k + 1) % 3]];
                    ends == edge.ends || [ends[1], ends[0]] == edge.ends
                });
                if let Some(k) = side {
                    normals[face][1 + k] = own[face] + own[other];
                }
            }
        }
        // Checked by the mesh: there are triangles, of vertices that are there and finite.
        let tree = SurfaceTree::of(&soup);
        Self { tree, normals }
    }

    /// The hierarchy of the triangles.
    #[must_use]
    pub fn tree(&self) -> &SurfaceTree {
        &self.tree
    }

    fn signed(&self, point: &Point3<f64>, nearest: &NearestPoint) -> Sample {
        let zero = nearest.weights.map(|w| w == 0.0);
        // The feature that holds the nearest place: a corner, an edge, or the face.
        let feature = match zero {
            [false, true, true] => 4,
            [true, false, true] => 5,
            [true, true, false] => 6,
            [false, false, true] => 1,
            [true, false, false] => 2,
            [false, true, false] => 3,
            _ => 0,
        };
        let normal = self.normals[nearest.face][feature];
        let way = point - nearest.point;
        let value = nearest.distance.copysign(way.dot(&normal));
        // Nowhere there is no gradient.
        let gradient = match nearest.distance {
            distance if !distance.is_finite() => Vector3::zeros(),
            distance if distance > 0.0 => way / value,
            _ => normal.normalize(),
        };
        Sample { value, gradient }
    }
}

impl DistanceField for MeshDistance {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        self.signed(point, &self.tree.nearest(point))
    }
}

/// A surface of triangles with a thickness, which need not be closed or connected (thesis 5.3): the
/// distance from it less half the thickness.
#[derive(Debug, Clone)]
pub struct Shell {
    tree: SurfaceTree,
    half: f64,
}

impl Shell {
    /// The shell of some triangles, `thickness` thick, m.
    ///
    /// # Errors
    /// As [`SurfaceTree::new`], and [`CollisionError::Length`] of a thickness that is negative or
    /// not finite.
    pub fn new(soup: &Soup, thickness: f64) -> Result<Self, CollisionError> {
        if !(thickness >= 0.0 && thickness.is_finite()) {
            let what = "the thickness of a shell";
            return Err(CollisionError::Length { what, value: thickness });
        }
        Ok(Self { tree: SurfaceTree::new(soup)?, half: 0.5 * thickness })
    }
}

impl DistanceField for Shell {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let nearest = self.tree.nearest(point);
        let way = point - nearest.point;
        let gradient = way.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        Sample { value: nearest.distance - self.half, gradient }
    }
}
