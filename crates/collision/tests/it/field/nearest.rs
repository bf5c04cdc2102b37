//! Exact distances through the hierarchy of triangles, against closed forms and all triangles.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{
    Cuboid, DistanceField, Grid, Mesh, MeshDistance, Shell, Soup, SurfaceTree, shapes,
};

fn point() -> impl Strategy<Value = Point3<f64>> {
    // Whole numbers hit corners, edges and symmetries.
    let x = prop_oneof![(-3..=3_i8).prop_map(f64::from), -3.0..3.0_f64];
    prop::array::uniform3(x).prop_map(Point3::from)
}

fn soup() -> impl Strategy<Value = Soup> {
    let triangle = prop::array::uniform3(point());
    prop::collection::vec(triangle, 1..40).prop_map(|triangles| Soup {
        vertices: triangles.iter().flatten().copied().collect(),
        triangles: (0_u32..).step_by(3).take(triangles.len()).map(|i| [i, i + 1, i + 2]).collect(),
    })
}

proptest! {
    /// The hierarchy finds what each triangle alone says, triangles of no area among them.
    #[test]
    fn the_nearest_point_is_the_least_of_all_triangles(soup in soup(), p in point()) {
        let found = SurfaceTree::new(&soup).expect("triangles").nearest(&p);
        let alone = soup.triangles.iter().map(|&triangle| {
            let one = Soup { vertices: soup.vertices.clone(), triangles: vec![triangle] };
            SurfaceTree::new(&one).expect("a triangle").nearest(&p).distance
        });
        prop_assert_eq!(found.distance, alone.fold(f64::INFINITY, f64::min));
        let corners = soup.triangles[found.face].map(|v| soup.vertices[v as usize].coords);
        let place: Vector3<f64> = (0..3).map(|k| found.weights[k] * corners[k]).sum();
        prop_assert!((place - found.point.coords).norm() <= 1e-12);
        prop_assert!(((p - found.point).norm() - found.distance).abs() <= 1e-12);
    }

    /// A box has faces, edges and corners, at all of which the side is right.
    #[test]
    fn a_box_is_as_far_as_its_closed_form(p in point()) {
        let half = Vector3::new(1.0, 0.5, 2.0);
        let mesh = Mesh::new(shapes::cuboid(half)).expect("a box");
        let exact = Cuboid { half };
        let distance = MeshDistance::new(&mesh);
        prop_assert!((distance.value(&p) - exact.value(&p)).abs() <= 1e-14);
        // Away from the surface, where rounding decides, inside is wound around once.
        if exact.value(&p).abs() > 1e-9 {
            let inside = if exact.value(&p) < 0.0 { 1.0 } else { 0.0 };
            prop_assert!((distance.tree().winding_number(&p) - inside).abs() <= 1e-12);
        }
    }
}

#[test]
fn the_gradient_is_the_way_from_the_surface() {
    let mesh = Mesh::new(shapes::sphere(0.05, 12)).expect("a ball");
    let distance = MeshDistance::new(&mesh);
    for p in [Point3::new(0.06, 0.01, 0.0), Point3::new(0.0113, -0.0217, 0.0291)] {
        let sample = distance.sample(&p);
        let h = 1e-7;
        let slope = Vector3::from_fn(|k, _| {
            let step = Vector3::ith(k, h);
            (distance.value(&(p + step)) - distance.value(&(p - step))) / (2.0 * h)
        });
        // The second derivative is at most the curvature of the level surface.
        assert!((slope - sample.gradient).norm() < 1e-6, "{p}: {slope}");
    }
    let nowhere = distance.sample(&Point3::new(f64::NAN, 0.0, 0.0));
    assert!(nowhere.value.is_infinite() && nowhere.gradient == Vector3::zeros());
    // At a corner there is no one gradient: it is the normal of the corner.
    let corner = mesh.vertices()[17];
    let sample = distance.sample(&corner);
    assert!(sample.value == 0.0 && sample.gradient.dot(&corner.coords.normalize()) > 0.99);
}

/// Sampling skips blocks by their centers; scanning visits features: the same grid but for the
/// rounding of single precision.
#[test]
fn sampling_the_distance_is_scanning_the_mesh() {
    let mesh = Mesh::new(shapes::sphere(0.05, 12)).expect("a ball");
    let scanned = Grid::scan(&mesh, 2e-3, 8e-3).expect("a grid");
    let frame = rapunzel_collision::field::GridFrame::new(
        Point3::from(Vector3::repeat(-0.06)),
        Point3::from(Vector3::repeat(0.06)),
        2e-3,
    );
    let sampled =
        Grid::sample(&MeshDistance::new(&mesh), frame.expect("a frame"), 8e-3).expect("a grid");
    for k in 0..200_u32 {
        let p = Point3::from(Vector3::from_fn(|i, _| {
            0.055 * (f64::from(k) * [0.7, 1.1, 1.9][i]).sin()
        }));
        let bound = 2e-3 * 2e-3 / (4.0 * 0.02);
        assert!((scanned.value(&p) - sampled.value(&p)).abs() < bound, "{p}");
    }
}

#[test]
fn a_shell_has_a_thickness_and_no_inside() {
    let open = Soup {
        vertices: vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2]],
    };
    let shell = Shell::new(&open, 0.2).expect("a shell");
    for side in [1.0, -1.0] {
        let sample = shell.sample(&Point3::new(0.2, 0.2, 0.5 * side));
        assert!((sample.value - 0.4).abs() < 1e-15 && sample.gradient.z == side);
    }
    assert!((shell.value(&Point3::new(0.2, 0.2, 0.0)) + 0.1).abs() < 1e-15);
    let refused = Shell::new(&open, f64::NAN).expect_err("no thickness");
    assert!(matches!(refused, CollisionError::Length { .. }));
}
