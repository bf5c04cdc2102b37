//! Increments of a step that are taken one by one, with impulses that change between them.

use crate::common::{node_points, set_out_and_solve};
use crate::staggered_response::{SEGMENTS, falling, hold, read};
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{
    Conditions, ImpulseResponse, Impulses, Point, RodStepReport, StaggeredBatch, StepError,
    StepVelocity,
};

/// A share of impulses that move all nodes by some decimetres a second, but every seventh.
fn impulses(batch: &StaggeredBatch, share: f64) -> Vec<Vector3<f64>> {
    let mass = batch.rods()[0].fiber.mass() / SEGMENTS as f64;
    let one = |node: usize| Vector3::new(0.1, -0.2, 0.05) * mass * (node % 7) as f64 * share;
    (0..batch.nodes()).map(one).collect()
}

fn on_nodes<'a>(points: &'a [Point], impulses: &'a [Vector3<f64>]) -> Impulses<'a> {
    Impulses { points, impulses }
}

/// Newton's method step by step from where the motion leads, with impulses that change on the way,
/// ends where it does with the last of them from the start.
#[test]
fn iterations_taken_one_by_one_end_in_the_same_step() {
    let (mut batch, start) = falling(3, 1e-3);
    let (hold, nodes) = (hold(), node_points(3, SEGMENTS));
    let conditions: Vec<&dyn Conditions> = vec![&hold; 3];
    let mut reports = [RodStepReport::default(); 3];
    let [impulses, half] = [1.0, 0.5].map(|share| impulses(&batch, share));
    batch.abandon();
    set_out_and_solve(&mut batch, 1e-3, &conditions, on_nodes(&nodes, &impulses))
        .expect("converges");
    batch.accept();
    let expected: Vec<_> = (0..3).map(|fiber| batch.state(fiber)).collect();
    batch.restore(&start).expect("the same batch");
    batch.set_out(1e-3, &conditions, on_nodes(&nodes, &half), &mut reports).expect("sound");
    let mut turns = Vec::new();
    for _ in 0..6 {
        batch.linearize().expect("regular");
        turns.push(batch.advance(on_nodes(&nodes, &impulses)).expect("regular"));
    }
    // What the last increment would add to first order is nothing any more.
    batch.linearize().expect("regular");
    let mut velocities =
        [vec![Vector3::zeros(); batch.nodes()], vec![Vector3::zeros(); batch.nodes()]];
    read(&batch, StepVelocity::Mean, &mut velocities[0]);
    read(&batch, StepVelocity::Linear, &mut velocities[1]);
    for (now, then) in velocities[0].iter().zip(&velocities[1]) {
        assert!((now - then).norm() < 1e-10 * 0.3 / 1e-3, "{turns:?}");
    }
    batch.accept();
    for (fiber, expected) in expected.iter().enumerate() {
        let state = batch.state(fiber);
        for (x, y) in state.positions.iter().zip(&expected.positions) {
            assert!((x - y).norm() < 1e-10 * 0.3, "{turns:?}");
        }
    }
}

/// Other impulses that are pressed on a step that was set out on count from its next linearisation
/// on.
#[test]
fn impulses_may_change_before_anything_moves() {
    let (mut batch, _) = falling(3, 1e-3);
    let (hold, nodes) = (hold(), node_points(3, SEGMENTS));
    let conditions: Vec<&dyn Conditions> = vec![&hold; 3];
    let mut reports = [RodStepReport::default(); 3];
    let [change, none] = [1.0, 0.0].map(|share| impulses(&batch, share));
    let mut velocities = [none.clone(), none.clone(), none.clone(), none.clone()];
    batch.abandon();
    set_out_and_solve(&mut batch, 1e-3, &conditions, on_nodes(&nodes, &change)).expect("converges");
    read(&batch, StepVelocity::Mean, &mut velocities[3]);
    batch.abandon();
    batch.press(Impulses::NONE).expect_err("no step is under way");
    batch.set_out(1e-3, &conditions, Impulses::NONE, &mut reports).expect("sound");
    batch.linearize().expect("regular");
    read(&batch, StepVelocity::Linear, &mut velocities[0]);
    assert!(batch.press(on_nodes(&nodes, &change)).expect("sound"), "they are others");
    assert!(!batch.press(on_nodes(&nodes, &change)).expect("sound"), "they are the same");
    batch.linearize().expect("regular");
    read(&batch, StepVelocity::Linear, &mut velocities[1]);
    for _ in 0..6 {
        batch.linearize().expect("regular");
        batch.advance(on_nodes(&nodes, &change)).expect("regular");
    }
    read(&batch, StepVelocity::Mean, &mut velocities[2]);
    let [without, with, found, expected] = &velocities;
    let farthest = |from: &[Vector3<f64>]| {
        from.iter().zip(expected).map(|(v, e)| (v - e).norm()).fold(0.0, f64::max)
    };
    assert!(farthest(with) < 0.2 * farthest(without), "{} {}", farthest(with), farthest(without));
    assert!(farthest(found) < 1e-10 * 0.3 / 1e-3);
}

