//! No step allocates once the integrator is warm.

mod common;

use common::{GRAVITY, hair};
use nalgebra::{Matrix3, Vector3};
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Conditions, ImpulseResponse, Instant, Point, Rod, RodIntegrator,
    StaggeredBatch, Steady, StepReport,
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
        let mut reports = vec![StepReport::default(); fibers];
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
        let points = [Point { fiber: 0, segment: 7, fraction: 0.3 }];
        let count = allocations(|| {
            batch.predict(1e-3, &conditions, &impulses, &mut reports).expect("a prediction");
            batch.mean_velocities(&mut velocities).expect("lengths");
            batch.respond(&impulses, &mut velocities).expect("lengths");
            batch.diagonal_blocks(&mut blocks).expect("lengths");
            batch.set_weights(&points, &[1e-6]).expect("weights");
            batch.correct(&impulses, &mut reports).expect("a step");
            batch.accept();
        });
        assert_eq!(count, 0, "the halves of a step of {fibers}");
    }
}
