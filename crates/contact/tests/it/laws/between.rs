//! Fig. 2.18: the five cases of the differential friction effect.
use nalgebra::Vector2;
use rapunzel_contact::{Friction, LimitCurve};
use std::f64::consts::{FRAC_PI_2, PI};

const WITH: f64 = 0.13;
const AGAINST: f64 = 0.61;
const ACROSS: f64 = 0.3;

fn fiber() -> LimitCurve {
    LimitCurve::cuticle(WITH, AGAINST, ACROSS)
}

/// Friction against a motion of the first along its axis, root first or tip first.
fn along(curve: &LimitCurve, tip_first: bool) -> f64 {
    let sense = if tip_first { 1.0 } else { -1.0 };
    curve.dissipation(&Vector2::new(sense, 0.0))
}

fn mean(a: f64, b: f64) -> f64 {
    (0.5 * (1.0 / (a * a) + 1.0 / (b * b))).sqrt().recip()
}

#[test]
fn a_fiber_slides_with_its_scales_root_first() {
    assert_eq!(along(&fiber(), false), WITH);
    assert_eq!(along(&fiber(), true), AGAINST);
    assert_eq!(fiber().dissipation(&Vector2::new(0.0, 2.0)), 2.0 * ACROSS);
}

#[test]
fn five_cases_of_fibers_on_fibers() {
    let opposite = LimitCurve::between(&fiber(), &fiber(), PI).expect("valid");
    assert!((along(&opposite, false) - WITH).abs() < 1e-15, "case 1");
    assert!((along(&opposite, true) - AGAINST).abs() < 1e-15, "case 2");

    let parallel = LimitCurve::between(&fiber(), &fiber(), 0.0).expect("valid");
    let (one, other) = (along(&parallel, false), along(&parallel, true));
    assert_eq!(one, other, "case 3: the relative motion does not matter");
    assert!((one - mean(WITH, AGAINST)).abs() < 1e-15);
    assert!(WITH < one && one < AGAINST);

    for turn in [FRAC_PI_2, -FRAC_PI_2] {
        let crossed = LimitCurve::between(&fiber(), &fiber(), turn).expect("valid");
        assert!((along(&crossed, false) - mean(WITH, ACROSS)).abs() < 1e-15, "case 4");
        assert!((along(&crossed, true) - mean(AGAINST, ACROSS)).abs() < 1e-15, "case 5");
        // The second moves along its own axis while the first slides sideways the other way.
        let second_tip_first = -Vector2::new(turn.cos(), turn.sin());
        let friction = crossed.dissipation(&second_tip_first);
        assert!((friction - mean(AGAINST, ACROSS)).abs() < 1e-15);
    }
}

/// Wool on wool, Tab. 2.11: directions 1 and 2 predict direction 3 within the bounds documented.
#[test]
fn wool_on_wool_is_between() {
    for (with, against, predicted) in [(0.13, 0.61, 0.180), (0.11, 0.38, 0.149)] {
        let wool = LimitCurve::cuticle(with, against, against);
        let parallel = LimitCurve::between(&wool, &wool, 0.0).expect("valid");
        assert!((along(&parallel, true) - predicted).abs() < 5e-4);
    }
}

#[test]
fn a_pair_is_the_same_seen_from_either() {
    for angle in [0.3, FRAC_PI_2, 2.0, PI, -1.0] {
        let other = LimitCurve::cuticle(0.2, 0.5, 0.25);
        let ours = LimitCurve::between(&fiber(), &other, angle).expect("valid");
        let theirs = LimitCurve::between(&other, &fiber(), -angle).expect("valid");
        for k in 0..200 {
            let slip = Vector2::new((0.1 * f64::from(k)).cos(), (0.1 * f64::from(k)).sin());
            let turned = nalgebra::Rotation2::new(-angle) * -slip;
            let difference = ours.dissipation(&slip) - theirs.dissipation(&turned);
            // Where the directions of the vertices differ, by what the edges are inside.
            assert!(difference.abs() < 5e-3 * ours.dissipation(&slip), "{angle} {slip}");
        }
    }
}

#[test]
fn polygons_meet_the_exact_curve_at_right_angles() {
    let exact = LimitCurve::between(&fiber(), &fiber(), FRAC_PI_2).expect("valid");
    let near = LimitCurve::between(&fiber(), &fiber(), FRAC_PI_2 + 1e-6).expect("valid");
    assert!(matches!(exact, LimitCurve::Quarters { .. }));
    assert!(matches!(near, LimitCurve::Polygon(_)));
    for k in 0..400 {
        let p = Vector2::new((0.1 * f64::from(k)).cos(), (0.1 * f64::from(k)).sin());
        let ratio = near.gauge(&p) / exact.gauge(&p);
        assert!((1.0 - 1e-5..1.006).contains(&ratio), "{p} {ratio}");
        let share = near.dissipation(&p) / exact.dissipation(&p);
        assert!((0.994..1.0 + 1e-5).contains(&share), "{p} {share}");
    }
}

#[test]
fn equal_circles_stay_and_one_without_friction_wins() {
    let (rough, smooth) = (LimitCurve::Circle { mu: 0.47 }, LimitCurve::Circle { mu: 0.0 });
    let LimitCurve::Circle { mu } = LimitCurve::between(&rough, &rough, 0.7).expect("valid") else {
        panic!("two circles make a circle");
    };
    assert!((mu - 0.47).abs() < 1e-15);
    assert_eq!(LimitCurve::between(&rough, &smooth, 0.7), Ok(smooth.clone()));
    let slit = LimitCurve::Ellipse { mu: [0.4, 0.0] };
    let line = LimitCurve::between(&slit, &rough, 0.3).expect("valid");
    assert_eq!(line.dissipation(&Vector2::y()), 0.0);
    assert!((line.dissipation(&Vector2::x()) - mean(0.4, 0.47)).abs() < 1e-12);
    let crossed = LimitCurve::between(&slit, &slit, 0.3).expect("valid");
    assert_eq!(crossed.dissipation(&Vector2::new(0.3, 0.4)), 0.0);
    assert!(LimitCurve::between(&slit, &slit, f64::NAN).is_err());
    assert!(LimitCurve::between(&slit, &LimitCurve::Circle { mu: -1.0 }, 0.0).is_err());
}

#[test]
fn resting_and_sliding_have_their_curves() {
    let surface = Friction { resting: fiber(), sliding: LimitCurve::Circle { mu: 0.1 } };
    assert_eq!(surface.curve(true), &surface.resting);
    assert_eq!(surface.curve(false), &surface.sliding);
    let pair = Friction::between(&surface, &surface, PI).expect("valid");
    assert_eq!(pair.resting, LimitCurve::between(&fiber(), &fiber(), PI).expect("valid"));
    assert!((pair.sliding.dissipation(&Vector2::x()) - 0.1).abs() < 1e-15);
}
