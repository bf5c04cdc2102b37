//! Alg. 6, corrected, against closed forms.

use super::common::{floor, number, numbers, particle, vector};
use crate::common::incline::{EndOfSlip, within};
use nalgebra::{Isometry3, Matrix3, Point3, Vector2, Vector3, Vector6};
use rapunzel_contact::thesis::projection::{Form, PolygonalCone, Touch, moreau_step, project};
use rapunzel_contact::{ContactError, RigidBody};
use rapunzel_oracles::cases;
use serde_json::Value;

/// Corners of a polygon that stands for a smooth curve.
const MANY: usize = 720;
/// Their distance on the unit circle.
const CORNER: f64 = 2.0 * std::f64::consts::PI / MANY as f64;

#[test]
fn every_case_that_one_body_can_show() {
    let mut shown = 0;
    for case in cases::<Value>("e_contact.json").expect("the oracle") {
        let name = case["name"].as_str().expect("a name");
        let kind = name.split('_').next().expect("never empty");
        match kind {
            "impact" => impact(&case),
            "rod" => rod_impact(&case),
            "incline" => incline(&case),
            "aniso" => anisotropic_incline(&case),
            "bounce" => bounce(&case),
            "polygon" => polygon(&case),
            "elliptic" => {
                let [mu1, mu2] = ["mu_t1", "mu_t2"].map(|key| number(&case, key));
                samples(&case, [mu1, mu1], mu2);
            }
            "two" => {
                let keys = ["mu_slip_plus_t1", "mu_slip_minus_t1"];
                samples(&case, keys.map(|key| number(&case, key)), number(&case, "mu_t2"));
            }
            // Many bodies in a rope, and elastic rods: not a matter of this method.
            "capstan" | "crossed" => continue,
            other => panic!("a case of an unknown kind: {other}"),
        }
        shown += 1;
    }
    assert!(shown > 0);
}

/// A particle meets a plane; the polygon has a corner against the slip, where it is the circle.
fn impact(case: &Value) {
    let (before, normal) = (vector(case, "v_before"), vector(case, "normal"));
    let mut bodies = [particle(number(case, "m"), before)];
    let slip = before - normal * normal.dot(&before);
    let slip = if slip.norm() > 1e-9 * before.norm() { slip } else { normal.yzx() };
    let touch = floor(normal, slip, PolygonalCone::regular(number(case, "mu"), 8).expect("valid"));
    project(&mut bodies, &[touch], number(case, "eps"), &Form::Corrected.into()).expect("solved");
    let error = (bodies[0].velocity - vector(case, "v_after")).norm();
    assert!(error < 1e-13 * before.norm(), "{case}: {error:e}");
}

fn rod_impact(case: &Value) {
    let (mass, length, offset) =
        (number(case, "m"), number(case, "L"), number(case, "contact_offset"));
    let across = mass * length * length / 12.0;
    let inertia = Matrix3::from_diagonal(&Vector3::new(1e-6 * across, across, across));
    let mut rod = RigidBody::new(mass, inertia, Isometry3::identity()).expect("valid");
    rod.velocity.z = number(case, "v_normal_before");
    let touch = Touch {
        point: Point3::new(offset, 0.0, 0.0),
        ..floor(Vector3::z(), Vector3::x(), super::common::frictionless())
    };
    let mut bodies = [rod];
    project(&mut bodies, &[touch], number(case, "eps"), &Form::Corrected.into()).expect("solved");
    // v + omega x along the rod: a positive omega of the case turns +x upwards, about -y.
    assert!((bodies[0].velocity.z - number(case, "v_com_after")).abs() < 1e-13, "{case}");
    let omega = -bodies[0].angular_velocity().y;
    assert!((omega - number(case, "omega_after")).abs() < 1e-12, "{case}: {omega}");
}

