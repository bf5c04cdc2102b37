//! The staggered rod on the reference hair: one step at a time in mid-fall, alone and in a batch,
//! the response to impulses, and the equilibrium from the horizontal.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, ImpulseResponse, Impulses, Instant, Rod, RodIntegrator, RodStepReport, Staggered,
    StaggeredBatch, Steady, equilibrium, fitted, natural_curvatures,
};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;
use std::time::Duration;

const LENGTH: f64 = 0.3;

fn pose() -> Isometry3<f64> {
    let horizontal = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    Isometry3::from_parts(Vector3::zeros().into(), horizontal)
}

fn hair(segments: usize, curly: bool) -> Rod {
    let kappa = if curly { Vector3::new(0.0, 4.0, 12.0) / LENGTH } else { Vector3::zeros() };
    let fiber =
        Fiber::uniform(LENGTH, segments, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .and_then(|fiber| fiber.with_natural_curvature(|_| kappa))
            .expect("a valid hair");
    Rod::new(fiber.with_root(pose()))
}

fn hold(curly: bool) -> Steady {
    let sideways = if curly { 0.2 * 9.81 } else { 0.0 };
    Steady(Instant::clamped(pose(), Vector3::new(0.0, sideways, -9.81)))
}

/// Hairs that have been released from the straight horizontal.
fn released(fibers: usize, curly: bool) -> StaggeredBatch {
    let straight = Staggered::new(hair(100, false)).expect("a valid rod").state();
    let mut batch = StaggeredBatch::new(vec![hair(100, curly); fibers], 0.3).expect("a batch");
    for fiber in 0..fibers {
        batch.set_state(fiber, &straight).expect("a state");
    }
    batch
}

/// Every sample is a run of whole steps through two seconds of fall, timed together, so that the
/// mean is over all phases of the motion.
fn steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("staggered");
    group.sample_size(10).measurement_time(Duration::from_secs(4));
    for (shape, curly) in [("planar", false), ("curly", true)] {
        let hold = hold(curly);
        for (label, dt) in [("33 ms", 1.0 / 30.0), ("10 ms", 1e-2), ("1 ms", 1e-3)] {
            for (company, fibers) in [("alone", 1), ("of 64", 8)] {
                // Sixty-four fibres are eight batches; one after the other they cost eight times
                // one.
                let conditions: Vec<&dyn Conditions> = vec![&hold; fibers];
                let mut reports = vec![RodStepReport::default(); fibers];
                let mut batch = released(fibers, curly);
                group.bench_function(format!("{shape} {label} {company}"), |b| {
                    b.iter_custom(|count| {
                        let mut time = Duration::ZERO;
                        for _ in 0..count {
                            if batch.time() > 60.0 {
                                batch = released(fibers, curly);
                            }
                            let clock = std::time::Instant::now();
                            batch.step(dt, &conditions, &mut reports).expect("a step");
                            time += clock.elapsed();
                        }
                        time / u32::try_from(fibers).expect("few")
                    });
                });
            }
        }
    }
    group.finish();
}

fn response(c: &mut Criterion) {
    let mut group = c.benchmark_group("response");
    let hold = hold(true);
    for (company, fibers) in [("alone", 1), ("of 8", 8)] {
        let mut batch = released(fibers, true);
        let conditions: Vec<&dyn Conditions> = vec![&hold; fibers];
        let mut reports = vec![RodStepReport::default(); fibers];
        for _ in 0..100 {
            batch.step(1e-3, &conditions, &mut reports).expect("a step");
        }
        let nodes = batch.nodes();
        let mut impulses = vec![Vector3::zeros(); nodes];
        batch.set_out(1e-3, &conditions, Impulses::NONE, &mut reports).expect("a step");
        for _ in 0..6 {
            batch.linearize().expect("a step");
            batch.advance(Impulses::NONE).expect("a step");
        }
        impulses[50] = Vector3::new(1e-9, 2e-9, 3e-9);
        let mut velocities = vec![Vector3::zeros(); nodes];
        let mut blocks = vec![Matrix3::zeros(); nodes];
        let mut turns = vec![Matrix3::zeros(); nodes - fibers];
        let share = u32::try_from(fibers).expect("few");
        group.bench_function(format!("column {company}"), |b| {
            b.iter_custom(|count| {
                let clock = std::time::Instant::now();
                for _ in 0..count {
                    batch.respond(black_box(&impulses), &mut velocities).expect("lengths");
                }
                clock.elapsed() / share
            });
        });
        group.bench_function(format!("diagonal blocks {company}"), |b| {
            b.iter_custom(|count| {
                let clock = std::time::Instant::now();
                for _ in 0..count {
                    batch.diagonal_blocks(&mut blocks, &mut turns).expect("lengths");
                }
                clock.elapsed() / share
            });
        });
    }
    group.finish();
}

fn statics(c: &mut Criterion) {
    let mut group = c.benchmark_group("equilibrium");
    for segments in [100, 400] {
        let rod = hair(segments, false);
        let start = Staggered::new(rod.clone()).expect("a valid rod").state();
        let conditions = hold(false).0;
        group.bench_function(format!("horizontal hair of {segments} segments"), |b| {
            b.iter(|| equilibrium(black_box(&rod), &conditions, &start).expect("an equilibrium"));
        });
    }
    group.finish();
}

/// Natural shapes of 1,900 strands of 100 points, 0.1 m long, on all threads: in closed form, with
/// the proof that each is stable, and of strands that are not and topple to the nearest that is.
fn natural_shapes(c: &mut Criterion) {
    const STRANDS: u32 = 1900;
    // They arch over from a lean of 0.2 rad and more, by `bend`, rad.
    let strand = |k: u32, bend: f64, leans: f64| {
        let fiber = Fiber::uniform(0.1, 99, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .expect("hair");
        let lean = 0.2 + leans * f64::from(k) / f64::from(STRANDS);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), lean);
        let fiber = fiber.with_root(Isometry3::from_parts(Vector3::zeros().into(), turn));
        let arched =
            fiber.with_natural_curvature(|_| Vector3::new(0.0, 10.0 * bend, 0.0)).expect("finite");
        let state = Staggered::new(Rod::new(arched.clone())).expect("a valid rod").state();
        (arched, state)
    };
    let strands = |bend: f64, leans: f64| -> Vec<_> {
        (0..STRANDS).map(|k| strand(k, bend, leans)).collect()
    };
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let clamped = |fiber: &Fiber| Instant::clamped(*fiber.root(), gravity);
    let mut group = c.benchmark_group("natural");
    group.sample_size(10);
    let arched = strands(2.5, 1.0);
    group.bench_function("1900 strands of 100 points", |b| {
        b.iter(|| {
            let all = arched.par_iter().map(|(fiber, state)| {
                natural_curvatures(fiber, state, &clamped(fiber), &[]).expect("a held root")
            });
            all.collect::<Vec<_>>()
        });
    });
    let toppling = strands(1.0, 0.5);
    for (name, strands) in [("stable", arched), ("toppling", toppling)] {
        group.bench_function(format!("1900 {name} strands of 100 points"), |b| {
            b.iter(|| {
                let all = strands.par_iter().map(|(fiber, state)| {
                    fitted(fiber, state, &clamped(fiber), &[], f64::INFINITY).expect("it rests")
                });
                let rests: Vec<_> = all.collect();
                assert!(rests.iter().all(|rest| rest.is_exact() == (name == "stable")));
                rests
            });
        });
    }
    group.finish();
}

criterion_group!(benches, steps, response, statics, natural_shapes);
criterion_main!(benches);
