//! How much a map of a surface to the plane stretches.

use super::scalp::ScalpMesh;
use nalgebra::Point2;

/// Stretch of the affine map from a triangle of the plane to one of the surface: the root of the
/// mean of its squared singular values, `sqrt((l_max^2 + l_min^2) / 2)` (thesis before (5.4) with
/// its erratum; P. V. Sander et al., Texture mapping progressive meshes, 2001). That is 1 for an
/// isometry and large where a piece of the surface gets little room in the plane. The thesis gives
/// the map the other way, but (5.6) evens out this one only. The plane's area is given, as twice
/// it.
fn triangle_stretch(
    [a, b, c]: [nalgebra::Point3<f64>; 3],
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

/// Stretch at the vertices (thesis (5.6) with its erratum): the root of the mean of the squared
/// stretches of the triangles there by their areas on the surface. It is scaled by the areas of
/// plane and surface as wholes: 1 for a similarity.
pub(super) fn vertex_stretches(mesh: &ScalpMesh, places: &[Point2<f64>]) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; places.len()];
    let mut plane = 0.0;
    for (face, (triangle, area)) in (0..).zip(mesh.triangles().iter().zip(mesh.areas())) {
        let flat = triangle.map(|v| places[v as usize]);
        let twice = twice_area(flat);
        plane += 0.5 * twice;
        let stretch = triangle_stretch(mesh.corners(face), flat, twice);
        for v in triangle {
            let [squares, areas] = &mut sums[*v as usize];
            *squares += area * stretch * stretch;
            *areas += area;
        }
    }
    let scale = plane / mesh.area();
    sums.into_iter().map(|[squares, areas]| (scale * squares / areas).sqrt()).collect()
}
