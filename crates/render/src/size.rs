use crate::RenderError;

/// Most pixels of a picture: those of 16384 x 16384.
const MOST_PIXELS: u64 = 1 << 28;

/// Number of pixels of a picture of a width and a height that can be held.
pub(crate) fn pixel_count(size: [u32; 2]) -> Result<usize, RenderError> {
    let [width, height] = size;
    let count = u64::from(width) * u64::from(height);
    let held = usize::try_from(count).ok().filter(|_| (1..=MOST_PIXELS).contains(&count));
    held.ok_or(RenderError::PictureSize { width, height })
}
