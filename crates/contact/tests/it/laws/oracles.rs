//! Every case of `e_contact.json` that needs no rod in large motion, dispatched by the start of its
//! name.
use super::{beams, rope};
use crate::common::incline::{EndOfSlip, within};
use crate::common::{Dense, act, along, circle, contact, exact, resolve};
use nalgebra::{Vector2, Vector3};
use rapunzel_contact::{Body, Contact, LimitCurve, Polygon, impact, impact_in_turn, solve_contact};
use rapunzel_oracles::cases;
use serde::Deserialize;
use serde_json::Value;

/// Whatever is not run here must be a case of the test in the crate `sim`, where there are rods:
/// that has all that tell of a `support_axis`.
#[test]
fn every_case_without_rods() {
    let (mut seen, mut elsewhere) = (0, 0);
    for case in cases::<Value>("e_contact.json").expect("the oracle") {
        let name = case["name"].as_str().expect("a name").to_owned();
        let is = |start: &str| name.starts_with(start);
        if is("incline_") {
            incline(&read(&case));
        } else if is("aniso_incline_") {
            slab(&read(&case));
        } else if is("capstan_") {
            capstan(&read(&case));
        } else if is("bounce_") {
            bounce(&read(&case));
        } else if is("impact_") {
            oblique(&read(&case));
        } else if is("rod_impact_") {
            rod(&read(&case));
        } else if is("elliptic_limit_curve_") {
            let mu = [number(&case, "mu_t1"), number(&case, "mu_t2")];
            samples(&case, &LimitCurve::Ellipse { mu });
        } else if is("two_half_ellipses_") {
            let (plus, minus) =
                (number(&case, "mu_slip_plus_t1"), number(&case, "mu_slip_minus_t1"));
            let across = number(&case, "mu_t2");
            samples(&case, &LimitCurve::Quarters { mu: [minus, plus, across, across] });
        } else if is("polygon_") {
            samples(&case, &polygon(&read(&case)));
        } else if is("crossed_beams_") {
            beams::crossed(&read(&case));
        } else {
            let bar = case.get("support_axis").is_some();
            assert!(is("crossed_fibre_") && bar, "{name}: nobody runs this case");
            elsewhere += 1;
            continue;
        }
        seen += 1;
    }
    println!("{seen} cases run here, {elsewhere} where there are rods");
    assert!(seen > 0);
}

fn read<T: for<'a> Deserialize<'a>>(case: &Value) -> T {
    serde_json::from_value(case.clone()).unwrap_or_else(|e| panic!("{}: {e}", case["name"]))
}

fn number(case: &Value, field: &str) -> f64 {
    case[field].as_f64().unwrap_or_else(|| panic!("{}: no number {field}", case["name"]))
}

#[derive(Deserialize)]
struct Incline {
    name: String,
    alpha_deg: f64,
    mu: f64,
    v0_downhill: f64,
    g: f64,
    t: Vec<f64>,
    x_downhill: Vec<f64>,
    v_downhill: Vec<f64>,
    regime_at_rest: String,
}