/// Position and velocity of a unit mass on a plane (x downhill, y across) at the times `t`.
fn slide(
    alpha: f64,
    v0: f64,
    tangent: Vector3<f64>,
    friction: &PolygonalCone,
    t: &[f64],
    dt: f64,
) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let load = Vector6::new(9.81 * alpha.sin(), 0.0, -9.81 * alpha.cos(), 0.0, 0.0, 0.0);
    let mut bodies = [particle(1.0, Vector3::new(v0, 0.0, 0.0))];
    let (mut out, mut step) = (Vec::new(), 0);
    for t in t {
        while (step as f64 + 0.5) * dt < *t {
            let touch = |bodies: &[RigidBody]| {
                let point = bodies[0].center();
                Ok(vec![Touch { point, ..floor(Vector3::z(), tangent, friction.clone()) }])
            };
            moreau_step(&mut bodies, &[load], touch, dt, 0.0, &Form::Corrected.into())
                .expect("solved");
            step += 1;
        }
        out.push((bodies[0].center().xy().coords, bodies[0].velocity.xy()));
    }
    out
}

fn incline(case: &Value) {
    let (alpha, dt) = (number(case, "alpha_deg").to_radians(), 2.5e-4);
    let friction = PolygonalCone::regular(number(case, "mu"), 4).expect("valid");
    let (x, v, t) = (numbers(case, "x_downhill"), numbers(case, "v_downhill"), numbers(case, "t"));
    let path = slide(alpha, number(case, "v0_downhill"), Vector3::x(), &friction, &t, dt);
    let (g, mu, v0) = (number(case, "g"), number(case, "mu"), number(case, "v0_downhill"));
    let bounds = EndOfSlip::new(alpha, mu, g, v0, dt);
    let farthest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert_eq!(path.len(), t.len());
    for (i, (position, velocity)) in path.iter().enumerate() {
        let (slower, behind) = (v[i] - velocity.x, x[i] - position.x);
        assert!(within(slower, bounds.velocity(t[i])), "{case}: {slower:e} at {}", t[i]);
        assert!(within(behind, bounds.way(t[i])), "{case}: {behind:e} at {}", t[i]);
        assert!(behind.abs() <= 1e-3 * farthest, "{case}: {behind:e} at {}", t[i]);
    }
}

fn anisotropic_incline(case: &Value) {
    let alpha = number(case, "alpha_deg").to_radians();
    let axis = number(case, "fibre_angle_deg").to_radians();
    let (mu1, mu2) = (number(case, "mu_t1"), number(case, "mu_t2"));
    let friction = smooth([mu1, mu1], mu2);
    let tangent = Vector3::new(axis.cos(), axis.sin(), 0.0);
    if case["regime"] == "stick" {
        let path = slide(alpha, 0.0, tangent, &friction, &[1.0], 1e-3);
        assert!(path[0].1.norm() < 1e-14, "{case}: {path:?}");
        return;
    }
    let t = numbers(case, "t");
    let path = slide(alpha, 0.0, tangent, &friction, &t, 1e-2);
    for (i, expected) in case["position"].as_array().expect("a list").iter().enumerate() {
        let expected = [&expected[0], &expected[1]].map(|x| x.as_f64().expect("a number"));
        let error = (path[i].0 - Vector2::from(expected)).norm();
        let tolerance = 0.5 * t[i] * t[i] * 9.81 * CORNER * mu1.max(mu2);
        assert!(error < tolerance + 1e-12, "{case}: {error:e} at {}", t[i]);
    }
}

/// A curve of two half ellipses as a polygon of many corners, evenly spaced in the ellipses'
/// parameter: `mu_t1` for slip towards +t1 (force towards -t1) and towards -t1.
fn smooth(mu_t1: [f64; 2], mu_t2: f64) -> PolygonalCone {
    let corner = |i: usize| {
        let (sine, cosine) = (2.0 * std::f64::consts::PI * i as f64 / MANY as f64).sin_cos();
        let along = if cosine < 0.0 { mu_t1[0] } else { mu_t1[1] };
        let force = Vector2::new(along * cosine, mu_t2 * sine);
        (force.y.atan2(force.x), force.norm())
    };
    let spokes: Vec<_> = (0..MANY).map(corner).collect();
    PolygonalCone::new(&spokes).expect("valid")
}

/// Friction on a unit mass that lands at 1 m/s while it slips fast towards `degrees`.
fn friction_in_slip(friction: &PolygonalCone, degrees: f64) -> Vector2<f64> {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let before = Vector3::new(100.0 * cosine, 100.0 * sine, -1.0);
    let mut bodies = [particle(1.0, before)];
    let touch = floor(Vector3::z(), Vector3::x(), friction.clone());
    project(&mut bodies, &[touch], 0.0, &Form::Corrected.into()).expect("solved");
    (bodies[0].velocity - before).xy()
}

