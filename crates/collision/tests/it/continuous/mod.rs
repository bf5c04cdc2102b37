//! Continuous detection misses nothing, and its false alarms are within the tolerance.

mod faces;
mod known;
mod parallel;
mod queries;
mod reference;
mod surface;

use crate::geometry::random::Random;
use nalgebra::Vector3;
use rapunzel_collision::continuous::{Impact, MovingSegment};
use reference::reference;

const REACH: f64 = 70e-6;
const TOLERANCE: f64 = 1e-3 * REACH;

/// Distance of two segments at a time of the step.
fn distance(a: &MovingSegment, b: &MovingSegment, time: f64) -> f64 {
    a.at(time, 0.0).closest(&b.at(time, 0.0)).distance()
}

/// An impact must be where it says it is.
fn check_alarm(a: &MovingSegment, b: &MovingSegment, reach: f64, impact: &Impact<2>) {
    assert!(impact.resolved, "given up: {a:?} {b:?}");
    let there = distance(a, b, impact.time);
    assert!(there <= reach + TOLERANCE + 1e-12, "a false alarm at {there}");
    let [s, t] = impact.coordinates;
    let (p, q) = (a.at(impact.time, 0.0).at(s), b.at(impact.time, 0.0).at(t));
    assert!((q - p - impact.offset).norm() <= 1e-12, "the points are not at the offset");
}

/// Segments of hair, 0.1 to 3 mm long, that move by up to 2 mm and are likely to meet; a part of
/// them points, parallel, or at rest.
fn random_segment(random: &mut Random) -> MovingSegment {
    let middle = random.point(1e-3);
    let half = random.range(0.05e-3, 1.5e-3) * random.unit_vector();
    let half = if random.once_in(16) { 0.0 * half } else { half };
    let half = if random.once_in(8) { half.x * Vector3::x() } else { half };
    let before = [middle - half, middle + half];
    let (shift, turn) = (random.vector(1e-3), random.vector(1e-3));
    let turn = if random.once_in(4) { 0.0 * turn } else { turn };
    MovingSegment { before, after: [before[0] + shift - turn, before[1] + shift + turn] }
}

fn random_motions(count: usize, seed: u64) {
    let mut random = Random::new(seed);
    let (mut touches, mut alarms, mut evaluations) = (0, 0, 0);
    for _ in 0..count {
        let (a, b) = (random_segment(&mut random), random_segment(&mut random));
        let speed =
            |i: usize, j: usize| ((b.after[j] - b.before[j]) - (a.after[i] - a.before[i])).norm();
        let fastest = speed(0, 0).max(speed(0, 1)).max(speed(1, 0)).max(speed(1, 1));
        let truth = reference(|t| distance(&a, &b, t), fastest, REACH, 1e-9);
        let impact = a.impact(&b, REACH, TOLERANCE);
        if let Some(touch) = truth {
            touches += 1;
            let impact = impact.expect("a touch was missed");
            assert!(impact.time <= touch, "reported at {} after {touch}", impact.time);
        }
        if let Some(impact) = impact {
            check_alarm(&a, &b, REACH, &impact);
            evaluations += impact.evaluations;
            alarms += usize::from(truth.is_none());
        }
    }
    assert!(touches > count / 20, "only {touches} touch");
    // The band of false alarms is a thousandth of the reach.
    assert!(alarms <= touches / 200 + 5, "{alarms} false alarms against {touches} touches");
    println!("{touches} touch, {alarms} false alarms, {evaluations} evaluations");
}

#[test]
fn random_motions_agree_with_bisection() {
    random_motions(20_000, 1);
}

#[test]
#[ignore = "slow: 15 s, ten million motions against bisection"]
fn ten_million_random_motions_agree_with_bisection() {
    random_motions(10_000_000, 2);
}
