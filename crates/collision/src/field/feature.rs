//! Faces, edges and vertices of a mesh with their Voronoi regions (thesis 7.2.2).
//!
//! The region of a feature holds the points whose nearest point lies on it, as far as its neighbors
//! tell. It is an intersection of half-spaces: beside a face those of its three sides (7.2), beside
//! an edge those of its ends and the sides of both faces (7.3), at a vertex those of all its edges
//! (7.4). None of them depends on whether the feature is convex: where it is not, or at a saddle,
//! the region turns to the other side or is empty by itself. The roof planes of (7.3) and (7.4)
//! serve to find the lattice points only; they stand at the distance of the band (erratum).
//!
//! The side of the surface follows from normals weighted by angles, which are right for any nearest
//! feature of a closed mesh (Baerentzen and Aanaes 2005), where a mean of the normals is not.

use super::Mesh;
use super::mesh::index;
use nalgebra::{Point3, Vector3};

/// A feature and its region.
#[derive(Debug, Clone)]
pub(super) struct Feature {
    kind: FeatureKind,
    /// A point of the feature.
    point: Point3<f64>,
    /// Normal, weighted by angles; its length does not matter.
    normal: Vector3<f64>,
    /// Half-spaces of the region: points with `normal . (q - point) <= offset`.
    sides: Vec<(Vector3<f64>, f64)>,
    /// Low and high corner of a box that holds the region up to the band.
    pub(super) bounds: [Point3<f64>; 2],
}

#[derive(Debug, Clone, Copy)]
enum FeatureKind {
    /// With the unit normal as the normal.
    Face,
    /// With its unit direction.
    Edge(Vector3<f64>),
    Vertex,
}

impl Feature {
    /// Signed distance of a point of the region closer than `limit`, m; none outside of the region,
    /// whose half-spaces are wider by `slack`, so that rounding leaves no gaps between regions.
    pub(super) fn distance(&self, q: &Point3<f64>, limit: f64, slack: f64) -> Option<f64> {
        let w = q - self.point;
        let side = self.normal.dot(&w);
        let distance = match self.kind {
            FeatureKind::Face => side.abs(),
            FeatureKind::Edge(direction) => w.cross(&direction).norm(),
            FeatureKind::Vertex => w.norm(),
        };
        let inside = distance < limit
            && self.sides.iter().all(|(normal, offset)| normal.dot(&w) <= offset + slack);
        inside.then(|| distance.copysign(side))
    }
}

/// All features of a mesh, with their regions up to the distance `band`.
pub(super) fn features(mesh: &Mesh, band: f64) -> Vec<Feature> {
    let vertices = mesh.vertices();
    let faces = 0..index(mesh.triangles().len());
    let normals: Vec<_> = faces.clone().map(|face| normal(&mesh.corners(face))).collect();
    let mut features: Vec<_> =
        faces.map(|f| face(&mesh.corners(f), normals[f as usize], band)).collect();
    for edge in mesh.edges() {
        let ends = edge.ends.map(|v| vertices[v as usize]);
        features.push(self::edge(ends, edge.faces.map(|f| normals[f as usize]), band));
    }
    features.extend(points(mesh, &normals, band));
    features
}

/// Unit normal of a triangle.
fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)).normalize()
}

fn face(corners: &[Point3<f64>; 3], normal: Vector3<f64>, band: f64) -> Feature {
    let [a, b, c] = *corners;
    let side = |from: Point3<f64>, to: Point3<f64>| {
        // Outward in the plane of the face: -d of (7.2).
        let outward = (to - from).normalize().cross(&normal);
        (outward, outward.dot(&(from - a)))
    };
    let roof = band * normal;
    Feature {
        kind: FeatureKind::Face,
        point: a,
        normal,
        sides: vec![side(a, b), side(b, c), side(c, a)],
        bounds: bounds(corners.iter().flat_map(|p| [p + roof, p - roof])),
    }
}

/// The first normal is that of the face that runs through the edge from the first end.
fn edge([a, b]: [Point3<f64>; 2], normals: [Vector3<f64>; 2], band: f64) -> Feature {
    let length = (b - a).norm();
    let e = (b - a) / length;
    let [n1, n2] = normals;
    // Into the two faces: -d of (7.3).
    let sides = vec![(e, length), (-e, 0.0), (n1.cross(&e), 0.0), (e.cross(&n2), 0.0)];
    // The wedge is between the normals on the convex side, and between their opposites on the
    // other.
    let convex = n1.cross(&n2).dot(&e) >= 0.0;
    let sign = if convex { 1.0 } else { -1.0 };
    // The roof planes touch the circle of the band half-way between a normal and the middle one, so
    // that they cut all three at the same distance.
    let middle = (n1 + n2).try_normalize(1e-9).unwrap_or_else(|| n1.cross(&e));
    let height = sign * band / (0.5 * (1.0 + n1.dot(&middle))).sqrt();
    let roof = [n1, n2, middle, Vector3::zeros()].map(|n| height * n);
    Feature {
        kind: FeatureKind::Edge(e),
        point: a,
        normal: n1 + n2,
        sides,
        bounds: bounds(roof.iter().flat_map(|r| [a + r, b + r])),
    }
}

/// All vertices that have edges.
fn points(mesh: &Mesh, normals: &[Vector3<f64>], band: f64) -> Vec<Feature> {
    let vertices = mesh.vertices();
    let reach = Vector3::repeat(band);
    let at = |&point: &Point3<f64>| Feature {
        kind: FeatureKind::Vertex,
        point,
        normal: Vector3::zeros(),
        sides: Vec::new(),
        bounds: [point - reach, point + reach],
    };
    let mut features: Vec<_> = vertices.iter().map(at).collect();
    for edge in mesh.edges() {
        let [a, b] = edge.ends.map(|v| v as usize);
        let e = (vertices[b] - vertices[a]).normalize();
        features[a].sides.push((e, 0.0));
        features[b].sides.push((-e, 0.0));
    }
    for (triangle, normal) in mesh.triangles().iter().zip(normals) {
        for k in 0..3 {
            let [p, q, r] = [0, 1, 2].map(|i| triangle[(k + i) % 3] as usize);
            let angle = (vertices[q] - vertices[p]).angle(&(vertices[r] - vertices[p]));
            features[p].normal += angle * normal;
        }
    }
    features.retain(|feature| !feature.sides.is_empty());
    features
}

fn bounds(points: impl Iterator<Item = Point3<f64>>) -> [Point3<f64>; 2] {
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(-f64::INFINITY));
    for p in points {
        low = low.inf(&p.coords);
        high = high.sup(&p.coords);
    }
    [low.into(), high.into()]
}
