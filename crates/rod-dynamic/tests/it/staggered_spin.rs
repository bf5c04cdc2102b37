//! Spin of free fibres about their axes in steps by backward Euler: any number of turns in a step.

use crate::common::{couples, set_out_and_solve};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, Impulses, Instant, Rod, RodError, RodStepReport, StaggeredBatch, Steady,
    StepVelocity,
};

const SEGMENTS: usize = 10;
const RADIUS: f64 = 4e-5;
const LENGTH: f64 = 0.02;
const DENSITY: f64 = 1300.0;
const DT: f64 = 1e-3;

/// A free hair at rest, straight, and what holds it: nothing.
fn free_hair(
    batch: impl Fn(Vec<Rod>, f64) -> Result<StaggeredBatch, RodError>,
) -> (StaggeredBatch, Steady) {
    let material = Material { density: DENSITY, youngs_modulus: 4e9, shear_modulus: 1.5e9 };
    let fiber = Fiber::uniform(LENGTH, SEGMENTS, Section::Circle { radius: RADIUS }, &material)
        .expect("a fibre");
    let mut instant = Instant::clamped(Isometry3::identity(), Vector3::zeros());
    instant.root = instant.tip;
    (batch(vec![Rod::new(fiber)], 0.3).expect("a batch"), Steady(instant))
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

/// A free stubby rod that tumbles and spins at once, a gyroscope, as its momentum after each of
/// some steps tells.
fn gyroscope(flying: bool, dt: f64) -> Vec<Vector3<f64>> {
    let material = Material { density: DENSITY, youngs_modulus: 4e9, shear_modulus: 1.5e9 };
    let section = Section::Circle { radius: 1e-2 };
    let fiber = Fiber::uniform(5e-2, 4, section, &material).expect("a fibre");
    let mut batch = StaggeredBatch::hybrid(vec![Rod::new(fiber)], 0.3).expect("a batch");
    let mut state = batch.state(0);
    let spin = Vector3::new(3.0, 0.0, 40.0);
    for (node, velocity) in state.velocities.iter_mut().enumerate() {
        let arm = state.frames[0] * Vector3::z() * 1.25e-2 * (node as f64 - 2.0);
        *velocity = (state.frames[0] * spin).cross(&arm);
    }
    state.angular_velocities.fill(spin);
    batch.set_state(0, &state).expect("its own state");
    batch.set_bearing(0, !flying);
    let mut instant = Instant::clamped(Isometry3::identity(), Vector3::zeros());
    instant.root = instant.tip;
    let hold = Steady(instant);
    let conditions: [&dyn Conditions; 1] = [&hold];
    let mut reports = [RodStepReport::default()];
    let mut found = vec![batch.momentum(0).angular];
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is small")]
    for _ in 0..(0.2 / dt).round() as usize {
        batch.step(dt, &conditions, &mut reports).expect("a step");
        found.push(batch.momentum(0).angular);
    }
    found
}

/// Spin and tumbling exchange angular momentum by the gyroscopic torque: what is left of the error
/// of the whole is of second order in flight, and of first order for what bears.
#[test]
fn a_gyroscope_keeps_its_angular_momentum() {
    for (flying, order) in [(true, 2.0), (false, 1.0)] {
        let worst = |dt: f64| {
            let found = gyroscope(flying, dt);
            let off = found.iter().map(|momentum| (momentum - found[0]).norm());
            off.fold(0.0, f64::max) / found[0].norm()
        };
        let [coarse, fine] = [1e-3, 2.5e-4].map(worst);
        let found = (coarse / fine).log(4.0);
        println!("flying: {flying}, errors {coarse:e}, {fine:e}, order {found}");
        assert!(found > order - 0.2, "{found}, errors {coarse:e} and {fine:e}");
        assert!(fine < 1e-2, "{fine:e}");
    }
}

/// A hair that is thrown tumbling end over end, and bears nothing, keeps its angular momentum as
/// the method of second order does; one that bears loses it.
#[test]
fn what_flies_is_hardly_damped() {
    let tumbling = |flying: bool| {
        let (mut batch, hold) = free_hair(StaggeredBatch::hybrid);
        let mut state = batch.state(0);
        let spin = Vector3::new(100.0, 0.0, 0.0);
        for (node, velocity) in state.velocities.iter_mut().enumerate() {
            let arm = LENGTH * (node as f64 / SEGMENTS as f64 - 0.5) * Vector3::z();
            *velocity = state.frames[0] * spin.cross(&arm);
        }
        state.angular_velocities.fill(spin);
        batch.set_state(0, &state).expect("its own state");
        let before = batch.momentum(0).angular;
        let mut reports = [RodStepReport::default()];
        batch.set_bearing(0, !flying);
        for _ in 0..1000 {
            batch.step(DT, &[&hold], &mut reports).expect("a step");
        }
        batch.momentum(0).angular.dot(&before) / before.norm_squared()
    };
    let [flying, bearing] = [true, false].map(tumbling);
    println!("{flying}, {bearing}");
    assert!(flying > 0.95 && bearing < 0.5, "{flying}, {bearing}");
}

/// Segments of a clamped hair that spin at rates of their own come to rest in steps in which these
/// would be many turns: torsion knows no whole turns, so none may be left to one segment alone.
#[test]
fn no_segment_keeps_whole_turns_of_its_own() {
    let (mut batch, _) = free_hair(|rods, _| StaggeredBatch::backward_euler(rods));
    let hold = Steady(Instant::clamped(Isometry3::identity(), Vector3::zeros()));
    let mut state = batch.state(0);
    for (segment, rate) in state.angular_velocities.iter_mut().enumerate() {
        *rate = Vector3::z() * 60.0 * (1.0 + segment as f64).sin();
    }
    batch.set_state(0, &state).expect("its own state");
    let mut reports = [RodStepReport::default()];
    let mut fastest = |dt: f64| {
        batch.step(dt, &[&hold], &mut reports).expect("a step");
        spins(&batch).iter().map(Vector3::norm).fold(0.0, f64::max)
    };
    // Less than half a turn in the first step, and nothing but rounding after that.
    let found = [1.0, 1.0, 0.1].map(&mut fastest);
    assert!(found[0] < std::f64::consts::PI, "{found:?}");
    assert!(found[1..].iter().all(|rate| *rate < 1e-9), "{found:?}");
}

proptest! {
    /// A moment `M` for an instant on all segments alike gives the spin `M / J`, which goes on for
    /// ever: of a radian or of hundreds in a step.
    #[test]
    fn a_free_fibre_spins_on(turns in prop_oneof![-1.0..1.0_f64, -300.0..300.0]) {
        let method = |rods, _| StaggeredBatch::backward_euler(rods);
        let (mut batch, hold) = free_hair(method);
        let conditions: [&dyn Conditions; 1] = [&hold];
        let axis = batch.state(0).frames[0] * Vector3::z();
        let spin = turns / DT;
        let moment = axis * spin * polar_inertia() / SEGMENTS as f64;
        let all = Impulses { points: &couples(SEGMENTS), impulses: &[moment; SEGMENTS] };
        set_out_and_solve(&mut batch, DT, &conditions, all).expect("a step");
        let mut mean = [Vector3::zeros(); SEGMENTS];
        batch.spins(StepVelocity::Mean, None, &mut [&mut mean]).expect("lengths");
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
    let (mut batch, hold) = free_hair(|rods, _| StaggeredBatch::backward_euler(rods));
    let conditions: [&dyn Conditions; 1] = [&hold];
    let axis = batch.state(0).frames[0] * Vector3::z();
    let momentum = 20.0 / DT * polar_inertia();
    let all = Impulses { points: &couples(1), impulses: &[momentum * axis] };
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