/// Positions by the trapezoidal rule, exact while the acceleration is constant.
fn incline(case: &Incline) {
    let alpha = case.alpha_deg.to_radians();
    let (sine, cosine) = alpha.sin_cos();
    let (dt, mass) = (2.5e-4, 0.7);
    let mut block = [Dense::particle(mass)];
    block[0].velocity[0] = case.v0_downhill;
    let contacts = [contact(0, None, &Vector3::z(), circle(case.mu))];
    let mut impulses = [Vector3::zeros()];
    let (mut x, mut steps) = (0.0, 0_u32);
    let bounds = EndOfSlip::new(alpha, case.mu, case.g, case.v0_downhill, dt);
    let farthest = case.x_downhill.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (i, &t) in case.t.iter().enumerate() {
        while f64::from(steps) * dt < t - 0.5 * dt {
            let before = block[0].velocity[0];
            block[0].push(&[mass * case.g * sine * dt, 0.0, -mass * case.g * cosine * dt]);
            impulses = [Vector3::zeros()];
            assert!(resolve(&mut block, &contacts, &mut impulses, &mut exact()).converged);
            x += 0.5 * dt * (before + block[0].velocity[0]);
            steps += 1;
        }
        let v = block[0].velocity[0];
        let (slower, behind) = (case.v_downhill[i] - v, case.x_downhill[i] - x);
        assert!(within(slower, bounds.velocity(t)), "{} {t}: {slower:e}", case.name);
        assert!(within(behind, bounds.way(t)), "{} {t}: {behind:e}", case.name);
        assert!(behind.abs() <= 1e-3 * farthest, "{} {t}: {behind:e}", case.name);
    }
    let stuck = case.regime_at_rest == "stick" && case.v_downhill.last() == Some(&0.0);
    if stuck {
        assert!(block[0].velocity.norm() < 1e-15, "{}", case.name);
        assert!(case.v0_downhill != 0.0 || x.abs() < 1e-15, "{}: {x}", case.name);
    }
    let friction = impulses[0].yz().norm() / impulses[0].x;
    let expected = if stuck { sine / cosine } else { case.mu };
    assert!((friction - expected).abs() < 1e-12, "{}: {friction}", case.name);
}

#[derive(Deserialize)]
struct Slab {
    name: String,
    alpha_deg: f64,
    fibre_angle_deg: f64,
    mu_t1: f64,
    mu_t2: f64,
    g: f64,
    regime: String,
    stick_ratio: f64,
    #[serde(default)]
    acceleration_downhill_cross: [f64; 2],
    #[serde(default)]
    position: Vec<[f64; 2]>,
    #[serde(default)]
    t: Vec<f64>,
}

fn slab(case: &Slab) {
    let (sine, cosine) = case.alpha_deg.to_radians().sin_cos();
    let angle = case.fibre_angle_deg.to_radians();
    let axis = Vector3::new(angle.cos(), angle.sin(), 0.0);
    let curve = LimitCurve::Ellipse { mu: [case.mu_t1, case.mu_t2] };
    let contacts = [along(0, None, &Vector3::z(), &axis, curve.clone())];
    let drive = contacts[0].frame.tr_mul(&Vector3::x()).yz() * (sine / cosine);
    let ratio = curve.gauge(&drive);
    assert!((ratio - case.stick_ratio).abs() < 1e-12 * ratio, "{}: {ratio}", case.name);

    let dt = 1e-2;
    let mut block = [Dense::particle(1.3)];
    let (mut x, mut steps) = (Vector2::zeros(), 0_u32);
    let ends = if case.t.is_empty() { vec![1.0] } else { case.t.clone() };
    for (i, &t) in ends.iter().enumerate() {
        while f64::from(steps) * dt < t - 0.5 * dt {
            let before = block[0].velocity.clone();
            block[0].push(&[1.3 * case.g * sine * dt, 0.0, -1.3 * case.g * cosine * dt]);
            assert!(
                resolve(&mut block, &contacts, &mut [Vector3::zeros()], &mut exact()).converged
            );
            let mean = 0.5 * (before + &block[0].velocity);
            x += Vector2::new(mean[0], mean[1]) * dt;
            steps += 1;
        }
        let expected = case.position.get(i).copied().unwrap_or_default();
        assert!((x - Vector2::from(expected)).norm() < 1e-11, "{} {t}: {x}", case.name);
    }
    let elapsed = f64::from(steps) * dt;
    let velocity = Vector2::new(block[0].velocity[0], block[0].velocity[1]);
    let expected = Vector2::from(case.acceleration_downhill_cross) * elapsed;
    assert!((velocity - expected).norm() < 1e-11, "{}: {velocity}", case.name);
    assert_eq!(case.regime == "stick", velocity.norm() < 1e-15, "{}", case.name);
}

#[derive(Deserialize)]
struct Capstan {
    name: String,
    #[serde(rename = "T_low")]
    low: f64,
    mu: f64,
    wrap_angle_rad: f64,
    #[serde(rename = "T_high_at_slip")]
    high: f64,
}

