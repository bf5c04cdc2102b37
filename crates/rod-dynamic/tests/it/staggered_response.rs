//! The response of the staggered rod to impulses: what a contact solver builds on.

use crate::common::{node_points, response_matrix, set_out_and_solve};
use nalgebra::{
    DMatrix, Isometry3, Matrix3, Point3, SymmetricEigen, Translation3, UnitQuaternion, Vector3,
};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, ImpulseResponse, Impulses, Instant, Point, PointResponses, Rod, RodStepReport,
    StaggeredBatch, Steady, StepVelocity,
};

pub(crate) const SEGMENTS: usize = 40;
const NODES: usize = SEGMENTS + 1;

fn pose() -> Isometry3<f64> {
    let root = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    Isometry3::from_parts(Translation3::new(0.1, -0.2, 0.3), root)
}

pub(crate) fn hold() -> Steady {
    Steady(Instant::clamped(pose(), Vector3::new(0.0, 2.0, -9.81)))
}

/// Curly hairs in full fall, each a little different, and the state before the step that is under
/// way.
pub(crate) fn falling(fibers: usize, dt: f64) -> (StaggeredBatch, Vec<f64>) {
    let rods = (0..fibers)
        .map(|i| {
            let radius = 35e-6 * (1.0 + 0.05 * i as f64);
            let kappa = Vector3::new(1.0, 4.0 + i as f64, 12.0) / 0.3;
            let section = Section::Circle { radius };
            let fiber = Fiber::uniform(0.3, SEGMENTS, section, &Material::HAIR)
                .and_then(|f| f.with_natural_curvature(|_| kappa))
                .expect("valid hair");
            Rod::new(fiber.with_root(pose()))
        })
        .collect();
    let mut batch = StaggeredBatch::new(rods, 0.3).expect("valid batch");
    let (hold, mut reports) = (hold(), vec![RodStepReport::default(); fibers]);
    let conditions: Vec<&dyn Conditions> = vec![&hold; fibers];
    let mut steps = 0;
    while batch.time() < 0.15 && steps < 400 {
        steps += 1;
        batch.step(dt, &conditions, &mut reports).expect("a step");
    }
    let mut start = Vec::new();
    batch.save(&mut start);
    set_out_and_solve(&mut batch, dt, &conditions, Impulses::NONE).expect("a step");
    (batch, start)
}

/// The response matrix of the first fibre, column by column.
fn matrix(batch: &mut StaggeredBatch) -> DMatrix<f64> {
    matrix_by(batch, false)
}

/// The same, also with weights.
fn matrix_by(batch: &mut StaggeredBatch, weighted: bool) -> DMatrix<f64> {
    let points: Vec<Point> = (0..NODES)
        .map(|a| u32::try_from(a).expect("few nodes"))
        .map(|a| match a {
            0 => Point::on_axis(0, 0, 0.0),
            a => Point::on_axis(0, a - 1, 1.0),
        })
        .collect();
    response_matrix(NODES, |impulses, velocities| {
        let answered = if weighted {
            batch.weighted_respond_at(&points, impulses, velocities)
        } else {
            batch.respond_at(&points, impulses, velocities)
        };
        answered.expect("lengths");
    })
}

/// Reads velocities of all nodes, fibre by fibre.
pub(crate) fn read(batch: &StaggeredBatch, which: StepVelocity, velocities: &mut [Vector3<f64>]) {
    let mut own: Vec<_> = velocities.chunks_mut(NODES).collect();
    batch.velocities(which, None, &mut own).expect("lengths");
}

#[test]
fn response_is_symmetric_and_semidefinite() {
    for dt in [1.0 / 30.0, 1e-2, 1e-3, 1e-4] {
        let w = matrix(&mut falling(1, dt).0);
        let largest = w.amax();
        assert!((&w - w.transpose()).amax() <= 1e-12 * largest, "dt {dt}: asymmetric");
        let smallest = SymmetricEigen::new(0.5 * (&w + w.transpose())).eigenvalues.min();
        assert!(smallest >= -1e-10 * largest, "dt {dt}: eigenvalue {smallest} of {largest}");
    }
}

#[test]
fn diagonal_blocks_are_those_of_the_columns() {
    for dt in [1.0 / 30.0, 1e-3] {
        let (mut batch, _) = falling(3, dt);
        let w = matrix(&mut batch);
        let mut blocks = vec![Matrix3::zeros(); batch.nodes()];
        let mut turns = vec![Matrix3::zeros(); batch.nodes() - 3];
        batch.diagonal_blocks(&mut blocks, &mut turns).expect("lengths");
        for a in 0..NODES {
            let column = w.fixed_view::<3, 3>(3 * a, 3 * a);
            let error = (blocks[a] - column).amax();
            // The axial part is a difference of larger numbers: two digits are lost there.
            assert!(error <= 1e-11 * w.amax(), "node {a}: {error}");
        }
    }
}

