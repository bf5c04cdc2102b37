//! Batches of staggered rods: company changes nothing, and failed steps leave no trace.

use nalgebra::{Isometry3, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Air, Conditions, Drag, End, Instant, Load, Rod, RodIntegrator, RodStepReport, Staggered,
    StaggeredBatch, StepError,
};

const DT: f64 = 1.0 / 60.0;
const SEGMENTS: usize = 20;

/// Rods that differ in everything a batch lets them differ in.
fn rod(i: usize) -> Rod {
    let x = i as f64;
    let section = Section::Ellipse { a: 35e-6 * (1.0 + 0.3 * x), b: 30e-6 };
    let curl = Vector3::new(3.0 * x, 10.0, 20.0 - 8.0 * x);
    let fiber = Fiber::uniform(0.1 + 0.05 * x, SEGMENTS, section, &Material::HAIR)
        .and_then(|f| f.with_natural_curvature(|_| curl))
        .expect("valid")
        .with_root(crate::common::planar_clamp(0.4 * x));
    Rod::damped(fiber, if i.is_multiple_of(2) { 0.0 } else { 1e-3 })
}

/// Conditions of all kinds: clamped in wind, moved, pulled, thrown.
fn conditions(i: usize) -> impl Fn(f64) -> Instant {
    let root = *rod(i).fiber.root();
    move |t: f64| {
        let clamped = Instant::clamped(root, crate::common::GRAVITY);
        let force = Load::Follower(Vector3::new(1e-7, 0.0, 2e-7));
        let pulled = End::Loaded { force, moment: Load::ZERO };
        match i % 4 {
            0 => Instant {
                air: Some(Air {
                    wind: Vector3::new(0.5, 0.0, 1.0),
                    drag: Drag { normal: 2e-5, tangential: 1e-5 },
                }),
                ..clamped
            },
            1 => {
                let shaken = Isometry3::translation(0.01 * (9.0 * t).sin(), 0.0, 0.0) * root;
                Instant { root: End::Held(shaken), ..clamped }
            }
            2 => Instant { tip: pulled, ..clamped },
            _ => Instant { root: End::FREE, ..clamped },
        }
    }
}

fn numbers(batch: &StaggeredBatch) -> Vec<u64> {
    let mut numbers = Vec::new();
    batch.save(&mut numbers);
    numbers.into_iter().map(f64::to_bits).collect()
}

fn step(batch: &mut StaggeredBatch, members: &[usize], dt: f64) -> Vec<RodStepReport> {
    let conditions: Vec<_> = members.iter().map(|&i| conditions(i)).collect();
    let conditions: Vec<&dyn Conditions> = conditions.iter().map(|c| c as _).collect();
    let mut reports = vec![RodStepReport::default(); members.len()];
    batch.step(dt, &conditions, &mut reports).expect("converges");
    reports
}

#[test]
fn fibers_move_bit_for_bit_alike_in_any_company() {
    let alone: Vec<_> = (0..8)
        .map(|i| {
            let mut single = Staggered::new(rod(i)).expect("valid");
            let conditions = conditions(i);
            let reports: Vec<_> =
                (0..60).map(|_| single.step(DT, &conditions).expect("converges")).collect();
            (single.state(), reports)
        })
        .collect();
    for members in [vec![0, 1], vec![3, 2, 1], vec![7, 0, 6, 1, 5, 2, 4, 3], vec![5, 5, 5, 2, 6]] {
        let rods = members.iter().map(|&i| rod(i)).collect();
        let mut batch = StaggeredBatch::new(rods, StaggeredBatch::DEFAULT_RHO_INF).expect("valid");
        let reports: Vec<_> = (0..60).map(|_| step(&mut batch, &members, DT)).collect();
        for (lane, &i) in members.iter().enumerate() {
            assert_eq!(batch.state(lane), alone[i].0, "fibre {i} in {members:?}");
            for (now, alone) in reports.iter().zip(&alone[i].1) {
                assert_eq!(now[lane], *alone, "work on fibre {i} in {members:?}");
            }
        }
    }
}

#[test]
fn restored_batches_continue_bit_for_bit() {
    let members = [0, 1, 2, 3];
    let new = || {
        let rods = members.iter().map(|&i| rod(i)).collect();
        StaggeredBatch::new(rods, 0.3).expect("valid")
    };
    let mut batch = new();
    let mut saved = Vec::new();
    batch.save(&mut saved);
    for before in [0, 1, 20] {
        for _ in 0..before {
            step(&mut batch, &members, DT);
        }
        saved.clear();
        batch.save(&mut saved);
        let mut copy = new();
        copy.restore(&saved).expect("own numbers");
        for _ in 0..20 {
            step(&mut batch, &members, DT);
            step(&mut copy, &members, DT);
            assert_eq!(numbers(&batch), numbers(&copy), "after {before} steps");
        }
    }
    assert!(batch.restore(&saved[1..]).is_err(), "one number is missing");
}