/// On a polygon of `n` contacts the load at slip is higher by `mu phi^3 (1 + mu^2) / (12 n^2)`.
fn capstan(case: &Capstan) {
    let n = 40;
    let (mu, angle) = (case.mu, case.wrap_angle_rad);
    let ratio = rope::slipping_ratio(mu, angle, n, case.low);
    let polygonal = rope::corner(mu, angle / n as f64).powi(40);
    assert!((ratio / polygonal - 1.0).abs() < 1e-6, "{}: {ratio} {polygonal}", case.name);
    let relative = ratio * case.low / case.high - 1.0;
    let expected = mu * angle.powi(3) * (1.0 + mu * mu) / (12.0 * (n * n) as f64);
    assert!((relative - expected).abs() < 0.1 * expected + 1e-6, "{}: {relative}", case.name);
}

#[derive(Deserialize)]
struct Bounce {
    name: String,
    h0: f64,
    eps: f64,
    g: f64,
    apex_heights: Vec<f64>,
    impact_times: Vec<f64>,
    impact_speeds: Vec<f64>,
    rest_time: Option<f64>,
}

/// Free flight in closed form; every impact by the law.
fn bounce(case: &Bounce) {
    let mut ball = Dense::sphere(0.3, 0.01, &[-Vector3::z()]);
    let contacts = [contact(0, None, &Vector3::z(), circle(0.5))];
    let (mut speed, mut t) = ((2.0 * case.g * case.h0).sqrt(), (2.0 * case.h0 / case.g).sqrt());
    for (i, (&time, &fast)) in case.impact_times.iter().zip(&case.impact_speeds).enumerate() {
        assert!((t - time).abs() < 1e-12 * time && (speed - fast).abs() < 1e-12 * fast);
        ball.velocity.fill(0.0);
        ball.velocity[2] = -speed;
        let velocities = ball.velocities();
        let mut bodies: [&mut dyn Body; 1] = [&mut ball];
        let hit = impact(&mut bodies, &contacts, &[case.eps], &velocities, &mut exact());
        ball.apply(&[contacts[0].frame * hit.expect("valid").impulses[0]]);
        speed = ball.velocity[2];
        let height = speed * speed / (2.0 * case.g);
        if let Some(&apex) = case.apex_heights.get(i + 1) {
            assert!((height - apex).abs() < 1e-12 * case.h0, "{}: {height}", case.name);
        }
        t += 2.0 * speed / case.g;
    }
    // The bounces that are left take a geometric series of times.
    let rest = t + 2.0 * speed / case.g * case.eps / (1.0 - case.eps);
    if let Some(expected) = case.rest_time.filter(|_| case.eps < 1.0) {
        assert!((rest - expected).abs() < 1e-12 * rest, "{}: {rest}", case.name);
    }
}

#[derive(Deserialize)]
struct Oblique {
    name: String,
    m: f64,
    v_before: [f64; 3],
    normal: [f64; 3],
    eps: f64,
    mu: f64,
    normal_impulse: f64,
    tangential_impulse: [f64; 3],
    v_after: [f64; 3],
    regime: String,
}

fn oblique(case: &Oblique) {
    let contacts = [contact(0, None, &case.normal.into(), circle(case.mu))];
    for in_turn in [false, true] {
        let mut particle = [Dense::particle(case.m)];
        particle[0].velocity.copy_from_slice(&case.v_before);
        let velocities = particle[0].velocities();
        let mut bodies: [&mut dyn Body; 1] = [&mut particle[0]];
        let hit = if in_turn {
            impact_in_turn(&mut bodies, &contacts, &[case.eps], &velocities, 10)
        } else {
            impact(&mut bodies, &contacts, &[case.eps], &velocities, &mut exact())
        };
        let impulse = hit.expect("valid").impulses[0];
        act(&mut particle, &contacts, &[impulse]);
        let after = particle[0].velocities()[0];
        let world = contacts[0].frame * Vector3::new(0.0, impulse.y, impulse.z);
        assert!((impulse.x - case.normal_impulse).abs() <= 1e-13 * case.normal_impulse);
        assert!((world - Vector3::from(case.tangential_impulse)).norm() < 1e-13, "{}", case.name);
        assert!((after - Vector3::from(case.v_after)).norm() < 1e-13, "{}: {after}", case.name);
        let slip = contacts[0].frame.tr_mul(&after).yz().norm();
        assert_eq!(case.regime == "stick", slip < 1e-13, "{}", case.name);
    }
}

