//! The terms of a guide's objective (5.8 to 5.10), each with its derivatives.

use super::PreGuide;
use super::flow::GuideFlow;
use crate::Region;
use crate::quadrature::trapezoid;
use nalgebra::{Matrix6, Point3, Vector3};
use rapunzel_rod_static::{Shape, ShapeDerivatives, ShapeResponse};

/// Rounds off the root of (5.9) at zero, where it has no derivative.
const ROUNDING: f64 = 1e-2;

/// One less the cosine of the angle to the pre-guides, integrated over the scaled length (5.8), and
/// weighted by their distances. Adds `weight` times its derivatives.
pub(super) fn direction(
    shape: &Shape,
    flow: &GuideFlow<'_>,
    weight: f64,
    by: &mut ShapeDerivatives,
) -> f64 {
    let segments = shape.frames().len() - 1;
    let mut sum = 0.0;
    for (node, (frame, along)) in shape.frames().iter().zip(&flow.tangents).enumerate() {
        let part = trapezoid(node, segments);
        sum += part * (1.0 - (frame * Vector3::z()).dot(along));
        by.tangents[node] -= along * (weight * part);
    }
    sum
}

/// The difference of the curvatures from those of each pre-guide, both of the curves scaled to unit
/// length (5.9, corrected), weighted as in [`direction`]; the root is rounded off at zero:
/// `sqrt(e^2 + x^2) - e`. Adds `weight` times its derivatives; `bends` are the curvatures times
/// `length`.
pub(super) fn curvature(
    bends: &[Vector3<f64>],
    length: f64,
    flow: &GuideFlow<'_>,
    weight: f64,
    by: &mut ShapeDerivatives,
) -> f64 {
    let part = (bends.len() as f64).recip();
    let mut sum = 0.0;
    for (share, guide) in &flow.parts {
        let differences = || bends.iter().zip(&guide.bends).map(|(own, other)| own - other);
        let square: f64 = differences().map(|difference| difference.norm_squared()).sum();
        let size = (ROUNDING * ROUNDING + part * square).sqrt();
        sum += share * (size - ROUNDING);
        for (by, difference) in by.curvatures.iter_mut().zip(differences()) {
            *by += difference * (weight * share * part * length / size);
        }
    }
    sum
}

/// What being near to the walls or behind them costs, integrated over the scaled length and summed
/// over head and hull (5.10, corrected): see [`wall`]. Adds `weight` times its derivatives.
pub(super) fn boundary(
    positions: &[Point3<f64>],
    region: Region<'_>,
    [margin, penalty]: [f64; 2],
    weight: f64,
    by: &mut ShapeDerivatives,
) -> f64 {
    let segments = positions.len() - 1;
    let mut sum = 0.0;
    for (node, position) in positions.iter().enumerate() {
        let part = trapezoid(node, segments);
        for sample in region.walls(position) {
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

/// Adds `weight` times the second derivatives of [`direction`] by loads with the given responses,
/// without those of the shape by the loads (Gauss and Newton).
pub(super) fn direction_bend(
    flow: &GuideFlow<'_>,
    weight: f64,
    responses: &[ShapeResponse; 6],
    hessian: &mut Matrix6<f64>,
) {
    let segments = flow.tangents.len() - 1;
    for (node, along) in flow.tangents.iter().enumerate() {
        // One less the cosine is half the square of a small angle.
        let part = weight * trapezoid(node, segments) * along.norm();
        add_squares(part, responses, |response| response.tangents[node], hessian);
    }
}

/// Adds `weight` times the second derivatives of [`curvature`] by loads with the given responses,
/// without those of the shape by the loads (Gauss and Newton).
pub(super) fn curvature_bend(
    bends: &[Vector3<f64>],
    length: f64,
    flow: &GuideFlow<'_>,
    weight: f64,
    responses: &[ShapeResponse; 6],
    hessian: &mut Matrix6<f64>,
) {
    let part = (bends.len() as f64).recip();
    let size = |guide: &PreGuide| {
        let squares =
            bends.iter().zip(&guide.bends).map(|(own, other)| (own - other).norm_squared());
        (ROUNDING * ROUNDING + part * squares.sum::<f64>()).sqrt()
    };
    let stiffness: f64 = flow.parts.iter().map(|(share, guide)| share / size(guide)).sum();
    let part = weight * stiffness * part * length * length;
    for segment in 0..bends.len() {
        add_squares(part, responses, |response| response.curvatures[segment], hessian);
    }
}

/// Adds `weight` times the second derivatives of [`boundary`] by loads with the given responses,
/// without those of the shape by the loads (Gauss and Newton).
pub(super) fn boundary_bend(
    positions: &[Point3<f64>],
    region: Region<'_>,
    [margin, penalty]: [f64; 2],
    weight: f64,
    responses: &[ShapeResponse; 6],
    hessian: &mut Matrix6<f64>,
) {
    let segments = positions.len() - 1;
    for (node, position) in positions.iter().enumerate() {
        let part = weight * trapezoid(node, segments) / (margin * margin);
        for sample in region.walls(position) {
            let bend = wall_bend(sample.value / margin, penalty);
            if bend > 0.0 {
                let toward = |response: &ShapeResponse| {
                    Vector3::new(response.positions[node].dot(&sample.gradient), 0.0, 0.0)
                };
                add_squares(part * bend, responses, toward, hessian);
            }
        }
    }
}

/// Second derivative of [`wall`].
fn wall_bend(depth: f64, penalty: f64) -> f64 {
    if depth <= -1.0 {
        0.0
    } else if depth <= 0.0 {
        1.0
    } else {
        penalty / (1.0 + depth * depth).powf(1.5)
    }
}

/// Adds `part` times the products of the changes `of` the responses.
fn add_squares(
    part: f64,
    responses: &[ShapeResponse; 6],
    of: impl Fn(&ShapeResponse) -> Vector3<f64>,
    hessian: &mut Matrix6<f64>,
) {
    let changes = responses.each_ref().map(of);
    for row in 0..6 {
        for column in 0..=row {
            hessian[(row, column)] += part * changes[row].dot(&changes[column]);
        }
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
            // The second derivative jumps at the margin and at the wall.
            let bend = (high[1] - low[1]) / (2.0 * h);
            let kink = i == -100 || i == 0;
            assert!(kink || (bend - wall_bend(depth, 10.0)).abs() < 1e-4, "{depth}: {bend}");
        }
        assert_eq!(wall(-1.0, 10.0), [0.0, 0.0]);
        assert_eq!(wall(0.0, 10.0), [0.5, 1.0]);
    }
}
