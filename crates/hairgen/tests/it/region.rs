//! The region between a head and a surface of hair.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::field::{Ball, DistanceField, Mesh, MeshDistance, Soup, shapes};
use rapunzel_hairgen::{FieldResolution, HairgenError, Region, SurfaceField};

fn ball(radius: f64) -> Ball {
    Ball { center: Point3::origin(), radius }
}

proptest! {
    /// Between two balls the depth is known, and its gradient is its slope.
    #[test]
    fn the_depth_between_balls_is_that_of_the_radius(
        direction in prop::array::uniform3(-1.0..1.0_f64), radius in 0.05..0.15_f64,
    ) {
        let (head, hull) = (ball(0.08), ball(0.12));
        let region = Region { head: &head, hull: &hull };
        let direction = Vector3::from(direction);
        prop_assume!(direction.norm() > 0.1);
        let point = Point3::from(direction.normalize() * radius);
        let exact = ((radius - 0.08) / 0.04).clamp(0.0, 1.0);
        let depth = region.depth(&point);
        prop_assert!((depth.value - exact).abs() < 1e-12);
        let slope = if (0.08..0.12).contains(&radius) { 1.0 / 0.04 } else { 0.0 };
        prop_assert!((depth.gradient - direction.normalize() * slope).norm() < 1e-9);
        let clearance = region.clearance(&point);
        prop_assert!((clearance.value - (radius - 0.08).min(0.12 - radius)).abs() < 1e-12);
    }
}

/// The stored field against the exact distance: near the surface to the bound of the fine grid, far
/// from it to that of the coarse one.
#[test]
fn a_field_is_near_and_far_as_the_surface_tells() {
    let mesh = Mesh::new(shapes::sphere(0.09, 40)).expect("a ball");
    let exact = MeshDistance::new(&mesh);
    let resolution = FieldResolution::default();
    let field = SurfaceField::solid("the ball", &mesh, resolution).expect("a field");
    for k in 0..4000_u32 {
        let p = Point3::from(Vector3::from_fn(|i, _| {
            0.12 * (f64::from(k) * [0.71, 1.13, 1.97][i]).sin()
        }));
        let (value, distance) = (field.value(&p), exact.value(&p));
        if distance.abs() > 0.9 * field.band() {
            continue;
        }
        // `h^2 / (4 R)` with the smallest radius of a level surface within the band.
        let far = distance.abs() > 0.5 * resolution.band - 1e-3;
        let (h, radius) = if far { (8e-3, 0.05) } else { (1e-3, 0.08) };
        let facets = 0.05e-3;
        assert!(
            (value - distance).abs() < h * h / (4.0 * radius) + facets,
            "{p}: {value} {distance}"
        );
        // The gradient is the slope of what is stored.
        let slope = Vector3::from_fn(|i, _| {
            let step = Vector3::ith(i, 1e-7);
            (field.value(&(p + step)) - field.value(&(p - step))) / 2e-7
        });
        let gradient = field.sample(&p).gradient;
        // But for the kinks between cells.
        assert!((slope - gradient).norm() < 0.1, "{p}: {slope} {gradient}");
    }
}

#[test]
fn an_open_surface_is_a_shell() {
    let mut cap = shapes::sphere(0.09, 16);
    cap.triangles.retain(|t| t.iter().all(|&v| cap.vertices[v as usize].y > 0.0));
    let shell = SurfaceField::shell("the cap", &cap, 2e-3, FieldResolution::default());
    let shell = shell.expect("a shell");
    let top = |y: f64| shell.value(&Point3::new(0.0, y, 0.0));
    for off in [-0.02, -0.003, 0.003, 0.02] {
        assert!(
            (top(0.09 + off) - (f64::abs(off) - 1e-3)).abs() < 0.3e-3,
            "{off}: {}",
            top(0.09 + off)
        );
    }
    assert!(top(0.09) < 0.0);
}

#[test]
fn what_is_no_surface_is_refused_by_name() {
    let nothing = Soup::default();
    let refused = SurfaceField::mended("the hull", nothing.clone(), FieldResolution::default());
    let refused = refused.expect_err("no triangles");
    assert!(matches!(refused, HairgenError::Surface { what: "the hull", .. }));
    assert!(refused.to_string().starts_with("the hull: the mesh has no triangles"));
    SurfaceField::shell("the hull", &nothing, 1e-3, FieldResolution::default()).expect_err("none");
    let mesh = Mesh::new(shapes::sphere(0.09, 8)).expect("a ball");
    let narrow = FieldResolution { band: 1e-3, ..FieldResolution::default() };
    SurfaceField::solid("the head", &mesh, narrow).expect_err("less than two spacings");
}
