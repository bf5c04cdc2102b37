//! What a page says of a picture by paths of light that it wants.

use nalgebra::Vector3;
use serde::Deserialize;

/// A picture that a page wishes for.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PictureWish {
    /// By what the page knows it.
    pub(crate) number: u32,
    /// Where the camera is and what it looks at, m, world; z is up.
    pub(crate) eye: [f64; 3],
    pub(crate) target: [f64; 3],
    /// Angle between the left and the right edge, rad.
    pub(crate) field: f64,
    /// How many times as thick fibres are drawn.
    pub(crate) thickness: f64,
    /// Whether it is to be clear with few samples: without ground, and no fibre thinner than can be
    /// seen.
    pub(crate) plain: bool,
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    /// Samples of a pixel in the end.
    pub(crate) samples: u32,
}

/// Least width of a fibre that is to be seen with few samples, pixels.
const WIDTH: f64 = 1.2;

impl PictureWish {
    /// How many times as thick fibres are drawn whose radius is this, m.
    pub(crate) fn thickness(&self, radius: f64) -> f64 {
        let far = (Vector3::from(self.eye) - Vector3::from(self.target)).norm();
        let pixel = 2.0 * (0.5 * self.field).tan() * far / f64::from(self.size[0].max(1));
        let least = if self.plain { 0.5 * WIDTH * pixel / radius } else { 0.0 };
        let thickness = self.thickness.clamp(0.0, 1e3).max(least);
        if thickness.is_finite() { thickness } else { 1.0 }
    }
}
