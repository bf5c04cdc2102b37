//! When two moving things touch, by bisection in time: no planes, no parts.

/// A time at which the `distance`, which changes no faster than by `fastest`, is at most `reach`,
/// not much later than the first; none if there is none, or it is nowhere less than `reach -
/// resolution`.
pub(crate) fn reference(
    distance: impl Fn(f64) -> f64,
    fastest: f64,
    reach: f64,
    resolution: f64,
) -> Option<f64> {
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
