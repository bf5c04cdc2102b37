//! What a page says of a picture by paths of light that it wants.

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
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    /// Samples of a pixel in the end.
    pub(crate) samples: u32,
}
