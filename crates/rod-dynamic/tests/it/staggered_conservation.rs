//! What the staggered rod keeps: lengths, momentum, its place in an equilibrium, the frame of
//! reference; and what it loses: the energy of fast oscillations, as its method says.

use crate::common::{chain, planar_clamp, scaled};
use nalgebra::{Complex, Isometry3, Matrix3, Translation3, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, so3};
use rapunzel_rod_dynamic::{
    Air, Drag, End, Instant, Load, Rod, RodIntegrator, RodState, Staggered, Steady, equilibrium,
    linearize,
};
use std::f64::consts::PI;

/// D7: after 1e5 steps of a whip.
#[test]
fn lengths_and_frames_hold_to_rounding() {
    let fiber =
        crate::common::hair(6).with_natural_curvature(|_| Vector3::new(0.0, 4.0, 12.0) / 0.3);
    let rod = Rod::new(fiber.expect("finite"));
    let mut integrator = Staggered::new(rod).expect("valid");
    let root = planar_clamp(0.0);
    let shaken = |t: f64| {
        let moved = Translation3::new(0.05 * (7.0 * t).sin(), 0.0, 0.03 * (5.0 * t).sin());
        Instant::clamped(moved * root, crate::common::GRAVITY)
    };
    for _ in 0..100_000 {
        integrator.step(0.01, &shaken).expect("converges");
    }
    let state = integrator.state();
    for (e, h) in integrator.rod().fiber.segment_lengths().iter().enumerate() {
        let length = (state.positions[e + 1] - state.positions[e]).norm();
        assert!((length / h - 1.0).abs() < 1e-12, "segment {e}: {length} for {h}");
        let r = state.frames[e].matrix();
        let skewed = (r.transpose() * r - Matrix3::identity()).amax();
        assert!(skewed < 1e-12, "frame {e} is off by {skewed:e}");
    }
}

/// A curled rod that is thrown, turning.
fn thrown(rho: f64) -> Staggered {
    let fiber = chain(20, |s| {
        let mut node = scaled(0.1, 0.08);
        node.linear_density = 1.3 - 0.6 * s;
        node.natural_curvature = Vector3::new(2.0, 1.0, 3.0);
        node
    });
    let mut integrator = Staggered::with_rho_inf(Rod::new(fiber), rho).expect("valid");
    let mut state = integrator.state();
    let spin = Vector3::new(1.0, 2.0, -1.5);
    for (v, r) in state.velocities.iter_mut().zip(&state.positions) {
        *v = Vector3::new(0.3, -0.2, 0.5) + spin.cross(&r.coords);
    }
    for (omega, frame) in state.angular_velocities.iter_mut().zip(&state.frames) {
        *omega = frame.inverse() * spin;
    }
    integrator.set_state(&state).expect("fits");
    integrator
}

/// Momentum and angular momentum; rotary inertia is 1e-8 and left out.
fn momenta(fiber: &Fiber, state: &RodState) -> (Vector3<f64>, Vector3<f64>) {
    let mut sum = (Vector3::zeros(), Vector3::zeros());
    for e in 0..fiber.segments() {
        for a in [e, e + 1] {
            let p = 0.5 * fiber.segment_mass(e) * state.velocities[a];
            sum.0 += p;
            sum.1 += state.positions[a].coords.cross(&p);
        }
    }
    sum
}

/// D6: the momentum of a flying rod changes by the impulse of its weight, to rounding.
#[test]
fn momentum_changes_by_the_impulse_of_gravity() {
    for (rho, gravity) in [(0.0, 1.0), (0.3, 0.0), (0.3, 1.0), (0.8, 0.0), (0.8, 1.0)] {
        let gravity = gravity * Vector3::new(0.1, -1.0, 0.2);
        let mut integrator = thrown(rho);
        let flight =
            Instant { root: End::FREE, ..Instant::clamped(Isometry3::identity(), gravity) };
        let fiber = integrator.rod().fiber.clone();
        let (mut before, _) = momenta(&fiber, &integrator.state());
        let dt = 0.01;
        for step in 0..200 {
            integrator.step(dt, &Steady(flight)).expect("converges");
            let (now, _) = momenta(&fiber, &integrator.state());
            let missing = (now - before - dt * fiber.mass() * gravity).norm();
            assert!(missing < 1e-12 * now.norm(), "rho {rho}, step {step}: {missing:e}");
            before = now;
        }
    }
}

