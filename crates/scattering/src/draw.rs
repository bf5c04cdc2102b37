/// Tries of a draw after which the last is taken: where each is refused with a chance below 0.9,
/// that happens once in 1e45.
pub(crate) const MOST_TRIES: u32 = 1000;

/// A number in `[-1, 1]` with the density `2 sqrt(1 - x^2) / pi`: a coordinate of a point in the
/// disc, and the sine of an inclination drawn evenly by `cos^2 theta d theta`.
pub(crate) fn semicircle(random: &mut dyn FnMut() -> f64) -> f64 {
    let mut x = 0.0;
    for _ in 0..MOST_TRIES {
        x = 2.0 * random() - 1.0;
        let y = 2.0 * random() - 1.0;
        if x * x + y * y < 1.0 {
            break;
        }
    }
    x
}

/// An index drawn by weights, by a number `u` in `[0, 1)`; `None` if no weight is positive.
pub(crate) fn choose(weights: &[f64], u: f64) -> Option<usize> {
    let mut left = u * weights.iter().sum::<f64>();
    let mut last = None;
    for (index, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
        last = Some(index);
        if left < *weight {
            break;
        }
        left -= weight;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_weight_is_never_chosen() {
        assert_eq!(choose(&[0.0, 0.0], 0.5), None);
        let weights = [0.0, 1.0, 0.0, 3.0, 0.0];
        let of = |u: f64| choose(&weights, u);
        assert_eq!([0.0, 0.24, 0.26, 1.0].map(of), [Some(1), Some(1), Some(3), Some(3)]);
    }
}
