//! What the printed Alg. 6 does, by numbers, and that its corrections do not.

use super::common::{Numbers, floor, frictionless, particle};
use nalgebra::{Isometry3, Point3, Vector3, Vector6};
use rapunzel_contact::RigidBody;
use rapunzel_contact::thesis::projection::{
    Differences, Form, Partner, PolygonalCone, Touch, moreau_step, project,
};

pub(crate) fn corrected() -> Differences {
    Form::Corrected.into()
}

fn land(velocity: Vector3<f64>, mu: f64, restitution: f64, form: Differences) -> Vector3<f64> {
    let mut bodies = [particle(1.0, velocity)];
    let friction = PolygonalCone::regular(mu, 8).expect("valid");
    project(&mut bodies, &[floor(Vector3::z(), Vector3::x(), friction)], restitution, &form)
        .expect("solved");
    bodies[0].velocity
}

#[test]
fn printed_restitution_keeps_falling() {
    let before = Vector3::new(1.0, 0.0, -1.0);
    let printed = Differences { restitution: Form::AsPrinted, ..corrected() };
    assert!((land(before, 0.0, 0.5, corrected()) - Vector3::new(1.0, 0.0, 0.5)).norm() < 1e-15);
    assert!((land(before, 0.0, 0.5, printed) - Vector3::new(2.0, 0.0, -0.5)).norm() < 1e-15);
    let all = land(before, 0.0, 0.5, Form::AsPrinted.into());
    assert!((all - Vector3::new(2.0, 0.0, -0.5)).norm() < 1e-15);
}

#[test]
fn printed_friction_reverses_a_slow_slip() {
    let before = Vector3::new(0.01, 0.0, -0.3);
    let printed = Differences { objective: Form::AsPrinted, ..corrected() };
    assert!(land(before, 0.47, 0.0, corrected()).norm() < 1e-16);
    let reversed = land(before, 0.47, 0.0, printed);
    assert!((reversed.x - (0.01 - 0.47 * 0.3)).abs() < 1e-7, "{reversed}");
    assert!((reversed.x + 0.131).abs() < 1e-7);
}

#[test]
fn printed_half_force_halves_the_slide() {
    let (alpha, mu, dt) = (30_f64.to_radians(), 0.2, 1e-3);
    let load = Vector6::new(9.81 * alpha.sin(), 0.0, -9.81 * alpha.cos(), 0.0, 0.0, 0.0);
    let acceleration = |form: Differences| {
        let mut bodies = [particle(1.0, Vector3::zeros())];
        let touch =
            floor(Vector3::z(), Vector3::x(), PolygonalCone::regular(mu, 4).expect("valid"));
        for _ in 0..100 {
            let found = |bodies: &[RigidBody]| {
                Ok(vec![Touch { point: bodies[0].center(), ..touch.clone() }])
            };
            moreau_step(&mut bodies, &[load], found, dt, 0.0, &form).expect("solved");
        }
        bodies[0].velocity.x / (100.0 * dt)
    };
    let exact = 9.81 * (alpha.sin() - mu * alpha.cos());
    assert!((exact - 3.206).abs() < 1e-3);
    assert!((acceleration(corrected()) - exact).abs() < 1e-12);
    let half = acceleration(Differences { force: Form::AsPrinted, ..corrected() });
    assert!((half - 0.5 * exact).abs() < 1e-12 && (half - 1.603).abs() < 1e-3, "{half}");
}

/// Rods that cross and meet with some slip, at a point each of their own choice.
pub(crate) fn rods(numbers: &mut Numbers, count: usize) -> Vec<RigidBody> {
    (0..count)
        .map(|_| {
            let turn = nalgebra::UnitQuaternion::from_scaled_axis(3.0 * numbers.vector());
            let pose = Isometry3::from_parts((0.05 * numbers.vector()).into(), turn);
            let mut rod =
                RigidBody::cylinder(0.5 + numbers.positive(), 0.01, 0.2, pose).expect("valid");
            rod.velocity = numbers.vector();
            rod.set_angular_velocity(&(10.0 * numbers.vector()));
            rod
        })
        .collect()
}

