//! Surfaces of triangles.

use crate::check::{check, check_point};
use crate::tree::{
    LeafThings, Leaves, NONE, RayBox, RayQuery, RayTree, SignBits, TreeRay, rounding, short,
    single, walk,
};
use crate::{Ray, RenderError};
use nalgebra::{Point3, Vector3};
use pulp::Simd;

/// A surface of triangles, seen from both sides, in a tree that finds where rays meet it.
///
/// Rays slip through no edge: beside it both triangles compute the same number, with opposite
/// signs.
#[derive(Debug, Clone)]
pub struct TriangleMesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    /// Normals at the corners of triangles, of unit length.
    normals: Vec<[Vector3<f32>; 3]>,
    tree: RayTree,
    leaves: Vec<LeafThings>,
    middle: Point3<f64>,
    extent: f64,
}

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshHit {
    /// From the origin of the ray, m.
    pub distance: f64,
    triangle: u32,
    /// Weights of the corners, of sum 1.
    weights: [f64; 3],
}

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePoint {
    /// The point (world), m.
    pub position: Point3<f64>,
    /// Normal of the triangle (world), of unit length, towards where the ray came from.
    pub face: Vector3<f64>,
    /// Smooth normal (world), of unit length, on the side of `face`.
    pub normal: Vector3<f64>,
}

impl TriangleMesh {
    /// A surface by its vertices (world), m, and its triangles; edges at which it bends by more
    /// than `crease`, rad, stay sharp.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if a vertex is not finite, or a triangle has a corner that is not
    /// there.
    pub fn new(
        vertices: Vec<Point3<f64>>,
        triangles: Vec<[u32; 3]>,
        crease: f64,
    ) -> Result<Self, RenderError> {
        vertices.iter().try_for_each(|p| check_point("a coordinate of a surface (m)", p))?;
        for corner in triangles.iter().flatten() {
            let there = (*corner as usize) < vertices.len();
            check("a corner of a triangle", f64::from(*corner), "the index of a vertex", there)?;
        }
        let count = triangles.len() as f64;
        check("the number of triangles", count, "below 2^31", count < 2_147_483_648.0)?;
        let normals = corner_normals(&vertices, &triangles, crease);
        let first = vertices.first().copied().unwrap_or_default();
        let [low, high] = vertices.iter().fold([first; 2], |[a, b], p| [a.inf(p), b.sup(p)]);
        let middle = nalgebra::center(&low, &high);
        let extent = (0.5 * (high - low).amax()).max(f64::MIN_POSITIVE) * (1.0 + 1e-6);
        let spare = Vector3::repeat(rounding(extent));
        let bounds = |(index, corners): (u32, &[u32; 3])| {
            let [a, b, c] = corners.map(|corner| vertices[corner as usize] - middle);
            let (low, high) = (a.inf(&b).inf(&c) - spare, a.sup(&b).sup(&c) + spare);
            RayBox::new(single(&low.into()), single(&high.into()), index)
        };
        let (tree, leaves) = RayTree::new((0..).zip(&triangles).map(bounds).collect());
        Ok(Self { vertices, triangles, normals, tree, leaves, middle, extent })
    }

    /// Vertices (world), m.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// The first triangle that a ray meets farther than `range[0]` and nearer than `range[1]`, m.
    #[must_use]
    pub fn hit(&self, ray: &Ray, range: [f64; 2]) -> Option<MeshHit> {
        self.walk(ray, range, RayQuery::Nearest)
    }

    /// Whether a ray meets any triangle between two distances, m.
    #[must_use]
    pub fn hides(&self, ray: &Ray, range: [f64; 2]) -> bool {
        self.walk(ray, range, RayQuery::Any).is_some()
    }

    fn walk(&self, ray: &Ray, range: [f64; 2], until: RayQuery) -> Option<MeshHit> {
        let mut in_tree = TreeRay::new(ray, range, &self.middle, self.extent)?;
        walk(&self.tree, &mut TriangleLeaves { mesh: self, ray, range }, &mut in_tree, until)
    }

