//! Equilibria of the staggered rod between two clamps.

use crate::common::{Clamped, chain, scaled};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{
    End, Instant, Load, Rod, RodIntegrator, RodState, Staggered, Steady, equilibrium,
};
use std::f64::consts::TAU;

/// Steps of the continuation along a path of clamps.
const PARTS: u32 = 20;

/// Positions at the stations of a case, and the elastic energy.
fn follow(case: &Clamped, segments: usize) -> (Vec<Vector3<f64>>, f64) {
    let rod = Rod::new(case.fiber(segments));
    let mut state = Staggered::new(rod.clone()).expect("a valid rod").state();
    let solve = |tip: End, part: f64, state: &RodState| {
        let gravity = Vector3::new(0.0, 0.0, -case.g * part);
        let conditions = Instant { tip, ..Instant::clamped(Isometry3::identity(), gravity) };
        let (state, _) = equilibrium(&rod, &conditions, state)
            .unwrap_or_else(|e| panic!("{}, part {part}: {e}", case.name));
        (state, conditions)
    };
    let moment = Load::World(Vector3::from(case.start_moment));
    (state, _) = solve(End::Loaded { force: Load::ZERO, moment }, 0.0, &state);
    let h = 1.0 / segments as f64;
    let last = state.frames[segments - 1];
    let mut from = Isometry3::from_parts(
        Translation3::from(state.positions[segments].coords),
        UnitQuaternion::from_rotation_matrix(
            &(last * so3::exp(&(state.curvatures[segments] * 0.5 * h))),
        ),
    );
    let mut conditions = None;
    for to in &case.path_from_start_state {
        let to = Isometry3::from_parts(
            Translation3::from(Vector3::from(to.r)),
            UnitQuaternion::from_scaled_axis(Vector3::from(to.rotvec)),
        );
        for part in 1..=PARTS {
            let part = f64::from(part) / f64::from(PARTS);
            // Slerp of the oracle's path is not needed: the branch is what counts.
            let pose = from.lerp_slerp(&to, part);
            let solved = solve(End::Held(pose), part, &state);
            (state, conditions) = (solved.0, Some(solved.1));
        }
        from = to;
    }
    let stations = case.stations.iter().map(|station| {
        let at = |node: &usize| (*node as f64 * h - station.s).abs() < 1e-9;
        let node = (0..=segments).find(at).expect("a station at a node");
        state.positions[node].coords
    });
    (stations.collect(), elastic(&rod, &conditions.expect("a path"), &state))
}

/// All cases: the error falls with the square of the segments, and extrapolated 1e-6 remain of the
/// positions and 1e-5 of the energy.
#[test]
fn clamped_rods_bend_as_the_reference() {
    let cases: Vec<Clamped> = cases("c_clamped_clamped.json").expect("the oracle");
    for case in &cases {
        let [coarse, fine] = [100, 200].map(|segments| follow(case, segments));
        let mut worst = [0.0_f64; 2];
        for (i, station) in case.stations.iter().enumerate() {
            let exact = Vector3::from(station.r);
            let extrapolated = (4.0 * fine.0[i] - coarse.0[i]) / 3.0;
            worst[0] = worst[0].max((coarse.0[i] - exact).norm());
            worst[1] = worst[1].max((extrapolated - exact).norm());
        }
        let energy = (4.0 * fine.1 - coarse.1) / 3.0 / case.elastic_energy - 1.0;
        let curvature = Vector3::from(case.kappa0).norm_squared();
        let bound = 1e-4 * (0.5 + curvature / 24.0);
        assert!(worst[0] < bound, "{}: {:e} of {bound:e}", case.name, worst[0]);
        assert!(worst[1] < 1e-6, "{}: {:e} extrapolated", case.name, worst[1]);
        assert!(energy.abs() < 1e-5, "{}: energy off by {energy:e}", case.name);
    }
}

/// S9 and D11 (Michell 1889, Zajac 1962): a naturally straight rod is twisted and welded to a ring.
/// It keeps its plane and its twist up to `2 pi sqrt(3) B / C` and leaves them beyond.
#[test]
fn a_twisted_ring_loses_its_twist() {
    let (n, torsion) = (100, 2.0 / 3.0);
    let zajac = TAU * 3.0_f64.sqrt() / torsion;
    for part in [0.5, 0.98, 1.02, 1.2] {
        let twist = part * zajac;
        let frame =
            |s: f64| so3::exp(&(TAU * s * Vector3::y())) * so3::exp(&(twist * s * Vector3::z()));
        let rod = Rod::new(chain(n, |_| scaled(1.0, torsion)));
        let mut state = Staggered::new(rod.clone()).expect("a valid rod").state();
        for (e, f) in state.frames.iter_mut().enumerate() {
            *f = frame((e as f64 + 0.5) / n as f64);
        }
        let tip = Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_rotation_matrix(&frame(1.0)),
        );
        let conditions = Instant {
            tip: End::Held(tip),
            ..Instant::clamped(Isometry3::identity(), Vector3::zeros())
        };
        let (state, _) = equilibrium(&rod, &conditions, &state).expect("an equilibrium");
        let energy = elastic(&rod, &conditions, &state);
        let planar = 0.5 * (TAU.powi(2) + torsion * twist.powi(2));
        // Once out of its plane the ring turns two turns of twist into writhe and loses them.
        let lost = 0.5 * torsion * (twist.powi(2) - (twist - 2.0 * TAU).powi(2));
        let expected = if part < 1.0 { planar } else { planar - lost };
        let error = (energy / expected - 1.0).abs();
        assert!(error < 1e-3, "{part} of the critical twist: energy {energy} for {expected}");
    }
}

/// Elastic energy of an equilibrium; a short rest in it measures the joints at the ends.
fn elastic(rod: &Rod, conditions: &Instant, state: &RodState) -> f64 {
    let mut integrator = Staggered::new(rod.clone()).expect("a valid rod");
    integrator.set_state(state).expect("a state of the rod");
    integrator.step(1e-9, &Steady(*conditions)).expect("rest");
    integrator.energy(&Vector3::zeros()).elastic
}