/// Nodes and directors move by straight increments, so that angular momentum is kept to the second
/// order of the method only.
#[test]
fn angular_momentum_drifts_with_second_order() {
    for rho in [0.3, 0.8] {
        let drift = |steps: usize| {
            let mut integrator = thrown(rho);
            let flight = Instant {
                root: End::FREE,
                ..Instant::clamped(Isometry3::identity(), Vector3::zeros())
            };
            let fiber = integrator.rod().fiber.clone();
            let (_, start) = momenta(&fiber, &integrator.state());
            for _ in 0..steps {
                integrator.step(0.5 / steps as f64, &Steady(flight)).expect("converges");
            }
            let (_, end) = momenta(&fiber, &integrator.state());
            (end - start).norm() / start.norm()
        };
        let (coarse, fine) = (drift(100), drift(200));
        assert!(fine < 1e-3 && fine < coarse / 3.0, "rho {rho}: {fine:e} after {coarse:e}");
    }
}

/// D10: ten seconds at 1/30 s in an equilibrium.
#[test]
fn equilibria_stay() {
    let curled = |fiber: Fiber| fiber.with_natural_curvature(|s| Vector3::new(5.0, 10.0 * s, 20.0));
    for fiber in [crate::common::hair(100), curled(crate::common::hair(50)).expect("finite")] {
        let rod = Rod::new(fiber);
        let hang = Instant::clamped(planar_clamp(0.0), crate::common::GRAVITY);
        let mut integrator = Staggered::new(rod.clone()).expect("valid");
        let (state, _) = equilibrium(&rod, &hang, &integrator.state()).expect("an equilibrium");
        integrator.set_state(&state).expect("fits");
        let mut fastest = 0.0_f64;
        for _ in 0..300 {
            integrator.step(1.0 / 30.0, &Steady(hang)).expect("converges");
            let speed = integrator.state().velocities.last().map_or(0.0, |v| v.norm());
            fastest = fastest.max(speed);
        }
        assert!(fastest < 1e-8, "tip moves at {fastest:e} m/s");
    }
}

/// The largest amplification factor of generalised-alpha (Chung and Hulbert 1993) for `y'' =
/// -omega^2 y`, from its amplification of `(y, dt y', dt^2 a)`.
fn amplification(rho: f64, omega_dt: f64) -> Complex<f64> {
    let (am, af) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
    let (gamma, beta) = (0.5 - am + af, 0.25 * (1.0 - am + af).powi(2));
    let w = omega_dt * omega_dt;
    let left = Matrix3::new(1.0, 0.0, -beta, 0.0, 1.0, -gamma, (1.0 - af) * w, 0.0, 1.0 - am);
    let right = Matrix3::new(1.0, 1.0, 0.5 - beta, 0.0, 1.0, 1.0 - gamma, -af * w, 0.0, -am);
    let matrix = left.try_inverse().expect("regular") * right;
    let factors = matrix.complex_eigenvalues();
    let larger = |a: Complex<f64>, b: &Complex<f64>| if b.norm() > a.norm() { *b } else { a };
    factors.iter().fold(Complex::new(0.0, 0.0), larger)
}

