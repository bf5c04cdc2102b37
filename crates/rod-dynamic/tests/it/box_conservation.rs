//! What does not change: momentum, energy, lengths, frames, the physics of a turned scene, rest.

use crate::common::{chain, orders, planar_clamp, scaled};
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_rod_dynamic::{
    Air, BoxIntegrator, BoxOptions, Drag, End, Instant, Load, Rod, RodIntegrator, RodState, Steady,
};

fn free_flight() -> Steady {
    Steady(Instant {
        gravity: Vector3::zeros(),
        distributed: Vector3::zeros(),
        root: End::FREE,
        tip: End::FREE,
        air: None,
        inside: 0.0,
    })
}

/// Linear momentum, angular momentum about the origin (rotary inertia is negligible).
fn momenta(rod: &Rod, state: &RodState) -> (Vector3<f64>, Vector3<f64>) {
    let mut sums = (Vector3::zeros(), Vector3::zeros());
    for i in 0..rod.fiber.segments() {
        let v = 0.5 * (state.velocities[i] + state.velocities[i + 1]);
        let r = 0.5 * (state.positions[i].coords + state.positions[i + 1].coords);
        let p = rod.fiber.segment_mass(i) * v;
        sums.0 += p;
        sums.1 += r.cross(&p);
    }
    sums
}

/// Largest drifts of momentum, angular momentum and energy of a free rod that starts straight,
/// translating, turning and bending, without numerical damping.
fn drifts(segments: usize, dt: f64) -> [f64; 3] {
    let rod = Rod::new(chain(segments, |_| scaled(0.5, 0.4)));
    let mut integrator =
        BoxIntegrator::new(rod, BoxOptions::with_damping(1.0).expect("valid")).expect("valid");
    let mut state = integrator.state();
    let (pi, n) = (std::f64::consts::PI, segments as f64);
    for (j, v) in state.velocities.iter_mut().enumerate() {
        let s = j as f64 / n;
        *v = Vector3::new(0.1 * (pi * s).sin(), 0.3 * (s - 0.5), 0.1);
    }
    for (i, omega) in state.angular_velocities.iter_mut().enumerate() {
        let s = (i as f64 + 0.5) / n;
        *omega = Vector3::new(-0.3, 0.1 * pi * (pi * s).cos(), 0.0);
    }
    integrator.set_state(&state).expect("fits");
    let none = Vector3::zeros();
    let start = momenta(integrator.rod(), &integrator.state());
    let energy = integrator.energy(&none).total();
    let mut drifts = [0.0_f64; 3];
    while integrator.time() < 1.0 {
        integrator.step(dt, &free_flight()).expect("converges");
        let now = momenta(integrator.rod(), &integrator.state());
        drifts[0] = drifts[0].max((now.0 - start.0).norm());
        drifts[1] = drifts[1].max((now.1 - start.1).norm());
        drifts[2] = drifts[2].max((integrator.energy(&none).total() - energy).abs());
    }
    drifts
}

#[test]
fn momentum_and_energy_of_a_free_rod_drift_with_second_order() {
    let coarse = drifts(20, 0.02);
    let fine = drifts(40, 0.01);
    let finer = drifts(80, 0.005);
    for i in 0..3 {
        let order = orders(&[1.0, 0.5, 0.25], &[coarse[i], fine[i], finer[i]])[1];
        assert!(order > 1.8 || finer[i] < 1e-12, "drift {i}: {:e}, order {order}", finer[i]);
    }
}

/// A curly hair shaken at its root, with wind and loads, for `steps` steps.
fn shaken(turn: &UnitQuaternion<f64>, steps: usize) -> BoxIntegrator {
    let curl = Vector3::new(3.0, 4.0, 12.0) / 0.3;
    let base = planar_clamp(0.3);
    let scene = Isometry3::from_parts(Vector3::zeros().into(), *turn);
    let fiber = crate::common::hair(30)
        .with_natural_curvature(|_| curl)
        .expect("finite")
        .with_root(scene * base);
    let rod = Rod::damped(fiber, 1e-3);
    let mut integrator = BoxIntegrator::new(rod, BoxOptions::default()).expect("valid");
    let turn = *turn;
    let conditions = move |t: f64| {
        let shake = Vector3::new(0.01 * (9.0 * t).sin(), 0.0, 0.0);
        let twist = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.3, 0.2) * (7.0 * t).sin());
        let root = scene * Isometry3::from_parts(shake.into(), twist) * base;
        Instant {
            gravity: turn * crate::common::GRAVITY,
            distributed: turn * Vector3::new(1e-6, 0.0, 2e-6),
            root: End::Held(root),
            tip: End::Loaded {
                force: Load::World(turn * Vector3::new(0.0, 0.0, 1e-6)),
                moment: Load::Follower(Vector3::new(0.0, 1e-9, 0.0)),
            },
            air: Some(Air {
                wind: turn * Vector3::new(0.5, 0.0, 0.2),
                drag: Drag { normal: 1e-5, tangential: 5e-6 },
            }),
            inside: 0.0,
        }
    };
    for _ in 0..steps {
        integrator.step(0.01, &conditions).expect("converges");
    }
    integrator
}