#[derive(Deserialize)]
struct Rod {
    name: String,
    m: f64,
    #[serde(rename = "L")]
    length: f64,
    contact_offset: f64,
    v_normal_before: f64,
    eps: f64,
    impulse: f64,
    v_com_after: f64,
    omega_after: f64,
    contact_normal_velocity_after: f64,
    effective_mass: f64,
}

/// A rod along x that falls along z; positive rotation lifts its positive end.
fn rod(case: &Rod) {
    let mut rod = [Dense::rod(case.m, case.length, &Vector3::x(), &[case.contact_offset])];
    rod[0].velocity[2] = case.v_normal_before;
    let contacts = [contact(0, None, &Vector3::z(), circle(0.0))];
    let mut answer = [Vector3::zeros()];
    rod[0].respond(&[Vector3::z()], &mut answer);
    assert!((1.0 / answer[0].z - case.effective_mass).abs() < 1e-12, "{}", case.name);
    let velocities = rod[0].velocities();
    let mut bodies: [&mut dyn Body; 1] = [&mut rod[0]];
    let hit = impact(&mut bodies, &contacts, &[case.eps], &velocities, &mut exact());
    let hit = hit.expect("valid");
    act(&mut rod, &contacts, &hit.impulses);
    let found =
        [hit.impulses[0].x, rod[0].velocity[2], -rod[0].velocity[4], rod[0].velocities()[0].z];
    let expected =
        [case.impulse, case.v_com_after, case.omega_after, case.contact_normal_velocity_after];
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{}: {found:?}", case.name);
    }
}

#[derive(Deserialize)]
struct Corners {
    mu_beta: Vec<f64>,
    directions_deg: Vec<f64>,
}

fn polygon(case: &Corners) -> LimitCurve {
    let points: Vec<_> = std::iter::zip(&case.mu_beta, &case.directions_deg)
        .map(|(mu, degrees)| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            Vector2::new(cosine, sine) * *mu
        })
        .collect();
    LimitCurve::Polygon(Polygon::new(&points).expect("around the origin"))
}

#[derive(Deserialize)]
struct Sample {
    slip_direction_deg: f64,
    friction_per_normal_force: [f64; 2],
    #[serde(rename = "dissipation_rate_per_N_and_unit_speed")]
    dissipation: Option<f64>,
}

/// The curve itself, and the impulse of a particle that slides fast in that direction.
fn samples(case: &Value, curve: &LimitCurve) {
    let contact =
        Contact { friction: curve.clone(), ..contact(0, None, &Vector3::z(), circle(0.0)) };
    for sample in read::<Vec<Sample>>(&case["samples"]) {
        let (sine, cosine) = sample.slip_direction_deg.to_radians().sin_cos();
        let slip = Vector2::new(cosine, sine);
        let expected = Vector2::from(sample.friction_per_normal_force);
        let friction = curve.friction(&slip);
        assert!((friction - expected).norm() < 1e-13, "{} {slip}: {friction}", case["name"]);
        if let Some(power) = sample.dissipation {
            assert!((curve.dissipation(&slip) - power).abs() < 1e-13, "{}", case["name"]);
        }
        // The slip after the impulse must have the sample's direction.
        let after = slip * 3.0;
        let free = after - expected;
        let impulse = solve_contact(
            &contact,
            &nalgebra::Matrix3::identity(),
            &Vector3::new(-1.0, free.x, free.y),
        );
        assert!((impulse.yz() - expected).norm() < 1e-12, "{} {slip}: {impulse}", case["name"]);
    }
}
