//! Every kind of end and load, against exact motions; and what is refused.

use crate::common::{chain, planar_clamp, scaled};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_dynamic::{
    Air, BoxIntegrator, BoxOptions, Drag, End, Instant, Load, Rod, RodIntegrator, Steady, StepError,
};

const SEGMENTS: usize = 40;

/// A rod of unit length, mass and the given stiffness along x.
fn rod(stiffness: f64) -> Rod {
    Rod::new(chain(SEGMENTS, |_| scaled(stiffness, 0.8 * stiffness)).with_root(planar_clamp(0.0)))
}

fn integrator(rod: Rod) -> BoxIntegrator {
    BoxIntegrator::new(rod, BoxOptions::default()).expect("valid")
}

fn nothing() -> Instant {
    Instant {
        gravity: Vector3::zeros(),
        distributed: Vector3::zeros(),
        root: End::FREE,
        tip: End::FREE,
        air: None,
        inside: 0.0,
    }
}

/// A clamped rod that is whirled at a constant rate stays straight, under the tension
/// `rho omega^2 (1 - s^2) / 2`.
#[test]
fn a_whirling_rod_stays_straight() {
    let mut integrator = integrator(rod(0.1));
    let rate = 2.0;
    let mut state = integrator.state();
    for (j, v) in state.velocities.iter_mut().enumerate() {
        *v = Vector3::new(0.0, rate * j as f64 / SEGMENTS as f64, 0.0);
    }
    state.angular_velocities.fill(Vector3::new(rate, 0.0, 0.0));
    integrator.set_state(&state).expect("fits");
    let conditions = |t: f64| Instant::clamped(planar_clamp(rate * t), Vector3::zeros());
    for _ in 0..100 {
        integrator.step(0.02, &conditions).expect("converges");
    }
    let state = integrator.state();
    let angle = rate * integrator.time();
    let exact = Vector3::new(angle.cos(), angle.sin(), 0.0);
    assert!((state.positions[SEGMENTS].coords - exact).norm() < 1e-8, "straight");
    for (i, force) in state.forces.iter().enumerate() {
        let s = (i as f64 + 0.5) / SEGMENTS as f64;
        let tension = 0.5 * rate * rate * (1.0 - s * s);
        // The force is a mean of nodes: off by rho omega^2 h^2 / 8.
        let tolerance = rate * rate / (8.0 * (SEGMENTS * SEGMENTS) as f64) + 1e-7;
        assert!((force.norm() - tension).abs() < tolerance, "segment {i}: {force}");
    }
}

/// Both ends held: the tip is pushed toward the root, the rod buckles, and the tip does not drift
/// from its support.
#[test]
fn a_held_tip_does_not_drift() {
    let mut rod = rod(1.0);
    rod.damping_time = 0.01;
    rod.fiber = rod.fiber.with_natural_curvature(|_| Vector3::new(0.2, 0.05, 0.0)).expect("finite");
    let mut integrator = integrator(rod);
    let rest = integrator.state();
    let root = planar_clamp(0.0);
    // The unloaded tip, from a rod that keeps its shape.
    let end = rest.positions[SEGMENTS];
    let tip_frame = rest.frames[SEGMENTS - 1] * so3::exp(&(rest.curvatures[SEGMENTS] / 80.0));
    let support = move |t: f64| {
        let s = (t / 2.0).min(1.0);
        let path = s * s * (3.0 - 2.0 * s);
        let turn = UnitQuaternion::from_scaled_axis(0.5 * path * Vector3::x());
        let rotation = turn * so3::quaternion(&tip_frame);
        Isometry3::from_parts((end.coords - 0.4 * path * Vector3::x()).into(), rotation)
    };
    let conditions = move |t: f64| Instant {
        tip: End::Held(support(t)),
        ..Instant::clamped(root, Vector3::zeros())
    };
    let tip = |i: &BoxIntegrator| {
        let state = i.state();
        let half = 0.25 / SEGMENTS as f64;
        let bend = half * (state.curvatures[SEGMENTS - 1] + state.curvatures[SEGMENTS]);
        (state.positions[SEGMENTS], state.frames[SEGMENTS - 1] * so3::exp(&bend))
    };
    let mut worst = 0.0_f64;
    for _ in 0..400 {
        integrator.step(0.02, &conditions).expect("converges");
        worst = worst.max(
            (tip(&integrator).0.coords - support(integrator.time()).translation.vector).norm(),
        );
    }
    // While it moves at up to 0.3 L per unit of time the tip lags by truncation errors of a step;
    // once it rests it is where it should be.
    let (position, frame) = tip(&integrator);
    let target = support(integrator.time());
    let gap = (position.coords - target.translation.vector).norm();
    let turn = so3::log(&(frame.inverse() * target.rotation.to_rotation_matrix())).norm();
    assert!(worst < 1e-4, "lags by {worst:e}");
    assert!(gap < 1e-9 && turn < 1e-8, "rests {gap:e} and {turn:e} off");
    assert!(integrator.state().positions[SEGMENTS / 2].coords.yz().norm() > 0.1, "buckled");
}

