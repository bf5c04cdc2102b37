//! Polygons as triangles.

use super::Soup;
use super::mesh::DEGENERATE;
use nalgebra::{Point2, Vector3};
use spade::handles::FixedDirectedEdgeHandle;
use spade::{ConstrainedDelaunayTriangulation, Triangulation};

impl Soup {
    /// Adds a polygon as triangles on its corners, with its orientation: it may be concave,
    /// somewhat out of its plane, and go along a side twice to leave out a hole. Corners that
    /// repeat the one before are dropped.
    ///
    /// A fan around the first corner does for most; others are triangulated after Delaunay in the
    /// plane of two axes in which they are largest. Polygons without an area, and those with a
    /// corner that is not there, become fans, which [`Mesh::new`](super::Mesh::new) refuses.
    ///
    /// # Errors
    /// What is wrong with a polygon that meets itself.
    pub(super) fn polygon(&mut self, mut corners: Vec<u32>) -> Result<(), &'static str> {
        corners.dedup();
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        let fan = |corners: &[u32]| -> Vec<[u32; 3]> {
            let sides = corners.get(1..).unwrap_or_default().windows(2);
            sides.map(|side| [corners[0], side[0], side[1]]).collect()
        };
        let triangles = match self.flat(&corners) {
            Some(flat) if flat.len() > 3 && !is_fan(&flat) => triangulate(&flat, &corners)
                .ok_or("is a polygon that meets itself; split it into triangles")?,
            _ => fan(&corners),
        };
        self.triangles.extend(triangles);
        Ok(())
    }

    /// Corners in the plane of two axes, counter-clockwise, about the first; `None` without an
    /// area.
    fn flat(&self, corners: &[u32]) -> Option<Vec<Point2<f64>>> {
        let places = corners.iter().map(|&v| self.vertices.get(v as usize));
        let places: Vec<_> = places.collect::<Option<_>>()?;
        let relative: Vec<_> = places.iter().map(|&p| p - places[0]).collect();
        let sum: Vector3<f64> = relative.windows(2).map(|pair| pair[0].cross(&pair[1])).sum();
        let axis = sum.iamax();
        let [mut i, mut j] = [(axis + 1) % 3, (axis + 2) % 3];
        if sum[axis] < 0.0 {
            (i, j) = (j, i);
        }
        let has_area = sum[axis].is_normal() && sum.iter().all(|x| x.is_finite());
        has_area.then(|| relative.iter().map(|p| Point2::new(p[i], p[j])).collect())
    }
}

/// Whether the triangles around the first corner are all counter-clockwise, with an area.
fn is_fan(flat: &[Point2<f64>]) -> bool {
    flat[1..].windows(2).all(|side| {
        let [b, c] = [side[0] - flat[0], side[1] - flat[0]];
        let longest = b.norm_squared().max(c.norm_squared()).max((c - b).norm_squared());
        b.perp(&c) > DEGENERATE.sqrt() * longest
    })
}

