//! Distances along the surface.

use super::{cap, cloth, mesh, scan};
use nalgebra::Point3;
use proptest::prelude::*;
use rapunzel_hairgen::growth::{ScalpMesh, geodesic_distances, surface_gradient};
use std::f64::consts::FRAC_PI_2;

/// Largest error on a half sphere of radius 1 from a point at an angle from the pole, in the inner
/// half, where shortest ways do not touch the border.
fn error(rings: u32, angle: f64) -> f64 {
    let scalp = mesh(cap(1.0, FRAC_PI_2, 4 * rings, rings));
    let source = scalp.nearest(&Point3::new(angle.sin(), angle.cos(), 0.0));
    let from = scalp.position(&source).coords.normalize();
    let distances = geodesic_distances(&scalp, &source);
    let inner = scalp.vertices().iter().zip(distances).filter(|(p, _)| p.y > 0.1);
    inner.map(|(p, d)| (d - from.angle(&p.coords)).abs()).fold(0.0, f64::max)
}

#[test]
fn distances_on_a_sphere_converge() {
    for angle in [0.0, 0.4, 1.0] {
        let errors = [8, 16, 32].map(|rings| error(rings, angle));
        println!("from {angle}: {errors:?}");
        assert!(errors[0] < 0.06, "{errors:?}");
        assert!(errors.windows(2).all(|two| two[1] < 0.6 * two[0]), "{errors:?}");
    }
}

fn check_gradient(scalp: &ScalpMesh) {
    let source = scalp.vertex(0);
    let distances = geodesic_distances(scalp, &source);
    let gradient = surface_gradient(scalp, &distances);
    let lengths = gradient.iter().zip(scalp.normals()).map(|(g, n)| {
        assert!(g.dot(n).abs() < 1e-12);
        g.norm()
    });
    let mean = lengths.sum::<f64>() / distances.len() as f64;
    assert!((0.9..1.01).contains(&mean), "{mean}");
}

#[test]
fn the_gradient_of_a_distance_is_about_one() {
    check_gradient(&mesh(cap(0.1, FRAC_PI_2, 40, 20)));
    if let Some(scalp) = scan("head/scalp.ply") {
        check_gradient(&scalp);
    }
}

#[test]
fn the_gradient_of_a_linear_function_is_exact() {
    let scalp = mesh(super::flat(9, 4));
    let values: Vec<f64> = scalp.vertices().iter().map(|p| 3.0 * p.x - 2.0 * p.z + 1.0).collect();
    for gradient in surface_gradient(&scalp, &values) {
        assert!((gradient - nalgebra::Vector3::new(3.0, 0.0, -2.0)).norm() < 1e-13);
    }
}

proptest! {
    /// On a flat convex mesh all ways are straight; obtuse triangles are there too.
    #[test]
    fn distances_are_exact_where_it_is_flat(
        cloth in cloth(0.0),
        place in prop::array::uniform2(-1.0..10.0_f64),
    ) {
        let scalp = mesh(cloth.soup());
        let source = scalp.nearest(&Point3::new(place[0], 0.0, -place[1]));
        let from = scalp.position(&source);
        let distances = geodesic_distances(&scalp, &source);
        for (p, distance) in scalp.vertices().iter().zip(distances) {
            let expected = (p - from).norm();
            prop_assert!((distance - expected).abs() < 1e-9, "{distance} for {expected}");
        }
    }

    /// Never shorter than the straight way in space, never longer than along edges.
    #[test]
    fn distances_are_between_space_and_edges(cloth in cloth(2.0)) {
        let scalp = mesh(cloth.soup());
        let source = scalp.vertex(0);
        let from = scalp.position(&source);
        let distances = geodesic_distances(&scalp, &source);
        for (p, &distance) in scalp.vertices().iter().zip(&distances) {
            prop_assert!(distance.is_finite());
            prop_assert!(distance >= (p - from).norm() * (1.0 - 1e-9));
        }
        for &[a, b, c] in scalp.triangles() {
            for [a, b] in [[a, b], [b, c], [c, a]] {
                let [p, q] = [a, b].map(|v| scalp.vertices()[v as usize]);
                let jump = (distances[a as usize] - distances[b as usize]).abs();
                prop_assert!(jump <= (p - q).norm() * (1.0 + 1e-9));
            }
        }
    }
}