/// Fibres that change places with others between steps go on to the same bits.
#[test]
fn fibers_go_on_bit_for_bit_in_another_batch() {
    let new = |members: &[usize], rho: f64| {
        StaggeredBatch::hybrid(members.iter().map(|&i| rod(i)).collect(), rho).expect("valid")
    };
    let (mut members, mut other_members) = ([1, 3, 5], [7, 9]);
    let (mut batch, mut other) = (new(&members, 0.3), new(&other_members, 0.3));
    batch.set_bearing(1, true);
    for _ in 0..10 {
        step(&mut batch, &members, DT);
        step(&mut other, &other_members, DT);
    }
    let [mut rods, mut others] = [&batch, &other].map(StaggeredBatch::moving_rods);
    for _ in 0..10 {
        step(&mut batch, &members, DT);
        step(&mut other, &other_members, DT);
    }
    let expected: Vec<_> = (0..3).map(|lane| batch.state(lane)).collect();
    let other_expected: Vec<_> = (0..2).map(|lane| other.state(lane)).collect();
    std::mem::swap(&mut rods[1], &mut others[0]);
    std::mem::swap(&mut members[1], &mut other_members[0]);
    let (mut moved, mut other_moved) = (new(&[11, 11, 11], 0.3), new(&[11, 11], 0.3));
    for (one, time) in [(&mut moved, batch.time()), (&mut other_moved, other.time())] {
        let mut state = one.state(0);
        state.time = time - 10.0 * DT;
        one.set_state(0, &state).expect("its own");
    }
    moved.replace_rods(rods).expect("of a kind");
    other_moved.replace_rods(others).expect("of a kind");
    assert!(!moved.bears(1) && other_moved.bears(0));
    for _ in 0..10 {
        step(&mut moved, &members, DT);
        step(&mut other_moved, &other_members, DT);
    }
    let states = |batch: &StaggeredBatch, lanes: &[usize]| -> Vec<_> {
        lanes.iter().map(|&lane| batch.state(lane).positions).collect()
    };
    let all: Vec<_> = expected.iter().chain(&other_expected).map(|s| s.positions.clone()).collect();
    let [a, b, c, d, e] = &all[..] else { panic!("five") };
    assert_eq!(states(&moved, &[0, 1, 2]), [a.clone(), d.clone(), c.clone()]);
    assert_eq!(states(&other_moved, &[0, 1]), [b.clone(), e.clone()]);
    // Those that are damped remember more.
    let mut undamped = new(&[0, 2], 0.3);
    let before = numbers(&undamped);
    undamped.replace_rods(batch.moving_rods()[1..].to_vec()).expect("all of another kind");
    let mixed =
        vec![undamped.moving_rods().swap_remove(0), new(&[0], 0.3).moving_rods().swap_remove(0)];
    undamped.replace_rods(mixed).expect_err("damped and not");
    assert_ne!(numbers(&undamped), before);
}

/// Loads that are not finite are refused, loads that overflow do not converge; what other fibres
/// did in the step, halved or not, is taken back.
#[test]
fn failed_steps_leave_batches_untouched() {
    let members = [0, 1, 2, 3];
    let rods = members.iter().map(|&i| rod(i)).collect();
    let mut batch = StaggeredBatch::new(rods, 0.3).expect("valid");
    for _ in 0..10 {
        step(&mut batch, &members, DT);
    }
    let before = numbers(&batch);
    // Gravity (m/s^2) and the speed of a storm (m/s) whose force overflows.
    for (gravity, storm) in [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (0.0, 1e200)] {
        for victim in members {
            let conditions: Vec<_> = members
                .iter()
                .map(|&i| {
                    let usual = conditions(i);
                    move |t: f64| {
                        let gravity = Vector3::new(gravity, 0.0, 0.0);
                        let drag = Drag { normal: 1e200, tangential: 0.0 };
                        let air = Some(Air { wind: Vector3::new(0.0, 0.0, storm), drag });
                        let now = usual(t);
                        if i == victim { Instant { gravity, air, ..now } } else { now }
                    }
                })
                .collect();
            let conditions: Vec<&dyn Conditions> = conditions.iter().map(|c| c as _).collect();
            let mut reports = [RodStepReport::default(); 4];
            let error = batch.step(DT, &conditions, &mut reports).expect_err("must fail");
            match error {
                StepError::Conditions { fiber, .. } => {
                    assert!(fiber == victim && !gravity.is_finite(), "{error}");
                }
                StepError::NotConverged { fiber, .. } => {
                    assert!(fiber == victim && storm > 0.0, "{error}");
                }
                _ => panic!("{error}"),
            }
            assert_eq!(numbers(&batch), before, "gravity {gravity}, storm {storm}, fibre {victim}");
        }
    }
    let mut control =
        StaggeredBatch::new(members.iter().map(|&i| rod(i)).collect(), 0.3).expect("valid");
    for _ in 0..10 {
        step(&mut control, &members, DT);
    }
    step(&mut control, &members, DT);
    step(&mut batch, &members, DT);
    assert_eq!(numbers(&batch), numbers(&control), "failed steps change nothing that follows");
}
