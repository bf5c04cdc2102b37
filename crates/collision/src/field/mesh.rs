//! Closed surfaces of triangles.

use crate::CollisionError;
use nalgebra::{Point3, Vector3};

/// Triangles as they come from a file, unchecked.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Soup {
    /// Corners (world), m.
    pub vertices: Vec<Point3<f64>>,
    /// Indices of the corners of every triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Sides of a triangle of less than this part of its longest, squared, in twice its area.
pub(super) const DEGENERATE: f64 = 1e-12;

/// A closed surface of triangles that bounds a solid.
///
/// It has been checked once: all vertices are finite; every triangle has three corners and an area;
/// every edge is between two triangles that run through it in opposite directions; the volume
/// inside is positive. What is not checked is that the surface does not cut through itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    soup: Soup,
    edges: Vec<Edge>,
}

/// An edge between two triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// Its ends, as the first face runs through it.
    pub(super) ends: [u32; 2],
    pub(super) faces: [u32; 2],
}

/// A side of a triangle: its ends, the smaller first, its face, and whether that runs through it
/// from the smaller to the larger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TriangleSide {
    pub(super) ends: [u32; 2],
    pub(super) face: u32,
    pub(super) forward: bool,
}

impl Mesh {
    /// Checks that the triangles bound a solid. [`Mesh::repaired`](Self::repaired) takes worse
    /// ones.
    ///
    /// # Errors
    /// [`CollisionError::NoTriangles`], [`CollisionError::Vertex`], [`CollisionError::Face`],
    /// [`CollisionError::Edge`], [`CollisionError::InsideOut`], each with the place. Cost: a sort
    /// of the sides.
    pub fn new(soup: Soup) -> Result<Self, CollisionError> {
        soup.check()?;
        for (face, &triangle) in soup.triangles.iter().enumerate() {
            let [a, b, c] = soup.corners(triangle);
            let longest =
                (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
            if (b - a).cross(&(c - a)).norm() <= DEGENERATE * longest {
                return Err(CollisionError::Face { face, problem: "has no area; remove it" });
            }
        }
        let mut edges = Vec::with_capacity(soup.triangles.len() * 3 / 2);
        for sides in soup.sides().chunk_by(|a, b| a.ends == b.ends) {
            let face = sides[0].face as usize;
            let refuse =
                |problem| Err(CollisionError::Edge { face, vertices: sides[0].ends, problem });
            let [first, second] = sides else {
                let [] = sides[1..] else {
                    return refuse("is between more than two faces; repair the mesh");
                };
                return refuse("is at a hole; close it, or repair the mesh");
            };
            if first.forward == second.forward {
                return refuse("is between faces of opposite orientation; repair the mesh");
            }
            let [a, b] = first.ends;
            let ends = if first.forward { [a, b] } else { [b, a] };
            edges.push(Edge { ends, faces: [first.face, second.face] });
        }
        if soup.volume() <= 0.0 {
            return Err(CollisionError::InsideOut);
        }
        Ok(Self { soup, edges })
    }

    /// The vertices (world), m.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.soup.vertices
    }

    /// The triangles as indices of vertices, counter-clockwise from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.soup.triangles
    }

    /// Volume inside, m³.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.soup.volume()
    }

    /// Low and high corner of the smallest box that holds the mesh (world), m.
    #[must_use]
    pub fn bounds(&self) -> [Point3<f64>; 2] {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for &triangle in self.triangles() {
            for corner in self.soup.corners(triangle) {
                low = low.inf(&corner.coords);
                high = high.sup(&corner.coords);
            }
        }
        [low.into(), high.into()]
    }

    /// Corners of a face (world), m.
    pub(super) fn corners(&self, face: u32) -> [Point3<f64>; 3] {
        self.soup.corners(self.soup.triangles[face as usize])
    }

    pub(super) fn edges(&self) -> &[Edge] {
        &self.edges
    }
}