/// D5: a small oscillation in the rod's first mode loses energy as the method does for one degree
/// of freedom.
#[test]
fn small_oscillations_are_damped_as_the_method_says() {
    let rod = Rod::new(chain(20, |_| scaled(1.0, 1.0)).with_root(planar_clamp(0.0)));
    let still = Instant::clamped(planar_clamp(0.0), Vector3::zeros());
    let rest = Staggered::new(rod.clone()).expect("valid").state();
    let modes = linearize(&rod, &still, &rest).and_then(|l| l.modes(1)).expect("modes");
    let mode = &modes[0];
    for rho in [0.0, 0.3, 0.5, 0.8, 1.0] {
        for omega_dt in [0.2, 0.5, 1.0] {
            let mut integrator = Staggered::with_rho_inf(rod.clone(), rho).expect("valid");
            let mut state = rest.clone();
            for (frame, q) in state.frames.iter_mut().zip(&mode.rotations) {
                *frame = so3::exp(&(1e-3 * q)) * *frame;
            }
            integrator.set_state(&state).expect("fits");
            let dt = omega_dt / mode.angular_frequency;
            let factor = amplification(rho, omega_dt);
            let expected = factor.norm().ln();
            // The energy oscillates at twice the frequency: means are taken over a whole number of
            // half periods.
            let halves = |n: usize| n as f64 * factor.arg().abs() / PI;
            let fraction = |n: &usize| (halves(*n) - halves(*n).round()).abs();
            let period = (20..60).min_by(|a, b| fraction(a).total_cmp(&fraction(b))).expect("some");
            let mut mean = |steps: usize| {
                (0..steps)
                    .map(|_| {
                        integrator.step(dt, &Steady(still)).expect("converges");
                        integrator.energy(&Vector3::zeros()).total().ln()
                    })
                    .sum::<f64>()
                    / steps as f64
            };
            mean(20);
            let (first, second) = (mean(period), mean(period));
            let found = 0.5 * (second - first) / period as f64;
            // Where the phase does not come round within 1e-3, 2 % at omega dt = 1.
            let tolerance = 0.02 * expected.abs() + 1e-6;
            assert!((found - expected).abs() < tolerance, "rho {rho}: {found:e} for {expected:e}");
        }
    }
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

/// A curled rod with a moving root, wind and an end load, all turned and shifted by `by`.
fn scene(by: &Isometry3<f64>) -> RodState {
    let fiber = chain(12, |s| {
        let mut node = scaled(0.1 - 0.05 * s, 0.08);
        node.stiffness.y = 0.2;
        node.natural_curvature = Vector3::new(1.0, 2.0 * s, 3.0);
        node
    });
    let turn = by.rotation;
    let conditions = |t: f64| {
        let root = Isometry3::new(Vector3::x() * 0.1 * t * t, Vector3::y() * 0.5 * t * t);
        let force = Load::World(turn * Vector3::new(0.1, 0.2, 0.1));
        Instant {
            tip: End::Loaded { force, moment: Load::Follower(Vector3::new(0.0, 0.02, 0.01)) },
            air: Some(Air {
                wind: turn * Vector3::new(0.2, 0.3, 0.1),
                drag: Drag { normal: 0.2, tangential: 0.1 },
            }),
            ..Instant::clamped(by * root, turn * Vector3::new(0.0, -1.0, 0.3))
        }
    };
    let rod = Rod::damped(fiber.with_root(*by), 0.01);
    let mut integrator = Staggered::new(rod).expect("valid");
    for _ in 0..40 {
        integrator.step(0.02, &conditions).expect("converges");
    }
    integrator.state()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]
    /// D8: a scene that is turned and shifted as a whole does the same there.
    #[test]
    fn turned_scenes_do_the_same(turn in vector(3.0), shift in vector(2.0)) {
        let by = Isometry3::new(shift, turn);
        let (here, there) = (scene(&Isometry3::identity()), scene(&by));
        let rotation = by.rotation.to_rotation_matrix();
        for a in 0..=12 {
            let off = (by * here.positions[a] - there.positions[a]).norm();
            prop_assert!(off < 1e-9, "node {a} is off by {off:e}");
            let off = (rotation * here.velocities[a] - there.velocities[a]).norm();
            prop_assert!(off < 1e-8, "velocity {a} is off by {off:e}");
            let off = (here.curvatures[a] - there.curvatures[a]).norm();
            prop_assert!(off < 1e-8, "curvature {a} is off by {off:e}");
        }
    }
}

/// Without loads the natural shape has no energy and stays, however its curvature varies.
#[test]
fn natural_shapes_rest() {
    let fiber = chain(40, |s| {
        let mut node = scaled(1.0, 0.7);
        node.natural_curvature = Vector3::new(9.0 * (20.0 * s).sin(), 5.0 * s, 3.0 - 8.0 * s * s);
        node
    });
    let hold = Steady(Instant::clamped(*fiber.root(), Vector3::zeros()));
    let mut rod = Staggered::new(Rod::new(fiber.clone())).expect("a valid rod");
    let start = rod.state();
    for _ in 0..100 {
        rod.step(0.01, &hold).expect("a step");
    }
    let energy = rod.energy(&Vector3::zeros()).total();
    assert!(energy < 1e-24, "energy {energy:e}");
    let tip = rod.state().tip(&fiber);
    let moved = (tip.translation.vector - start.tip(&fiber).translation.vector).norm();
    assert!(moved < 1e-12, "the tip moved by {moved:e}");
}
