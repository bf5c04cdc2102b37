//! The terms of a guide's objective (5.8, 5.9), each with its derivatives.

use super::flow::GuideFlow;
use crate::quadrature::trapezoid;
use nalgebra::Vector3;
use rapunzel_rod_static::{Shape, ShapeDerivatives};

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