    /// What is at a hit of a ray.
    #[must_use]
    pub fn at(&self, ray: &Ray, hit: &MeshHit) -> FacePoint {
        let triangle = hit.triangle as usize;
        let [a, b, c] = self.triangles[triangle].map(|corner| self.vertices[corner as usize]);
        let toward = |normal: Vector3<f64>, way: &Vector3<f64>| {
            if normal.dot(way) < 0.0 { -normal } else { normal }
        };
        let back = -ray.direction;
        let face = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or(back);
        let face = toward(face, &back);
        let [u, v, w] = hit.weights;
        let corners = self.normals[triangle].map(|normal| normal.cast::<f64>());
        let smooth = corners[0] * u + corners[1] * v + corners[2] * w;
        let normal = toward(smooth.try_normalize(1e-6).unwrap_or(face), &face);
        FacePoint { position: ray.at(hit.distance), face, normal }
    }

    /// Where a ray meets a triangle, by the signs of the volumes that it spans with its edges.
    fn meet(&self, ray: &Ray, triangle: u32) -> Option<MeshHit> {
        let corners = self.triangles[triangle as usize];
        let [a, b, c] = corners.map(|corner| self.vertices[corner as usize] - ray.origin);
        let d = &ray.direction;
        let volumes = [d.dot(&c.cross(&b)), d.dot(&a.cross(&c)), d.dot(&b.cross(&a))];
        let inside = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
        let sum: f64 = volumes.iter().sum();
        if !inside || sum == 0.0 {
            return None;
        }
        let weights = volumes.map(|v| v / sum);
        let distance = d.dot(&(a * weights[0] + b * weights[1] + c * weights[2]));
        distance.is_finite().then_some(MeshHit { distance, triangle, weights })
    }
}

/// The triangles in the leaves, for one ray.
struct TriangleLeaves<'a> {
    mesh: &'a TriangleMesh,
    ray: &'a Ray,
    range: [f64; 2],
}

impl Leaves for TriangleLeaves<'_> {
    type Found = MeshHit;

    #[inline(always)]
    fn meet<S: Simd, B: SignBits>(
        &mut self,
        _registers: (S, B),
        leaf: usize,
        ray: &mut TreeRay,
    ) -> Option<MeshHit> {
        let mut found = None;
        for &triangle in self.mesh.leaves[leaf].iter().take_while(|index| **index != NONE) {
            if let Some(hit) = self.mesh.meet(self.ray, triangle) {
                let [first, last] = self.range;
                if hit.distance > first && hit.distance < last {
                    self.range[1] = hit.distance;
                    ray.shorten(hit.distance);
                    found = Some(hit);
                }
            }
        }
        found
    }
}

/// Normals at the corners of triangles: of all faces around the vertex that bend away by at most
/// `crease`, rad, by their areas.
fn corner_normals(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    crease: f64,
) -> Vec<[Vector3<f32>; 3]> {
    let face = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
        (b - a).cross(&(c - a))
    };
    let faces: Vec<_> = triangles.iter().map(face).collect();
    let mut around = vec![Vec::new(); vertices.len()];
    for (index, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|corner| around[*corner as usize].push(short(index)));
    }
    let least = crease.cos();
    let corner = |own: &Vector3<f64>, vertex: u32| {
        let beside = around[vertex as usize].iter().map(|index| &faces[*index as usize]);
        let smooth = beside.filter(|face| face.dot(own) >= least * face.norm() * own.norm());
        let sum: Vector3<f64> = smooth.sum();
        sum.try_normalize(0.0).unwrap_or_default().cast::<f32>()
    };
    let of = |(corners, own): (&[u32; 3], &Vector3<f64>)| corners.map(|vertex| corner(own, vertex));
    triangles.iter().zip(&faces).map(of).collect()
}
