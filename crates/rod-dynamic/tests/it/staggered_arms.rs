//! The response of the staggered rod to impulses beside its axis, where surfaces touch.

use crate::common::{response_matrix, set_out_and_solve};
use nalgebra::{DMatrix, Isometry3, Matrix3, SymmetricEigen, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, ImpulseResponse, Impulses, Instant, Point, PointAction, Rod, RodStepReport,
    StaggeredBatch, Steady, StepVelocity,
};

const SEGMENTS: usize = 12;
const NODES: usize = SEGMENTS + 1;
const RADIUS: f64 = 2e-3;
const DT: f64 = 1e-3;

/// A soft curved rod, clamped or thrown, after some steps, in the step under way; and the state
/// before.
fn moving(clamped: bool) -> (StaggeredBatch, Vec<f64>, Steady) {
    let section = Section::Circle { radius: RADIUS };
    let material = Material { density: 1100.0, youngs_modulus: 3e6, shear_modulus: 1e6 };
    let fiber = Fiber::uniform(0.2, SEGMENTS, section, &material)
        .and_then(|fiber| fiber.with_natural_curvature(|_| Vector3::new(3.0, 5.0, 20.0)))
        .expect("a fibre");
    let mut batch = StaggeredBatch::backward_euler(vec![Rod::new(fiber)]).expect("a batch");
    let gravity = Vector3::new(0.0, 2.0, -9.81);
    let mut instant = Instant::clamped(Isometry3::identity(), gravity);
    if !clamped {
        instant.root = instant.tip;
    }
    let hold = Steady(instant);
    let mut reports = [RodStepReport::default()];
    for _ in 0..50 {
        batch.step(DT, &[&hold], &mut reports).expect("a step");
    }
    let mut start = Vec::new();
    batch.save(&mut start);
    set_out_and_solve(&mut batch, DT, &[&hold as &dyn Conditions], Impulses::NONE).expect("a step");
    (batch, start, hold)
}

/// Points on the surface, two of them on one segment, one on the axis, and two couples.
fn points() -> Vec<Point> {
    let at = |segment, fraction, x: f64, y: f64, z: f64| {
        let arm = RADIUS * Vector3::new(x, y, z).normalize();
        Point::beside_axis(0, segment, fraction, arm)
    };
    let lever = RADIUS * Matrix3::new(1.0, 0.2, -0.3, 0.1, 0.8, 0.4, -0.2, 0.5, 1.3);
    let couple = |segment| Point { fiber: 0, segment, action: PointAction::Couple { lever } };
    vec![
        at(0, 0.4, 1.0, 0.3, 0.0),
        at(5, 0.0, 0.0, 1.0, 0.2),
        at(5, 0.7, -1.0, 0.4, 0.9),
        Point::on_axis(0, 8, 0.5),
        at(11, 1.0, 0.2, 0.1, -1.0),
        couple(5),
        couple(9),
    ]
}

/// The response of points, column by column.
fn matrix(batch: &mut StaggeredBatch, weighted: bool) -> DMatrix<f64> {
    let points = points();
    response_matrix(points.len(), |impulses, velocities| {
        let answered = if weighted {
            batch.weighted_respond_at(&points, impulses, velocities)
        } else {
            batch.respond_at(&points, impulses, velocities)
        };
        answered.expect("points");
    })
}

#[test]
fn the_response_beside_the_axis_is_symmetric_and_positive() {
    for clamped in [true, false] {
        let (mut batch, ..) = moving(clamped);
        let w = matrix(&mut batch, false);
        assert!((&w - w.transpose()).amax() < 1e-12 * w.amax(), "asymmetric");
        let eigenvalues = SymmetricEigen::new(0.5 * (&w + w.transpose())).eigenvalues;
        // Points of one rigid segment keep their distance: to that nothing answers.
        assert!(eigenvalues.min() > -1e-12 * w.amax(), "{eigenvalues}");
        // What is written out is the same.
        let written = batch.write_out(&points()).expect("points");
        for (i, &row) in written[0].points.iter().enumerate() {
            for (j, &column) in written[0].points.iter().enumerate() {
                let found = written[0].matrix.fixed_view::<3, 3>(3 * i, 3 * j);
                let away = (found - w.fixed_view::<3, 3>(3 * row, 3 * column)).amax();
                assert!(away < 1e-12 * w.amax(), "{row} to {column}: {away}");
            }
        }
    }
}

