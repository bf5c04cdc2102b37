//! What nearness to walls costs (5.10), with its derivatives.

use crate::quadrature::trapezoid;
use nalgebra::Point3;
use rapunzel_collision::field::Sample;
use rapunzel_rod_static::ShapeDerivatives;

/// What being near to two walls or behind them costs, integrated over the scaled length and summed
/// over both (5.10, corrected): see [`wall`]. `depths` are those into the forbidden sides, m. Adds
/// `weight` times its derivatives.
pub(super) fn boundary(
    positions: &[Point3<f64>],
    depths: impl Fn(&Point3<f64>) -> [Sample; 2],
    [margin, penalty]: [f64; 2],
    weight: f64,
    by: &mut ShapeDerivatives,
) -> f64 {
    let segments = positions.len() - 1;
    let mut sum = 0.0;
    for (node, position) in positions.iter().enumerate() {
        let part = trapezoid(node, segments);
        for sample in depths(position) {
            let [value, slope] = wall(sample.value / margin, penalty);
            sum += part * value;
            by.positions[node] += sample.gradient * (weight * part * slope / margin);
        }
    }
    sum
}

/// A wall at the signed depth `depth` into the forbidden side, in units of the margin: its value
/// and slope. Before the wall half the square of what is missing to the margin, behind it a line
/// with the same slope and the penalty, whose jump in the thesis is a continuous rise here; the
/// slope is continuous.
fn wall(depth: f64, penalty: f64) -> [f64; 2] {
    if depth <= -1.0 {
        [0.0, 0.0]
    } else if depth <= 0.0 {
        [0.5 * (1.0 + depth) * (1.0 + depth), 1.0 + depth]
    } else {
        let root = (1.0 + depth * depth).sqrt();
        [0.5 + depth + penalty * (root - 1.0), 1.0 + penalty * depth / root]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The wall and its slope have no jump, and the slope is the derivative and rises.
    #[test]
    fn a_wall_rises_smoothly_into_the_forbidden_side() {
        let h = 1e-6;
        for i in -300..=300_i32 {
            let depth = f64::from(i) * 0.01;
            let [low, middle, high] = [depth - h, depth, depth + h].map(|d| wall(d, 10.0));
            let slope = (high[0] - low[0]) / (2.0 * h);
            assert!((slope - middle[1]).abs() < 1e-4, "{depth}: {slope} {middle:?}");
            assert!(low[0] <= high[0] && low[1] <= high[1], "{depth}");
        }
        assert_eq!(wall(-1.0, 10.0), [0.0, 0.0]);
        assert_eq!(wall(0.0, 10.0), [0.5, 1.0]);
    }
}
