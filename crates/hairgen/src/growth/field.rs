//! What varies over the scalp, as a function on the disc.

use super::image::GreyImage;
use crate::HairgenError;
use nalgebra::{Point2, Vector2};
use std::fmt;
use std::sync::Arc;

/// A function on the unit disc.
pub type DiscFunction = Arc<dyn Fn(&Point2<f64>) -> f64 + Send + Sync>;

/// A number at every place of the unit disc: hairs per m^2 of scalp, a length, an angle.
#[derive(Clone)]
pub enum DiscField {
    /// The same everywhere.
    Constant(f64),
    /// A grey image, linear from its black to its white.
    Image {
        /// The image.
        image: Arc<GreyImage>,
        /// Value of black.
        black: f64,
        /// Value of white.
        white: f64,
    },
    /// Any function.
    Function(DiscFunction),
}

impl DiscField {
    /// A grey image, linear from its black to its white.
    #[must_use]
    pub fn image(image: GreyImage, black: f64, white: f64) -> Self {
        Self::Image { image: Arc::new(image), black, white }
    }

    /// A function on the disc.
    #[must_use]
    pub fn function(function: impl Fn(&Point2<f64>) -> f64 + Send + Sync + 'static) -> Self {
        Self::Function(Arc::new(function))
    }

    /// The value at a place, unchecked.
    #[must_use]
    pub fn value(&self, place: &Point2<f64>) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Image { image, black, white } => black + image.value(place) * (white - black),
            Self::Function(function) => function(place),
        }
    }

    /// The direction of which the value is the angle, rad from `x` to `y`. Between pixels
    /// directions are mixed, not angles: one just below a full turn and one just above none lie
    /// side by side.
    #[must_use]
    pub fn direction(&self, place: &Point2<f64>) -> Vector2<f64> {
        let unit = |angle: f64| Vector2::new(angle.cos(), angle.sin());
        match self {
            Self::Image { image, black, white } => {
                let pixels = image.around(place);
                pixels.iter().map(|(w, v)| *w * unit(black + v * (white - black))).sum()
            }
            other => unit(other.value(place)),
        }
    }

    /// The value at a place, if it is in a range.
    ///
    /// # Errors
    /// [`HairgenError::DiscValue`] with the place.
    pub(super) fn checked(
        &self,
        what: &'static str,
        place: &Point2<f64>,
        [least, most]: [f64; 2],
    ) -> Result<f64, HairgenError> {
        let value = self.value(place);
        if (least..=most).contains(&value) {
            Ok(value)
        } else {
            Err(HairgenError::DiscValue { what, value, place: (*place).into(), least, most })
        }
    }

    /// A length in the disc over which the value is about linear.
    pub(super) fn grain(&self) -> f64 {
        match self {
            Self::Constant(_) => f64::INFINITY,
            // Half a pixel.
            Self::Image { image, .. } => 1.0 / image.side() as f64,
            Self::Function(_) => 1.0 / 64.0,
        }
    }
}

impl fmt::Debug for DiscField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "{value}"),
            Self::Image { image, black, white } => {
                write!(f, "image of {} pixels a side from {black} to {white}", image.side())
            }
            Self::Function(_) => f.write_str("function"),
        }
    }
}