/// What the response says of a small impulse on the surface is what a step makes of it, and what it
/// does about the axis matters.
#[test]
fn the_response_beside_the_axis_is_the_derivative_of_a_step() {
    for clamped in [true, false] {
        let (mut batch, start, hold) = moving(clamped);
        let w = matrix(&mut batch, false);
        // A rotation vector and an increment after it add up but for half of their product.
        let mut spins = [Vector3::zeros(); SEGMENTS];
        batch.spins(StepVelocity::Mean, None, &mut [&mut spins]).expect("lengths");
        let turn = DT * spins.iter().map(|spin| spin.norm()).fold(0.0, f64::max);
        assert!(turn < 0.02, "{turn} rad");
        for (pushed, point) in points().iter().enumerate() {
            for axis in 0..3 {
                let column = w.column(3 * pushed + axis);
                // A tenth of a millimetre per second of the point that gives way most.
                let size = 1e-4 / column.amax();
                let mut ends = [Vec::new(), Vec::new()];
                for (sign, end) in [1.0, -1.0].into_iter().zip(&mut ends) {
                    let impulse = sign * size * Vector3::ith(axis, 1.0);
                    let all = Impulses { points: &[*point], impulses: &[impulse] };
                    batch.restore(&start).expect("own numbers");
                    set_out_and_solve(&mut batch, DT, &[&hold as &dyn Conditions], all)
                        .expect("a step");
                    let mut nodes = [Vector3::zeros(); NODES];
                    let mut segments = [Vector3::zeros(); SEGMENTS];
                    batch.velocities(StepVelocity::Mean, None, &mut [&mut nodes]).expect("lengths");
                    batch.spins(StepVelocity::Mean, None, &mut [&mut segments]).expect("lengths");
                    end.extend(points().iter().map(|point| {
                        let segment = point.segment as usize;
                        let [before, behind] = point.shares();
                        nodes[segment] * before
                            + nodes[segment + 1] * behind
                            + point.turned(&segments[segment])
                    }));
                }
                for (i, (up, down)) in ends[0].iter().zip(&ends[1]).enumerate() {
                    let found = (up - down) / (2.0 * size);
                    let error = (found - column.fixed_rows::<3>(3 * i)).norm() / column.amax();
                    assert!(error < 1e-4 + 0.5 * turn, "{clamped}, {pushed} to {i}: {error:.1e}");
                }
            }
        }
    }
}

/// Masses beside the axis add to the inverse of the response of their points.
#[test]
fn masses_beside_the_axis_add_to_the_inverse() {
    for clamped in [true, false] {
        let (mut batch, ..) = moving(clamped);
        let w = matrix(&mut batch, false);
        let mass = batch.rods()[0].fiber.mass();
        let masses = [0.3, 0.02, 1.0, 0.5, 0.2, 0.4, 0.6].map(|part| part * mass);
        batch.set_weights(&points(), &masses).expect("weights");
        let weighted = matrix(&mut batch, true);
        let inverse =
            DMatrix::from_fn(
                w.nrows(),
                w.nrows(),
                |i, j| if i == j { 1.0 / masses[i / 3] } else { 0.0 },
            );
        let inner = (&inverse + &w).try_inverse().expect("positive definite");
        let expected = &w - &w * inner * &w;
        // The weighted matrix is linearised at the last iterate, the other at that before.
        let error = (&weighted - &expected).amax() / w.amax();
        assert!(error < 1e-7, "{clamped}: {error:e}");
        assert!((&weighted - &w).amax() > 1e-2 * w.amax(), "the weights matter");
        assert_eq!(matrix(&mut batch, false), w, "the rods' own response is left alone");
    }
}

/// Blocks of segments are how they answer moments on themselves.
#[test]
fn blocks_of_segments_are_their_answers_to_moments() {
    let (mut batch, ..) = moving(false);
    let mut nodes = vec![Matrix3::zeros(); NODES];
    let mut segments = vec![Matrix3::zeros(); SEGMENTS];
    batch.diagonal_blocks(&mut nodes, &mut segments).expect("lengths");
    for segment in 0..SEGMENTS {
        let number = u32::try_from(segment).expect("few");
        for axis in 0..3 {
            // A couple of impulses with the moment of a unit about an axis.
            let (arm, push) =
                (Vector3::ith((axis + 1) % 3, 0.5), Vector3::ith((axis + 2) % 3, 1.0));
            let pair = [arm, -arm].map(|arm| Point::beside_axis(0, number, 0.5, arm));
            let mut velocities = [Vector3::zeros(); 2];
            batch.respond_at(&pair, &[push, -push], &mut velocities).expect("points");
            // They go apart by the rotation alone: `w x 2 arm`.
            let expected = segments[segment].column(axis).cross(&(2.0 * arm));
            let error = (velocities[0] - velocities[1] - expected).norm();
            assert!(error < 1e-10 * segments[segment].amax(), "{segment}, {axis}: {error:e}");
        }
    }
}
