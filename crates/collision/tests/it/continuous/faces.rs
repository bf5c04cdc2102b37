//! A moving point against a moving triangle.

use super::reference::reference;
use super::{REACH, TOLERANCE};
use crate::geometry::random::Random;
use crate::geometry::triangle::to_triangle;
use nalgebra::Vector3;
use rapunzel_collision::continuous::{MovingPoint, MovingTriangle};

/// A triangle of up to 2 mm that moves and changes its shape, a part of them rigid or degenerate,
/// and a point that is likely to meet it.
fn motion(random: &mut Random) -> (MovingPoint, MovingTriangle) {
    let start = random.point(0.5e-3);
    let point = MovingPoint { before: start, after: start + random.vector(2e-3) };
    let mut before = [0, 1, 2].map(|_| random.point(1e-3));
    if random.once_in(16) {
        before[1] = before[0];
    }
    if random.once_in(16) {
        before[2] = before[0] + 0.3 * (before[1] - before[0]);
    }
    let (shift, bend) = (random.vector(0.5e-3), if random.once_in(2) { 0.0 } else { 1e-3 });
    let after = before.map(|p| p + shift + random.vector(bend));
    (point, MovingTriangle { before, after })
}

fn random_motions(count: usize, seed: u64) {
    let mut random = Random::new(seed);
    let (mut touches, mut alarms) = (0, 0);
    for _ in 0..count {
        let (point, triangle) = motion(&mut random);
        let way = point.after - point.before;
        let place = |t: f64| point.before + t * way;
        let corners = |t: f64| {
            [0, 1, 2].map(|k| triangle.before[k] + t * (triangle.after[k] - triangle.before[k]))
        };
        let speed = |k: usize| (triangle.after[k] - triangle.before[k] - way).norm();
        let fastest = speed(0).max(speed(1)).max(speed(2));
        let distance = |t: f64| to_triangle(&place(t), corners(t));
        let truth = reference(distance, fastest, REACH, 1e-9);
        let impact = point.impact(&triangle, REACH, TOLERANCE);
        if let Some(touch) = truth {
            touches += 1;
            let impact = impact.expect("a touch was missed");
            assert!(impact.time <= touch, "reported at {} after {touch}", impact.time);
        }
        if let Some(impact) = impact {
            alarms += usize::from(truth.is_none());
            assert!(impact.resolved && distance(impact.time) <= REACH + TOLERANCE + 1e-12);
            let corners = corners(impact.time);
            let foot: Vector3<f64> =
                (0..3).map(|k| impact.coordinates[k] * corners[k].coords).sum();
            assert!((foot - place(impact.time).coords - impact.offset).norm() <= 1e-12);
        }
    }
    assert!(touches > count / 20, "only {touches} touch");
    assert!(alarms <= touches / 200 + 5, "{alarms} false alarms against {touches} touches");
    println!("{touches} touch, {alarms} false alarms");
}

#[test]
fn random_motions_of_faces_agree_with_bisection() {
    random_motions(20_000, 21);
}

#[test]
fn a_million_random_motions_of_faces_agree_with_bisection() {
    random_motions(1_000_000, 22);
}
