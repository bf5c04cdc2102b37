//! Where a surface cuts through itself.

use super::mesh::index;
use super::nearest::SurfaceTree;
use nalgebra::Point3;
use rayon::prelude::*;
use robust::{Coord3D, orient3d};

/// A triangle of a surface that another one cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfCrossing {
    /// Index of the triangle.
    pub face: usize,
    /// A place on both (world), m.
    pub place: Point3<f64>,
}

impl SurfaceTree {
    /// The triangles that others cut, in their order, each with one place where that is so.
    ///
    /// Two triangles cut each other if an edge of one has its ends on different sides of the other
    /// and meets it; the signs are exact. Neighbors are told apart by the edges that they do not
    /// share. What only touches cuts nothing, and triangles that overlap in one plane are not
    /// found. Cost: about `n log n` for `n` triangles.
    #[must_use]
    pub fn crossings(&self) -> Vec<SelfCrossing> {
        let faces = 0..index(self.corners().len());
        let found = faces.into_par_iter().filter_map(|face| {
            let own = self.corners()[face as usize];
            let [a, b, c] = own.map(|p| p.coords);
            let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
            let place = self.find_near(&low, &high, |other| {
                let other = &self.corners()[other as usize];
                cut(&own, other).or_else(|| cut(other, &own))
            })?;
            Some(SelfCrossing { face: face as usize, place })
        });
        found.collect()
    }
}

/// Where an edge of the triangle `a` goes through the triangle `b`.
fn cut(a: &[Point3<f64>; 3], b: &[Point3<f64>; 3]) -> Option<Point3<f64>> {
    (0..3).find_map(|k| {
        let [start, end] = [a[k], a[(k + 1) % 3]];
        if b.contains(&start) || b.contains(&end) {
            return None;
        }
        let [over, under] = [start, end].map(|p| side(b, &p));
        let part = over / (over - under);
        if over.min(under) >= 0.0 || over.max(under) <= 0.0 || !part.is_finite() {
            return None;
        }
        let around = [0, 1, 2].map(|i| side(&[start, end, b[i]], &b[(i + 1) % 3]));
        let meets = around.iter().all(|s| *s >= 0.0) || around.iter().all(|s| *s <= 0.0);
        meets.then(|| start + (end - start) * part)
    })
}

/// Six times the volume of the tetrahedron of a triangle and a point, m³, of the exact sign.
fn side(triangle: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    let [a, b, c, d] =
        [triangle[0], triangle[1], triangle[2], *point].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Soup, shapes};
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn crossed(soup: &Soup) -> Vec<SelfCrossing> {
        SurfaceTree::new(soup).expect("a surface").crossings()
    }

    /// Two surfaces as one, the second moved.
    fn both(mut a: Soup, b: &Soup, by: Vector3<f64>) -> Soup {
        let count = index(a.vertices.len());
        a.vertices.extend(b.vertices.iter().map(|p| p + by));
        a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + count)));
        a
    }

    #[test]
    fn surfaces_of_solids_cut_nothing() {
        let flat = shapes::cuboid(Vector3::new(1.0, 0.1, 0.3));
        for soup in [shapes::sphere(0.7, 9), shapes::torus(3.0, 1.0, [9, 7]), flat] {
            assert_eq!(crossed(&soup), []);
        }
    }

    /// A corner of a box in the side of another: three edges go through it.
    #[test]
    fn the_places_lie_on_both() {
        let cube = shapes::cuboid(Vector3::repeat(1.0));
        let soup = both(cube.clone(), &cube, Vector3::new(1.9, 1.1, 1.3));
        let found = crossed(&soup);
        assert!(!found.is_empty() && found.iter().any(|c| c.face >= 12));
        for SelfCrossing { place, .. } in found {
            let on = |middle: Vector3<f64>| ((place.coords - middle).amax() - 1.0).abs() < 1e-14;
            assert!(on(Vector3::zeros()) && on(Vector3::new(1.9, 1.1, 1.3)), "{place}");
        }
    }

    proptest! {
        /// Two balls cut each other if their surfaces meet, and not if they are apart or one is in
        /// the other.
        #[test]
        fn balls_cut_where_they_meet(
            radius in 0.2..2.0_f64,
            direction in prop::array::uniform3(-1.0..1.0_f64),
            distance in 0.0..4.0_f64,
        ) {
            let Some(direction) = Vector3::from(direction).try_normalize(0.1) else { return Ok(()) };
            let (one, other) = (shapes::sphere(1.0, 8), shapes::sphere(radius, 8));
            let soup = both(one, &other, direction * distance);
            let found = !crossed(&soup).is_empty();
            // A triangulated ball lies between its own and 0.95 of its radius.
            let thick = 0.05 * (1.0 + radius);
            let apart = distance > 1.0 + radius || distance < (1.0 - radius).abs() - thick;
            let meets = distance < 1.0 + radius - thick && distance > (1.0 - radius).abs() + thick;
            prop_assert!(!(apart && found) && (!meets || found), "{distance} {radius}");
        }

        /// Any soup has an answer, also one of triangles without area.
        #[test]
        fn any_triangles_are_judged(
            corners in prop::collection::vec(prop::array::uniform3(-2..2_i8), 3..30),
        ) {
            let vertices = corners.iter().map(|p| Point3::from(p.map(f64::from))).collect();
            let triangles = (0..index(corners.len() / 3)).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
            let soup = Soup { vertices, triangles: triangles.collect() };
            for SelfCrossing { place, .. } in crossed(&soup) {
                prop_assert!(place.iter().all(|x| x.abs() <= 2.0));
            }
        }
    }
}
