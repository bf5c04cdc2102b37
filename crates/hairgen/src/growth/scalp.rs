//! The scalp as a mesh that has the shape of a disc.

use super::rings::Rings;
use super::surface_point::SurfacePoint;
use crate::HairgenError;
use nalgebra::{Point3, Unit, Vector3};
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{Soup, SurfaceTree};

/// A triangle of less than this part of its longest side squared, in twice its area, has none.
const LEAST_AREA: f64 = 1e-12;

/// The part of a head on which hair grows: an open surface of triangles with one border.
///
/// It has been checked once: all vertices are finite, every triangle has an area, no edge is
/// between more than two triangles, neighbors run through their edge in opposite directions, no
/// two parts meet in a vertex alone, all is one part with one border and without handles: a disc.
/// Which side is the outer one cannot be told of an open surface: corners must run
/// counter-clockwise seen from outside. Vertices that no triangle has are left out, so that
/// numbers may differ from those of the source. What is not checked is that the surface does not
/// cut through itself.
#[derive(Debug, Clone)]
pub struct ScalpMesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    areas: Vec<f64>,
    normals: Vec<Unit<Vector3<f64>>>,
    border: Vec<u32>,
    rings: Rings,
    tree: SurfaceTree,
}

impl ScalpMesh {
    /// Checks that the triangles make a disc. Cost: sorts of the sides and the triangles.
    ///
    /// # Errors
    /// [`HairgenError::Surface`] with the vertex, face or edge that is wrong,
    /// [`HairgenError::EmptyScalp`], [`HairgenError::ScalpPinch`], [`HairgenError::ScalpParts`],
    /// [`HairgenError::ClosedScalp`], [`HairgenError::ScalpHoles`],
    /// [`HairgenError::ScalpHandles`].
    pub fn new(soup: Soup) -> Result<Self, HairgenError> {
        if soup.triangles.is_empty() {
            return Err(HairgenError::EmptyScalp);
        }
        let areas = areas(&soup)?;
        let (Soup { vertices, triangles }, sources) = used(soup);
        let rings = Rings::new(vertices.len(), &triangles, &sources)?;
        let border = border(&rings, &sources)?;
        // Euler: a disc has V - E + F = 1, every handle takes 2; all but the border's edges are
        // shared by two faces.
        let (faces, corners) = (triangles.len(), vertices.len());
        let edges = (3 * faces + border.len()) / 2;
        let handles = (edges + 1).saturating_sub(corners + faces) / 2;
        if handles > 0 {
            return Err(HairgenError::ScalpHandles { handles });
        }
        let normals = normals(&vertices, &triangles);
        let soup = Soup { vertices, triangles };
        let tree = SurfaceTree::new(&soup).map_err(HairgenError::scalp)?;
        let Soup { vertices, triangles } = soup;
        Ok(Self { vertices, triangles, areas, normals, border, rings, tree })
    }

    /// The vertices (world), m.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// The triangles as indices of vertices, counter-clockwise from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Areas of the triangles, m^2.
    #[must_use]
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// Area of the whole, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// Outward normals at the vertices (world): means of those of the triangles there by their
    /// angles.
    #[must_use]
    pub fn normals(&self) -> &[Unit<Vector3<f64>>] {
        &self.normals
    }

    /// The vertices of the border in order, counter-clockwise seen from outside: the surface is to
    /// the left.
    #[must_use]
    pub fn border(&self) -> &[u32] {
        &self.border
    }

    /// Diagonal of the smallest box along the axes that holds the scalp, m.
    #[must_use]
    pub fn size(&self) -> f64 {
        let far = Vector3::repeat(f64::INFINITY);
        let (low, high) = self
            .vertices
            .iter()
            .fold((far, -far), |(low, high), p| (low.inf(&p.coords), high.sup(&p.coords)));
        (high - low).norm()
    }