#[test]
fn response_is_the_derivative_of_a_step() {
    for dt in [1.0 / 30.0, 1e-2, 1e-3] {
        let (mut batch, start) = falling(1, dt);
        let (hold, nodes) = (hold(), node_points(1, SEGMENTS));
        let push = [(5, Vector3::x()), (20, Vector3::y()), (40, Vector3::new(0.6, 0.0, 0.8))];
        for (node, direction) in push {
            let mut impulses = vec![Vector3::zeros(); NODES];
            impulses[node] = direction;
            let mut linear = vec![Vector3::zeros(); NODES];
            batch.restore(&start).expect("own numbers");
            set_out_and_solve(&mut batch, dt, &[&hold], Impulses::NONE).expect("a step");
            batch.respond(&impulses, &mut linear).expect("lengths");
            let scale = linear.iter().map(|v| v.norm()).fold(0.0, f64::max);
            // An impulse that changes the most mobile node's velocity by a tenth of a millimetre
            // per second: large against rounding, small against the curvature of the problem.
            let size = 1e-4 / scale;
            let mut moved = [Vec::new(), Vec::new()];
            for (sign, moved) in [1.0, -1.0].into_iter().zip(&mut moved) {
                batch.restore(&start).expect("own numbers");
                let small: Vec<_> = impulses.iter().map(|p| p * sign * size).collect();
                let small = Impulses { points: &nodes, impulses: &small };
                set_out_and_solve(&mut batch, dt, &[&hold], small).expect("a step");
                batch.accept();
                *moved = batch.state(0).positions;
            }
            for a in 0..NODES {
                let difference = (moved[0][a] - moved[1][a]) / (2.0 * size * dt);
                let error = (difference - linear[a]).norm() / scale;
                assert!(error < 1e-4, "dt {dt}, impulse at {node}, answer at {a}: {error:.1e}");
            }
        }
    }
}

/// Where a step starts from, and how fast, is the state before it; both kinds of coordinates.
#[test]
fn a_step_starts_from_the_state() {
    let (falling, dt) = (falling(3, 1e-3).0, 1e-3);
    let rods: Vec<Rod> = falling.rods().to_vec();
    let spinning = StaggeredBatch::backward_euler(rods).expect("valid batch");
    let (hold, mut reports) = (hold(), vec![RodStepReport::default(); 3]);
    let conditions: Vec<&dyn Conditions> = vec![&hold; 3];
    for mut batch in [falling, spinning] {
        batch.abandon();
        batch.step(dt, &conditions, &mut reports).expect("a step");
        batch.step(dt, &conditions, &mut reports).expect("a step");
        let states: Vec<_> = (0..3).map(|fiber| batch.state(fiber)).collect();
        let none = vec![Vector3::zeros(); batch.nodes()];
        batch.set_out(dt, &conditions, Impulses::NONE, &mut reports).expect("sound");
        let mut positions = vec![Point3::origin(); batch.nodes()];
        batch.start_positions(&mut positions.chunks_mut(NODES).collect::<Vec<_>>()).expect("all");
        let mut velocities = none;
        read(&batch, StepVelocity::Start, &mut velocities);
        let mut spins = vec![Vector3::zeros(); 3 * SEGMENTS];
        let mut own: Vec<_> = spins.chunks_mut(SEGMENTS).collect();
        batch.spins(StepVelocity::Start, None, &mut own).expect("lengths");
        batch.spins(StepVelocity::Start, None, &mut own[..2]).expect_err("one for each fibre");
        assert!(velocities.iter().any(|v| v.norm() > 1e-3) && spins.iter().any(|w| w.norm() > 0.1));
        for (fiber, state) in states.iter().enumerate() {
            assert_eq!(state.positions, positions[fiber * NODES..][..NODES]);
            assert_eq!(state.velocities, velocities[fiber * NODES..][..NODES]);
            for (e, spin) in spins[fiber * SEGMENTS..][..SEGMENTS].iter().enumerate() {
                let expected = state.frames[e] * state.angular_velocities[e];
                let error = (spin - expected).norm();
                assert!(error <= 1e-13 * (1.0 + expected.norm()), "{spin} {expected}");
            }
        }
    }
}

#[test]
fn a_step_without_impulses_is_a_step() {
    let dt = 1e-3;
    let (mut batch, start) = falling(1, dt);
    let (hold, mut reports) = (hold(), [RodStepReport::default()]);
    let mut mean = vec![Vector3::zeros(); NODES];
    batch.velocities(StepVelocity::Mean, None, &mut [&mut mean]).expect("lengths");
    batch.accept();
    let accepted = batch.state(0);
    batch.restore(&start).expect("own numbers");
    let before = batch.state(0);
    batch.step(dt, &[&hold], &mut reports).expect("a step");
    let whole = batch.state(0);
    for a in 0..NODES {
        // Newton's method leaves 1e-11 rad a segment.
        assert!((accepted.positions[a] - whole.positions[a]).norm() < 1e-10 * 0.3, "node {a}");
        assert!(
            (accepted.velocities[a] - whole.velocities[a]).norm() < 1e-10 * 0.3 / dt,
            "node {a}"
        );
        let displacement = whole.positions[a] - before.positions[a];
        assert!((displacement / dt - mean[a]).norm() < 1e-10 * 0.3 / dt, "mean velocity {a}");
    }
}

