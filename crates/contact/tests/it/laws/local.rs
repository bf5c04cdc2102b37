//! One contact, solved exactly.
use crate::common::{Random, circle, contact, polygon};
use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};
use proptest::prelude::*;
use rapunzel_contact::{Contact, LimitCurve, Violation, solve_contact};
use std::f64::consts::TAU;

fn with(curve: LimitCurve) -> Contact {
    contact(0, None, &Vector3::z(), curve)
}

/// A response with eigenvalues over `decades` in random directions.
fn response(random: &mut Random, decades: f64) -> Matrix3<f64> {
    let turn = Rotation3::new(random.direction() * 3.0 * random.unit()).into_inner();
    let scale = Vector3::from_fn(|_, _| 10.0_f64.powf(-decades * random.unit()));
    let w = turn * Matrix3::from_diagonal(&scale) * turn.transpose();
    0.5 * (w + w.transpose())
}

/// The largest violation of the law, as an impulse relative to the impulse and as a velocity
/// relative to the free one.
fn violation(contact: &Contact, w: &Matrix3<f64>, free: &Vector3<f64>, r: &Vector3<f64>) -> f64 {
    let soft = w + Matrix3::from_diagonal_element(contact.compliance);
    let violation = Violation::new(contact, &(soft * r + free), r, 3.0 / soft.trace());
    let speed = free.norm() + (soft * r).norm();
    (violation.normal.max(violation.slip) / speed)
        .max(violation.impulse / (r.norm() + contact.adhesion + speed * 3.0 / soft.trace()))
}

#[test]
fn the_law_holds_for_every_curve_and_response() {
    let mut random = Random(11);
    for (decades, tolerance) in [(0.0, 1e-14), (1.0, 1e-13), (4.0, 1e-11), (7.0, 1e-8)] {
        let mut worst: f64 = 0.0;
        for trial in 0..12_000 {
            let mut c = with(random.curve(trial, 5.0));
            if trial % 3 == 0 {
                c.adhesion = random.unit();
                c.compliance = random.unit() * 0.1;
            }
            let w = response(&mut random, decades);
            let free = random.vector();
            let r = solve_contact(&c, &w, &free);
            let error = violation(&c, &w, &free, &r);
            assert!(error < tolerance, "{decades} {c:?} {w} {free} {r}: {error}");
            worst = worst.max(error);
        }
        println!("responses over {decades} decades: violation at most {worst:.1e}");
    }
}

/// Of all impulses on a fine grid of sliding frictions the exact one has the least residual.
#[test]
fn brute_force_finds_the_same_sliding() {
    let mut random = Random(12);
    for trial in 0..100 {
        let mu = [0.2, 0.4, 0.3, 0.5].map(|mu| mu * (0.5 + random.unit()));
        let c = with(LimitCurve::Quarters { mu });
        let w = response(&mut random, 0.5);
        let free = random.vector() - Vector3::x();
        let exact = solve_contact(&c, &w, &free);
        let (mut best, mut least) = (Vector3::zeros(), f64::INFINITY);
        let mut consider = |r: Vector3<f64>| {
            let error = violation(&c, &w, &free, &r);
            if error < least {
                (best, least) = (r, error);
            }
        };
        consider(Vector3::zeros());
        consider(-w.try_inverse().expect("regular") * free);
        for k in 0..5_000 {
            let angle = TAU * f64::from(k) / 5_000.0;
            let point = c.friction.friction(&Vector2::new(angle.cos(), angle.sin()));
            let along = Vector3::new(1.0, point.x, point.y);
            consider(along * (-free.x / (w * along).x).max(0.0));
        }
        let difference = (best - exact).norm() / (1.0 + exact.norm());
        assert!(difference < 5e-3 / w.symmetric_eigenvalues().min(), "{trial}: {best} {exact}");
    }
}

#[test]
fn curves_of_the_same_shape_agree() {
    let mut random = Random(13);
    for _ in 0..2000 {
        let (mu, w) = (random.unit(), response(&mut random, 0.7));
        let free = random.vector() - Vector3::x() * 0.5;
        let round = solve_contact(&with(circle(mu)), &w, &free);
        let same = [LimitCurve::Ellipse { mu: [mu; 2] }, LimitCurve::Quarters { mu: [mu; 4] }];
        for curve in same {
            assert!((solve_contact(&with(curve), &w, &free) - round).norm() < 1e-12);
        }
        // 512 corners are within 1 - cos(pi / 512) of the circle, but the slip direction, and with
        // it the place on the curve, only within pi / 512.
        let near = solve_contact(&with(polygon(&vec![mu; 512])), &w, &free);
        assert!((near - round).norm() < 0.03 * (1.0 + round.norm()), "{near} {round}");
    }
}

