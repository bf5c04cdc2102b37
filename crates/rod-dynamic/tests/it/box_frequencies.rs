//! Frequencies of small oscillations against closed forms.

use crate::common::{Frequencies, planar_clamp};
use nalgebra::{Rotation3, Vector3};
use rapunzel_fiber::{Fiber, Material, Section, so3};
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator};

/// First root of cos x cosh x = -1.
const BETA: f64 = 1.875_104_068_711_961_1;

/// Curvature of the first mode of a cantilever, 1 at the root.
fn mode(s: f64) -> f64 {
    let sigma = (BETA.cos() + BETA.cosh()) / (BETA.sin() + BETA.sinh());
    let x = BETA * s;
    0.5 * (x.cosh() + x.cos() - sigma * (x.sinh() + x.sin()))
}

/// Angular frequency of the tip's crossings of its rest position, for a rod released from a small
/// deflection in its first mode.
fn measured(fiber: Fiber, gravity: Vector3<f64>, expected: f64, dt: f64) -> f64 {
    swing(Rod::new(fiber), gravity, expected, dt).0
}

/// The same, and by what factor the tip's largest deflection shrinks in each half period.
fn swing(rod: Rod, gravity: Vector3<f64>, expected: f64, dt: f64) -> (f64, f64) {
    let root = *rod.fiber.root();
    let segments = rod.fiber.segments();
    let amplitude = 1e-3 / rod.fiber.length();
    let options = BoxOptions::with_damping(1.0).expect("valid");
    let mut integrator = BoxIntegrator::new(rod, options).expect("valid");
    let mut state = integrator.state();
    let h = integrator.rod().fiber.segment_lengths().to_vec();
    let mut frame: Rotation3<f64> = root.rotation.to_rotation_matrix();
    for (j, kappa) in state.curvatures.iter_mut().enumerate() {
        kappa.x = amplitude * mode(j as f64 / segments as f64);
    }
    for i in 0..segments {
        let half = so3::exp(&(0.25 * h[i] * (state.curvatures[i] + state.curvatures[i + 1])));
        state.frames[i] = frame * half;
        frame = state.frames[i] * half;
    }
    integrator.set_state(&state).expect("fits");
    // Rest is straight along d3; the deflection is along d2.
    let across = root.rotation * Vector3::y();
    let deflection = |i: &BoxIntegrator| i.state().positions[segments].coords.dot(&across);
    let conditions = |_: f64| Instant::clamped(root, gravity);
    let mut crossings = Vec::new();
    let mut peaks = vec![0.0_f64];
    let mut last = deflection(&integrator);
    while crossings.len() < 17 {
        integrator.step(dt, &conditions).expect("converges");
        assert!(integrator.time() < 20.0 * 6.3 / expected, "it swings");
        let now = deflection(&integrator);
        let peak = peaks.last_mut().expect("never empty");
        *peak = peak.max(now.abs());
        if last * now < 0.0 {
            peaks.push(0.0);
            crossings.push(integrator.time() - dt * now / (now - last));
        }
        last = now;
    }
    let half_periods = 16.0;
    let omega = std::f64::consts::PI * half_periods / (crossings[16] - crossings[0]);
    (omega, (peaks[16] / peaks[1]).powf(1.0 / 15.0))
}

/// The midpoint rule slows an oscillation of frequency omega by (omega dt)^2 / 12, and as the box
/// scheme treats space as it treats time, a wave of wave number beta is off by (beta h)^2 / 12.
fn check(name: &str, found: f64, expected: f64, dt: f64, wave_number: f64, segments: usize) {
    let space = (wave_number / segments as f64).powi(2) / 12.0;
    let tolerance = (expected * dt).powi(2) / 12.0 + space;
    let error = (found / expected - 1.0).abs();
    assert!(error < 1.2 * tolerance, "{name}: {found} for {expected}, error {error:e}");
}

#[test]
fn cantilevers_swing_at_their_first_frequency() {
    let cases: Vec<Frequencies> = cases("d_linear_frequencies.json").expect("the oracle");
    let segments = 40;
    let mut checked = 0;
    for case in &cases {
        if let (Some(hz), Some(e), Some(rho), Some(radius), Some(length), Some(g)) = (
            &case.bending_hz,
            case.youngs_modulus,
            case.rho,
            case.radius,
            case.length,
            case.shear_modulus,
        ) {
            let material = Material { density: rho, youngs_modulus: e, shear_modulus: g };
            let fiber = Fiber::uniform(length, segments, Section::Circle { radius }, &material)
                .expect("valid")
                .with_root(planar_clamp(0.0));
            let expected = std::f64::consts::TAU * hz[0];
            let dt = 0.05 / expected;
            let found = measured(fiber, Vector3::zeros(), expected, dt);
            check(&case.name, found, expected, dt, BETA, segments);
            checked += 1;
        }
        if let (Some(g), Some(omega)) = (case.gravity_parameter, &case.omega_bending) {
            // Units EI = rho A = L = 1: gravity is G, along the hanging rod.
            let node = crate::common::scaled(1.0, 1.0);
            let fiber = crate::common::chain(segments, |_| node).with_root(planar_clamp(0.0));
            let dt = 0.05 / omega[0];
            let found = measured(fiber, Vector3::new(g, 0.0, 0.0), omega[0], dt);
            check(&case.name, found, omega[0], dt, omega[0].sqrt(), segments);
            checked += 1;
        }
    }
    assert!(checked > 0, "no case with a stiff rod");
}

/// A Kelvin-Voigt rod's mode of frequency omega decays as exp(-tau omega^2 t / 2).
#[test]
fn internal_damping_damps_at_its_rate() {
    let node = crate::common::scaled(1.0, 1.0);
    let fiber = crate::common::chain(40, |_| node).with_root(planar_clamp(0.0));
    let omega = BETA * BETA;
    let (tau, dt) = (0.01 / omega, 0.05 / omega);
    let rod = Rod::damped(fiber, tau);
    let (_, shrinks) = swing(rod, Vector3::zeros(), omega, dt);
    let expected = (-tau * omega * std::f64::consts::PI / 2.0).exp();
    // The rate is off as the frequency is, and peaks are seen at steps: (omega dt)^2 / 8 at most.
    let tolerance = (0.05_f64).powi(2) / 8.0 / 15.0 + 1e-3 * (1.0 - expected);
    assert!((shrinks - expected).abs() < tolerance, "{shrinks} for {expected}");
}
