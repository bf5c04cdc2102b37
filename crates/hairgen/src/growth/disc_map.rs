//! The scalp in the unit disc.

use super::axes::HeadAxes;
use super::scalp::ScalpMesh;
use super::stretch::{Stretch, twice_area};
use super::surface_point::SurfacePoint;
use super::weights::ConvexWeights;
use crate::HairgenError;
use nalgebra::{DMatrix, Point2, Point3, Vector2, Vector3};
use rapunzel_collision::field::{Soup, SurfaceTree};
use rapunzel_linalg::SparseSystem;
use std::f64::consts::TAU;

/// Rounds of relaxation at most.
const MOST_ROUNDS: usize = 50;

/// A round that lets the stretch fall by less than this part of it does not count.
const LEAST_FALL: f64 = 1e-4;

/// A one-to-one map of a scalp to the unit disc (thesis 5.3.2).
///
/// The border lies on the circle, its edges in proportion to their lengths; the vertices inside
/// are convex combinations of their neighbors, relaxed as in (5.6). Seen from above, with the
/// axes that are given: the face is at negative `y`, the person's left at positive `x`. The
/// triangles fill the polygon of the border, which is inside of the circle: a point between both
/// is taken for the nearest one of the polygon.
#[derive(Debug, Clone)]
pub struct DiscMap {
    places: Vec<Point2<f64>>,
    triangles: Vec<[u32; 3]>,
    tree: SurfaceTree,
    history: Vec<f64>,
}

impl DiscMap {
    /// Maps a scalp. Stretch is evened out by weights `w_ij / delta_j` with the stretches `delta`
    /// at the vertices (S. Yoshizawa, A. Belyaev, H.-P. Seidel, A fast and simple
    /// stretch-minimizing mesh parameterization, Shape Modeling International 2004), again and
    /// again as long as the stretch of the whole falls; the last map that let it fall is kept.
    /// The whole is measured by areas, as by these authors. The thesis adds up the values of the
    /// vertices, but that depends on how dense they are, and need not fall. Cost: a sparse system a
    /// round.
    ///
    /// # Errors
    /// Those of [`convex_map`].
    pub fn new(
        mesh: &ScalpMesh,
        weights: ConvexWeights,
        axes: &HeadAxes,
    ) -> Result<Self, HairgenError> {
        let border = circle(mesh, axes);
        let mut weights = all_weights(mesh, weights);
        let mut places = solve(mesh, &weights, &border)?;
        let mut stretch = Stretch::new(mesh, &places);
        let mut history = vec![stretch.whole];
        for _ in 0..MOST_ROUNDS {
            relax(mesh, &mut weights, &stretch.at_vertices);
            // Weights may become so uneven that triangles vanish.
            let Ok(next) = solve(mesh, &weights, &border) else { break };
            let before = stretch.whole;
            stretch = Stretch::new(mesh, &next);
            if stretch.whole > (1.0 - LEAST_FALL) * before {
                break;
            }
            places = next;
            history.push(stretch.whole);
        }
        let triangles = mesh.triangles().to_vec();
        let vertices = places.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        let flat = Soup { vertices, triangles: triangles.clone() };
        let tree = SurfaceTree::new(&flat).map_err(HairgenError::scalp)?;
        Ok(Self { places, triangles, tree, history })
    }

    /// Places of the vertices in the unit disc.
    #[must_use]
    pub fn places(&self) -> &[Point2<f64>] {
        &self.places
    }

    /// Stretch of the whole without relaxation and after every round of it that was kept, falling:
    /// the root of the mean by area of `(l_max^2 + l_min^2) / 2`, with the singular values of the
    /// map from the disc to the surface in a triangle, scaled so that a similarity has 1 and all
    /// else more.
    #[must_use]
    pub fn stretch_history(&self) -> &[f64] {
        &self.history
    }

    /// Corners of a face in the disc.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn corners(&self, face: u32) -> [Point2<f64>; 3] {
        self.triangles[face as usize].map(|v| self.places[v as usize])
    }

    /// Place of a point of the surface in the disc.
    ///
    /// # Panics
    /// If the point is of another mesh and there is no such face here.
    #[must_use]
    pub fn place(&self, point: &SurfacePoint) -> Point2<f64> {
        point.mix(self.corners(point.face()).map(|p| p.coords)).into()
    }

    /// The point of the surface at a place of the disc; outside of the border's polygon that of
    /// its nearest point. Cost: logarithmic.
    #[must_use]
    pub fn locate(&self, place: &Point2<f64>) -> SurfacePoint {
        self.tree.nearest(&Point3::new(place.x, place.y, 0.0)).into()
    }

    /// The direction on the surface (world, not of unit length) of a direction in the disc, at the
    /// point of a face.
    #[must_use]
    pub(super) fn lifted(
        &self,
        mesh: &ScalpMesh,
        face: u32,
        direction: &Vector2<f64>,
    ) -> Vector3<f64> {
        let ([a, b, c], [u, v, w]) = (mesh.corners(face), self.corners(face));
        let (e, f) = (v - u, w - u);
        let (along_e, along_f) = (direction.perp(&f), e.perp(direction));
        ((b - a) * along_e + (c - a) * along_f) / e.perp(&f)
    }
}