/// Increments are taken once; after them other impulses are answered by the matrix that was, to
/// first order: half the change leaves a quarter of the error.
#[test]
fn a_chord_step_is_off_by_the_square_of_the_change() {
    let (mut batch, start) = falling(3, 1e-3);
    let (hold, nodes) = (hold(), node_points(3, SEGMENTS));
    let conditions: Vec<&dyn Conditions> = vec![&hold; 3];
    let mut reports = [RodStepReport::default(); 3];
    let none = impulses(&batch, 0.0);
    batch.abandon();
    let [whole, half] = [1.0, 0.5].map(|share| {
        let change = impulses(&batch, share);
        batch.restore(&start).expect("the same batch");
        batch.set_out(1e-3, &conditions, Impulses::NONE, &mut reports).expect("sound");
        for _ in 0..6 {
            batch.linearize().expect("regular");
            batch.advance(Impulses::NONE).expect("regular");
        }
        assert_eq!(batch.advance(Impulses::NONE).expect("regular"), 0.0);
        batch.advance(on_nodes(&nodes, &change)).expect("regular");
        let mut velocities = [none.clone(), none.clone()];
        read(&batch, StepVelocity::Mean, &mut velocities[0]);
        for _ in 0..6 {
            batch.linearize().expect("regular");
            batch.advance(on_nodes(&nodes, &change)).expect("regular");
        }
        read(&batch, StepVelocity::Mean, &mut velocities[1]);
        batch.abandon();
        let [chord, exact] = &velocities;
        chord.iter().zip(exact).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    });
    assert!((3.5..4.5).contains(&(whole / half)), "{whole} {half}");
}

/// Impulses on one point add up, and those that make no sense are refused and change nothing.
#[test]
fn impulses_add_up_or_are_refused() {
    let (mut batch, _) = falling(3, 1e-3);
    let point = Point::beside_axis(1, 7, 0.25, Vector3::new(0.0, 2e-5, 1e-5));
    let own = Vector3::new(2e-9, -4e-9, 8e-9);
    let once = Impulses { points: &[point], impulses: &[own] };
    assert!(batch.press(once).expect("sound"), "they are others");
    let halves = Impulses { points: &[point; 2], impulses: &[0.5 * own; 2] };
    assert!(!batch.press(halves).expect("sound"), "they are the same");
    let bad = [
        (Point::on_axis(3, 7, 0.25), own),
        (Point::on_axis(1, 40, 0.25), own),
        (Point::on_axis(1, 7, 1.25), own),
        (Point::beside_axis(1, 7, 0.25, Vector3::repeat(f64::NAN)), own),
        (point, Vector3::repeat(f64::INFINITY)),
    ];
    for (point, own) in bad {
        let all = Impulses { points: &[point], impulses: &[own] };
        let error = batch.press(all).expect_err("no sense");
        assert!(matches!(error, StepError::Conditions { what: "impulses", .. }), "{error}");
    }
    batch.press(Impulses { points: &[point], impulses: &[] }).expect_err("none for the point");
    assert!(!batch.press(once).expect("sound"), "they are the same");
}
