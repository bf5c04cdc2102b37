//! Nearly parallel hairs that turn and slide beside each other: the hard case.

use super::{TOLERANCE, check_alarm, distance};
use crate::geometry::random::Random;
use nalgebra::Vector3;
use rapunzel_collision::continuous::MovingSegment;

/// A hair of 3 mm along `direction`, whose ends move by up to 1 mm together, or a hundredth of it,
/// and by 1 um to 1 mm each on its own.
fn hair(random: &mut Random, direction: Vector3<f64>) -> MovingSegment {
    let start = random.point(0.1e-3) - 1.5e-3 * direction;
    let before = [start, start + 3e-3 * direction];
    let size = if random.once_in(2) { 1e-3 } else { 0.01e-3 };
    let shift = random.vector(size);
    let own = 10.0_f64.powf(random.range(-6.0, -3.0));
    MovingSegment { before, after: before.map(|p| p + shift + random.vector(own)) }
}

/// The least distance over the step: by samples, refined by thirds around the least of them.
fn least(a: &MovingSegment, b: &MovingSegment) -> f64 {
    let sample = |k: u32| distance(a, b, f64::from(k) / 1000.0);
    let best = (0..=1000).min_by(|&i, &j| sample(i).total_cmp(&sample(j))).unwrap_or(0);
    let mut low = f64::from(best.saturating_sub(1)) / 1000.0;
    let mut high = f64::from((best + 1).min(1000)) / 1000.0;
    for _ in 0..60 {
        let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(a, b, s) < distance(a, b, t) {
            high = t;
        } else {
            low = s;
        };
    }
    distance(a, b, low).min(sample(best))
}

#[test]
fn nearly_parallel_hairs_are_told_apart_to_the_tolerance() {
    let mut random = Random::new(31);
    let mut count = 0;
    while count < 1000 {
        let angle = 10.0_f64.powf(random.range(-5.0, -1.0));
        let along = (Vector3::x() + angle * random.vector(1.0)).normalize();
        let (a, b) = (hair(&mut random, Vector3::x()), hair(&mut random, along));
        let least = least(&a, &b);
        if least < 20e-6 {
            continue;
        }
        count += 1;
        assert_eq!(a.impact(&b, least - 1.1 * TOLERANCE, TOLERANCE), None);
        let reach = least + 1e-12;
        check_alarm(&a, &b, reach, &a.impact(&b, reach, TOLERANCE).expect("a touch was missed"));
    }
}