/// A stiff rod pinned at its root is a pendulum of frequency sqrt(3 g / 2 L).
#[test]
fn a_pinned_rod_is_a_pendulum() {
    let mut integrator = integrator(rod(1e4));
    let turned = planar_clamp(-std::f64::consts::FRAC_PI_2 + 0.01);
    let fiber = chain(SEGMENTS, |_| scaled(1e4, 1e4)).with_root(turned);
    let hung = BoxIntegrator::new(Rod::new(fiber), *integrator.options()).expect("valid");
    integrator.set_state(&hung.state()).expect("fits");
    let conditions = Steady(Instant {
        gravity: -Vector3::y(),
        root: End::pinned(Point3::origin()),
        ..nothing()
    });
    let dt = 0.02;
    let mut crossings = Vec::new();
    let mut last = integrator.state().positions[SEGMENTS].x;
    while crossings.len() < 5 {
        integrator.step(dt, &conditions).expect("converges");
        let now = integrator.state().positions[SEGMENTS].x;
        if last * now < 0.0 {
            crossings.push(integrator.time() - dt * now / (now - last));
        }
        last = now;
    }
    let omega = 4.0 * std::f64::consts::PI / (crossings[4] - crossings[0]);
    let exact = 1.5_f64.sqrt();
    // (omega dt)^2 / 12 of the midpoint rule, five times at rho 0.8; h^2 of the mass at means.
    let tolerance = (exact * dt).powi(2) / 2.0 + (1.0 / SEGMENTS as f64).powi(2);
    assert!((omega / exact - 1.0).abs() < tolerance, "{omega} for {exact}");
    let root = integrator.state().positions[0].coords.norm();
    assert!(root < 1e-15, "the pin holds: {root:e}");
}

/// A pinned tip stays, and the rod hangs between its ends.
#[test]
fn a_pinned_tip_stays() {
    let mut rod = rod(0.05);
    rod.damping_time = 0.1;
    let (root, curl) = (planar_clamp(-0.4), Vector3::new(0.5, 0.0, 0.0));
    rod.fiber = rod.fiber.with_root(root).with_natural_curvature(|_| curl).expect("finite");
    let mut integrator = integrator(rod);
    let start = integrator.state().positions[SEGMENTS];
    let pin = move |t: f64| start - 0.2 * (t / 2.0).min(1.0) * Vector3::x();
    let conditions = |t: f64| Instant {
        gravity: -Vector3::y(),
        tip: End::pinned(pin(t)),
        ..Instant::clamped(root, Vector3::zeros())
    };
    for _ in 0..200 {
        integrator.step(0.05, &conditions).expect("converges");
    }
    let state = integrator.state();
    let gap = (state.positions[SEGMENTS] - pin(20.0)).norm();
    assert!(gap < 1e-9, "the tip is off by {gap:e}");
    assert!(state.positions[SEGMENTS / 2].y < -0.1, "the rod sags");
    // No moment at a pin: the natural curvature.
    let off = (state.curvatures[SEGMENTS] - curl).norm();
    assert!(off < 1e-6, "{}", state.curvatures[SEGMENTS]);
}

/// A free rod falls as a body, and a push at its ends accelerates it by force over mass.
#[test]
fn a_free_rod_falls() {
    let mut integrator = integrator(rod(10.0));
    let push = End::Loaded { force: Load::World(Vector3::z()), moment: Load::ZERO };
    let conditions = Steady(Instant { gravity: -Vector3::y(), root: push, tip: push, ..nothing() });
    let dt = 0.01;
    for _ in 0..50 {
        integrator.step(dt, &conditions).expect("converges");
    }
    let state = integrator.state();
    let (t, mass) = (integrator.time(), 1.0);
    let mean = |f: &dyn Fn(usize) -> Vector3<f64>| {
        (0..SEGMENTS).map(|i| 0.5 * (f(i) + f(i + 1))).sum::<Vector3<f64>>() / SEGMENTS as f64
    };
    let velocity = mean(&|j| state.velocities[j]);
    let center = mean(&|j| state.positions[j].coords) - Vector3::new(0.5, 0.0, 0.0);
    let acceleration = Vector3::new(0.0, -1.0, 2.0 / mass);
    let second_order = dt * dt * 3.0 + (1.0 / SEGMENTS as f64).powi(2);
    assert!((velocity - acceleration * t).norm() < second_order, "{velocity}");
    assert!((center - 0.5 * acceleration * t * t).norm() < second_order, "{center}");
}

