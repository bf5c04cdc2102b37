//! Blocks on slopes and belts: contact.md's tests 1 to 5, 15 and 17.
use crate::common::{Dense, G, along, circle, contact, exact, polygon, resolve};
use nalgebra::{Matrix3, Vector2, Vector3};
use rapunzel_contact::{Friction, LimitCurve, solve_contact};

const DT: f64 = 1e-3;

/// Velocity along and across a slope after `steps` steps from rest, and the way made.
fn slide(
    degrees: f64,
    axis_degrees: f64,
    curve: &LimitCurve,
    steps: usize,
) -> (Vector2<f64>, Vector2<f64>) {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let axis = axis_degrees.to_radians();
    let axis = Vector3::new(axis.cos(), axis.sin(), 0.0);
    let contacts = [along(0, None, &Vector3::z(), &axis, curve.clone())];
    let mut block = [Dense::particle(0.1)];
    let mut way = Vector2::zeros();
    for _ in 0..steps {
        block[0].push(&[0.1 * G * sine * DT, 0.0, -0.1 * G * cosine * DT]);
        assert!(resolve(&mut block, &contacts, &mut [Vector3::zeros()], &mut exact()).converged);
        way += block[0].velocities()[0].xy() * DT;
    }
    (block[0].velocities()[0].xy(), way)
}

/// The angle at which a slope's block begins to slip, and the direction in which it does.
fn slip_angle(axis_degrees: f64, curve: &LimitCurve) -> (f64, Vector2<f64>) {
    let (mut low, mut high) = (0.0, 80.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if slide(middle, axis_degrees, curve, 1).0.norm() > 1e-15 {
            high = middle;
        } else {
            low = middle;
        }
    }
    (high, slide(high, axis_degrees, curve, 1).0.normalize())
}

#[test]
fn a_block_slips_at_the_angle_of_friction_and_not_before() {
    let (angle, _) = slip_angle(0.0, &circle(0.47));
    assert!((angle - 25.174).abs() < 1e-3, "{angle}");
    for mu in [0.0, 5.0_f64] {
        let (angle, _) = slip_angle(0.0, &circle(mu));
        assert!((angle - mu.atan().to_degrees()).abs() < 1e-5, "{mu}: {angle}");
    }
    for curve in [circle(0.47), LimitCurve::cuticle(0.3, 0.48, 0.6), polygon(&[0.48; 8])] {
        let (velocity, way) = slide(25.17, 0.0, &curve, 10_000);
        let stays = curve.contains(&Vector2::new(-25.17_f64.to_radians().tan(), 0.0), 1.0);
        assert!(stays, "the axis points downhill: the slope drives tip first, against the scales");
        assert!(velocity.norm() < 1e-16 && way.norm() < 1e-15, "{curve:?}: {way}");
    }
}

#[test]
fn a_sliding_block_accelerates_by_the_rest() {
    let angle = 35_f64.to_radians();
    let expected = G * (angle.sin() - 0.47 * angle.cos());
    assert!((expected - 1.850).abs() < 1e-3);
    for steps in [1, 2, 100] {
        let (velocity, _) = slide(35.0, 0.0, &circle(0.47), steps);
        let acceleration = velocity.x / (steps as f64 * DT);
        assert!((acceleration - expected).abs() < 1e-12 * expected);
    }
}

#[test]
fn a_block_stops_in_its_time_and_way() {
    let mut block = [Dense::particle(0.1)];
    block[0].velocity[0] = 1.0;
    let contacts = [contact(0, None, &Vector3::z(), circle(0.3))];
    let (mut time, mut way) = (0.0, 0.0);
    while block[0].velocity[0] > 0.0 {
        let before = block[0].velocity[0];
        block[0].push(&[0.0, 0.0, -0.1 * G * DT]);
        resolve(&mut block, &contacts, &mut [Vector3::zeros()], &mut exact());
        way += 0.5 * DT * (before + block[0].velocity[0]);
        time += DT;
    }
    assert!((time - 0.33979).abs() < DT && (way - 0.16989).abs() < DT, "{time} {way}");
}

#[test]
fn an_anisotropic_slab_slips_where_dissipation_is_largest() {
    let curve = LimitCurve::Ellipse { mu: [0.2, 0.4] };
    let (angle, direction) = slip_angle(45.0, &curve);
    let axis = Vector2::new(1.0, 1.0).normalize();
    let off = axis.dot(&direction).acos().to_degrees();
    println!("slips at {angle:.4} degrees, {off:.4} degrees off the axis of low friction");
    assert!((angle - 14.197).abs() < 1e-3, "{angle}");
    assert!((off - 14.036).abs() < 1e-2, "{off}");
    // As quarter-ellipses, and nearly as a polygon of many corners.
    let (same, _) = slip_angle(45.0, &LimitCurve::Quarters { mu: [0.2, 0.2, 0.4, 0.4] });
    assert!((same - angle).abs() < 1e-6);
    let mu: Vec<_> = (0..720)
        .map(|k| {
            let (sine, cosine) = f64::from(k).mul_add(0.5, 0.0).to_radians().sin_cos();
            (cosine / 0.2).hypot(sine / 0.4).recip()
        })
        .collect();
    let (near, _) = slip_angle(45.0, &polygon(&mu));
    assert!((near - angle).abs() < 1e-2, "{near}");
}

