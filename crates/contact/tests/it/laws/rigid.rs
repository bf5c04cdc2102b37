//! Free rigid bodies: what they conserve, how they turn, how they answer a solver.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_contact::{Body, ContactError, RigidBody};

fn brick() -> RigidBody {
    let pose = Isometry3::from_parts(
        Translation3::new(0.3, -0.2, 0.1),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -1.1, 0.3)),
    );
    let mut body = RigidBody::cuboid(0.7, Vector3::new(0.1, 0.2, 0.4), pose).expect("valid");
    body.velocity = Vector3::new(0.2, 0.5, -1.0);
    body.set_angular_velocity(&Vector3::new(2.0, -3.0, 5.0));
    body
}

#[test]
fn a_free_body_keeps_its_momenta_and_nearly_its_energy() {
    let mut body = brick();
    let (angular, energy) = (body.angular_momentum, body.kinetic_energy());
    let about_origin = body.angular_momentum_about(&Point3::origin());
    let mut worst = 0.0_f64;
    for _ in 0..20_000 {
        body.step(&Vector3::zeros(), &Vector3::zeros(), 1e-3).expect("turns little");
        worst = worst.max((body.kinetic_energy() / energy - 1.0).abs());
    }
    assert_eq!(body.angular_momentum, angular);
    let drift = (body.angular_momentum_about(&Point3::origin()) - about_origin).norm();
    assert!(drift < 1e-12 * body.mass() * body.velocity.norm() * 20.0, "{drift}");
    // Second order: (omega dt)^2 / 12 of the energy at most, and no drift over 120 rad.
    assert!(worst < 4e-6, "{worst}");
}

#[test]
fn a_symmetric_top_precesses_at_its_exact_rate() {
    let (across, along) = (2.0, 0.5);
    let inertia = Matrix3::from_diagonal(&Vector3::new(across, across, along));
    let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.6, 0.0, 0.0));
    let momentum = Vector3::new(0.0, 0.0, 3.0);
    let precession = 3.0 / across;
    let after = |steps: usize| {
        let mut body =
            RigidBody::new(1.0, inertia, Isometry3::from_parts(Translation3::identity(), tilt))
                .expect("valid");
        body.angular_momentum = momentum;
        for _ in 0..steps {
            body.step(&Vector3::zeros(), &Vector3::zeros(), 2.0 / steps as f64).expect("small");
        }
        let axis = body.pose.rotation * Vector3::z();
        let exact = UnitQuaternion::from_scaled_axis(Vector3::z() * (2.0 * precession))
            * (tilt * Vector3::z());
        (axis - exact).norm()
    };
    let (coarse, fine) = (after(100), after(200));
    assert!(fine < 1e-4, "{fine}");
    assert!((coarse / fine - 4.0).abs() < 0.05, "second order: {coarse} {fine}");
}

#[test]
fn the_step_is_reversible() {
    let start = brick();
    let mut body = start.clone();
    let (force, moment) = (Vector3::new(0.1, 0.2, -0.3), Vector3::new(0.02, -0.01, 0.03));
    body.step(&force, &moment, 1e-2).expect("small");
    body.velocity = -body.velocity;
    body.angular_momentum = -body.angular_momentum;
    body.step(&force, &moment, 1e-2).expect("small");
    assert!((body.pose.translation.vector - start.pose.translation.vector).norm() < 1e-15);
    assert!(body.pose.rotation.angle_to(&start.pose.rotation) < 1e-7);
    assert!((body.angular_momentum + start.angular_momentum).norm() < 1e-15);
}

#[test]
fn bad_bodies_and_steps_are_refused() {
    let pose = Isometry3::identity();
    assert!(RigidBody::ball(0.0, 1.0, pose).is_err());
    assert!(RigidBody::ball(f64::NAN, 1.0, pose).is_err());
    assert!(
        RigidBody::new(1.0, Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)), pose).is_err()
    );
    let mut body = brick();
    let before = body.clone();
    let refused = body.step(&Vector3::zeros(), &Vector3::zeros(), 1e4);
    assert!(matches!(refused, Err(ContactError::Invalid { .. })), "{refused:?}");
    assert_eq!(body, before);
    let mut points = body.with_points(&[Point3::origin()]).expect("valid");
    assert!(points.set_weights(&[1.0, 2.0]).is_err());
}

#[test]
fn an_answer_is_what_the_impulses_do() {
    let body = brick();
    let at = [Point3::new(0.3, 0.1, 0.2), Point3::new(0.1, -0.3, 0.3)];
    let impulses = [Vector3::new(0.1, 0.2, 0.3), Vector3::new(-0.3, 0.1, 0.2)];
    let mut points = body.with_points(&at).expect("valid");
    let mut answer = [Vector3::zeros(); 2];
    points.respond(&impulses, &mut answer);
    let mut pushed = body.clone();
    pushed.apply_wrench(&points.wrench(&impulses));
    let mut one_by_one = body.clone();
    for (point, impulse) in at.iter().zip(&impulses) {
        one_by_one.apply_impulse(impulse, point);
    }
    for (point, change) in at.iter().zip(&answer) {
        let direct = pushed.velocity_at(point) - body.velocity_at(point);
        assert!((direct - change).norm() < 1e-13, "{direct} {change}");
        assert!((pushed.velocity_at(point) - one_by_one.velocity_at(point)).norm() < 1e-13);
    }
}

proptest! {
    #[test]
    fn weights_answer_as_their_own_resistance(
        weights in prop::collection::vec(prop_oneof![Just(0.0), 0.0..5.0_f64], 3),
        raw in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 6),
    ) {
        let body = brick();
        let at: Vec<Point3<f64>> = raw[..3].iter().map(|x| Point3::from(*x)).collect();
        let impulses: Vec<Vector3<f64>> = raw[3..].iter().map(|x| Vector3::from(*x)).collect();
        let mut plain = body.with_points(&at).expect("valid");
        let mut weighted = plain.clone();
        weighted.set_weights(&weights).expect("not negative");
        let (mut v, mut again) = (vec![Vector3::zeros(); 3], vec![Vector3::zeros(); 3]);
        weighted.weighted_respond(&impulses, &mut v);
        // (A + H^T M H) w = H^T p  <=>  A w = H^T (p - M H w).
        let left: Vec<_> = (0..3).map(|i| impulses[i] - weights[i] * v[i]).collect();
        plain.respond(&left, &mut again);
        let size: f64 = v.iter().map(|x| x.norm()).sum::<f64>() + 1.0;
        for i in 0..3 {
            prop_assert!((v[i] - again[i]).norm() < 1e-11 * size * (1.0 + weights[i]));
        }
        let (mut traces, mut own) = ([0.0; 3], [0.0; 3]);
        weighted.own_traces(&mut traces);
        for axis in 0..3 {
            for i in 0..3 {
                let mut unit = vec![Vector3::zeros(); 3];
                unit[i][axis] = 1.0;
                weighted.respond(&unit, &mut v);
                own[i] += v[i][axis];
            }
        }
        for i in 0..3 {
            prop_assert!((traces[i] - own[i]).abs() < 1e-12 * own[i]);
        }
    }
}
