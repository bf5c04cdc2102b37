//! How much a map of a surface to the plane stretches.

use super::scalp::ScalpMesh;
use nalgebra::{Point2, Point3};

/// Stretch of the affine map from a triangle of the plane to one of the surface: the root of the
/// mean of its squared singular values, `sqrt((l_max^2 + l_min^2) / 2)` (thesis before (5.4) with
/// its erratum; P. V. Sander et al., Texture mapping progressive meshes, 2001). That is 1 for an
/// isometry and large where a piece of the surface gets little room in the plane. The thesis gives
/// the map the other way, but (5.6) evens out this one only. The plane's area is given, as twice
/// it.
fn triangle_stretch(
    [a, b, c]: [Point3<f64>; 3],
    [u, v, w]: [Point2<f64>; 3],
    twice_area: f64,
) -> f64 {
    // Derivatives of the place on the surface by both coordinates of the plane.
    let along_x =
        (a.coords * (v.y - w.y) + b.coords * (w.y - u.y) + c.coords * (u.y - v.y)) / twice_area;
    let along_y =
        (a.coords * (w.x - v.x) + b.coords * (u.x - w.x) + c.coords * (v.x - u.x)) / twice_area;
    (0.5 * (along_x.norm_squared() + along_y.norm_squared())).sqrt()
}

/// Twice the area of a triangle of the plane, negative if it is clockwise.
pub(super) fn twice_area([u, v, w]: [Point2<f64>; 3]) -> f64 {
    (v - u).perp(&(w - u))
}

/// How much a map of a surface to the plane stretches, scaled by the areas of plane and surface as
/// wholes: a similarity has 1 everywhere.
pub(super) struct Stretch {
    /// Of the surface: the root of the mean of the squared stretches of the triangles by their
    /// areas on the surface (Sander et al. 2001). Only a similarity has 1, all others more.
    pub(super) whole: f64,
    /// At the vertices (thesis (5.6) with its erratum): the same over the triangles there.
    pub(super) at_vertices: Vec<f64>,
}

impl Stretch {
    /// Stretch of a map without triangles that are turned over.
    pub(super) fn new(mesh: &ScalpMesh, places: &[Point2<f64>]) -> Self {
        let mut sums = vec![[0.0; 2]; places.len()];
        let (mut plane, mut whole) = (0.0, 0.0);
        for (face, (triangle, area)) in (0..).zip(mesh.triangles().iter().zip(mesh.areas())) {
            let flat = triangle.map(|v| places[v as usize]);
            let twice = twice_area(flat);
            plane += 0.5 * twice;
            let stretch = triangle_stretch(mesh.corners(face), flat, twice);
            whole += area * stretch * stretch;
            for v in triangle {
                let [squares, areas] = &mut sums[*v as usize];
                *squares += area * stretch * stretch;
                *areas += area;
            }
        }
        let scale = plane / mesh.area();
        let root = |[squares, areas]: [f64; 2]| (scale * squares / areas).sqrt();
        let whole = root([whole, mesh.area()]);
        Self { whole, at_vertices: sums.into_iter().map(root).collect() }
    }
}