#[test]
fn diagonal_responses_have_closed_forms() {
    let w = Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, 1.0));
    let solve = |mu: f64, free: [f64; 3]| solve_contact(&with(circle(mu)), &w, &free.into());
    assert_eq!(solve(0.5, [0.1, 3.0, 0.0]), Vector3::zeros());
    assert_eq!(solve(0.0, [-2.0, 3.0, 4.0]), Vector3::x());
    assert_eq!(solve(10.0, [-2.0, 3.0, 4.0]), Vector3::new(1.0, -3.0, -4.0));
    assert!((solve(0.5, [-2.0, 3.0, 4.0]) - Vector3::new(1.0, -0.3, -0.4)).norm() < 1e-15);

    let mut sticky = with(circle(0.5));
    sticky.adhesion = 1.0;
    // It holds against a pull, and friction has the adhesion's share.
    let held = solve_contact(&sticky, &w, &Vector3::new(1.0, 0.2, 0.0));
    assert!((held - Vector3::new(-0.5, -0.2, 0.0)).norm() < 1e-15);
    let slipping = solve_contact(&sticky, &w, &Vector3::new(1.0, 3.0, 0.0));
    assert!((slipping - Vector3::new(-0.5, -0.25, 0.0)).norm() < 1e-15);
    assert_eq!(solve_contact(&sticky, &w, &Vector3::new(3.0, 0.0, 0.0)), -Vector3::x());

    let mut soft = with(circle(0.5));
    soft.compliance = 2.0;
    let pressed = solve_contact(&soft, &w, &Vector3::new(-2.0, 0.0, 0.0));
    assert!((pressed - Vector3::x() * 0.5).norm() < 1e-15);
}

/// A push along the surface may close the gap more than friction's own normal force opens it.
#[test]
fn painleve_couplings_have_solutions() {
    let mut random = Random(14);
    for trial in 0..20_000 {
        let c = with(random.curve(trial, 50.0));
        let (a, b) = (random.signed() * 0.999, random.signed() * 0.3);
        let w = Matrix3::new(1.0, a, b, a, 1.0, a * b, b, a * b, 1.0);
        if w.cholesky().is_none() {
            continue;
        }
        let free = Vector3::new(-random.unit(), 5.0 * random.signed(), random.signed());
        let r = solve_contact(&c, &w, &free);
        let error = violation(&c, &w, &free, &r);
        assert!(error < 1e-9, "{c:?} {w} {free} {r}: {error}");
    }
}

#[test]
fn singular_responses_do_no_harm() {
    let mut random = Random(15);
    for trial in 0..20_000 {
        let c = with(random.curve(trial, 2.0));
        let (p, q) = (random.vector(), random.vector());
        let w = match trial % 3 {
            0 => p * p.transpose(),
            1 => p * p.transpose() + q * q.transpose(),
            _ => Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)),
        };
        // What can move at all.
        let free = w * random.vector();
        let r = solve_contact(&c, &w, &free);
        assert!(r.iter().all(|x| x.is_finite()));
        let u = w * r + free;
        assert!(u.x > -1e-8, "{c:?} {w:?} {free} {r} {u}");
        let excess = (r.yz() - c.friction.project(&r.yz(), r.x)).norm();
        assert!(excess <= 1e-9 * r.norm(), "{c:?} {w} {free} {r}");
        let power = r.yz().dot(&u.yz()) / (r.norm() * free.norm());
        assert!(r.norm() == 0.0 || power < 1e-7, "{c:?} {w:?} {free} {r} {u}: {power}");
    }
    assert_eq!(
        solve_contact(&with(circle(1.0)), &Matrix3::zeros(), &-Vector3::x()),
        Vector3::zeros()
    );
}

proptest! {
    #[test]
    fn friction_never_does_work(
        seed in any::<u64>(),
        kind in 0_usize..4,
        decades in 0.0..4.0,
        free in prop::array::uniform3(-1.0..1.0),
    ) {
        let mut random = Random(seed);
        let c = with(random.curve(kind, 5.0));
        let w = response(&mut random, decades);
        let free = Vector3::from(free);
        let r = solve_contact(&c, &w, &free);
        let u = w * r + free;
        prop_assert!(r.x >= 0.0);
        prop_assert!(r.yz().dot(&u.yz()) <= 1e-10 * r.norm());
        // Without restitution the energy falls.
        prop_assert!(r.dot(&(free + 0.5 * (w * r))) <= 1e-10 * r.norm());
    }
}
