//! Rods that are fed through a nozzle, out of it and into it.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Air, Conditions, Drag, End, Instant, Ledger, Load, Rod, RodStepReport, StaggeredBatch,
    StepError,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const LENGTH: f64 = 0.1;
const RADIUS: f64 = 5e-4;
const MATTER: Material = Material { density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6 };
const G: f64 = 9.81;

fn rod(segments: usize, damping_time: f64) -> Rod {
    let fiber = Fiber::uniform(LENGTH, segments, Section::Circle { radius: RADIUS }, &MATTER);
    Rod::damped(fiber.expect("a valid fibre"), damping_time)
}

fn weight_per_length() -> f64 {
    MATTER.density * PI * RADIUS.powi(2) * G
}

fn bending() -> f64 {
    MATTER.youngs_modulus * TAU / 8.0 * RADIUS.powi(4)
}

/// The conditions of a rod that leaves a nozzle at `mouth`, along its z axis, and is inside it by a
/// length, m.
fn fed(mouth: Isometry3<f64>, inside: f64) -> Instant {
    let root = mouth * Translation3::new(0.0, 0.0, -inside);
    Instant { inside, ..Instant::clamped(root, Vector3::zeros()) }
}

fn down() -> Isometry3<f64> {
    Isometry3::rotation(Vector3::x() * PI)
}

/// A batch of one, by backward Euler or the generalised-alpha method, straight through a nozzle at
/// `mouth` and moving along its axis.
fn batch(
    own: &Rod,
    rho: Option<f64>,
    mouth: Isometry3<f64>,
    inside: f64,
    speed: f64,
) -> StaggeredBatch {
    let root = mouth * Translation3::new(0.0, 0.0, -inside);
    let own = Rod { fiber: own.fiber.clone().with_root(root), ..own.clone() };
    let mut batch = match rho {
        None => StaggeredBatch::backward_euler(vec![own]),
        Some(rho) => StaggeredBatch::new(vec![own], rho),
    }
    .expect("a batch");
    let mut state = batch.state(0);
    state.velocities.fill(mouth * Vector3::z() * speed);
    batch.set_state(0, &state).expect("fits");
    batch.keep_ledgers(true);
    batch
}

/// Takes steps; returns the sum of their ledgers, and the share of all that was turned over that
/// the worst of them misses.
fn run(batch: &mut StaggeredBatch, dt: f64, steps: usize, now: &dyn Conditions) -> (Ledger, f64) {
    let (mut sum, mut worst) = (Ledger::default(), 0.0_f64);
    for _ in 0..steps {
        let before = batch.energy(0, &Vector3::zeros());
        batch.step(dt, &[now], &mut [RodStepReport::default()]).expect("a step");
        let after = batch.energy(0, &Vector3::zeros());
        let one = batch.ledger(0).expect("kept");
        let works = [one.kinetic, one.elastic, one.supports, one.gravity, one.loads];
        let scale = works.iter().map(|x| x.abs()).sum::<f64>() + 1e-3 * after.total();
        worst = worst.max((one.gain() - one.work()).abs() / scale);
        worst = worst.max((after.elastic - before.elastic - one.elastic).abs() / scale);
        worst = worst.max((after.kinetic - before.kinetic - one.kinetic).abs() / scale);
        sum += one;
    }
    (sum, worst)
}

/// A straight rod that is paid out downward hangs with the weight of what is outside, whatever part
/// of a segment that is, and drawn in it lifts a load by the work of both: to rounding.
#[test]
fn a_straight_rod_hangs_by_what_is_outside() {
    let gravity = -Vector3::z() * G;
    for rho in [None, Some(0.3)] {
        for (start, speed) in [(0.08, 0.05), (0.03, -0.05)] {
            let load = 2e-3;
            let inside = move |t: f64| start - speed * t;
            let tip = End::Loaded { force: Load::World(-load * Vector3::z()), moment: Load::ZERO };
            let now = move |t: f64| Instant { gravity, tip, ..fed(down(), inside(t)) };
            let mut batch = batch(&rod(16, 0.0), rho, down(), start, speed);
            let mut supports = 0.0;
            for _ in 0..100 {
                let (sum, missed) = run(&mut batch, 1e-2, 1, &now);
                assert!(missed < 1e-11, "{missed:e}");
                supports += sum.supports;
                let state = batch.state(0);
                let out = LENGTH - inside(state.time);
                let right = load + weight_per_length() * out;
                let found = -state.forces[0].z;
                assert!((found / right - 1.0).abs() < 1e-9, "{found} for {right}");
                let tip = state.positions[16].z + out;
                assert!(tip.abs() < 1e-14, "{tip:e}");
            }
            // The work of the nozzle: against the load, and the weight that grows with the length.
            let outside = [start, inside(1.0)].map(|inside| LENGTH - inside);
            let right = -load * (outside[1] - outside[0])
                - 0.5 * weight_per_length() * (outside[1].powi(2) - outside[0].powi(2));
            // Weights are those at the ends of steps, or means, of which the first is not known.
            let room = weight_per_length() * (speed * 1e-2).powi(2) * 100.0;
            assert!((supports - right).abs() < 0.51 * room, "{supports:e} for {right:e}");
        }
    }
}

