use super::Film;
use super::pixel::{FilmPixel, PixelSums};
use crate::RenderError;
use crate::size::pixel_count;
use std::io::{ErrorKind, Read, Write};

/// First bytes of a saved picture: the name and the version of the format.
const MAGIC: &[u8; 12] = b"RAPFILM\0\x01\0\0\0";
/// Bytes of the magic number, the size, the seed and the hash.
const HEAD: usize = 12 + 8 + 8 + 32;
/// Bytes of a pixel.
const PIXEL: usize = 8 * PixelSums::COUNT + 16;
/// Pixels that are read and written at once.
const BATCH: usize = 1024;

/// What a saved picture is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilmKey {
    /// The seed of its random numbers.
    pub seed: u64,
    /// A hash of all else that decides its samples: the scene, the camera and the settings.
    pub hash: [u8; 32],
}

impl Film {
    /// Writes all sums, so that a stopped picture goes on to the same bits.
    ///
    /// The format: a magic number with a version, width, height, seed and hash; 11 sums in double
    /// precision and 4 counts of 32 bits for each pixel; the BLAKE3 hash of all before. Numbers are
    /// little endian.
    ///
    /// # Errors
    /// [`RenderError::Io`] if `out` fails.
    pub fn write_state(&self, out: &mut impl Write, key: &FilmKey) -> Result<(), RenderError> {
        let mut hasher = blake3::Hasher::new();
        let mut put = |bytes: &[u8]| {
            hasher.update(bytes);
            out.write_all(bytes)
        };
        put(&head(self.size, key))?;
        let mut bytes = Vec::with_capacity(BATCH * PIXEL);
        for batch in self.pixels.chunks(BATCH) {
            bytes.clear();
            for pixel in batch {
                let FilmPixel { sums, fiber, samples, covered, rejected } = pixel;
                bytes.extend(sums.numbers().iter().flat_map(|x| x.to_le_bytes()));
                let counts = [fiber, samples, covered, rejected];
                bytes.extend(counts.into_iter().flat_map(|n| n.to_le_bytes()));
            }
            put(&bytes)?;
        }
        Ok(out.write_all(hasher.finalize().as_bytes())?)
    }

    /// Reads what [`Self::write_state`] wrote with the same key. Memory is taken as bytes arrive.
    ///
    /// # Errors
    /// [`RenderError::PictureState`] if it is none, of another key, cut short or damaged;
    /// [`RenderError::PictureSize`] or [`RenderError::PictureMemory`] if it is too large;
    /// [`RenderError::Io`] if `input` fails.
    pub fn read_state(input: &mut impl Read, key: &FilmKey) -> Result<Self, RenderError> {
        let mut hasher = blake3::Hasher::new();
        let mut bytes = vec![0; HEAD];
        take(input, &mut bytes)?;
        let [width, height] = [number(&bytes[12..]), number(&bytes[16..])].map(u32::from_le_bytes);
        if bytes[..12] != *MAGIC {
            return Err(bad("it is none of this version"));
        }
        if bytes != head([width, height], key) {
            return Err(bad("it is of another scene or seed"));
        }
        hasher.update(&bytes);
        let count = pixel_count([width, height])?;
        let mut pixels = Vec::new();
        while pixels.len() < count {
            let batch = BATCH.min(count - pixels.len());
            bytes.resize(batch * PIXEL, 0);
            take(input, &mut bytes)?;
            hasher.update(&bytes);
            let held = pixels.try_reserve(batch);
            held.map_err(|_| RenderError::PictureMemory { width, height })?;
            pixels.extend(bytes.chunks_exact(PIXEL).map(pixel));
        }
        let mut hash = [0; 32];
        take(input, &mut hash)?;
        let is_whole = |p: &FilmPixel| p.sums.is_finite() && p.covered <= p.samples;
        if hasher.finalize() != hash || !pixels.iter().all(is_whole) {
            return Err(bad("it is damaged"));
        }
        Ok(Self { size: [width, height], pixels })
    }
}

fn head(size: [u32; 2], key: &FilmKey) -> Vec<u8> {
    let [width, height] = size.map(u32::to_le_bytes);
    [&MAGIC[..], &width, &height, &key.seed.to_le_bytes(), &key.hash].concat()
}

/// The pixel in [`PIXEL`] bytes.
fn pixel(bytes: &[u8]) -> FilmPixel {
    let (sums, counts) = bytes.split_at(8 * PixelSums::COUNT);
    let sums = std::array::from_fn(|k| f64::from_le_bytes(number(&sums[8 * k..])));
    let [fiber, samples, covered, rejected] =
        [0, 4, 8, 12].map(|k| u32::from_le_bytes(number(&counts[k..])));
    FilmPixel { sums: PixelSums::of(sums), fiber, samples, covered, rejected }
}

/// The first bytes of a slice that has them.
fn number<const N: usize>(bytes: &[u8]) -> [u8; N] {
    std::array::from_fn(|k| bytes[k])
}

fn take(input: &mut impl Read, bytes: &mut [u8]) -> Result<(), RenderError> {
    input.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => bad("it is cut short"),
        _ => error.into(),
    })
}

fn bad(problem: &'static str) -> RenderError {
    RenderError::PictureState { problem }
}
