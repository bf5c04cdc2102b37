//! Motions whose answer is known without a search.

use super::{REACH, TOLERANCE, check_alarm};
use crate::geometry::random::Random;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::continuous::MovingSegment;

/// A segment that is at `ends` at `time`, where the ends have `velocities`.
fn through(time: f64, ends: [Point3<f64>; 2], velocities: [Vector3<f64>; 2]) -> MovingSegment {
    let at = |t: f64| [0, 1].map(|k| ends[k] + (t - time) * velocities[k]);
    MovingSegment { before: at(0.0), after: at(1.0) }
}

/// Two segments on either side of a plane with normal `n`, one of the ends or an inner point of
/// each at the distance `REACH` across the plane: crossing, end to side, end to end, parallel.
fn across_a_plane(random: &mut Random, n: &Vector3<f64>) -> [[Point3<f64>; 2]; 2] {
    let parallel = random.once_in(4).then(|| random.unit_vector());
    let foot = random.point(1e-2);
    let mut side = |sign: f64| {
        let d = parallel.unwrap_or_else(|| random.unit_vector());
        let d = random.range(0.1e-3, 3e-3) * (d - n * n.dot(&d));
        let s = if random.once_in(2) { 0.0 } else { random.range(0.0, 1.0) };
        // Away from the plane with the other end, if the first touches it.
        let lift = if s == 0.0 { random.range(0.0, 1e-3) } else { 0.0 };
        let lift = if random.once_in(3) { 0.0 } else { lift };
        let start = foot + sign * 0.5 * REACH * n - s * d;
        [start, start + d + sign * lift * n]
    };
    [side(-1.0), side(1.0)]
}

/// Velocities of the ends that have all `sign` times a positive part along `n`.
fn velocities(random: &mut Random, n: &Vector3<f64>, sign: f64) -> [Vector3<f64>; 2] {
    let size = if random.once_in(4) { 0.1 } else { 2e-3 };
    [0, 1].map(|_| {
        let v = random.vector(size);
        v - n * n.dot(&v) + sign * random.range(0.01, 1.0) * size * n
    })
}

/// The plane separates the two until they touch at a chosen time: that is the first time.
fn first_touches(count: usize, seed: u64) {
    let mut random = Random::new(seed);
    for _ in 0..count {
        let n = random.unit_vector();
        let time = random.range(0.0, 1.0);
        let ends = across_a_plane(&mut random, &n);
        let a = through(time, ends[0], velocities(&mut random, &n, 1.0));
        let b = through(time, ends[1], velocities(&mut random, &n, -1.0));
        // The construction itself is rounded.
        let impact = a.impact(&b, REACH + 1e-15, TOLERANCE).expect("a touch was missed");
        check_alarm(&a, &b, REACH + 1e-15, &impact);
        assert!(impact.time <= time + 1e-10, "{} after {time}", impact.time);
    }
}

/// The plane separates the two by more than the tolerance all the time.
fn near_misses(count: usize, seed: u64) {
    let mut random = Random::new(seed);
    for _ in 0..count {
        let n = random.unit_vector();
        let time = random.range(0.0, 1.0);
        let ends = across_a_plane(&mut random, &n);
        let tangential = |v: [Vector3<f64>; 2]| v.map(|v| v - n * n.dot(&v));
        let a = through(time, ends[0], tangential(velocities(&mut random, &n, 1.0)));
        let b = through(time, ends[1], tangential(velocities(&mut random, &n, 1.0)));
        let reach = REACH - 1.001 * TOLERANCE;
        let impact = a.impact(&b, reach, TOLERANCE);
        assert!(impact.is_none_or(|i| !i.resolved), "a false alarm: {impact:?}");
        assert!(impact.is_none(), "given up: {impact:?}");
    }
}

#[test]
fn a_constructed_first_touch_is_found() {
    first_touches(20_000, 3);
}

#[test]
fn a_constructed_near_miss_is_none() {
    near_misses(20_000, 4);
}

#[test]
fn two_million_constructed_motions() {
    first_touches(1_000_000, 5);
    near_misses(1_000_000, 6);
}

/// Point-like segments that pass each other on a line: the least distance is exact.
#[test]
fn grazing_by_a_billionth_of_a_meter() {
    for miss in [-1e-9, -1e-12, 0.0, 1e-9] {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let still = MovingSegment { before: [p(0.0, 0.0); 2], after: [p(0.0, 0.0); 2] };
        let y = REACH + miss;
        let moving = MovingSegment { before: [p(-1e-3, y); 2], after: [p(1e-3, y); 2] };
        let impact = still.impact(&moving, REACH, 1e-10);
        if miss > 1e-10 {
            assert_eq!(impact, None);
        } else {
            let impact = impact.expect("touches");
            assert!(impact.resolved && impact.time <= 0.5);
        }
    }
}

#[test]
fn segments_in_touch_from_the_start_touch_at_zero() {
    let mut random = Random::new(7);
    for _ in 0..1000 {
        let n = random.unit_vector();
        let ends = across_a_plane(&mut random, &n);
        let [a, b] = ends.map(|ends| {
            let size = random.range(0.0, 1.0);
            through(0.0, ends, [random.vector(size), random.vector(size)])
        });
        let impact = a.impact(&b, 1.01 * REACH, TOLERANCE).expect("they touch");
        assert!(impact.time == 0.0 && impact.resolved && impact.evaluations == 1);
    }
}

/// A fibre crosses another at 10 m/s, 143 diameters in a step of 1 ms.
fn fast_fibers(count: usize, seed: u64) {
    let mut random = Random::new(seed);
    for _ in 0..count {
        let (u, v) = (random.unit_vector(), random.unit_vector());
        let meeting = random.point(0.1);
        let velocity = 10.0 * 1e-3 * random.unit_vector();
        let time = random.range(0.0, 1.0);
        let mut axis = |d: Vector3<f64>| {
            let start = meeting - random.range(0.0, 3e-3) * d;
            [start, start + 3e-3 * d]
        };
        let a = through(time, axis(u), [Vector3::zeros(); 2]);
        let b = through(time, axis(v), [velocity; 2]);
        let (a, b) = if random.once_in(2) { (a, b) } else { (b, a) };
        let impact = a.impact(&b, REACH, TOLERANCE).expect("tunneled");
        check_alarm(&a, &b, REACH, &impact);
        assert!(impact.time <= time);
    }
}

#[test]
fn no_fiber_tunnels_at_ten_meters_per_second() {
    fast_fibers(20_000, 8);
}

#[test]
fn what_is_not_finite_touches() {
    let p = Point3::origin();
    let still = MovingSegment { before: [p; 2], after: [p; 2] };
    for bad in [f64::NAN, f64::INFINITY] {
        let far = Point3::new(1.0, bad, 0.0);
        for odd in [
            MovingSegment { before: [far, p], after: [p; 2] },
            MovingSegment { before: [p; 2], after: [p, far] },
        ] {
            let impact = still.impact(&odd, REACH, TOLERANCE).expect("touches");
            assert!(impact.time == 0.0 && !impact.resolved);
        }
    }
}
