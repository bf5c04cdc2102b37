use crate::ScatteringError;
use crate::error::check;
use nalgebra::Vector3;

/// Absorption of eumelanin (black, brown) per unit of concentration and radius of the fibre, for
/// red, green and blue (Chiang et al. 2016, after d'Eon et al. 2011).
pub const EUMELANIN: Vector3<f64> = Vector3::new(0.419, 0.697, 1.37);

/// Absorption of pheomelanin (red, yellow), in the units of [`EUMELANIN`].
pub const PHEOMELANIN: Vector3<f64> = Vector3::new(0.187, 0.4, 1.05);

/// What colors a fibre. The thesis gives no absorption to its hair colors (6.4.1). That 1.3 of
/// eumelanin is brown is the default of the renderer pbrt; the concentrations of the other named
/// colors are our choice, not measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pigments {
    /// Concentration of eumelanin, at least 0: 8 is black, 1.3 brown, 0.3 blond.
    pub eumelanin: f64,
    /// Concentration of pheomelanin, at least 0: about 1 and more is red.
    pub pheomelanin: f64,
    /// Absorption of dyes, per radius of the fibre, each at least 0, for red, green and blue.
    pub dye: Vector3<f64>,
}

impl Pigments {
    /// White hair.
    pub const WHITE: Self =
        Self { eumelanin: 0.0, pheomelanin: 0.0, dye: Vector3::new(0.0, 0.0, 0.0) };
    /// Blond hair.
    pub const BLOND: Self = Self { eumelanin: 0.3, ..Self::WHITE };
    /// Brown hair.
    pub const BROWN: Self = Self { eumelanin: 1.3, ..Self::WHITE };
    /// Red hair.
    pub const RED: Self = Self { eumelanin: 0.2, pheomelanin: 1.2, ..Self::WHITE };
    /// Black hair.
    pub const BLACK: Self = Self { eumelanin: 8.0, ..Self::WHITE };

    /// These pigments after bleach has left the share `left`, in `[0, 1]`, of the melanin.
    #[must_use]
    pub fn bleached(self, left: f64) -> Self {
        Self { eumelanin: self.eumelanin * left, pheomelanin: self.pheomelanin * left, ..self }
    }

    /// These pigments with a dye besides that alone would give white hair the absorption `dye`, as
    /// from [`absorption_of_color`].
    #[must_use]
    pub fn dyed(self, dye: Vector3<f64>) -> Self {
        Self { dye: self.dye + dye, ..self }
    }

    /// The absorption, per radius of the fibre, for red, green and blue: what is needed of a fibre
    /// of radius `R` with the coefficient `sigma_a` is `sigma_a R`.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if a concentration or a dye is negative or not finite.
    pub fn absorption(&self) -> Result<Vector3<f64>, ScatteringError> {
        let melanin = EUMELANIN * self.eumelanin + PHEOMELANIN * self.pheomelanin;
        for (what, value) in [
            ("the concentration of eumelanin", self.eumelanin),
            ("the concentration of pheomelanin", self.pheomelanin),
            ("the absorption of a dye in red", self.dye.x),
            ("the absorption of a dye in green", self.dye.y),
            ("the absorption of a dye in blue", self.dye.z),
        ] {
            check(what, value, "finite and not negative", value >= 0.0 && value.is_finite())?;
        }
        Ok(melanin + self.dye)
    }
}

/// The absorption, per radius, that gives a volume of hair of the azimuthal roughness `beta` the
/// wanted `color`, linear red, green and blue (Chiang et al. 2016, (9), a fit to their renderings).
///
/// # Errors
/// [`ScatteringError::Parameter`] if `beta` is not in `[0, 1]` or a color not in `(0, 1]`; black
/// would need an infinite absorption.
pub fn absorption_of_color(
    color: &Vector3<f64>,
    beta: f64,
) -> Result<Vector3<f64>, ScatteringError> {
    check("the azimuthal roughness", beta, "in [0, 1]", (0.0..=1.0).contains(&beta))?;
    for value in color {
        check("a wanted color", *value, "in (0, 1]", *value > 0.0 && *value <= 1.0)?;
    }
    let fit = [5.969, -0.215, 2.532, -10.73, 5.574, 0.245];
    let scale = fit.iter().rev().fold(0.0, |sum, c| sum * beta + c);
    Ok(color.map(|c| (c.ln() / scale).powi(2)))
}
