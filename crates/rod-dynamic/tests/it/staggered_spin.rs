//! Spin of free fibres about their axes in steps by backward Euler: any number of turns in a step.

use crate::common::set_out_and_solve;
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, Impulses, Instant, Rod, RodStepReport, StaggeredBatch, Steady,
};

const SEGMENTS: usize = 10;
const RADIUS: f64 = 4e-5;
const LENGTH: f64 = 0.02;
const DENSITY: f64 = 1300.0;
const DT: f64 = 1e-3;

/// A free hair at rest, straight, and what holds it: nothing.
fn free_hair() -> (StaggeredBatch, Steady) {
    let material = Material { density: DENSITY, youngs_modulus: 4e9, shear_modulus: 1.5e9 };
    let fiber = Fiber::uniform(LENGTH, SEGMENTS, Section::Circle { radius: RADIUS }, &material)
        .expect("a fibre");
    let mut instant = Instant::clamped(Isometry3::identity(), Vector3::zeros());
    instant.root = instant.tip;
    let batch = StaggeredBatch::backward_euler(vec![Rod::new(fiber)]).expect("a batch");
    (batch, Steady(instant))
}

/// Polar inertia of the whole hair, `m r^2 / 2`, kg m^2.
fn polar_inertia() -> f64 {
    let mass = DENSITY * std::f64::consts::PI * RADIUS.powi(2) * LENGTH;
    0.5 * mass * RADIUS.powi(2)
}

/// Angular velocities of all segments, rad/s, world.
fn spins(batch: &StaggeredBatch) -> Vec<Vector3<f64>> {
    let state = batch.state(0);
    state.frames.iter().zip(&state.angular_velocities).map(|(frame, spin)| frame * spin).collect()
}

proptest! {
    /// A moment `M` for an instant on all segments alike gives the spin `M / J`, which goes on for
    /// ever: of a radian or of thousands in a step.
    #[test]
    fn a_free_fibre_spins_on(turns in prop_oneof![-1.0..1.0_f64, -4000.0..4000.0]) {
        let (mut batch, hold) = free_hair();
        let conditions: [&dyn Conditions; 1] = [&hold];
        let axis = batch.state(0).frames[0] * Vector3::z();
        let spin = turns / DT;
        let moment = axis * spin * polar_inertia() / SEGMENTS as f64;
        let (nodes, moments) = ([Vector3::zeros(); SEGMENTS + 1], [moment; SEGMENTS]);
        let all = Impulses { nodes: &nodes, segments: &moments };
        set_out_and_solve(&mut batch, DT, &conditions, all).expect("a step");
        let mut mean = [Vector3::zeros(); SEGMENTS];
        batch.mean_spins(&mut mean).expect("lengths");
        batch.accept();
        let mut reports = [RodStepReport::default()];
        for _ in 0..20 {
            batch.step(DT, &conditions, &mut reports).expect("a step");
        }
        // Rounding of each of 21 steps, times what torsion is stiffer than inertia, 3e5.
        let bound = 21.0 * 3e5 * f64::EPSILON * (1.0 + turns.abs()) / DT;
        for found in mean.into_iter().chain(spins(&batch)) {
            let error = (found - spin * axis).norm();
            prop_assert!(error <= bound, "{found:?} for {spin}");
        }
    }
}

/// Spun at one end only, a fibre twists and untwists until it turns as a whole: with the angular
/// momentum that it was given.
#[test]
fn spin_spreads_along_a_fibre() {
    let (mut batch, hold) = free_hair();
    let conditions: [&dyn Conditions; 1] = [&hold];
    let axis = batch.state(0).frames[0] * Vector3::z();
    let momentum = 20.0 / DT * polar_inertia();
    let nodes = [Vector3::zeros(); SEGMENTS + 1];
    let mut moments = [Vector3::zeros(); SEGMENTS];
    moments[0] = momentum * axis;
    let all = Impulses { nodes: &nodes, segments: &moments };
    set_out_and_solve(&mut batch, DT, &conditions, all).expect("a step");
    batch.accept();
    let mut reports = [RodStepReport::default()];
    for _ in 0..20 {
        batch.step(DT, &conditions, &mut reports).expect("a step");
        let left = batch.momentum(0).angular - momentum * axis;
        assert!(left.norm() < 1e-10 * momentum, "{left:?} of {momentum}");
    }
    for spin in spins(&batch) {
        assert!((spin - 20.0 / DT * axis).norm() < 1e-6 / DT, "{spin:?}");
    }
}