fn check_shape(integrator: &BoxIntegrator) {
    let state = integrator.state();
    for (i, h) in integrator.rod().fiber.segment_lengths().iter().enumerate() {
        let length = (state.positions[i + 1] - state.positions[i]).norm();
        assert!((length - h).abs() < 1e-12 * h + 1e-16, "segment {i}: {length} of {h}");
        let frame = state.frames[i].matrix();
        let skew = (frame.transpose() * frame - nalgebra::Matrix3::identity()).norm();
        assert!(skew < 1e-12, "frame {i} is off by {skew}");
    }
}

#[test]
fn segments_keep_their_length_and_frames_stay_orthonormal() {
    check_shape(&shaken(&UnitQuaternion::identity(), 300));
}

#[test]
fn lengths_and_frames_hold_for_a_hundred_thousand_steps() {
    let rod = Rod::new(chain(6, |_| scaled(0.5, 0.4)));
    let mut integrator = BoxIntegrator::new(rod, BoxOptions::default()).expect("valid");
    let mut state = integrator.state();
    let rates = Vector3::new(1.0, -2.0, 3.0);
    state.angular_velocities.fill(rates);
    for (v, r) in state.velocities.iter_mut().zip(&state.positions) {
        *v = rates.cross(&r.coords);
    }
    integrator.set_state(&state).expect("fits");
    for _ in 0..100_000 {
        integrator.step(0.01, &free_flight()).expect("converges");
    }
    check_shape(&integrator);
}

#[test]
fn a_turned_scene_gives_the_turned_motion() {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(1.1, -0.7, 2.0));
    let (plain, turned) = (shaken(&UnitQuaternion::identity(), 100), shaken(&turn, 100));
    let (a, b) = (plain.state(), turned.state());
    for (p, q) in a.positions.iter().zip(&b.positions) {
        // Each step is solved to 1e-10; the error grows with the motion, not beyond 1e-7 L.
        assert!((turn * p - q).norm() < 1e-7 * 0.3, "{p} turned is not {q}");
    }
    let moved =
        (a.positions[30] - shaken(&UnitQuaternion::identity(), 1).state().positions[30]).norm();
    assert!(moved > 0.01, "the scene moves at all: {moved}");
}

#[test]
fn an_equilibrium_stays_at_rest() {
    let root = planar_clamp(0.0);
    let conditions = Steady(Instant::clamped(root, crate::common::GRAVITY));
    // Settle under heavy internal damping: the viscous rod has the same equilibrium.
    let viscous = Rod::damped(crate::common::hair(100), 1.0);
    let options = BoxOptions::with_damping(0.0).expect("valid");
    let mut settling = BoxIntegrator::new(viscous, options).expect("valid");
    for _ in 0..40 {
        settling.step(20.0, &conditions).expect("converges");
    }
    let mut state = settling.state();
    state.velocities.fill(Vector3::zeros());
    state.angular_velocities.fill(Vector3::zeros());
    let mut integrator =
        BoxIntegrator::new(Rod::new(crate::common::hair(100)), BoxOptions::default())
            .expect("valid");
    integrator.set_state(&state).expect("fits");
    // The reference case's exact tip; the box scheme's error there is 2.1e-4 L.
    let exact = Vector3::new(0.026_079_223_997, -0.289_426_328_091, 0.0);
    let error = (state.positions[100].coords - exact).norm();
    assert!(error < 2.5e-4 * 0.3, "static error {error}");
    let mut fastest = 0.0_f64;
    for _ in 0..300 {
        integrator.step(1.0 / 30.0, &conditions).expect("converges");
        fastest = fastest.max(integrator.state().velocities[100].norm());
    }
    assert!(fastest < 1e-8, "the tip moves at {fastest} m/s");
}

#[test]
fn a_state_read_and_set_is_the_same() {
    let mut integrator = shaken(&UnitQuaternion::identity(), 20);
    let state = integrator.state();
    integrator.set_state(&state).expect("fits");
    let again = integrator.state();
    let gap = |a: &[Rotation3<f64>], b: &[Rotation3<f64>]| {
        a.iter().zip(b).map(|(a, b)| (a.matrix() - b.matrix()).norm()).fold(0.0, f64::max)
    };
    assert!(gap(&state.frames, &again.frames) < 1e-13, "frames");
    let (a, b) = (&state.angular_velocities, &again.angular_velocities);
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).norm() < 1e-10), "angular velocities");
    // Curvatures that do not fit the frames are recomputed from them.
    let mut vague = state.clone();
    vague.curvatures.fill(Vector3::zeros());
    integrator.set_state(&vague).expect("fits");
    let off = (integrator.state().positions[30] - state.positions[30]).norm();
    assert!(off < 1e-3 * 0.3, "the tip is off by {off}");
}

#[test]
fn saved_numbers_continue_bit_for_bit() {
    let mut integrator = shaken(&UnitQuaternion::identity(), 20);
    let conditions = Steady(Instant::clamped(planar_clamp(0.3), crate::common::GRAVITY));
    let mut numbers = Vec::new();
    integrator.save(&mut numbers);
    integrator.step(0.01, &conditions).expect("converges");
    let first = integrator.state();
    integrator.restore(&numbers).expect("its own");
    integrator.step(0.01, &conditions).expect("converges");
    assert_eq!(first, integrator.state());
    assert!(integrator.restore(&numbers[1..]).is_err(), "too few numbers");
}