#[test]
fn a_cuticle_slips_one_way_before_the_other() {
    let (with, against) = (0.19, 0.38);
    let quarters = LimitCurve::cuticle(with, against, 0.25);
    let corners = polygon(&[with, 0.22, 0.25, 0.3, against, 0.3, 0.25, 0.22]);
    for curve in [quarters, corners] {
        // The axis uphill: gravity draws root first.
        let (root_first, _) = slip_angle(180.0, &curve);
        let (tip_first, _) = slip_angle(0.0, &curve);
        assert!((root_first - with.atan().to_degrees()).abs() < 1e-5, "{root_first}");
        assert!((tip_first - against.atan().to_degrees()).abs() < 1e-5, "{tip_first}");
    }
}

/// A cube that slides on its four corners leans on the front ones, and nothing lifts it.
#[test]
fn a_slider_is_not_lifted() {
    let (edge, mass) = (0.1, 1.0);
    let inertia = Matrix3::from_diagonal_element(mass * edge * edge / 6.0);
    let corners: Vec<_> = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
        .map(|(x, y)| Vector3::new(x, y, -1.0) * (0.5 * edge))
        .to_vec();
    let mut cube = [Dense::rigid(mass, &inertia, &corners)];
    cube[0].velocity[0] = 6.0;
    let contacts: Vec<_> = (0..4).map(|i| contact(i, None, &Vector3::z(), circle(0.5))).collect();
    let mut impulses = [Vector3::zeros(); 4];
    let mut lift = [0.0_f64; 4];
    let mut steps = 0;
    while cube[0].velocity[0] > 1e-9 {
        cube[0].push(&[0.0, 0.0, -mass * G * DT, 0.0, 0.0, 0.0]);
        // The impulses of the last step act at first.
        let report = resolve(&mut cube, &contacts, &mut impulses, &mut exact());
        assert!(report.converged, "{steps} {report:?}");
        for (lift, v) in lift.iter_mut().zip(cube[0].velocities()) {
            *lift += v.z * DT;
        }
        steps += 1;
    }
    let worst = lift.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    println!("cube at 6 m/s: {steps} steps, lift at most {worst:.1e} m");
    assert!(worst < 1e-9, "{lift:?}");
    assert!((f64::from(steps) * DT - 6.0 / (0.5 * G)).abs() < 2.0 * DT);
}

/// 1 g on a spring of 1 N/m and a belt of 1 cm/s: it sticks until the spring draws with the
/// friction at rest, then swings about the place where it draws with that of sliding.
#[test]
fn a_belt_makes_an_oscillator_stick_and_slip() {
    let (mass, stiffness, belt, dt) = (1e-3_f64, 1.0, 0.01, 1e-5);
    let friction = Friction { resting: circle(0.4), sliding: circle(0.3) };
    let w = (stiffness / mass).sqrt();
    let overshoot = 0.1 * mass * G / stiffness;
    assert!((overshoot - 0.981e-3).abs() < 1e-9);
    let period =
        2.0 * overshoot / belt + 2.0 / w * (std::f64::consts::PI - (w * overshoot / belt).atan());
    let mut on_belt = along(0, None, &Vector3::z(), &Vector3::x(), circle(0.0));
    on_belt.bias.y = -belt;
    let response = Matrix3::identity() / mass;
    let (mut x, mut v, mut stuck, mut t) = (0.0, belt, true, 0.0);
    let mut slips = Vec::new();
    while slips.len() < 4 {
        let free = v - dt * stiffness / mass * x;
        on_belt.friction = friction.curve(stuck).clone();
        let impulse = solve_contact(&on_belt, &response, &Vector3::new(-G * dt, free - belt, 0.0));
        v = free + impulse.y / mass;
        let sticks = (v - belt).abs() < 1e-12;
        if stuck && !sticks {
            slips.push(t);
        }
        stuck = sticks;
        x += v * dt;
        t += dt;
    }
    let found = (slips[3] - slips[1]) / 2.0;
    println!("stick-slip period {found:.5} s, theory {period:.5} s");
    assert!((found / period - 1.0).abs() < 5e-3, "{found} {period}");
}
