//! Directions of growth and heights.

use super::{cap, flat, mesh, scan};
use nalgebra::{Point2, Point3, Vector3};
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::growth::{
    DiscField, GrowthFlow, GrowthOptions, GrowthRegion, ScalpMesh, Whorl,
};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

fn region(scalp: ScalpMesh, flow: GrowthFlow, tilt: Option<f64>) -> GrowthRegion {
    let density = DiscField::Constant(2000.0 / scalp.area());
    let tilt = tilt.map(DiscField::Constant);
    let options = GrowthOptions { density, flow, tilt, ..Default::default() };
    GrowthRegion::new(scalp, options).expect("a region")
}

#[test]
fn hair_lies_flat_at_temples_and_neck_and_stands_at_the_top() {
    let Some(scalp) = scan("head/scalp.ply") else { return };
    let region = region(scalp, GrowthFlow::Whorl(Whorl::default()), None);
    let crown = region.mesh().position(&region.crown());
    println!("crown at {crown:.3}");
    assert!(crown.y > 0.03 && crown.z < -0.03 && crown.x.abs() < 0.02);
    for pore in region.pores(2000, 1).expect("pores") {
        let tilt = pore.direction.angle(&pore.normal);
        if pore.position.y > 0.1 {
            assert!(tilt < 0.25 * PI, "{tilt} at {}", pore.position);
        } else if pore.position.y < -0.04 {
            assert!(tilt > 0.38 * PI, "{tilt} at {}", pore.position);
        }
    }
    // At the neck it grows down, at the forehead to the front.
    let at = |x, y, z| region.pore_near(&Point3::new(x, y, z)).expect("a pore").direction;
    assert!(at(0.0, -0.1, -0.1).y < -0.5);
    assert!(at(0.0, 0.1, 0.2).z > 0.5);
    assert!(at(0.1, 0.0, 0.0).x > 0.1 && at(-0.1, 0.0, 0.0).x < -0.1);
    let height = |x, y, z| {
        let point = region.mesh().nearest(&Point3::new(x, y, z));
        region.geodesic_height(&region.map().place(&point))
    };
    let [neck, top, front] =
        [height(0.0, -0.2, -0.1), height(0.0, 0.2, 0.0), height(0.0, 0.1, 0.2)];
    assert!(neck < 0.2 && neck < top && top < front && front > 0.8, "{neck} {top} {front}");
}

/// On a half sphere with the whorl at its pole all is known.
#[test]
fn a_whorl_turns_by_its_angle() {
    let whorl = Whorl { place: Some(Point2::origin()), turn: 1.0, reach: 0.05 };
    let region = region(mesh(cap(0.1, FRAC_PI_2, 80, 40)), GrowthFlow::Whorl(whorl), Some(0.7));
    assert!(region.mesh().position(&region.crown()).y > 0.0999);
    let mut checked = 0;
    for pore in region.pores(500, 1).expect("pores") {
        let (p, normal) = (pore.position.coords, pore.normal);
        assert!((pore.direction.angle(&normal) - 0.7).abs() < 1e-9);
        if p.y > 0.09 || p.y < 0.01 {
            continue;
        }
        checked += 1;
        let distance = 0.1 * p.angle(&Vector3::y());
        let away = (p * p.y - Vector3::y() * p.norm_squared()).normalize();
        let level = pore.direction.into_inner() - 0.7_f64.cos() * normal.into_inner();
        // Counter-clockwise from outside, from straight away.
        let turn = away.cross(&level).dot(&normal).atan2(away.dot(&level));
        let expected = (-distance / 0.05).exp();
        assert!((turn - expected).abs() < 0.03, "{turn} for {expected}");
    }
    assert!(checked > 300);
}

#[test]
fn angles_in_the_disc_are_directions_on_the_surface() {
    // Seen from above x is to the right, z down.
    for angle in [0.0_f64, 1.0, 3.0, -2.0] {
        let flow = GrowthFlow::Angle(DiscField::Constant(angle));
        let region = region(mesh(flat(24, 5)), flow, Some(FRAC_PI_4));
        let expected = Vector3::new(angle.cos(), 1.0, -angle.sin()).normalize();
        for pore in region.pores(20, 1).expect("pores") {
            assert!((pore.direction.into_inner() - expected).norm() < 1e-9);
        }
    }
}

#[test]
fn bad_whorls_tilts_and_angles_are_told() {
    let refused = |whorl| {
        let options = GrowthOptions { flow: GrowthFlow::Whorl(whorl), ..Default::default() };
        GrowthRegion::new(mesh(flat(8, 2)), options).expect_err("refused")
    };
    let whorl = Whorl::default();
    for reach in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(Whorl { reach, ..whorl }), HairgenError::Whorl { .. }));
    }
    assert!(matches!(refused(Whorl { turn: f64::NAN, ..whorl }), HairgenError::Whorl { .. }));
    let place = Some(Point2::new(f64::NAN, 0.0));
    assert!(matches!(refused(Whorl { place, ..whorl }), HairgenError::Place { .. }));
    for tilt in [-0.1, 1.6, f64::NAN] {
        let region = region(mesh(flat(8, 2)), GrowthFlow::Whorl(whorl), Some(tilt));
        let error = region.pores(5, 1).expect_err("refused");
        assert!(matches!(error, HairgenError::DiscValue { .. }), "{error}");
    }
    let angle = GrowthFlow::Angle(DiscField::function(|_| f64::NAN));
    let error = region(mesh(flat(8, 2)), angle, None).pores(5, 1).expect_err("refused");
    assert!(matches!(error, HairgenError::DiscValue { .. }), "{error}");
}

#[test]
fn a_head_in_millimeters_is_told() {
    let mut soup = cap(0.1, FRAC_PI_2, 12, 4);
    soup.vertices.iter_mut().for_each(|p| *p *= 1e3);
    let error = GrowthRegion::new(mesh(soup), GrowthOptions::default()).expect_err("refused");
    assert!(matches!(error, HairgenError::Size { .. }), "{error}");
    assert!(error.to_string().contains("millimeters"));
}

/// On what is flat there is no height, and the crown is the first vertex that is farthest back.
#[test]
fn a_flat_scalp_has_directions_too() {
    let region = region(mesh(flat(12, 3)), GrowthFlow::Whorl(Whorl::default()), None);
    for pore in region.pores(200, 1).expect("pores") {
        assert!(pore.direction.iter().all(|x| x.is_finite()) && pore.direction.y > 0.1);
    }
    let height = region.geodesic_height(&Point2::new(0.2, 0.3));
    assert!((0.0..=1.0).contains(&height));
}