pub(crate) fn random_touches(numbers: &mut Numbers, bodies: usize, count: usize) -> Vec<Touch> {
    (0..count)
        .map(|i| {
            let body = i % bodies;
            let partner = (i + 1) % bodies;
            let friction = PolygonalCone::regular(2.0 * numbers.positive(), 8).expect("valid");
            Touch {
                body,
                partner: if partner == body || i % 3 == 2 {
                    Partner::Given(Vector3::zeros())
                } else {
                    Partner::Body(partner)
                },
                point: (0.1 * numbers.vector()).into(),
                normal: numbers.vector(),
                tangent: numbers.vector(),
                closing: 0.0,
                friction,
            }
        })
        .collect()
}

fn energy(bodies: &[RigidBody]) -> f64 {
    bodies.iter().map(RigidBody::kinetic_energy).sum()
}

/// Share of random contact sets that gain energy, and the largest gain relative to the energy
/// before.
fn gains(sets: usize, bodies: usize, contacts: usize, form: &Differences) -> (f64, f64) {
    let mut numbers = Numbers(0x5eed);
    let (mut gained, mut largest) = (0, f64::NEG_INFINITY);
    for _ in 0..sets {
        let mut rods = rods(&mut numbers, bodies);
        let touches = random_touches(&mut numbers, bodies, contacts);
        let restitution = numbers.positive();
        let before = energy(&rods);
        project(&mut rods, &touches, restitution, form).expect("solved");
        let gain = energy(&rods) / before - 1.0;
        gained += usize::from(gain > 1e-12);
        largest = largest.max(gain);
    }
    (gained as f64 / sets as f64, largest)
}

#[test]
fn corrected_impacts_never_gain_energy() {
    for (sets, bodies, contacts) in [(100_000, 1, 1), (100_000, 2, 3), (30_000, 3, 6)] {
        let (share, largest) = gains(sets, bodies, contacts, &corrected());
        assert!(
            share == 0.0,
            "{bodies} bodies, {contacts} contacts: {share} gain, up to {largest}"
        );
    }
}

#[test]
fn printed_impacts_gain_energy() {
    let (share, largest) = gains(500, 1, 1, &Form::AsPrinted.into());
    println!("all prints: {share} of the sets gain energy, up to {largest} of it");
    assert!(share > 0.5 && largest > 1.0, "{share} {largest}");
    for (name, form, least) in [
        ("restitution", Differences { restitution: Form::AsPrinted, ..corrected() }, 0.5),
        ("objective", Differences { objective: Form::AsPrinted, ..corrected() }, 0.01),
        ("metric", Differences { metric: Form::AsPrinted, ..corrected() }, 0.01),
        ("velocity", Differences { friction_velocity: Form::AsPrinted, ..corrected() }, 0.0001),
    ] {
        let (share, largest) = gains(2_000, 1, 1, &form);
        println!("{name}: {share} of the sets gain energy, up to {largest} of it");
        assert!(share > least, "{name}: {share} {largest}");
    }
}

