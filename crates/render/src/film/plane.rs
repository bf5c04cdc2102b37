use super::FilmPixel;
use crate::RenderError;
use crate::size::pixel_count;
use rayon::prelude::*;

/// A picture in the making: sums over the samples of each of its pixels.
///
/// Rows are filled in parallel, without locks; whoever adds the samples of a pixel in one order
/// gets the same bits on any number of threads. It takes 104 bytes a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    pub(super) size: [u32; 2],
    pub(super) pixels: Vec<FilmPixel>,
}

impl Film {
    /// An empty picture of a width and a height.
    ///
    /// # Errors
    /// [`RenderError::PictureSize`] if it has no pixels or more than 2^28;
    /// [`RenderError::PictureMemory`] if there is no memory for it.
    pub fn new(size: [u32; 2]) -> Result<Self, RenderError> {
        let count = pixel_count(size)?;
        let [width, height] = size;
        let mut pixels = Vec::new();
        let held = pixels.try_reserve_exact(count);
        held.map_err(|_| RenderError::PictureMemory { width, height })?;
        pixels.resize(count, FilmPixel::EMPTY);
        Ok(Self { size, pixels })
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// All pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[FilmPixel] {
        &self.pixels
    }

    /// The rows, from the top, to be filled in parallel.
    pub fn rows_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [FilmPixel]> {
        self.pixels.par_chunks_mut(self.size[0] as usize)
    }

    /// Number of samples that were rejected, since they were not finite. A picture without bias has
    /// none.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.pixels.iter().map(|pixel| u64::from(pixel.rejected())).sum()
    }

    /// Standard error of the luminance of the picture, W/(m^2 sr): the root mean square of those of
    /// its pixels; `None` if a pixel has fewer than two samples.
    #[must_use]
    pub fn standard_error(&self) -> Option<f64> {
        let squares = self.pixels.iter().map(|pixel| Some(pixel.standard_error()?.powi(2)));
        let sum: f64 = squares.sum::<Option<f64>>()?;
        Some((sum / self.pixels.len() as f64).sqrt())
    }
}