#[test]
fn weights_add_to_the_inverse() {
    let (mut batch, _) = falling(2, 1e-2);
    let w = matrix(&mut batch);
    let mass = batch.rods()[0].fiber.mass();
    let points = [(0, 7, 0.25), (0, 7, 0.9), (0, 39, 1.0), (1, 20, 0.5)]
        .map(|(fiber, segment, fraction)| Point::on_axis(fiber, segment, fraction));
    let masses = [0.3 * mass, 0.02 * mass, 0.5 * mass, mass];
    batch.set_weights(&points, &masses).expect("valid weights");
    let weighted = matrix_by(&mut batch, true);
    // (W^-1 + H^T M H)^-1 = W - W H^T (M^-1 + H W H^T)^-1 H W, for W is singular.
    let mut h = DMatrix::zeros(9, 3 * NODES);
    let mut inverse = DMatrix::zeros(9, 9);
    for (i, (point, mass)) in points[..3].iter().zip(&masses).enumerate() {
        let node = 3 * point.segment as usize;
        for k in 0..3 {
            h[(3 * i + k, node + k)] = point.shares()[0];
            h[(3 * i + k, node + 3 + k)] = point.shares()[1];
            inverse[(3 * i + k, 3 * i + k)] = 1.0 / mass;
        }
    }
    let hw = &h * &w;
    let inner = (inverse + &hw * h.transpose()).try_inverse().expect("positive definite");
    let expected = &w - hw.transpose() * inner * &hw;
    // The weighted matrix is linearised at the last iterate, the dense one at that before.
    assert!((&weighted - &expected).amax() < 1e-7 * w.amax(), "weighted response");
    assert!((&weighted - &w).amax() > 1e-2 * w.amax(), "the weights matter");
    assert_eq!(matrix(&mut batch), w, "the rods' own response is left alone");
}

/// What is written out is what each point answers by itself, whoever else is in the batch.
#[test]
fn points_that_are_written_out_answer_alike() {
    let (mut batch, _) = falling(3, 1e-3);
    let points = [(2, 39, 1.0), (0, 20, 0.5), (1, 17, 0.3), (1, 17, 0.8), (0, 5, 0.0), (2, 0, 0.4)]
        .map(|(fiber, segment, fraction)| Point::on_axis(fiber, segment, fraction));
    let all = batch.write_out(&points).expect("points on the fibres");
    assert_eq!(
        all.iter().map(|one| one.points.clone()).collect::<Vec<_>>(),
        [[4, 1], [2, 3], [5, 0]]
    );
    for PointResponses { points: own, matrix } in &all {
        assert_eq!(matrix, &matrix.transpose());
        for (row, &i) in own.iter().enumerate() {
            for k in 0..3 {
                let mut impulses = [Vector3::zeros(); 6];
                impulses[i][k] = 1.0;
                let mut velocities = [Vector3::zeros(); 6];
                batch.respond_at(&points, &impulses, &mut velocities).expect("lengths");
                for (column, &j) in own.iter().enumerate() {
                    let found = matrix.fixed_view::<3, 1>(3 * column, 3 * row + k);
                    let away = (found - velocities[j]).amax();
                    assert!(away <= 1e-12 * matrix.amax(), "{i} to {j}: {away}");
                }
            }
        }
    }
    let off = Point { fiber: 3, ..points[0] };
    assert!(batch.write_out(&[off]).is_err());
}

/// An impulse at a point is its shares on the two nodes, and its velocity is interpolated alike.
#[test]
fn points_answer_as_their_nodes() {
    let (mut batch, _) = falling(3, 1e-3);
    let points = [(2, 39, 1.0), (0, 0, 0.5), (1, 17, 0.3), (1, 17, 0.8), (0, 5, 0.0)]
        .map(|(fiber, segment, fraction)| Point::on_axis(fiber, segment, fraction));
    let impulses: Vec<_> = (0..5).map(|i| Vector3::new(1.0, f64::from(i), -2.0) * 1e-9).collect();
    let mut answers = vec![Vector3::zeros(); 5];
    batch.respond_at(&points, &impulses, &mut answers).expect("valid points");
    let mut nodes = vec![Vector3::zeros(); batch.nodes()];
    let first = |p: &Point| p.fiber as usize * NODES + p.segment as usize;
    for (point, impulse) in points.iter().zip(&impulses) {
        nodes[first(point)] += impulse * point.shares()[0];
        nodes[first(point) + 1] += impulse * point.shares()[1];
    }
    let mut velocities = vec![Vector3::zeros(); batch.nodes()];
    batch.respond(&nodes, &mut velocities).expect("lengths");
    for (point, answer) in points.iter().zip(&answers) {
        let a = first(point);
        let expected = velocities[a].lerp(&velocities[a + 1], point.shares()[1]);
        assert!((answer - expected).norm() <= 1e-13 * expected.norm(), "{point:?}");
        assert!(expected.norm() > 0.0);
    }
    let off = Point::on_axis(3, 0, 0.0);
    batch.respond_at(&[off], &impulses[..1], &mut answers[..1]).expect_err("no such fibre");
}
