//! Meshes of simple shapes around the origin.

use super::Soup;
use super::mesh::index;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// A box with faces normal to the axes and sides of twice `half`, m; 12 triangles.
#[must_use]
pub fn cuboid(half: Vector3<f64>) -> Soup {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let corner =
        |k: usize| Vector3::new(sign(k & 1), sign(k & 2), sign(k & 4)).component_mul(&half);
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Soup { vertices: (0..8).map(|k| corner(k).into()).collect(), triangles }
}

/// A sphere, m: an octahedron with every face cut into `n²` triangles, at least one, all vertices
/// on the sphere.
#[must_use]
pub fn sphere(radius: f64, n: i32) -> Soup {
    let n = n.max(1);
    let mut soup = Soup::default();
    let mut known = BTreeMap::new();
    for signs in (0..8).map(|k| [1 - 2 * (k & 1), 1 - (k & 2), 1 - (k & 4) / 2]) {
        let mut vertex = |i: i32, j: i32| {
            let key = [signs[0] * i, signs[1] * j, signs[2] * (n - i - j)];
            *known.entry(key).or_insert_with(|| {
                let direction = Vector3::from(key.map(f64::from)).normalize();
                soup.vertices.push((radius * direction).into());
                index(soup.vertices.len() - 1)
            })
        };
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            let [a, b, c] = [vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)];
            let mut triangles = vec![[a, b, c]];
            if i + j + 1 < n {
                triangles.push([b, vertex(i + 1, j + 1), c]);
            }
            // In a mirrored octant the order is reversed.
            let mirrored = signs.iter().product::<i32>() < 0;
            let turn = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
            soup.triangles.extend(triangles.into_iter().map(turn));
        }
    }
    soup
}

/// A torus around the z axis: a circle of radius `tube`, m, led around one of radius `ring`, m,
/// with `around` vertices on the ring and `along` on the tube, each at least three.
#[must_use]
pub fn torus(ring: f64, tube: f64, [around, along]: [u32; 2]) -> Soup {
    let (around, along) = (around.max(3), along.max(3));
    let angle = |k: u32, of: u32| TAU * f64::from(k) / f64::from(of);
    let vertex = |i: u32, j: u32| {
        let ((sin, cos), (s, c)) = (angle(i, around).sin_cos(), angle(j, along).sin_cos());
        Point3::new((ring + tube * c) * cos, (ring + tube * c) * sin, tube * s)
    };
    let index = |i: u32, j: u32| i % around * along + j % along;
    let quad = |i: u32, j: u32| {
        let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let places = |(i, j): &(u32, u32)| vertex(*i, *j);
    let all: Vec<_> = (0..around).flat_map(|i| (0..along).map(move |j| (i, j))).collect();
    Soup {
        vertices: all.iter().map(places).collect(),
        triangles: all.iter().flat_map(|&(i, j)| quad(i, j)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Mesh;
    use std::f64::consts::PI;

    #[test]
    fn the_shapes_are_solids_of_about_the_right_volume() {
        let sphere = Mesh::new(sphere(2.0, 20)).expect("a solid");
        assert_eq!((sphere.vertices().len(), sphere.triangles().len()), (1602, 3200));
        assert!((sphere.volume() / (32.0 / 3.0 * PI) - 1.0).abs() < 0.01);
        let torus = Mesh::new(torus(3.0, 1.0, [60, 40])).expect("a solid");
        assert!((torus.volume() / (6.0 * PI * PI) - 1.0).abs() < 0.01);
        assert!(Mesh::new(super::sphere(1.0, 1)).is_ok());
        assert!(Mesh::new(super::torus(3.0, 1.0, [3, 3])).is_ok());
    }
}