/// Triangles on the corners of a counter-clockwise polygon; `None` if it meets itself.
fn triangulate(flat: &[Point2<f64>], corners: &[u32]) -> Option<Vec<[u32; 3]>> {
    let mut delaunay = ConstrainedDelaunayTriangulation::<spade::Point2<f64>>::new();
    let mut vertices = Vec::with_capacity(flat.len());
    let mut names = Vec::with_capacity(flat.len());
    for (p, &corner) in flat.iter().zip(corners) {
        let vertex = delaunay.insert(spade::Point2::new(p.x, p.y)).ok()?;
        if vertex.index() == names.len() {
            names.push(corner);
        }
        vertices.push(vertex);
    }
    for (k, &vertex) in vertices.iter().enumerate() {
        let next = vertices[(k + 1) % vertices.len()];
        let is_there = delaunay.exists_constraint(vertex, next);
        if !is_there && delaunay.try_add_constraint(vertex, next).len() != 1 {
            return None;
        }
    }
    // Inside is what can be reached from the left of the sides without crossing any.
    let mut front: Vec<FixedDirectedEdgeHandle> = Vec::with_capacity(flat.len());
    for (k, &vertex) in vertices.iter().enumerate() {
        let next = vertices[(k + 1) % vertices.len()];
        front.push(delaunay.get_edge_from_neighbors(vertex, next)?.fix());
    }
    let mut inside = vec![false; delaunay.num_all_faces()];
    let mut triangles = Vec::with_capacity(flat.len());
    while let Some(edge) = front.pop() {
        let face = delaunay.directed_edge(edge).face().as_inner()?;
        if std::mem::replace(&mut inside[face.index()], true) {
            continue;
        }
        triangles.push(face.vertices().map(|vertex| names[vertex.index()]));
        let open = face.adjacent_edges().into_iter().filter(|edge| !edge.is_constraint_edge());
        front.extend(open.map(|edge| edge.rev().fix()));
    }
    (triangles.len() + 2 == corners.len()).then_some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Rotation3};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// The polygon with these corners in the plane of x and y, turned and moved in space.
    fn placed(flat: &[[f64; 2]], turn: [f64; 3], height: impl Fn(usize) -> f64) -> Soup {
        let turn = Rotation3::from_scaled_axis(Vector3::from(turn));
        let place = |(k, p): (usize, &[f64; 2])| {
            Point3::new(0.3, -0.2, 0.1) + turn * Vector3::new(p[0], p[1], height(k))
        };
        Soup { vertices: flat.iter().enumerate().map(place).collect(), triangles: Vec::new() }
    }

    /// Twice the area of a polygon in the plane, positive if it is counter-clockwise.
    fn doubled(flat: &[[f64; 2]]) -> f64 {
        let next = flat.iter().cycle().skip(1);
        flat.iter().zip(next).map(|([a, b], [c, d])| a * d - b * c).sum()
    }

    /// The triangles are as many as the corners less two, and have the polygon's sides, in its
    /// direction, once each: all others lie between two of them.
    fn check_sides(corners: &[u32], triangles: &[[u32; 3]]) -> Result<(), TestCaseError> {
        prop_assert_eq!(triangles.len() + 2, corners.len());
        for k in 0..corners.len() {
            let side = [corners[k], corners[(k + 1) % corners.len()]];
            let has = |t: &&[u32; 3]| (0..3).any(|i| [t[i], t[(i + 1) % 3]] == side);
            prop_assert_eq!(triangles.iter().filter(has).count(), 1);
        }
        Ok(())
    }

    /// They have an area on the polygon's side, and together that of the polygon: with its sides
    /// they cover it and no more.
    fn check(flat: &[[f64; 2]], corners: &[u32], soup: &Soup) -> Result<(), TestCaseError> {
        check_sides(corners, &soup.triangles)?;
        let area = |corners: &[u32]| {
            doubled(&corners.iter().map(|&v| flat[v as usize]).collect::<Vec<_>>())
        };
        let whole = area(corners);
        let parts: Vec<_> = soup.triangles.iter().map(|t| area(t)).collect();
        prop_assert!(parts.iter().all(|&part| part * whole > 0.0), "{parts:?} of {whole}");
        let sum: f64 = parts.iter().sum();
        prop_assert!((sum / whole - 1.0).abs() < 1e-12, "{sum} of {whole}");
        Ok(())
    }

    /// Corners of a polygon that can be seen from the origin, at growing angles.
    fn star() -> impl Strategy<Value = Vec<[f64; 2]>> {
        prop::collection::vec((0.2..1.0_f64, 0.1..1.0_f64), 4..40).prop_map(|parts| {
            let whole: f64 = parts.iter().map(|part| part.0).sum();
            let mut angle = 0.0;
            let corner = |&(part, radius): &(f64, f64)| {
                angle += TAU * part / whole;
                [radius * f64::cos(angle), radius * f64::sin(angle)]
            };
            parts.iter().map(corner).collect()
        })
    }

    /// A comb: teeth of any height down from a straight back with as many corners on it.
    fn comb() -> impl Strategy<Value = Vec<[f64; 2]>> {
        prop::collection::vec(0.1..2.0_f64, 2..20).prop_map(|heights| {
            let count = heights.len();
            let at = |k: usize| k as f64 / count as f64;
            let back = (0..count).rev().map(|k| [at(k), 3.0]);
            let tooth =
                |(k, height): (usize, &f64)| [at(k), if k % 2 == 0 { *height } else { 2.5 }];
            heights.iter().enumerate().map(tooth).chain(back).collect()
        })
    }

    proptest! {
        /// Also where the polygon is somewhat out of its plane, but then an area has no side.
        #[test]
        fn triangles_cover_a_polygon_and_no_more(
            flat in prop_oneof![star(), comb()],
            turn in prop::array::uniform3(-3.0..3.0_f64),
            first in 0..40_u32,
            reversed: bool,
            bulge in 0.0..0.02_f64,
        ) {
            let count = u32::try_from(flat.len()).expect("few");
            let mut corners: Vec<u32> = (0..count).map(|k| (k + first) % count).collect();
            if reversed {
                corners.reverse();
            }
            let mut soup = placed(&flat, turn, |_| 0.0);
            soup.polygon(corners.clone()).expect("simple");
            check(&flat, &corners, &soup)?;
            let mut soup = placed(&flat, turn, |k| bulge * (k as f64).sin());
            if soup.polygon(corners.clone()).is_ok() {
                check_sides(&corners, &soup.triangles)?;
            }
        }
    }

    #[test]
    fn straight_corners_and_holes_are_kept() {
        // A square whose side has a corner in the middle; one with a square hole, by a side gone
        // along twice.
        let straight = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut soup = placed(&straight, [0.1, 0.2, 0.3], |_| 0.0);
        soup.polygon(vec![0, 1, 2, 3, 4]).expect("simple");
        check(&straight, &[0, 1, 2, 3, 4], &soup).expect("covered");
        let holed = [0.0, 1.0].map(|inner| {
            let [low, high] = [inner, 3.0 - inner];
            [[low, low], [high, low], [high, high], [low, high]]
        });
        let mut soup = placed(holed.as_flattened(), [0.4, 0.0, 0.9], |_| 0.0);
        soup.polygon(vec![0, 1, 2, 3, 0, 4, 7, 6, 5, 4]).expect("simple but for its bridge");
        assert_eq!(soup.triangles.len(), 8);
        let area: f64 = soup
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = soup.corners(*t);
                0.5 * (b - a).cross(&(c - a)).norm()
            })
            .sum();
        assert!((area - 8.0).abs() < 1e-12);
    }

    #[test]
    fn repeated_corners_are_dropped() {
        let mut soup = placed(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [0.0; 3], |_| 0.0);
        soup.polygon(vec![0, 0, 1, 2, 2, 0]).expect("a triangle");
        soup.polygon(vec![1, 1]).expect("nothing");
        soup.polygon(vec![]).expect("nothing");
        assert_eq!(soup.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn what_meets_itself_is_refused_and_what_has_no_area_is_a_fan() {
        let crossed = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.5], [0.5, -1.0]];
        let mut soup = placed(&crossed, [0.0; 3], |_| 0.0);
        assert!(soup.polygon(vec![0, 1, 2, 3, 4]).is_err());
        let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.5, 0.0]];
        let mut soup = placed(&line, [0.0; 3], |_| 0.0);
        soup.polygon(vec![0, 1, 2, 3]).expect("a fan");
        soup.polygon(vec![0, 1, 9, 3]).expect("a fan");
        assert_eq!(soup.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 9], [0, 9, 3]]);
    }
}