/// Two rods that meet at two points: by themselves each finds other impulses than its partner.
#[test]
fn printed_scope_loses_momentum() {
    let mut numbers = Numbers(7);
    let (mut worst_printed, mut worst) = (0.0_f64, 0.0_f64);
    for _ in 0..200 {
        let start = rods(&mut numbers, 2);
        let mut touches = random_touches(&mut numbers, 2, 2);
        for touch in &mut touches {
            (touch.body, touch.partner) = (0, Partner::Body(1));
        }
        let size: f64 = start.iter().map(|b| b.mass() * b.velocity.norm()).sum();
        let total = |bodies: &[RigidBody]| {
            let linear: Vector3<f64> = bodies.iter().map(|b| b.mass() * b.velocity).sum();
            let origin = Point3::origin();
            let angular: Vector3<f64> =
                bodies.iter().map(|b| b.angular_momentum_about(&origin)).sum();
            (linear, angular)
        };
        for (form, worst) in [
            (corrected(), &mut worst),
            (Differences { scope: Form::AsPrinted, ..corrected() }, &mut worst_printed),
        ] {
            let mut bodies = start.clone();
            project(&mut bodies, &touches, 0.3, &form).expect("solved");
            let (before, after) = (total(&start), total(&bodies));
            let error = (after.0 - before.0).norm() / size;
            *worst = worst.max(error).max((after.1 - before.1).norm() / size);
        }
    }
    println!("momentum lost: together {worst:e}, each by itself {worst_printed}");
    assert!(worst < 1e-12, "{worst:e}");
    assert!(worst_printed > 0.1, "{worst_printed}");
}

#[test]
fn one_contact_without_friction_keeps_momentum_in_either_scope() {
    let mut bodies = rods(&mut Numbers(11), 2);
    let before: Vector3<f64> = bodies.iter().map(|b| b.mass() * b.velocity).sum();
    let relative =
        bodies[0].velocity_at(&Point3::origin()) - bodies[1].velocity_at(&Point3::origin());
    let mut touch = floor(-relative, Vector3::new(0.3, 0.2, 0.9), frictionless());
    touch.partner = Partner::Body(1);
    let printed = Differences { scope: Form::AsPrinted, ..corrected() };
    project(&mut bodies, &[touch], 0.4, &printed).expect("solved");
    let after: Vector3<f64> = bodies.iter().map(|b| b.mass() * b.velocity).sum();
    assert!((after - before).norm() < 1e-14, "(8.67) is right for one contact");
}

/// (8.63) is another set than (8.48): larger for a circle, smaller at the tips of an ellipse.
#[test]
fn printed_half_planes_are_another_set() {
    let reach = |friction: &PolygonalCone, form: Form, angle: f64| {
        let direction = nalgebra::Vector2::new(angle.cos(), angle.sin());
        let bound = |(a, b): &(nalgebra::Vector2<f64>, f64)| {
            let along = a.dot(&direction);
            if along > 1e-12 { b / along } else { f64::INFINITY }
        };
        friction.half_planes(form).iter().map(bound).fold(f64::INFINITY, f64::min)
    };
    let circle = PolygonalCone::regular(0.47, 8).expect("valid");
    let middle = std::f64::consts::PI / 8.0;
    let excess = reach(&circle, Form::AsPrinted, middle) / 0.47;
    assert!((excess - 1.0 / middle.cos()).abs() < 1e-12, "{excess}");
    let inner = reach(&circle, Form::Corrected, middle) / 0.47;
    assert!((inner - middle.cos()).abs() < 1e-12, "{inner}");
    let spokes: Vec<_> = (0..8)
        .map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4)
        .map(|angle| (angle, 1.0 / angle.cos().hypot(angle.sin() / 0.1)))
        .collect();
    let ellipse = PolygonalCone::new(&spokes).expect("valid");
    let tip = reach(&ellipse, Form::AsPrinted, 0.0);
    assert!((tip - 2_f64.sqrt() * spokes[1].1).abs() < 1e-12);
    println!("the tip of the ellipse is cut off to {tip}");
    // The corner at the tip violates the half plane across 45 degrees by 0.57.
    let violation = 0.5_f64.sqrt() - spokes[1].1;
    assert!((violation - 0.57).abs() < 5e-3, "{violation}");
    assert!((reach(&ellipse, Form::Corrected, 0.0) - 1.0).abs() < 1e-12);
}

