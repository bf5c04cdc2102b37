//! Scanned meshes against the distance to every triangle.

use crate::geometry::random::Random;
use crate::geometry::triangle::to_triangle;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{DistanceField, Grid, Mesh, shapes};

/// Distance of a point to a mesh.
pub(crate) fn distance(mesh: &Mesh, p: &Point3<f64>) -> f64 {
    let to = |t: &[u32; 3]| to_triangle(p, t.map(|v| mesh.vertices()[v as usize]));
    mesh.triangles().iter().map(to).fold(f64::INFINITY, f64::min)
}

/// How often a mesh winds around a point, by the solid angles of its triangles.
pub(crate) fn winding(mesh: &Mesh, p: &Point3<f64>) -> f64 {
    let solid = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices()[v as usize] - p);
        let (x, y, z) = (a.norm(), b.norm(), c.norm());
        let over = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        2.0 * a.dot(&b.cross(&c)).atan2(over)
    };
    mesh.triangles().iter().map(solid).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Compares a grid at its nodes, where it does not interpolate.
fn check(mesh: &Mesh, spacing: f64, band: f64) {
    let grid = Grid::scan(mesh, spacing, band).expect("a grid");
    let low = mesh.bounds()[0] - Vector3::repeat(band + spacing);
    let size = mesh.bounds()[1] - low;
    let along = |k: usize| {
        let count = size[k] / spacing + 6.0;
        (0..).map(f64::from).take_while(move |&i: &f64| i <= count)
    };
    let mut near = 0;
    for (i, j, k) in
        along(0).flat_map(|i| along(1).flat_map(move |j| along(2).map(move |k| (i, j, k))))
    {
        let p = low + spacing * Vector3::new(i, j, k);
        let distance = distance(mesh, &p);
        let value = grid.value(&p);
        let expected = distance.min(band);
        if distance < band || value < band {
            // Single precision, and the rounding of the place in the lattice.
            assert!((value.abs() - expected).abs() <= 1e-6 * band, "{value} for {distance} at {p}");
            near += 1;
        }
        if distance > 1e-9 {
            let inside = winding(mesh, &p) > 0.5;
            assert_eq!(value < 0.0, inside, "{value} at {p}");
        }
    }
    assert!(near > 100);
}

/// A mesh whose vertices are moved at random, by so little that it does not cut itself.
fn shaken(mut soup: rapunzel_collision::field::Soup, size: f64, seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    for vertex in &mut soup.vertices {
        *vertex += random.vector(size);
    }
    Mesh::new(soup).expect("a mesh")
}

#[test]
fn a_box_is_exact() {
    check(&Mesh::new(shapes::cuboid(Vector3::new(0.5, 0.4, 0.3))).expect("valid"), 0.093, 0.25);
    check(&Mesh::new(shapes::cuboid(Vector3::new(0.5, 0.5, 0.5))).expect("valid"), 0.125, 0.25);
}

#[test]
fn a_torus_with_saddles_is_exact() {
    check(&Mesh::new(shapes::torus(1.0, 0.4, [9, 7])).expect("valid"), 0.1, 0.35);
}

#[test]
fn shaken_meshes_are_exact() {
    for seed in 0..2 {
        check(&shaken(shapes::sphere(1.0, 3), 0.12, seed), 0.13, 0.4);
        check(&shaken(shapes::torus(1.0, 0.4, [9, 7]), 0.08, seed), 0.11, 0.3);
    }
}

#[test]
fn meshes_finer_than_the_lattice_are_exact() {
    check(&shaken(shapes::sphere(1.0, 12), 0.01, 9), 0.2, 0.41);
}

/// A box with a notch that reaches its middle: concave edges and a saddle.
#[test]
fn a_mesh_with_a_notch_is_exact() {
    let mut soup = shapes::sphere(1.0, 4);
    for vertex in &mut soup.vertices {
        if vertex.z > 0.6 {
            vertex.z -= 1.1;
        }
    }
    check(&Mesh::new(soup).expect("a mesh"), 0.09, 0.3);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = shaken(shapes::torus(1.0, 0.4, [30, 20]), 0.01, 5);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| Grid::scan(&mesh, 0.05, 0.2).expect("a grid"))
    };
    assert!(with(1) == with(3));
}

#[test]
fn a_box_that_does_not_hold_the_mesh_is_refused() {
    let mesh = Mesh::new(shapes::cuboid(Vector3::repeat(0.5))).expect("valid");
    let frame = |half: f64| {
        let corner = Point3::from(Vector3::repeat(half));
        rapunzel_collision::field::GridFrame::new(-corner, corner, 0.05).expect("a lattice")
    };
    assert!(Grid::scan_in(&mesh, frame(0.6), 0.2).is_err());
    assert!(Grid::scan_in(&mesh, frame(0.71), 0.2).is_ok());
    assert!(Grid::scan_in(&mesh, frame(0.71), 0.05).is_err());
}
