//! The response to impulses of rods whose ends are held, sprung or free by freedoms.

use crate::common::{node_points, response_matrix, set_out_and_solve};
use crate::supported_ends::{LENGTH, rod, support, weightless};
use Restraint::{Free, Held, Sprung};
use nalgebra::{DMatrix, Matrix3, SymmetricEigen, UnitQuaternion, Vector3};
use rapunzel_rod_dynamic::{
    End, ImpulseResponse, Impulses, Instant, Load, Restraint, RodStepReport, StaggeredBatch, Steady,
};

/// The answer to impulses is symmetric, semidefinite, has the diagonal blocks of its columns, also
/// with weights, and is the derivative of a step.
#[test]
fn supported_ends_answer_impulses() {
    const NODES: usize = 13;
    let own = rod(12, 0.0);
    let mut root = support(0.0, [Held, Sprung(0.02), Free], [Held, Free, Sprung(1e-6)]);
    root.axes = UnitQuaternion::from_euler_angles(0.4, 0.2, -0.3);
    let mut tip = support(LENGTH, [Sprung(0.1), Held, Free], [Free, Held, Held]);
    tip.axes = UnitQuaternion::from_euler_angles(-0.2, 0.7, 0.1);
    tip.force = Load::World(Vector3::new(2e-4, 0.0, 1e-4));
    let gravity = Vector3::new(1.0, 0.0, -3.0);
    let ends = [End::Supported(root), End::Supported(tip)];
    let conditions = Steady(Instant { root: ends[0], tip: ends[1], gravity, ..weightless() });
    let dt = 2e-3;
    let mut batch = StaggeredBatch::new(vec![own], 0.3).expect("a batch");
    for _ in 0..10 {
        batch.step(dt, &[&conditions], &mut [RodStepReport::default()]).expect("a step");
    }
    let mut start = Vec::new();
    batch.save(&mut start);
    set_out_and_solve(&mut batch, dt, &[&conditions], Impulses::NONE).expect("a step");
    let points = node_points(1, NODES - 1);
    let matrix = |batch: &mut StaggeredBatch, weighted: bool| -> DMatrix<f64> {
        response_matrix(NODES, |impulses, velocities| {
            let answered = if weighted {
                batch.weighted_respond_at(&points, impulses, velocities)
            } else {
                batch.respond_at(&points, impulses, velocities)
            };
            answered.expect("lengths");
        })
    };
    let w = matrix(&mut batch, false);
    let masses = vec![1e-6; NODES];
    batch.set_weights(&points, &masses).expect("masses");
    let weighted = matrix(&mut batch, true);
    // (W^-1 + M)^-1 = (E + W M)^-1 W.
    let heavy = DMatrix::identity(3 * NODES, 3 * NODES) + 1e-6 * &w;
    let right = heavy.lu().solve(&w).expect("regular");
    assert!((weighted - &right).amax() < 1e-9 * right.amax());
    assert!((&w - w.transpose()).amax() < 1e-12 * w.amax());
    let smallest = SymmetricEigen::new(0.5 * (&w + w.transpose())).eigenvalues.min();
    assert!(smallest > -1e-10 * w.amax(), "{smallest}");
    let mut blocks = vec![Matrix3::zeros(); NODES];
    let mut turns = vec![Matrix3::zeros(); NODES - 1];
    batch.diagonal_blocks(&mut blocks, &mut turns).expect("lengths");
    for (a, block) in blocks.iter().enumerate() {
        let column = w.fixed_view::<3, 3>(3 * a, 3 * a);
        assert!((block - column).amax() < 1e-11 * w.amax(), "node {a}");
    }
    for node in [0, 5, 12] {
        let mut moved = [Vec::new(), Vec::new()];
        let size = 1e-4 / w.amax();
        for (sign, moved) in [1.0, -1.0].into_iter().zip(&mut moved) {
            batch.restore(&start).expect("own numbers");
            let mut impulses = vec![Vector3::zeros(); NODES];
            impulses[node] = sign * size * Vector3::new(0.6, 0.5, -0.4);
            let all = Impulses { points: &points, impulses: &impulses };
            set_out_and_solve(&mut batch, dt, &[&conditions], all).expect("a step");
            batch.accept();
            *moved = batch.state(0).positions;
        }
        for a in 0..NODES {
            let found = (moved[0][a] - moved[1][a]) / (2.0 * size * dt);
            let right = w.fixed_view::<3, 3>(3 * a, 3 * node) * Vector3::new(0.6, 0.5, -0.4);
            assert!((found - right).norm() < 1e-4 * w.amax(), "impulse at {node}, node {a}");
        }
    }
}