impl Soup {
    /// There are triangles, of vertices that are there and finite.
    pub(super) fn check(&self) -> Result<(), CollisionError> {
        if self.triangles.is_empty() {
            return Err(CollisionError::NoTriangles);
        }
        for (vertex, p) in self.vertices.iter().enumerate() {
            if !p.iter().all(|x| x.is_finite()) {
                return Err(CollisionError::Vertex { vertex, position: p.coords.into() });
            }
        }
        let count = self.vertices.len();
        let bad = |&triangle: &[u32; 3]| triangle.iter().any(|&v| v as usize >= count);
        match self.triangles.iter().position(bad) {
            Some(face) => {
                Err(CollisionError::Face { face, problem: "has a corner that is not there" })
            }
            None => Ok(()),
        }
    }

    /// Corners of a triangle.
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [Point3<f64>; 3] {
        triangle.map(|v| self.vertices[v as usize])
    }

    /// All sides of all triangles, sorted, so that those of one edge follow each other.
    pub(super) fn sides(&self) -> Vec<TriangleSide> {
        let mut sides = Vec::with_capacity(3 * self.triangles.len());
        for (face, &[a, b, c]) in (0_u32..).zip(&self.triangles) {
            for [a, b] in [[a, b], [b, c], [c, a]] {
                sides.push(TriangleSide { ends: [a.min(b), a.max(b)], face, forward: a < b });
            }
        }
        sides.sort_unstable();
        sides
    }

    /// Volume inside; negative if the triangles face inward.
    pub(super) fn volume(&self) -> f64 {
        self.volume_of(&self.triangles)
    }

    /// Volume inside some triangles on the vertices.
    pub(super) fn volume_of(&self, triangles: &[[u32; 3]]) -> f64 {
        let Some(origin) = self.vertices.first() else { return 0.0 };
        let part = |&triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(triangle).map(|p| p - origin);
            a.cross(&b).dot(&c) / 6.0
        };
        triangles.iter().map(part).sum()
    }
}

/// An index in the width of the triangles; one that is too large is that of no vertex.
pub(super) fn index(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::shapes;

    fn refused(change: impl Fn(&mut Soup)) -> CollisionError {
        let mut soup = shapes::cuboid(Vector3::new(1.0, 2.0, 3.0));
        change(&mut soup);
        Mesh::new(soup).expect_err("refused")
    }

    #[test]
    fn bad_meshes_are_refused_with_the_place() {
        assert_eq!(Mesh::new(Soup::default()).expect_err("refused"), CollisionError::NoTriangles);
        let error = refused(|soup| soup.vertices[3].y = f64::INFINITY);
        assert!(matches!(error, CollisionError::Vertex { vertex: 3, .. }));
        let error = refused(|soup| soup.triangles[4][1] = 8);
        assert!(matches!(error, CollisionError::Face { face: 4, .. }));
        let error = refused(|soup| soup.triangles[4][1] = soup.triangles[4][0]);
        assert!(matches!(error, CollisionError::Face { face: 4, .. }));
        let error = refused(|soup| soup.triangles.truncate(11));
        assert!(matches!(error, CollisionError::Edge { .. }) && error.to_string().contains("hole"));
        let error = refused(|soup| soup.triangles.push(soup.triangles[2]));
        assert!(error.to_string().contains("more than two"));
        let error = refused(|soup| soup.triangles[5].swap(0, 1));
        assert!(error.to_string().contains("orientation"));
        let error = refused(|soup| soup.triangles.iter_mut().for_each(|t| t.swap(0, 1)));
        assert_eq!(error, CollisionError::InsideOut);
    }

    #[test]
    fn a_box_has_its_volume_and_bounds() {
        let mesh = Mesh::new(shapes::cuboid(Vector3::new(1.0, 2.0, 3.0))).expect("valid");
        assert!((mesh.volume() - 48.0).abs() <= 1e-12);
        assert_eq!(mesh.bounds(), [Point3::new(-1.0, -2.0, -3.0), Point3::new(1.0, 2.0, 3.0)]);
        assert_eq!(mesh.edges().len(), 18);
    }
}
