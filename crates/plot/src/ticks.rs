//! Round numbers for axes and bars.

/// Multiples of 1, 2 or 5 times a power of ten within an interval, at most some `most` of them, and
/// the difference between neighbors.
pub(crate) fn ticks([low, high]: [f64; 2], most: f64) -> (Vec<f64>, f64) {
    let raw = (high - low) / most;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw * 0.999);
    let step = step.unwrap_or(raw);
    let first = (low / step - 1e-9).ceil();
    let count = ((high / step + 1e-9).floor() - first).max(0.0);
    let numbers = std::iter::successors(Some(0.0), |i| Some(i + 1.0));
    (numbers.take_while(|i| *i <= count).map(|i| (first + i) * step).collect(), step)
}

/// A multiple of `step` with the decimals that its neighbors need too; those that would need many
/// digits are written with a power of ten.
pub(crate) fn label(x: f64, step: f64) -> String {
    let x = if x.abs() < 0.5 * step { 0.0 } else { x };
    let decimals = (0..5).find(|d| {
        let scaled = step * 10f64.powi(*d);
        (scaled - scaled.round()).abs() < 1e-6 * scaled
    });
    match decimals {
        Some(decimals) if x.abs() < 1e6 => format!("{x:.*}", decimals.unsigned_abs() as usize),
        _ if x == 0.0 => "0".into(),
        _ => format!("{:e}", format!("{x:.9e}").parse().unwrap_or(x)),
    }
}

/// The largest of 1, 2 or 5 times a power of ten that is not above `x`, which is positive.
pub(crate) fn round_below(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|v| *v <= x * 1.001).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let (values, step) = ticks([0.0, 0.2], 5.0);
        assert_eq!((values.len(), step), (5, 0.05));
        assert!((values[4] - 0.2).abs() < 1e-15, "{values:?}");
        assert_eq!(ticks([-3.0, 12.0], 4.0), (vec![0.0, 5.0, 10.0], 5.0));
        assert_eq!(ticks([0.0, 50.0], 6.0).0, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]);
    }

    #[test]
    fn labels_are_short() {
        let cases = [
            (0.1 + 0.2, 0.1, "0.3"),
            (0.0, 0.05, "0.00"),
            (-1e-17, 0.5, "0.0"),
            (3.0 * 2e-7, 2e-7, "6e-7"),
            (2e7, 5e6, "2e7"),
        ];
        for (x, step, expected) in cases {
            assert_eq!(label(x, step), expected);
        }
    }

    #[test]
    fn bars_are_round() {
        for (x, bar) in [(0.13, 0.1), (0.2, 0.2), (4.9, 2.0), (70.0, 50.0)] {
            assert!((round_below(x) / bar - 1.0).abs() < 1e-12, "{x}");
        }
    }
}
