use crate::common::{Random, circle, polygon};
use nalgebra::{Vector2, Vector3};
use rapunzel_contact::{LimitCurve, Polygon};
use std::f64::consts::TAU;

fn direction(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// The projection `x` of `p` onto a convex set is the point of the set at which `p - x` is an
/// outward normal, which says that the support in that direction is at `x`.
#[test]
fn projections_are_the_nearest_points() {
    let mut random = Random(1);
    for trial in 0..40_000 {
        let curve = random.curve(trial, 2.0);
        let scale = 10.0_f64.powf(4.0 * random.signed());
        let p = Vector2::new(random.signed(), random.signed())
            * (scale * 10.0_f64.powf(3.0 * random.signed()));
        let x = curve.project(&p, scale);
        let size = p.norm().max(scale);
        let again = curve.project(&x, scale);
        assert!((again - x).norm() <= 1e-14 * size, "{curve:?} {p} {x} {again}");
        let outward = p - x;
        let support = -curve.friction(&-outward).dot(&-outward);
        let excess = scale * support - outward.dot(&x);
        assert!(excess.abs() <= 1e-14 * size * size, "{trial} {curve:?} {scale} {p} {x}: {excess}");
        if curve.contains(&p, scale * (1.0 - 1e-14)) {
            assert!(outward.norm() <= 1e-15 * size);
        }
    }
}

#[test]
fn the_gauge_is_one_on_the_curve() {
    let mut random = Random(2);
    for trial in 0..4000 {
        let curve = random.curve(trial, 5.0);
        let slip = direction(TAU * random.unit());
        let friction = curve.friction(&slip);
        assert!(friction.norm() == 0.0 || (curve.gauge(&friction) - 1.0).abs() < 1e-12);
        assert!(curve.dissipation(&slip) >= 0.0);
        assert_eq!(curve.gauge(&Vector2::zeros()), 0.0);
        for _ in 0..20 {
            let other = curve.friction(&direction(TAU * random.unit()));
            assert!((friction - other).dot(&slip) <= 1e-15 * 5.0, "{curve:?}");
        }
        assert_eq!(curve.reflected().reflected(), curve);
        let mirrored = -curve.reflected().friction(&-slip);
        assert!((curve.dissipation(&slip) + mirrored.dot(&slip)).abs() < 1e-14);
    }
}

/// Moreau: the difference of a point and its projection onto a convex cone is at a right angle to
/// the projection and in the polar cone.
#[test]
fn cone_projections_split_by_moreau() {
    let mut random = Random(3);
    for trial in 0..20_000 {
        let curve = random.curve(trial, 3.0);
        let q = random.vector();
        let x = curve.project_cone(&q);
        let rest = q - x;
        assert!(curve.contains(&(x.yz() * (1.0 - 1e-13)), x.x) || x.yz().norm() < 1e-14);
        assert!(rest.dot(&x).abs() < 1e-13, "{curve:?} {q} {x}");
        let polar = rest.x + curve.dissipation(&-rest.yz());
        assert!(polar < 1e-13, "{curve:?} {q} {x}: {polar}");
    }
}

#[test]
fn kinds_agree_where_they_are_the_same() {
    let mut random = Random(4);
    for _ in 0..1000 {
        let (a, b) = (random.unit(), random.unit());
        let (p, scale) = (Vector2::new(random.signed(), random.signed()), random.unit());
        let ellipse = LimitCurve::Ellipse { mu: [a, b] };
        let quarters = LimitCurve::Quarters { mu: [a, a, b, b] };
        assert_eq!(ellipse.project(&p, scale), quarters.project(&p, scale));
        let round = LimitCurve::Ellipse { mu: [a, a] };
        assert!((round.project(&p, scale) - circle(a).project(&p, scale)).norm() < 1e-15);
        let many = polygon(&[a; 1000]);
        let gap = a * (1.0 - (TAU / 2000.0).cos());
        assert!((many.gauge(&p) - circle(a).gauge(&p)).abs() <= 1.1 * gap / a / a * p.norm());
    }
}

#[test]
fn curves_may_be_segments_and_points() {
    let p = Vector2::new(2.0, 3.0);
    for point in [circle(0.0), LimitCurve::Ellipse { mu: [0.0; 2] }, polygon(&[0.0; 5])] {
        assert_eq!(point.project(&p, 1.0), Vector2::zeros());
        assert_eq!(point.friction(&p).norm(), 0.0);
        assert_eq!(point.gauge(&p), f64::INFINITY);
        assert_eq!(point.project_cone(&Vector3::new(1.0, 2.0, 3.0)), Vector3::x());
    }
    let ends = [Vector2::new(-0.5, 0.0), Vector2::new(1.0, 0.0)];
    let segment = LimitCurve::Polygon(Polygon::new(&ends).expect("through the origin"));
    let ellipse = LimitCurve::Quarters { mu: [1.0, 0.5, 0.0, 0.0] };
    for curve in [segment, ellipse] {
        assert_eq!(curve.project(&p, 1.0), Vector2::new(1.0, 0.0));
        assert_eq!(curve.project(&-p, 1.0), Vector2::new(-0.5, 0.0));
        assert_eq!(curve.friction(&p), Vector2::new(-0.5, 0.0));
        assert_eq!(curve.gauge(&Vector2::new(-2.0, 0.0)), 4.0);
        assert_eq!(curve.gauge(&p), f64::INFINITY);
    }
}

#[test]
fn polygons_are_hulls_around_the_origin() {
    let corner = |x: f64, y: f64| Vector2::new(x, y);
    let square = [corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)];
    let mut points = square.to_vec();
    points.extend([corner(0.0, 0.3), corner(1.0, 0.0), corner(1.0, 1.0)]);
    let polygon = Polygon::new(&points).expect("around the origin");
    assert_eq!(polygon.vertices(), square);
    for bad in [vec![], vec![corner(1.0, 0.0), corner(2.0, 1.0)], vec![corner(f64::NAN, 0.0)]] {
        assert!(Polygon::new(&bad).is_err(), "{bad:?}");
    }
    for mu in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(LimitCurve::Circle { mu }.validate().is_err());
        assert!(LimitCurve::Ellipse { mu: [0.1, mu] }.validate().is_err());
        assert!(LimitCurve::Quarters { mu: [0.1, 0.1, 0.1, mu] }.validate().is_err());
    }
    assert_eq!(circle(5.0).validate(), Ok(()));
    // A whole edge dissipates the same: the vertex that was given first is taken.
    let friction = LimitCurve::Polygon(polygon).friction(&corner(-1.0, 0.0));
    assert_eq!(friction, corner(1.0, -1.0));
}