fn expected(sample: &Value) -> (f64, Vector2<f64>) {
    let force = numbers(sample, "friction_per_normal_force");
    (number(sample, "slip_direction_deg"), Vector2::new(force[0], force[1]))
}

fn polygon(case: &Value) {
    let spokes: Vec<_> = numbers(case, "directions_deg")
        .iter()
        .map(|degrees| degrees.to_radians())
        .zip(numbers(case, "mu_beta"))
        .collect();
    let friction = PolygonalCone::new(&spokes).expect("valid");
    for sample in case["samples"].as_array().expect("a list") {
        let (slip, force) = expected(sample);
        let error = (friction_in_slip(&friction, slip) - force).norm();
        assert!(error < 1e-13, "{case}: {slip} {error:e}");
    }
}

/// The force is the corner nearest to the right point, so its dissipation is right to second order.
fn samples(case: &Value, mu_t1: [f64; 2], mu_t2: f64) {
    let friction = smooth(mu_t1, mu_t2);
    let size = mu_t1[0].max(mu_t1[1]).max(mu_t2);
    for sample in case["samples"].as_array().expect("a list") {
        let (slip, force) = expected(sample);
        let found = friction_in_slip(&friction, slip);
        let (sine, cosine) = slip.to_radians().sin_cos();
        assert!((found - force).norm() < CORNER * size, "{case}: {slip} {found}");
        let dissipation = (found - force).dot(&Vector2::new(cosine, sine)).abs();
        assert!(dissipation < CORNER * CORNER * size, "{case}: {slip} {dissipation:e}");
    }
}

fn bounce(case: &Value) {
    let (h, restitution, dt) = (number(case, "h0"), number(case, "eps"), 1e-4);
    let load = Vector6::new(0.0, 0.0, -number(case, "g"), 0.0, 0.0, 0.0);
    let mut bodies = [particle(1.0, Vector3::zeros())];
    bodies[0].pose.translation.vector.z = h;
    let friction = super::common::frictionless();
    let touch = |bodies: &[RigidBody]| -> Result<Vec<Touch>, ContactError> {
        let point = bodies[0].center();
        let touch = Touch { point, ..floor(Vector3::z(), Vector3::x(), friction.clone()) };
        Ok(if point.z <= 0.0 { vec![touch] } else { Vec::new() })
    };
    let (heights, times) = (numbers(case, "apex_heights"), numbers(case, "impact_times"));
    let (mut apexes, mut apex, mut hits) = (Vec::new(), h, Vec::new());
    for i in 0.. {
        let (before, t) = (bodies[0].velocity.z, f64::from(i) * dt);
        if t > number(case, "rest_time") + 0.1 {
            break;
        }
        moreau_step(&mut bodies, &[load], touch, dt, restitution, &Form::Corrected.into())
            .expect("solved");
        apex = apex.max(bodies[0].center().z);
        if before < 0.0 && bodies[0].velocity.z >= 0.0 {
            hits.push(t);
            apexes.push(apex);
            apex = 0.0;
        }
    }
    let known = heights.iter().zip(&times).zip(apexes.iter().zip(&hits));
    let mut compared = 0;
    for (i, ((height, time), (apex, hit))) in known.enumerate() {
        // Each impact is met within a step, so its speed within g dt; both errors add up.
        let count = (i + 1) as f64;
        let late = count * (count + 1.0) * dt;
        if *height < 2.0 * 9.81 * late * late {
            break;
        }
        let high = 2.0 * count * dt * (2.0 * 9.81 * height).sqrt() + 9.81 * late * late;
        assert!((apex - height).abs() < high, "{case} {i} {apex}");
        assert!((hit - time).abs() < late, "{case} {i} {hit}");
        compared += 1;
    }
    assert!(compared >= times.len().min(4), "{case}: {compared} bounces, {hits:?}");
    let rest = bodies[0].center().z;
    assert!(rest.abs() < 2.0 * dt * (2.0 * 9.81 * h).sqrt(), "{case}: rests at {rest}");
}