/// The bound (8.67) is a velocity along the normal in space, the printed normal has six dimensions.
#[test]
fn printed_normal_misses_a_moving_wall() {
    let rod = RigidBody::cylinder(1.0, 0.01, 8.0, Isometry3::identity()).expect("valid");
    let arm = 3.0;
    let mut touch = floor(Vector3::x(), Vector3::y(), frictionless());
    touch.point = Point3::new(0.0, 0.0, arm);
    touch.partner = Partner::Given(Vector3::x());
    let pushed = |form: &Differences| {
        let mut bodies = [rod.clone()];
        project(&mut bodies, std::slice::from_ref(&touch), 0.0, form).expect("solved");
        bodies[0].velocity_at(&touch.point).x
    };
    assert!((pushed(&corrected()) - 1.0).abs() < 1e-13);
    let printed = pushed(&Differences { normal: Form::AsPrinted, ..corrected() });
    assert!((printed - (1.0 + arm * arm).sqrt()).abs() < 1e-12, "{printed}");
}

/// A particle in a groove of two planes at 60 degrees: (8.27) counts the impulses twice.
#[test]
fn printed_impulses_count_twice() {
    let groove = |form: &Differences| {
        let mut bodies = [particle(1.0, Vector3::new(0.0, 1.0, -1.0))];
        let tilt = 60_f64.to_radians();
        let touches = [-1.0, 1.0].map(|side| {
            let normal = Vector3::new(side * (0.5 * tilt).sin(), 0.0, (0.5 * tilt).cos());
            floor(normal, Vector3::y(), PolygonalCone::regular(0.1, 4).expect("valid"))
        });
        project(&mut bodies, &touches, 0.0, form).expect("solved");
        1.0 - bodies[0].velocity.y
    };
    let (half, mu) = (30_f64.to_radians().cos(), 0.1);
    // Each plane bears 1 / (2 cos 30) of the impulse; printed, cos 30.
    assert!((groove(&corrected()) - mu / half).abs() < 1e-12);
    let printed = groove(&Differences { impulse: Form::AsPrinted, ..corrected() });
    assert!((printed - 2.0 * mu * half).abs() < 1e-12, "{printed}");
}

#[test]
fn printed_euclidean_projection_is_not_along_the_wrench() {
    let push = |form: &Differences| {
        let mut bodies =
            [RigidBody::cylinder(2.0, 0.01, 1.0, Isometry3::identity()).expect("valid")];
        bodies[0].velocity = Vector3::new(-1.0, 0.0, 0.0);
        let mut touch = floor(Vector3::x(), Vector3::y(), frictionless());
        touch.point = Point3::new(0.0, 0.0, 0.5);
        let start = bodies[0].velocity;
        project(&mut bodies, std::slice::from_ref(&touch), 0.0, form).expect("solved");
        let body = &bodies[0];
        let impulse = body.mass() * (body.velocity - start);
        let moment = body.angular_momentum - (touch.point - body.center()).cross(&impulse);
        moment.norm() / impulse.norm()
    };
    assert!(push(&corrected()) < 1e-14);
    let arm = push(&Differences { metric: Form::AsPrinted, ..corrected() });
    println!("the Euclidean impulse acts {arm} m beside the contact");
    assert!(arm > 0.4, "{arm}");
}

#[test]
fn printed_rotation_lacks_the_gyroscopic_term() {
    let turn = |form: &Differences| {
        let edges = Vector3::new(0.1, 0.2, 0.4);
        let mut bodies = [RigidBody::cuboid(1.0, edges, Isometry3::identity()).expect("valid")];
        bodies[0].set_angular_velocity(&Vector3::new(1.0, 5.0, 3.0));
        let start = bodies[0].angular_momentum;
        for _ in 0..1000 {
            moreau_step(&mut bodies, &[Vector6::zeros()], |_| Ok(Vec::new()), 1e-3, 0.0, form)
                .expect("no contact");
        }
        (bodies[0].angular_momentum - start).norm() / start.norm()
    };
    assert!(turn(&corrected()) < 1e-13);
    let printed = turn(&Differences { gyroscopic: Form::AsPrinted, ..corrected() });
    println!("angular momentum changes by {printed} in 1 s");
    assert!(printed > 0.1, "{printed}");
}
