//! Frequencies of the linearised staggered rod against closed forms and Ritz values.

use crate::common::{Frequencies, chain, planar_clamp, scaled};
use nalgebra::{Isometry3, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{
    End, Instant, Mode, Rod, RodIntegrator, Staggered, equilibrium, linearize,
};
use std::f64::consts::{PI, TAU};

/// Modes of the equilibrium that the natural shape falls into.
fn modes(fiber: Fiber, conditions: &Instant, count: usize) -> Vec<Mode> {
    let rod = Rod::new(fiber);
    let start = Staggered::new(rod.clone()).expect("a valid rod").state();
    let (state, _) = equilibrium(&rod, conditions, &start).expect("an equilibrium");
    let modes = linearize(&rod, conditions, &state).and_then(|l| l.modes(count));
    modes.expect("modes")
}

/// Whether a mode of a straight rod along x turns its segments about their axis.
fn is_torsion(mode: &Mode) -> bool {
    let (along, all) = mode
        .rotations
        .iter()
        .fold((0.0, 0.0), |(along, all), q| (along + q.x * q.x, all + q.norm_squared()));
    along > 0.5 * all
}

/// The frequencies of bending modes (of circular sections: each is double), or of torsion.
fn frequencies(modes: &[Mode], torsion: bool) -> Vec<f64> {
    let chosen = modes.iter().filter(|m| is_torsion(m) == torsion).map(|m| m.angular_frequency);
    chosen.step_by(if torsion { 1 } else { 2 }).collect()
}

/// Checks frequencies of three meshes: errors of `c (beta h)^2`, `beta` the wave number, and what
/// two extrapolations leave, of order `(beta h)^6`, beside the reference's own error.
fn check(
    name: &str,
    expected: &[f64],
    wave: impl Fn(usize) -> f64,
    at: impl Fn(usize) -> Vec<f64>,
) {
    let meshes = [20, 40, 80].map(|n| (n, at(n)));
    for (i, exact) in expected.iter().enumerate() {
        let error = |n: usize, omega: f64| {
            let bound = (wave(i) / n as f64).powi(2) / 3.0;
            let error = (omega / exact - 1.0).abs();
            assert!(error < bound + 1e-6, "{name}: mode {i}, {n} segments: {error:e} of {bound:e}");
        };
        let [a, b, c] = [0, 1, 2].map(|k| {
            error(meshes[k].0, meshes[k].1[i]);
            meshes[k].1[i]
        });
        let (ab, bc) = ((4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0);
        let left = (((16.0 * bc - ab) / 15.0) / exact - 1.0).abs();
        let bound = (wave(i) / 40.0).powi(6) + 5e-7;
        assert!(left < bound, "{name}: mode {i} extrapolated: {left:e} of {bound:e}");
    }
}

/// Wave number of the i-th bending mode of a cantilever.
fn bending_wave(i: usize) -> f64 {
    (i as f64 + 0.5) * PI + if i == 0 { 0.3 } else { 0.0 }
}

/// D1, D2, D3: every case of the file.
#[test]
fn frequencies_meet_every_reference() {
    let cases: Vec<Frequencies> = cases("d_linear_frequencies.json").expect("the oracle");
    for case in &cases {
        let name = &case.name;
        if let (Some(e), Some(density), Some(radius), Some(length), Some(g)) =
            (case.youngs_modulus, case.rho, case.radius, case.length, case.shear_modulus)
        {
            let material = Material { density, youngs_modulus: e, shear_modulus: g };
            let solve = |torsion| {
                move |n| {
                    let fiber = Fiber::uniform(length, n, Section::Circle { radius }, &material)
                        .expect("valid")
                        .with_root(planar_clamp(0.0));
                    let still = Instant::clamped(*fiber.root(), Vector3::zeros());
                    let all = modes(fiber, &still, 3 * n);
                    frequencies(&all, torsion).iter().map(|omega| omega / TAU).collect()
                }
            };
            let bending = case.bending_hz.as_ref().expect("bending frequencies");
            check(name, bending, bending_wave, solve(false));
            let torsion = case.torsion_hz.as_ref().expect("torsion frequencies");
            check(name, torsion, |i| (i as f64 + 0.5) * PI, solve(true));
        } else if let Some(omega) = &case.omega_bending {
            // Units EI = rho A = L = 1; hanging along x.
            let gravity = Vector3::x() * case.gravity_parameter.unwrap_or(0.0);
            let epsilon = case.rotary_inertia.unwrap_or(1e-12);
            // The clamp's boundary layer has the wave number sqrt(G).
            let layer = gravity.x.powf(0.5) / 3.0;
            check(
                name,
                omega,
                |i| bending_wave(i) + layer,
                |n| {
                    let mut node = scaled(1.0, 1.0);
                    // Torsion much faster than bending.
                    node.stiffness.z = 1e3;
                    node.rotary_inertia = Vector3::new(1.0, 1.0, 2.0) * epsilon;
                    let fiber = chain(n, |_| node).with_root(planar_clamp(0.0));
                    let conditions = Instant::clamped(*fiber.root(), gravity);
                    frequencies(&modes(fiber, &conditions, 3 * n), false)
                },
            );
        } else if let (Some(omega), Some(g), Some(length)) = (&case.omega, case.g, case.length) {
            // Stiffness shortens a chain at its clamp by sqrt(B / (w L)) and so raises all
            // frequencies by half of that over L: 5e-8 here.
            // A chain's waves shorten towards its tip, where w'' = w' j^2 / 8, j the zero of J0.
            let j0 = |i: usize| (i as f64 + 0.75) * PI;
            let stiffness = 1e-14 * g * length.powi(3);
            check(
                name,
                omega,
                |i| j0(i).max(j0(i).powi(2) / 8.0),
                |n| {
                    let mut node = scaled(stiffness, g * length.powi(3));
                    node.rotary_inertia *= 1e-4 * length * length;
                    let lengths = vec![length / n as f64; n];
                    let fiber = Fiber::new(planar_clamp(0.0), lengths, vec![node; n + 1]);
                    let fiber = fiber.expect("valid");
                    let conditions = Instant::clamped(*fiber.root(), g * Vector3::x());
                    frequencies(&modes(fiber, &conditions, 3 * n), false)
                },
            );
        } else {
            panic!("{name}: a case of no known kind");
        }
    }
}

/// D1 at 100 segments.
#[test]
fn hundred_segments_meet_the_first_four_frequencies() {
    let fiber = chain(100, |_| scaled(1.0, 1e3)).with_root(planar_clamp(0.0));
    let still = Instant::clamped(*fiber.root(), Vector3::zeros());
    let found = frequencies(&modes(fiber, &still, 12), false);
    let exact = [3.516_015_269, 22.034_491_565, 61.697_214_414, 120.901_916_052];
    for ((found, exact), tolerance) in found.iter().zip(exact).zip([1e-3, 2e-3, 5e-3, 1e-2]) {
        let error = (found / exact - 1.0).abs();
        assert!(error < tolerance, "{found} for {exact}: {error:e}");
    }
}

/// A rod that nothing holds: six motions that cost nothing, then the free-free beam's modes.
#[test]
fn free_rod_has_six_rigid_motions() {
    let mut node = scaled(1.0, 10.0);
    node.rotary_inertia *= 100.0;
    let fiber = chain(60, |_| node).with_root(planar_clamp(0.0));
    let free =
        Instant { root: End::FREE, ..Instant::clamped(Isometry3::identity(), Vector3::zeros()) };
    let rod = Rod::new(fiber);
    let state = Staggered::new(rod.clone()).expect("a valid rod").state();
    let linear = linearize(&rod, &free, &state).expect("an equilibrium");
    let modes = linear.modes(10).expect("modes");
    for mode in &modes[..6] {
        let rate = mode.angular_frequency.max(mode.growth_rate);
        // Rounding of the highest omega^2, which is that of torsion: 4 C / (h^2 I3).
        let highest = 4.0 * 10.0 * 60.0_f64.powi(2) / node.rotary_inertia.z;
        assert!(rate.powi(2) < 1e-14 * highest, "a rigid motion at {rate}");
    }
    for (mode, beta) in [(&modes[6], 4.730_040_744_862_704_f64), (&modes[8], 7.853_204_624)] {
        let error = (mode.angular_frequency / (beta * beta) - 1.0).abs();
        assert!(error < (beta / 60.0).powi(2) / 4.0, "{} : {error:e}", mode.angular_frequency);
    }
}

/// Mode shapes have modal mass one and keep the segments' lengths to first order.
#[test]
fn shapes_are_orthonormal_motions_of_the_rod() {
    let fiber = chain(30, |s| {
        let mut node = scaled(0.1 - 0.05 * s, 0.1);
        node.natural_curvature = Vector3::new(2.0, 1.0, 3.0 * s);
        node
    });
    let conditions = Instant::clamped(*fiber.root(), Vector3::new(1.0, 0.3, 0.2));
    let rod = Rod::new(fiber);
    let start = Staggered::new(rod.clone()).expect("a valid rod").state();
    let (state, _) = equilibrium(&rod, &conditions, &start).expect("an equilibrium");
    let modes = linearize(&rod, &conditions, &state).and_then(|l| l.modes(6)).expect("modes");
    for mode in &modes {
        let mut kinetic = 0.0;
        for (a, u) in mode.displacements.iter().enumerate() {
            kinetic += u.norm_squared() / 30.0 * if a % 30 == 0 { 0.5 } else { 1.0 };
        }
        // Rotary inertia is 1e-8.
        assert!((kinetic - 1.0).abs() < 1e-3, "modal mass {kinetic}");
        for e in 0..30 {
            let stretch = (mode.displacements[e + 1] - mode.displacements[e])
                .dot(&(state.frames[e] * Vector3::z()));
            assert!(stretch.abs() < 1e-12, "segment {e} stretches by {stretch:e}");
        }
    }
}
