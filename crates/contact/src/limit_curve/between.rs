use super::{LimitCurve, Polygon};
use crate::ContactError;
use nalgebra::{Rotation2, Vector2};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Largest angle between neighboring vertices of a merged polygon: its edges are then an eighth of
/// a percent inside a circle, and half a percent inside an ellipse of 5 to 1.
const LARGEST_STEP: f64 = TAU / 64.0;

/// Below this angle two directions are one.
const SAME_DIRECTION: f64 = 1e-9;

impl LimitCurve {
    /// The limit curve of two surfaces that rub on each other, in the frame of the first.
    ///
    /// Each curve is of friction on its own surface with `t1` along its own axis (root to tip); the
    /// second's axis is turned by `angle` from the first's, counterclockwise as `t1` turns to `t2`.
    ///
    /// Both surfaces bear the same force, in opposite directions. The square of its gauge in the
    /// pair is the mean of the squares in the two curves. That keeps convexity and symmetry, leaves
    /// equal curves as they are, gives quarter-ellipses for fibers that are parallel, opposite or
    /// at right angles, and agrees with what is known of hair and wool (thesis 2.4.9, Fig. 2.18):
    ///
    /// | case | the fibers are | they move | friction |
    /// |---|---|---|---|
    /// | 1 | opposite | both root first | that of one with its scales |
    /// | 2 | opposite | both tip first | that of one against its scales |
    /// | 3 | parallel | either way | the same both ways, between 1 and 2 |
    /// | 4, 5 | crossed | one root first or tip first | between that and across the other |
    ///
    /// For wool (Tab. 2.11) case 3 is 0.180 at rest and 0.149 sliding where 0.21 and 0.15 were
    /// measured; the smaller of the two curves would give 0.13 and 0.11, the mean 0.37 and 0.25.
    ///
    /// Curves at other angles become a polygon of some seventy vertices, which are exact; its edges
    /// are up to half a percent inside if one coefficient is five times another. That costs some
    /// microseconds: keep the result for pairs at like angles.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for a curve that does not validate and an angle that is not
    /// finite.
    pub fn between(first: &Self, second: &Self, angle: f64) -> Result<Self, ContactError> {
        first.validate()?;
        second.validate()?;
        if !angle.is_finite() {
            return Err(ContactError::Invalid {
                what: "angle between two fibers",
                value: angle,
                why: "it must be finite",
            });
        }
        if [first, second].contains(&&Self::Joint) {
            return Ok(Self::Joint);
        }
        if let (Self::Circle { mu: a }, Self::Circle { mu: b }) = (first, second) {
            return Ok(Self::Circle { mu: merged(*a, *b) });
        }
        let turns = (angle / FRAC_PI_2).round();
        let aligned = (angle - turns * FRAC_PI_2).abs() < SAME_DIRECTION;
        match (first.semi_axes(), second.reflected().semi_axes()) {
            (Some(a), Some(b)) if aligned => {
                let b = match turns.rem_euclid(4.0) {
                    1.0 => [b[3], b[2], b[0], b[1]],
                    2.0 => [b[1], b[0], b[3], b[2]],
                    3.0 => [b[2], b[3], b[1], b[0]],
                    _ => b,
                };
                Ok(Self::Quarters { mu: std::array::from_fn(|i| merged(a[i], b[i])) })
            }
            _ => polygon(first, second, angle),
        }
    }
}

/// The coefficient whose reciprocal square is the mean of those of `a` and `b`.
fn merged(a: f64, b: f64) -> f64 {
    let (small, large) = (a.min(b), a.max(b));
    if small <= 0.0 { 0.0 } else { small * (2.0 / (1.0 + (small / large).powi(2))).sqrt() }
}

/// Limit curve of two surfaces as a polygon, whose vertices are points of the curve in directions
/// at most [`LARGEST_STEP`] apart.
fn polygon(
    first: &LimitCurve,
    second: &LimitCurve,
    angle: f64,
) -> Result<LimitCurve, ContactError> {
    let turn = Rotation2::new(angle);
    let mut directions = corners(first);
    directions.extend(corners(second).iter().map(|d| turn * -d));
    directions.sort_by(|a, b| a.y.atan2(a.x).total_cmp(&b.y.atan2(b.x)));
    let mut points = Vec::new();
    for (i, from) in directions.iter().enumerate() {
        let to = directions[(i + 1) % directions.len()];
        let gap = from.perp(&to).atan2(from.dot(&to)).rem_euclid(TAU);
        if !(SAME_DIRECTION..=TAU - SAME_DIRECTION).contains(&gap) {
            continue;
        }
        let parts = (gap / LARGEST_STEP).ceil();
        let mut part = 0.0;
        while part < parts {
            let direction = Rotation2::new(gap * part / parts) * from;
            let other = second.gauge(&turn.inverse_transform_vector(&-direction));
            let gauge = first.gauge(&direction).hypot(other) / std::f64::consts::SQRT_2;
            points.push(if gauge < f64::INFINITY { direction / gauge } else { Vector2::zeros() });
            part += 1.0;
        }
    }
    Ok(LimitCurve::Polygon(Polygon::new(&points)?))
}

/// Unit vectors to where a curve's pieces join.
fn corners(curve: &LimitCurve) -> Vec<Vector2<f64>> {
    let axes = [Vector2::x(), -Vector2::x(), Vector2::y(), -Vector2::y()];
    let mut corners = axes.to_vec();
    if let LimitCurve::Polygon(polygon) = curve {
        corners.extend(polygon.vertices().iter().filter_map(|v| v.try_normalize(0.0)));
    }
    corners
}