/// Places of all vertices for given places of the border's, in its order (thesis (5.5)): every
/// other vertex is a convex combination of its neighbors. Where the border is mapped to a convex
/// polygon, counter-clockwise and without straight corners, the map is one-to-one (M. S. Floater,
/// One-to-one piecewise linear mappings over triangulations, Mathematics of Computation 72, 2003).
///
/// # Errors
/// [`HairgenError::BorderCount`] for another number of places, [`HairgenError::Flipped`] where
/// triangles vanish in rounding or turn over, and [`HairgenError::Linear`].
pub fn convex_map(
    mesh: &ScalpMesh,
    weights: ConvexWeights,
    border: &[Point2<f64>],
) -> Result<Vec<Point2<f64>>, HairgenError> {
    let (given, needed) = (border.len(), mesh.border().len());
    if given != needed {
        return Err(HairgenError::BorderCount { given, needed });
    }
    solve(mesh, &all_weights(mesh, weights), border)
}

/// The border on the unit circle by its lengths, turned so that its places fit those from above
/// best, with the face at negative `y`.
fn circle(mesh: &ScalpMesh, axes: &HeadAxes) -> Vec<Point2<f64>> {
    let border: Vec<_> = mesh.border().iter().map(|&v| mesh.vertices()[v as usize]).collect();
    let count = border.len();
    let lengths: Vec<_> =
        (0..count).map(|k| (border[(k + 1) % count] - border[k]).norm()).collect();
    let whole: f64 = lengths.iter().sum();
    let (mut angles, mut sum) = (Vec::with_capacity(count), 0.0);
    for length in lengths {
        angles.push(TAU * sum / whole);
        sum += length;
    }
    // The turn that makes the sum of the products of both largest.
    let center = border.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count as f64;
    let (mut sin, mut cos) = (0.0, 0.0);
    for (p, angle) in border.iter().zip(&angles) {
        let from_center = p.coords - center;
        let (x, y) = (from_center.dot(&axes.left()), -from_center.dot(&axes.front()));
        cos += x * angle.cos() + y * angle.sin();
        sin += y * angle.cos() - x * angle.sin();
    }
    let turn = sin.atan2(cos);
    let place = |angle: f64| Point2::new((angle + turn).cos(), (angle + turn).sin());
    angles.into_iter().map(place).collect()
}

/// Weights of the neighbors of all vertices that are not at the border, in the order of the rings;
/// none for the others.
fn all_weights(mesh: &ScalpMesh, weights: ConvexWeights) -> Vec<Vec<f64>> {
    let of = |v| if mesh.rings().is_open(v) { Vec::new() } else { weights.of(mesh, v) };
    (0..).take(mesh.vertices().len()).map(of).collect()
}

/// New weights `w_ij / delta_j`, of sum 1.
fn relax(mesh: &ScalpMesh, weights: &mut [Vec<f64>], stretches: &[f64]) {
    for (vertex, weights) in (0..).zip(weights) {
        let neighbors = mesh.rings().of(vertex);
        for (weight, &j) in weights.iter_mut().zip(neighbors) {
            *weight /= stretches[j as usize];
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
    }
}

/// The linear system (5.5), without the rows of the border, whose places are known.
fn solve(
    mesh: &ScalpMesh,
    weights: &[Vec<f64>],
    border: &[Point2<f64>],
) -> Result<Vec<Point2<f64>>, HairgenError> {
    let mut places = vec![Point2::origin(); mesh.vertices().len()];
    for (&v, place) in mesh.border().iter().zip(border) {
        places[v as usize] = *place;
    }
    let rings = mesh.rings();
    let mut rows = vec![None; places.len()];
    let inside: Vec<u32> = (0..).take(places.len()).filter(|&v| !rings.is_open(v)).collect();
    for (row, &v) in inside.iter().enumerate() {
        rows[v as usize] = Some(row);
    }
    if !inside.is_empty() {
        let mut entries = Vec::with_capacity(7 * inside.len());
        let mut right = DMatrix::zeros(inside.len(), 2);
        for (row, &v) in inside.iter().enumerate() {
            entries.push((row, row, 1.0));
            for (&j, &weight) in rings.of(v).iter().zip(&weights[v as usize]) {
                match rows[j as usize] {
                    Some(column) => entries.push((row, column, -weight)),
                    None => {
                        right[(row, 0)] += weight * places[j as usize].x;
                        right[(row, 1)] += weight * places[j as usize].y;
                    }
                }
            }
        }
        let solution = SparseSystem::new(inside.len(), &entries)?.solve(&right)?;
        for (row, &v) in inside.iter().enumerate() {
            places[v as usize] = Point2::new(solution[(row, 0)], solution[(row, 1)]);
        }
    }
    check(mesh, &places)?;
    Ok(places)
}

/// No triangle is without area or turned over, to rounding.
fn check(mesh: &ScalpMesh, places: &[Point2<f64>]) -> Result<(), HairgenError> {
    let flipped = |triangle: &[u32; 3]| {
        let corners = triangle.map(|v| places[v as usize]);
        let size = corners.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let rounding = 4.0 * f64::EPSILON * size * (corners[1] - corners[0]).amax();
        let positive = twice_area(corners) > rounding;
        !positive
    };
    let mut faces = mesh.triangles().iter().enumerate().filter(|(_, t)| flipped(t));
    match faces.next() {
        None => Ok(()),
        Some((face, _)) => Err(HairgenError::Flipped { face, count: 1 + faces.count() }),
    }
}