/// A rod that falls through air reaches weight over drag, across and along.
#[test]
fn drag_limits_the_fall() {
    for (down, coefficient) in [(-Vector3::y(), 2.0), (Vector3::x(), 1.0)] {
        let wind = Vector3::new(0.1, 0.2, 0.3);
        let air = Air { wind, drag: Drag { normal: 2.0, tangential: 1.0 } };
        let mut integrator = integrator(rod(0.1));
        let mut state = integrator.state();
        state.velocities.fill(wind);
        integrator.set_state(&state).expect("fits");
        let conditions = Steady(Instant { gravity: down, air: Some(air), ..nothing() });
        for _ in 0..300 {
            integrator.step(0.1, &conditions).expect("converges");
        }
        let velocity = integrator.state().velocities[SEGMENTS / 2] - wind;
        assert!((velocity - down / coefficient).norm() < 1e-7, "{velocity} for {down}");
    }
}

/// Weights hung on the nodes bend a rod as the same weight spread out, to second order in h.
#[test]
fn node_forces_bend_like_a_distributed_force() {
    let settled = |forces: Option<Vec<Vector3<f64>>>, distributed| {
        let mut rod = rod(0.1);
        rod.damping_time = 5.0;
        let mut integrator = integrator(rod);
        if let Some(forces) = forces {
            integrator.set_node_forces(&forces).expect("one per node");
        }
        let conditions = Steady(Instant {
            distributed,
            ..Instant::clamped(planar_clamp(0.0), Vector3::zeros())
        });
        for _ in 0..60 {
            integrator.step(5.0, &conditions).expect("converges");
        }
        integrator.state().positions[SEGMENTS]
    };
    let weight = Vector3::new(0.0, -1.0, 0.2);
    let mut forces = vec![weight / SEGMENTS as f64; SEGMENTS + 1];
    forces[0] *= 0.5;
    forces[SEGMENTS] *= 0.5;
    let (hung, spread) = (settled(Some(forces), Vector3::zeros()), settled(None, weight));
    let off = (hung - spread).norm();
    assert!(off < (1.0 / SEGMENTS as f64).powi(2), "off by {off:e}");
    assert!(spread.y < -0.4, "it bends: {spread}");
}

/// A held end that is let go falls on.
#[test]
fn a_held_root_can_be_released() {
    let mut integrator = integrator(rod(0.1));
    let conditions = |t: f64| Instant {
        root: if t < 0.5 { End::Held(planar_clamp(0.0)) } else { End::FREE },
        gravity: -Vector3::y(),
        ..nothing()
    };
    for _ in 0..100 {
        integrator.step(0.02, &conditions).expect("converges");
    }
    assert!(integrator.state().positions[0].y < -0.5, "{}", integrator.state().positions[0]);
}

#[test]
fn what_makes_no_sense_is_refused_and_changes_nothing() {
    let mut integrator = integrator(rod(0.1));
    let conditions = Steady(Instant::clamped(planar_clamp(0.0), -Vector3::y()));
    integrator.step(0.05, &conditions).expect("converges");
    let before = integrator.state();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(integrator.step(dt, &conditions), Err(StepError::TimeStep(_))),
            "a step of {dt} s"
        );
    }
    let late_nan = |t: f64| {
        let gravity = if t < 0.09 { -Vector3::y() } else { Vector3::repeat(f64::NAN) };
        Instant::clamped(planar_clamp(0.0), gravity)
    };
    let error = integrator.step(0.05, &late_nan).expect_err("NaN");
    assert!(matches!(error, StepError::Conditions { what: "gravity", .. }), "{error}");
    assert!(integrator.set_node_forces(&[Vector3::zeros()]).is_err(), "one force for 41 nodes");
    assert!(
        BoxIntegrator::new(Rod { damping_time: f64::NAN, ..rod(0.1) }, BoxOptions::default())
            .is_err()
    );
    assert_eq!(before, integrator.state(), "untouched");
}

#[test]
fn a_step_that_does_not_converge_says_so_and_changes_nothing() {
    // One iteration never reaches 1e-15 from a free fall into a bend.
    let options = BoxOptions { max_iterations: 1, tolerance: 1e-15, ..BoxOptions::default() };
    let mut integrator = BoxIntegrator::new(rod(0.1), options).expect("valid");
    let before = integrator.state();
    let conditions = Steady(Instant::clamped(planar_clamp(0.0), -Vector3::y()));
    let error = integrator.step(1.0, &conditions).expect_err("cannot converge");
    let StepError::NotConverged { residuals, dt, .. } = &error else { panic!("{error}") };
    assert!(residuals.len() == 2 && *dt < 1e-3, "{error}");
    assert_eq!(before, integrator.state(), "untouched");
}
