//! Fibres that bear impulses in some steps and fly in others.

use crate::common::{GRAVITY, node_points, planar_clamp};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, ImpulseResponse, Impulses, Instant, Rod, RodStepReport, StaggeredBatch, Steady,
    StepVelocity,
};

const DT: f64 = 1e-3;
const SEGMENTS: usize = 12;
const LENGTH: f64 = 0.08;

/// Hairs that are clamped in several directions.
fn rod(i: usize, damping_time: f64) -> Rod {
    let section = Section::Circle { radius: 3.5e-5 };
    let fiber = Fiber::uniform(LENGTH, SEGMENTS, section, &Material::HAIR).expect("valid");
    Rod::damped(fiber.with_root(planar_clamp(0.5 * i as f64)), damping_time)
}

fn hybrid(fibers: usize) -> StaggeredBatch {
    StaggeredBatch::hybrid((0..fibers).map(|i| rod(i, 1e-3)).collect(), 0.3).expect("a batch")
}

fn set_out(batch: &mut StaggeredBatch) {
    let hold = |rod: &Rod| Steady(Instant::clamped(*rod.fiber.root(), GRAVITY));
    let holds: Vec<_> = batch.rods().iter().map(hold).collect();
    let conditions: Vec<&dyn Conditions> = holds.iter().map(|hold| hold as _).collect();
    let mut reports = vec![RodStepReport::default(); holds.len()];
    batch.set_out_free(DT, &conditions, &mut reports).expect("a step");
}

/// Solves a step in several calls, up to where it may be accepted.
fn solve(batch: &mut StaggeredBatch) {
    set_out(batch);
    for _ in 0..6 {
        batch.linearize().expect("a solution");
        batch.advance(Impulses::NONE).expect("a solution");
    }
}

/// Eleven steps in which the first of some fibres bears and the others fly.
fn bear(batch: &mut StaggeredBatch) {
    batch.set_bearing(0, true);
    for _ in 0..10 {
        solve(batch);
        batch.accept();
    }
    solve(batch);
}

fn fly(batch: &mut StaggeredBatch) {
    for _ in 0..20 {
        solve(batch);
        batch.accept();
    }
}

/// While a fibre bears alone nobody needs its accelerations; beside one that flies they are known.
/// It takes off alike.
#[test]
fn a_fiber_takes_off_alike_in_any_company() {
    let mut batches = [1, 2].map(hybrid);
    for batch in &mut batches {
        bear(batch);
        batch.set_bearing(0, false);
        assert!(!batch.bears(0), "in the next step");
        batch.accept();
        fly(batch);
    }
    let [alone, beside] = batches.map(|batch| batch.state(0));
    assert_eq!(alone, beside);
}

/// Where a fibre is let fly only after a step has been accepted its acceleration is found anew, as
/// that of a state that is set.
#[test]
fn a_fiber_that_takes_off_late_finds_its_acceleration() {
    // A state does not tell the rates of joints, which damping needs.
    let undamped = || StaggeredBatch::hybrid(vec![rod(0, 0.0)], 0.3).expect("a batch");
    let mut late = undamped();
    bear(&mut late);
    late.accept();
    let state = late.state(0);
    late.set_bearing(0, false);
    let mut anew = undamped();
    anew.set_state(0, &state).expect("a state");
    let mut early = undamped();
    bear(&mut early);
    early.set_bearing(0, false);
    early.accept();
    for batch in [&mut late, &mut anew, &mut early] {
        fly(batch);
    }
    let [late, anew, early] = [late, anew, early].map(|batch| batch.state(0).positions);
    let apart = |a: &[Point3<f64>], b: &[Point3<f64>]| {
        a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    assert!(apart(&late, &anew) < 1e-9 * LENGTH, "{:e}", apart(&late, &anew));
    // What backward Euler leaves is the acceleration half a step before.
    assert!(apart(&late, &early) < 1e-3 * LENGTH, "{:e}", apart(&late, &early));
}

/// Fibres that fly keep no matrix: what asks for one finds it where the step has been solved to.
#[test]
fn a_matrix_that_was_not_kept_is_found_anew() {
    let mut batches = [false, true].map(|asks| {
        let mut batch = hybrid(3);
        fly(&mut batch);
        set_out(&mut batch);
        let mean = velocities(&batch, StepVelocity::Mean);
        if asks {
            batch.linearize().expect("a solution");
        } else {
            assert_eq!(velocities(&batch, StepVelocity::Linear), mean, "no increments are left");
        }
        batch
    });
    let nodes = 3 * (SEGMENTS + 1);
    let impulses: Vec<_> =
        (0..nodes).map(|i| Vector3::new(1e-9, 2e-9 * (i % 5) as f64, -1e-9)).collect();
    let answers = batches.each_mut().map(|batch| {
        let mut velocities = vec![Vector3::zeros(); nodes];
        batch.respond(&impulses, &mut velocities).expect("a step is under way");
        velocities
    });
    assert_eq!(answers[0], answers[1]);
    assert!(answers[0][SEGMENTS].norm() > 0.0);
    for batch in &mut batches {
        let all = Impulses { points: &node_points(3, SEGMENTS), impulses: &impulses };
        batch.advance(all).expect("a solution");
        batch.accept();
    }
    let [found, asked] = batches.map(|batch| batch.state(1));
    assert_eq!(found, asked);
}

fn velocities(batch: &StaggeredBatch, which: StepVelocity) -> Vec<Vector3<f64>> {
    let mut all = vec![Vector3::zeros(); 3 * (SEGMENTS + 1)];
    let mut slices: Vec<_> = all.chunks_mut(SEGMENTS + 1).collect();
    batch.velocities(which, None, &mut slices).expect("a step is under way");
    all
}