/// A rod that is bent by a couple at its end has the same moment everywhere, and the nozzle pushes
/// it out by `m^2 / 2 B`, the force of a sliding sleeve: so much does it cost to pull it out
/// slowly, or is gained, per length.
#[test]
fn a_bent_rod_is_pushed_out_by_its_moment() {
    let moment = 0.4 * bending() / LENGTH * FRAC_PI_2;
    let (start, way) = (0.05, 0.02);
    for sign in [1.0, -1.0] {
        // At rest first, then slowly on.
        let inside = move |t: f64| start - sign * way * ((t - 1.0) / 9.0).clamp(0.0, 1.0);
        let force = Load::World(Vector3::x() * moment);
        let tip = End::Loaded { force: Load::ZERO, moment: force };
        let now = move |t: f64| Instant { tip, ..fed(Isometry3::identity(), inside(t)) };
        let mut batch = batch(&rod(20, 0.0), None, Isometry3::identity(), start, 0.0);
        run(&mut batch, 5e-3, 200, &now);
        let (sum, missed) = run(&mut batch, 5e-3, 1800, &now);
        assert!(missed < 1e-9, "{missed:e}");
        let push = -sum.supports / (sign * way);
        let right = moment.powi(2) / (2.0 * bending());
        println!("pushed by {push:e} N for {right:e} N");
        // A segment is let go, or held, a 64th of a joint early: twice that part of a joint's
        // energy is lost, as its angle is too large by so much, and is found anew.
        assert!((push / right - 1.0).abs() < 2.0 / 64.0, "{push:e} for {right:e}");
        // Its curvature is that of the moment up to the mouth, where a joint is short.
        let state = batch.state(0);
        let held = state.curvatures.iter().filter(|k| k.x == 0.0).count();
        for k in &state.curvatures[held..20] {
            assert!((k.x / (moment / bending()) - 1.0).abs() < 1e-3, "{k}");
        }
    }
}

/// Books close to rounding where a nozzle sways and turns, and feeds a damped rod to and fro in
/// wind; and from numbers that are saved it goes on to the same bits.
#[test]
fn books_of_a_fed_rod_close_and_it_resumes() {
    let sway = |t: f64| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.1, 0.4) * (1.0 - t.cos()));
        Isometry3::from_parts(Translation3::new(0.01 * (1.0 - (2.0 * t).cos()), 0.0, 0.0), turn)
    };
    let gravity = Vector3::new(0.3, 0.2, -G);
    let drag = Drag { normal: 2e-3, tangential: 1e-3 };
    let air = Some(Air { wind: Vector3::new(0.1, 0.3, 0.0), drag });
    let now = move |t: f64| Instant {
        gravity,
        air,
        ..fed(sway(t) * down(), 0.06 - 0.03 * (5.0 * t).cos())
    };
    for rho in [None, Some(0.0), Some(0.3)] {
        let mut one = batch(&rod(16, 2e-3), rho, down(), 0.03, 0.0);
        let mut saved = Vec::new();
        for k in 0..400 {
            let (_, missed) = run(&mut one, 2e-3, 1, &now);
            assert!(missed < 1e-9, "{rho:?}, step {k}: {missed:e}");
            if k == 157 {
                one.save(&mut saved);
            }
        }
        // It has bent.
        assert!(one.state(0).positions[16].x.abs() > 1e-3);
        let mut again = batch(&rod(16, 2e-3), rho, down(), 0.03, 0.0);
        again.restore(&saved).expect("own numbers");
        for _ in 158..400 {
            again.step(2e-3, &[&now], &mut [RodStepReport::default()]).expect("a step");
        }
        assert!(again.state(0) == one.state(0));
        assert!(again.energy(0, &gravity).elastic == one.energy(0, &gravity).elastic);
    }
}

#[test]
fn what_a_nozzle_cannot_do_is_refused() {
    let refused = |inside: fn(f64) -> f64, root: Option<End>| {
        let now = move |t: f64| {
            let now = fed(down(), inside(t));
            Instant { root: root.unwrap_or(now.root), ..now }
        };
        let mut batch = batch(&rod(10, 0.0), Some(0.3), down(), 0.05, 0.0);
        let mut step = || batch.step(1e-2, &[&now], &mut [RodStepReport::default()]);
        let error = step().and_then(|()| step()).expect_err("refused");
        let StepError::Conditions { what: "nozzle", why, .. } = error else {
            panic!("{error}");
        };
        why
    };
    assert!(refused(|_| -1e-3, None).contains("has left it"));
    assert!(refused(|_| 0.095, None).contains("last segment"));
    assert!(refused(|t| 0.05 - 2.0 * t, None).contains("more than a segment"));
    assert!(refused(|_| 0.05, Some(End::FREE)).contains("held with its frame"));
}
