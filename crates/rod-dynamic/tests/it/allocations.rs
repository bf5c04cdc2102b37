//! No step allocates once the integrator is warm, and none leaves more than it must.

use crate::common::{GRAVITY, hair};
use nalgebra::{Matrix3, Vector3};
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Conditions, ImpulseResponse, Impulses, Instant, Point, Rod,
    RodIntegrator, RodStepReport, StaggeredBatch, Steady, StepVelocity,
};

/// Allocations of the second of two runs of `step`.
fn allocations(mut step: impl FnMut()) -> u64 {
    step();
    allocation_counter::measure(step).count_total
}

#[test]
fn warm_steps_do_not_allocate() {
    let rod = Rod::new(hair(50));
    let hold = Steady(Instant::clamped(*rod.fiber.root(), GRAVITY));

    let mut single = BoxIntegrator::new(rod.clone(), BoxOptions::default()).expect("valid options");
    let count = allocations(|| {
        for _ in 0..20 {
            single.step(1e-3, &hold).expect("a step");
        }
    });
    assert_eq!(count, 0, "box scheme");

    for fibers in [1, 8] {
        let mut batch = StaggeredBatch::new(vec![rod.clone(); fibers], 0.3).expect("a batch");
        let conditions: Vec<&dyn Conditions> = vec![&hold; fibers];
        let mut reports = vec![RodStepReport::default(); fibers];
        let count = allocations(|| {
            for _ in 0..20 {
                batch.step(1e-3, &conditions, &mut reports).expect("a step");
            }
        });
        assert_eq!(count, 0, "batch of {fibers}");

        let nodes = batch.nodes();
        let impulses = vec![Vector3::new(1e-9, 0.0, 0.0); nodes];
        let mut velocities = vec![Vector3::zeros(); nodes];
        let mut blocks = vec![Matrix3::zeros(); nodes];
        let mut turns = vec![Matrix3::zeros(); nodes - fibers];
        let points = [Point::beside_axis(0, 7, 0.3, Vector3::new(0.0, 0.0, 1e-5))];
        let whole = Impulses { points: &points, impulses: &[Vector3::new(0.0, 1e-9, 0.0)] };
        let count = allocations(|| {
            batch.set_out(1e-3, &conditions, whole, &mut reports).expect("sound");
            batch.linearize().expect("regular");
            let mut own: [&mut [_]; 8] = Default::default();
            let per_fiber = velocities.chunks_mut(nodes / fibers);
            own.iter_mut().zip(per_fiber).for_each(|(own, part)| *own = part);
            for which in [StepVelocity::Linear, StepVelocity::Mean] {
                batch.velocities(which, None, &mut own[..fibers]).expect("lengths");
            }
            batch.respond(&impulses, &mut velocities).expect("lengths");
            batch.diagonal_blocks(&mut blocks, &mut turns).expect("lengths");
            batch.set_weights(&points, &[1e-6]).expect("weights");
            batch.press(whole).expect("sound");
            batch.advance(whole).expect("regular");
            batch.accept();
        });
        assert_eq!(count, 0, "a step of {fibers} with impulses");
    }
}

/// A segment has 10 numbers of its model and 13 of its shape and force, and remembers 7 of those;
/// its rates are 9 numbers, their accelerations 18 more. While a step is under way from call to
/// call, 54 numbers of its solve and 3 of impulses are kept. All else is lent, also while nothing
/// is under way.
#[test]
fn batches_hold_what_their_motion_needs() {
    let segments = 1000;
    let rod = Rod::new(hair(segments));
    let hold = Steady(Instant::clamped(*rod.fiber.root(), GRAVITY));
    let conditions: Vec<&dyn Conditions> = vec![&hold; 8];
    let mut reports = vec![RodStepReport::default(); 8];
    let mut held = |euler: bool| {
        let mut batch = None;
        let made = allocation_counter::measure(|| {
            let rods = vec![rod.clone(); 8];
            let new = if euler {
                StaggeredBatch::backward_euler(rods)
            } else {
                StaggeredBatch::new(rods, 0.3)
            };
            let batch = batch.insert(new.expect("a batch"));
            for _ in 0..2 {
                batch.step(1e-3, &conditions, &mut reports).expect("a step");
            }
        });
        let kept = allocation_counter::measure(|| {
            let batch = batch.as_mut().expect("a batch");
            batch.set_out(1e-3, &conditions, Impulses::NONE, &mut reports).expect("sound");
            batch.linearize().expect("regular");
        });
        // Of eight lanes, eight bytes each.
        [made, kept].map(|one| one.bytes_current as f64 / (64 * segments) as f64)
    };
    // What is lent stays with the thread.
    held(false);
    for (euler, numbers) in [(false, 57.0), (true, 39.0)] {
        let [made, kept] = held(euler);
        assert!(made < numbers + 1.0, "{made} numbers a segment");
        assert!(kept < 57.0 + 1.0, "{kept} numbers a segment");
    }
}
