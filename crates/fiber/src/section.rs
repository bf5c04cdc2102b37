use crate::FiberError;
use crate::error::positive;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The cross section of a fibre, in metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Section {
    /// A circle.
    Circle {
        /// Radius, m.
        radius: f64,
    },
    /// An ellipse with its axes along the directors.
    Ellipse {
        /// Semi-axis along d1, m.
        a: f64,
        /// Semi-axis along d2, m.
        b: f64,
    },
}

impl Section {
    /// Checks that all lengths are positive and finite.
    ///
    /// # Errors
    /// [`FiberError::NotPositive`] names the length that is not.
    pub fn validate(&self) -> Result<(), FiberError> {
        match *self {
            Self::Circle { radius } => positive("radius (m)", radius),
            Self::Ellipse { a, b } => {
                positive("semi-axis a (m)", a)?;
                positive("semi-axis b (m)", b)
            }
        }
    }

    /// Semi-axes along d1 and d2, m.
    #[must_use]
    pub fn semi_axes(&self) -> (f64, f64) {
        match *self {
            Self::Circle { radius } => (radius, radius),
            Self::Ellipse { a, b } => (a, b),
        }
    }

    /// Area of the section, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        let (a, b) = self.semi_axes();
        PI * a * b
    }

    /// Radius of the circle of the same area, m.
    #[must_use]
    pub fn equivalent_radius(&self) -> f64 {
        let (a, b) = self.semi_axes();
        (a * b).sqrt()
    }

    /// Second moments of area `[I1, I2, I3]`, m^4: `I1` about d1, `I2` about d2 and the polar
    /// one `I3 = I1 + I2` (thesis, after (3.11), which prints `diag(I1, I3, I3)`; corrected).
    #[must_use]
    pub fn second_moments(&self) -> [f64; 3] {
        let (a, b) = self.semi_axes();
        let (i1, i2) = (PI * a * b.powi(3) / 4.0, PI * a.powi(3) * b / 4.0);
        [i1, i2, i1 + i2]
    }

    /// Saint-Venant torsion constant, m^4: `pi a^3 b^3 / (a^2 + b^2)`. It equals the polar second
    /// moment for a circle and is smaller for an ellipse, whose section warps.
    #[must_use]
    pub fn torsion_constant(&self) -> f64 {
        let (a, b) = self.semi_axes();
        PI * (a * b).powi(3) / (a * a + b * b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn circle_is_the_ellipse_with_equal_axes() {
        let (c, e) = (Section::Circle { radius: 0.3 }, Section::Ellipse { a: 0.3, b: 0.3 });
        assert_relative_eq!(c.area(), PI * 0.09);
        assert_relative_eq!(c.torsion_constant(), c.second_moments()[2], max_relative = 1e-15);
        assert_eq!(c.second_moments(), e.second_moments());
    }

    #[test]
    fn ellipse_bends_more_easily_about_its_long_axis() {
        // d1 carries the long axis: bending about d1 displaces along d2, the short way.
        let e = Section::Ellipse { a: 2.0, b: 1.0 };
        let [i1, i2, i3] = e.second_moments();
        assert_relative_eq!(i1, PI / 2.0, max_relative = 1e-15);
        assert_relative_eq!(i2, 2.0 * PI, max_relative = 1e-15);
        assert!(e.torsion_constant() < i3, "a section that warps is softer in torsion");
        assert_relative_eq!(e.torsion_constant(), 8.0 * PI / 5.0, max_relative = 1e-15);
    }

    #[test]
    fn nonsense_is_refused() {
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Section::Circle { radius }.validate().is_err(), "radius {radius}");
        }
    }
}
