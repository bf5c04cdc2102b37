//! A head and its hair out of one surface.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::field::{DistanceField, Mesh, MeshDistance, Soup, shapes};
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::fit::{FitOptions, HeadTemplate, Similarity, fit};
use rapunzel_hairgen::head::{HairVolume, Hairline, HeadMeasures, ParametricHead};

fn head() -> ParametricHead {
    ParametricHead::new(HeadMeasures::default(), Hairline::default()).expect("a head")
}

fn moved(soup: &Soup, by: &Similarity) -> Soup {
    let vertices = soup.vertices.iter().map(|p| by.apply(p)).collect();
    Soup { vertices, triangles: soup.triangles.clone() }
}

proptest! {
    /// Pairs that are moved by a similarity give it back, also those of a plane.
    #[test]
    fn a_similarity_is_found_again(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..20),
        flat in any::<bool>(),
        angles in prop::array::uniform3(-3.0..3.0_f64),
        scale in 0.1..10.0_f64,
    ) {
        let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let exact = Similarity { scale, rotation, translation: Vector3::new(0.3, -0.2, 0.7) };
        let points = points.iter().map(|&p| Point3::from(p));
        let points: Vec<_> = points.map(|p| if flat { Point3::new(p.x, p.y, 0.0) } else { p }).collect();
        // Points near a line do not tell the rotation about it.
        let a = points[1] - points[0];
        prop_assume!(points.iter().any(|p| a.cross(&(p - points[0])).norm() > 0.1));
        let pairs: Vec<_> = points.iter().map(|p| [*p, exact.apply(p)]).collect();
        let found = Similarity::between(&pairs).expect("no line");
        for p in &points {
            prop_assert!((found.apply(p) - exact.apply(p)).norm() < 1e-9 * scale);
        }
        prop_assert!((found.rotation.matrix().determinant() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn points_on_a_line_are_no_face() {
    let pairs: Vec<_> = (0..5).map(|i| [Point3::new(f64::from(i), 0.0, 0.0); 2]).collect();
    assert_eq!(Similarity::between(&pairs), None);
}

/// A head with an afro, turned, grown and in millimeters, is taken apart again.
#[test]
fn a_head_is_found_under_its_hair() {
    let head = head();
    let by = Similarity {
        scale: 1080.0,
        rotation: Rotation3::from_euler_angles(0.06, -0.1, 0.05),
        translation: Vector3::new(12.0, -30.0, 25.0),
    };
    let scan =
        Mesh::new(moved(&head.hull(&HairVolume::AFRO).expect("a hull"), &by)).expect("solid");
    let fitted = fit(&scan, &HeadTemplate::from(&head), &FitOptions::default()).expect("a head");
    assert_eq!(fitted.report.meters_per_unit, 1e-3);
    assert!(fitted.report.rms < 1e-3, "{}", fitted.report);
    assert!((fitted.report.similarity.scale - 1.08).abs() < 0.01, "{}", fitted.report);
    // The skull is where it was, though nothing of it is seen: the template is the head itself.
    let meters = Similarity { scale: by.scale * 1e-3, translation: by.translation * 1e-3, ..by };
    let truth = Mesh::new(moved(&head.mesh(), &meters)).expect("a solid");
    let truth = MeshDistance::new(&truth);
    for p in &fitted.scalp.vertices {
        assert!(truth.value(p).abs() < 4e-3, "{} m", truth.value(p));
    }
    // All of the skull lies under the hair.
    let hull = MeshDistance::new(&fitted.hull);
    let bald = MeshDistance::new(&Mesh::new(fitted.head).expect("a solid"));
    assert!(fitted.scalp.vertices.iter().all(|p| hull.value(p) < 0.0));
    // The surface of the hair is the scan where it is away from the head.
    assert!(fitted.hair_surface.triangles.len() > 5000);
    for p in &fitted.hair_surface.vertices {
        assert!(hull.value(p).abs() < 1e-12);
    }
    for triangle in &fitted.hair_surface.triangles {
        let corners = triangle.map(|v| fitted.hair_surface.vertices[v as usize].coords);
        let middle = Point3::from((corners[0] + corners[1] + corners[2]) / 3.0);
        assert!(bald.value(&middle) > FitOptions::default().threshold);
    }
}

#[test]
fn what_is_no_head_is_refused() {
    let template = HeadTemplate::from(&head());
    let options = FitOptions::default();
    let dust = Mesh::new(shapes::sphere(1e-6, 6)).expect("a ball");
    assert!(matches!(fit(&dust, &template, &options), Err(HairgenError::Units { .. })));
    let plate = Mesh::new(shapes::cuboid(Vector3::new(0.5, 0.002, 0.5))).expect("a plate");
    let refused = fit(&plate, &template, &options).expect_err("no face");
    assert!(matches!(refused, HairgenError::NoFace { .. }), "{refused}");
}