    /// Corners of a face (world), m.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn corners(&self, face: u32) -> [Point3<f64>; 3] {
        self.triangles[face as usize].map(|v| self.vertices[v as usize])
    }

    /// A vertex as a point of the surface.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn vertex(&self, vertex: u32) -> SurfacePoint {
        self.tree.nearest(&self.vertices[vertex as usize]).into()
    }

    /// The point of the scalp that is nearest to a point (world). Cost: logarithmic near the
    /// surface.
    #[must_use]
    pub fn nearest(&self, point: &Point3<f64>) -> SurfacePoint {
        self.tree.nearest(point).into()
    }

    /// Place of a point of the surface (world), m.
    ///
    /// # Panics
    /// If the point is of another mesh and there is no such face here; so for all that takes one.
    #[must_use]
    pub fn position(&self, point: &SurfacePoint) -> Point3<f64> {
        point.mix(self.corners(point.face()).map(|p| p.coords)).into()
    }

    /// Outward normal at a point of the surface (world), between those of the vertices.
    #[must_use]
    pub fn normal(&self, point: &SurfacePoint) -> Unit<Vector3<f64>> {
        let triangle = self.triangles[point.face() as usize];
        let mean = point.mix(triangle.map(|v| self.normals[v as usize].into_inner()));
        Unit::try_new(mean, 0.0).unwrap_or(self.normals[triangle[0] as usize])
    }

    /// What the vertices have around them.
    pub(super) fn rings(&self) -> &Rings {
        &self.rings
    }
}

/// Areas of the triangles, of vertices that are there and finite.
fn areas(soup: &Soup) -> Result<Vec<f64>, HairgenError> {
    for (vertex, p) in soup.vertices.iter().enumerate() {
        if !p.iter().all(|x| x.is_finite()) {
            let position = p.coords.into();
            return Err(HairgenError::scalp(CollisionError::Vertex { vertex, position }));
        }
    }
    let area = |(face, triangle): (usize, &[u32; 3])| {
        let wrong = |problem| HairgenError::scalp(CollisionError::Face { face, problem });
        if triangle.iter().any(|&v| v as usize >= soup.vertices.len()) {
            return Err(wrong("has a corner that is not there"));
        }
        let [a, b, c] = triangle.map(|v| soup.vertices[v as usize]);
        let longest =
            (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        let twice = (b - a).cross(&(c - a)).norm();
        // Also what is too large or too small to be squared.
        if twice > LEAST_AREA * longest && twice.is_normal() {
            Ok(0.5 * twice)
        } else {
            Err(wrong("has no area; remove it"))
        }
    };
    soup.triangles.iter().enumerate().map(area).collect()
}

/// The mesh without vertices that no triangle has, and the numbers that the others had.
fn used(soup: Soup) -> (Soup, Vec<u32>) {
    let mut sources = soup.triangles.as_flattened().to_vec();
    sources.sort_unstable();
    sources.dedup();
    let mut numbers = vec![0; soup.vertices.len()];
    for (new, &old) in (0..).zip(&sources) {
        numbers[old as usize] = new;
    }
    let vertices = sources.iter().map(|&v| soup.vertices[v as usize]).collect();
    let triangles = soup.triangles.iter().map(|t| t.map(|v| numbers[v as usize])).collect();
    (Soup { vertices, triangles }, sources)
}

/// The vertices of the only border of the only part, in order.
fn border(rings: &Rings, sources: &[u32]) -> Result<Vec<u32>, HairgenError> {
    let (parts, second) = rings.parts();
    if parts > 1 {
        return Err(HairgenError::ScalpParts { parts, vertex: sources[second as usize] });
    }
    let mut borders = rings.borders();
    match borders.len() {
        0 => Err(HairgenError::ClosedScalp),
        1 => Ok(borders.remove(0)),
        loops => {
            // The shortest is most likely the hole.
            borders.sort_by_key(Vec::len);
            Err(HairgenError::ScalpHoles { loops, vertex: sources[borders[0][0] as usize] })
        }
    }
}

fn normals(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Unit<Vector3<f64>>> {
    let mut sums = vec![Vector3::zeros(); vertices.len()];
    // Where they cancel out, that of one triangle is as good as any.
    let mut last = vec![Vector3::z_axis(); vertices.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| vertices[v as usize]);
        let normal = Unit::new_normalize((b - a).cross(&(c - a)));
        for k in 0..3 {
            let [v, next, before] = [0, 1, 2].map(|j| triangle[(k + j) % 3] as usize);
            let angle = (vertices[next] - vertices[v]).angle(&(vertices[before] - vertices[v]));
            sums[v] += angle * normal.into_inner();
            last[v] = normal;
        }
    }
    let unit = |(sum, last): (Vector3<f64>, Unit<Vector3<f64>>)| {
        Unit::try_new(sum, f64::EPSILON.sqrt()).unwrap_or(last)
    };
    sums.into_iter().zip(last).map(unit).collect()
}
