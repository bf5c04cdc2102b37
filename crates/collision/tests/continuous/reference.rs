//! When two moving segments touch, by bisection in time: no planes, no parts.

use rapunzel_collision::continuous::MovingSegment;

/// A time at which the distance is at most `reach`, not much later than the first; none if there is
/// none, or the distance is nowhere less than `reach - resolution`.
///
/// The distance changes no faster than the fastest pair of ends moves against each other.
pub(crate) fn reference(
    a: &MovingSegment,
    b: &MovingSegment,
    reach: f64,
    resolution: f64,
) -> Option<f64> {
    let speed =
        |i: usize, j: usize| ((b.after[j] - b.before[j]) - (a.after[i] - a.before[i])).norm();
    let fastest = speed(0, 0).max(speed(0, 1)).max(speed(1, 0)).max(speed(1, 1));
    let distance = |t: f64| a.at(t, 0.0).closest(&b.at(t, 0.0)).distance();
    let mut touch = (distance(0.0) <= reach).then_some(0.0);
    let mut waiting = vec![(0.0, 1.0)];
    while let (Some((low, high)), None) = (waiting.pop(), touch) {
        let middle = 0.5 * (low + high);
        let here = distance(middle);
        let radius = 0.5 * fastest * (high - low);
        if here - radius > reach || radius < resolution {
            if here <= reach {
                touch = Some(middle);
            }
            continue;
        }
        // The earlier half is taken first.
        waiting.push((middle, high));
        waiting.push((low, middle));
    }
    touch.or((distance(1.0) <= reach).then_some(1.0))
}
