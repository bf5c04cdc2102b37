use super::chords::chords;
use crate::FiberError;
use crate::error::positive;
use nalgebra::Point3;
use std::f64::consts::{PI, TAU};

/// An overhand knot in a straight fibre: a round loop whose ends wind one and a half times about
/// each other and leave along one line. Pulled tight by its ends it stays the open trefoil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overhand {
    /// Radius of the loop, m.
    pub radius: f64,
    /// Distance of the axes of the two strands that wind about each other, m; more than a diameter.
    pub spacing: f64,
}

/// Angle by which the strands wind about each other, rad; half a turn would be a loop without a
/// knot.
const WINDING: f64 = 3.0 * PI;

impl Overhand {
    /// Nodes of the knot, m, for segments of the given lengths, m. It begins at the origin along z,
    /// its loop stands out along x, its ends lie on the z axis and are equally long.
    ///
    /// All segments are chords of one smooth curve and have their lengths to rounding.
    ///
    /// # Errors
    /// Refuses lengths that are not positive, a spacing of more than a tenth of the radius,
    /// segments longer than half the radius, and a fibre too short for the knot.
    pub fn nodes(&self, lengths: &[f64]) -> Result<Vec<Point3<f64>>, FiberError> {
        positive("radius of the knot (m)", self.radius)?;
        positive("distance of the strands of the knot (m)", self.spacing)?;
        let refuse = |quantity, value, range| FiberError::OutOfRange { quantity, value, range };
        if self.spacing > 0.1 * self.radius {
            let quantity = "distance of the strands of the knot (m)";
            return Err(refuse(quantity, self.spacing, "(0, a tenth of the radius]"));
        }
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        if longest > 0.5 * self.radius {
            let needed = (lengths.len() as f64 * longest / (0.5 * self.radius)).ceil();
            return Err(FiberError::Unresolved { segments: lengths.len(), needed });
        }
        let end = 0.5 * (lengths.iter().sum::<f64>() - self.knotted());
        if end.is_nan() || end <= 0.0 {
            let range = "[0, so small that the fibre is longer than the knot)";
            return Err(refuse("radius of the knot (m)", self.radius, range));
        }
        Ok(chords(lengths, |way| self.curve(way, end)))
    }

    /// Half the length over which the strands wind, m: so long that their curvature is at most the
    /// curvature of the loop.
    fn half(&self) -> f64 {
        0.75 * WINDING * (0.5 * self.spacing * self.radius).sqrt()
    }

    /// Length of the curve from where the strands begin to wind to where they end, m, measured
    /// along z while they wind.
    fn knotted(&self) -> f64 {
        TAU * self.radius + 6.0 * self.half()
    }

    /// Point at the arc length `way` of the curve, m, after a straight `end`.
    fn curve(&self, way: f64, end: f64) -> Point3<f64> {
        let (b, r, half_turn) = (self.half(), self.radius, PI * self.radius);
        let middle = end + b;
        // From the middle of the winding, one strand and the other.
        let first = way - middle;
        let second = first - (4.0 * b + 2.0 * half_turn);
        if first <= b {
            return self.strand(first, middle, 1.0);
        }
        if second >= -b {
            return self.strand(second, middle, -1.0);
        }
        let (up, over) = (first - b, first - b - half_turn);
        let down = over - 2.0 * b;
        let (x, z) = if over <= 0.0 {
            let (sin, cos) = (up / r).sin_cos();
            (r * (1.0 - cos), b + r * sin)
        } else if down <= 0.0 {
            (2.0 * r, b - over)
        } else {
            let (sin, cos) = (down / r).sin_cos();
            (r * (1.0 + cos), -b - r * sin)
        };
        Point3::new(self.spacing + x, 0.0, middle + z)
    }

    /// Point of one of the strands, m, at the distance `along` z from the middle of the winding.
    fn strand(&self, along: f64, middle: f64, side: f64) -> Point3<f64> {
        let t = (0.5 * (along / self.half() + 1.0)).clamp(0.0, 1.0);
        // Without a kink where the winding begins and ends.
        let (sin, cos) = (WINDING * t * t * (3.0 - 2.0 * t)).sin_cos();
        let arm = 0.5 * self.spacing;
        Point3::new(arm * (1.0 - side * cos), -arm * side * sin, middle + along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn segments_have_their_lengths_and_stay_apart(
            radius in 1e-3..0.02_f64,
            spacing in 0.001..0.1_f64,
            segments in 150..400_usize,
            length in 17.0..30.0_f64,
        ) {
            let knot = Overhand { radius, spacing: spacing * radius };
            let lengths = vec![length * radius / segments as f64; segments];
            let nodes = knot.nodes(&lengths).expect("a knot");
            let last = nodes[segments];
            for (w, length) in nodes.windows(2).zip(&lengths) {
                prop_assert!(((w[1] - w[0]).norm() / length - 1.0).abs() < 1e-12);
            }
            // Ends are on one line, and the loop is as high as it is wide.
            prop_assert!(nodes[0].coords.norm() < 1e-15);
            prop_assert!(last.x.hypot(last.y) < 1e-12 && last.z > 0.0, "{last}");
            let highest = nodes.iter().map(|p| p.x).fold(0.0, f64::max);
            let (top, sagitta) = (2.0 * radius + knot.spacing, lengths[0].powi(2) / radius);
            prop_assert!(highest <= top * (1.0 + 1e-12) && highest > top - sagitta);
        }
    }

    #[test]
    fn the_curve_is_smooth() {
        let knot = Overhand { radius: 0.01, spacing: 2e-4 };
        let (end, step) = (0.02, 1e-5);
        let at = |k: usize| knot.curve(step * k as f64, end);
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand points")]
        let count = ((2.0 * end + knot.knotted()) / step) as usize;
        for k in 1..count {
            // Curvatures are at most that of the loop and what the cubic adds at its ends.
            let bend = (at(k + 1) - at(k) - (at(k) - at(k - 1))).norm() / (step * step);
            assert!(bend < 2.0 / knot.radius, "{bend} at {k}");
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let nodes = |radius, spacing, length: f64, segments: usize| {
            Overhand { radius, spacing }.nodes(&vec![length / segments as f64; segments])
        };
        assert!(matches!(nodes(0.0, 1e-4, 0.2, 200), Err(FiberError::NotPositive { .. })));
        assert!(matches!(nodes(0.01, f64::NAN, 0.2, 200), Err(FiberError::NotPositive { .. })));
        assert!(matches!(nodes(0.01, 2e-3, 0.2, 200), Err(FiberError::OutOfRange { .. })));
        assert!(matches!(nodes(0.01, 1e-4, 0.06, 200), Err(FiberError::OutOfRange { .. })));
        assert!(matches!(nodes(0.01, 1e-4, 0.2, 20), Err(FiberError::Unresolved { .. })));
    }
}
