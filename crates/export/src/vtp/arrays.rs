use super::read::{field, header, number};
use crate::ExportError;
use std::io::{BufRead, Seek, SeekFrom};
use std::ops::Range;

/// A frame that [`write()`](super::write()) wrote, read array by array: only the requested arrays
/// are read, with no more than a buffer in memory.
#[derive(Debug)]
pub struct Arrays<R> {
    input: R,
    /// Byte offset of the appended data.
    start: u64,
    index: usize,
    points: usize,
    strands: usize,
}

impl<R: BufRead + Seek> Arrays<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`ExportError::Malformed`] or [`ExportError::Io`], as for all methods.
    pub fn open(mut input: R) -> Result<Self, ExportError> {
        let header = header(&mut input)?;
        let start = input.stream_position()?;
        let count = |name| number(field(&header, "<Piece", name, "\"")?);
        Ok(Self {
            input,
            start,
            index: number(field(&header, "Name=\"FrameIndex\"", ">", "<")?)?,
            points: count("NumberOfPoints=\"")?,
            strands: count("NumberOfLines=\"")?,
        })
    }

    /// Number of the frame in its series.
    #[must_use]
    pub fn index(&self) -> usize {
        self.index
    }

    /// Number of points of all strands.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points
    }

    /// Number of points of each strand.
    ///
    /// # Errors
    /// [`ExportError::Malformed`], also where the strands do not follow each other, or
    /// [`ExportError::Io`].
    pub fn counts(&mut self) -> Result<Vec<usize>, ExportError> {
        // After the positions and ten arrays of 24 numbers a point comes the connectivity.
        let before = ArrayBlock { arrays: 12, parts: 28 };
        let ends = self.block::<1>(before, 0..self.strands, self.strands)?;
        let mut last = 0;
        let mut count = |end: [u8; 8]| {
            let end = usize::try_from(u64::from_le_bytes(end)).ok();
            let count = end.and_then(|end| end.checked_sub(last)).filter(|&count| count >= 2);
            last += count.unwrap_or(0);
            count.ok_or(ExportError::Malformed { what: "the ends of the lines are out of order" })
        };
        ends.map(|end| count(end?[0])).collect()
    }

    /// Positions (world, m) of a range of points, strand by strand.
    ///
    /// # Errors
    /// [`ExportError::Malformed`] or [`ExportError::Io`], also of the items.
    pub fn positions(&mut self, range: Range<usize>) -> Result<impl VectorSource, ExportError> {
        self.vectors(ArrayBlock { arrays: 0, parts: 0 }, range)
    }

    /// Velocities (world, m/s) of a range of points, strand by strand.
    ///
    /// # Errors
    /// [`ExportError::Malformed`] or [`ExportError::Io`], also of the items.
    pub fn velocities(&mut self, range: Range<usize>) -> Result<impl VectorSource, ExportError> {
        self.vectors(ArrayBlock { arrays: 2, parts: 4 }, range)
    }

    /// First directors (world) of the segments that begin at a range of points, strand by strand;
    /// the last point of a strand repeats its last segment.
    ///
    /// # Errors
    /// [`ExportError::Malformed`] or [`ExportError::Io`], also of the items.
    pub fn directors(&mut self, range: Range<usize>) -> Result<impl VectorSource, ExportError> {
        self.vectors(ArrayBlock { arrays: 4, parts: 10 }, range)
    }

    /// Radii (m) of a range of points, strand by strand.
    ///
    /// # Errors
    /// [`ExportError::Malformed`] or [`ExportError::Io`], also of the items.
    pub fn radii(
        &mut self,
        range: Range<usize>,
    ) -> Result<impl Iterator<Item = Result<f64, ExportError>>, ExportError> {
        let radii = self.block::<1>(ArrayBlock { arrays: 1, parts: 3 }, range, self.points)?;
        Ok(radii.map(|radius| Ok(f64::from_le_bytes(radius?[0]))))
    }

    fn vectors(
        &mut self,
        before: ArrayBlock,
        range: Range<usize>,
    ) -> Result<impl VectorSource, ExportError> {
        let vectors = self.block::<3>(before, range, self.points)?;
        Ok(vectors.map(|vector| Ok(vector?.map(f64::from_le_bytes))))
    }

    /// A reader of a range of an array of `count` times `N` numbers.
    fn block<const N: usize>(
        &mut self,
        ArrayBlock { arrays, parts }: ArrayBlock,
        range: Range<usize>,
        count: usize,
    ) -> Result<impl Iterator<Item = Result<[[u8; 8]; N], ExportError>>, ExportError> {
        let malformed = |what| ExportError::Malformed { what };
        let length = |numbers: usize, count: usize| {
            let bytes = count.checked_mul(8 * numbers).and_then(|n| u64::try_from(n).ok());
            bytes.ok_or(malformed("an array is larger than any file"))
        };
        let before = length(parts, self.points)?.checked_add(8 * arrays + self.start);
        let before = before.ok_or(malformed("an array is larger than any file"))?;
        self.input.seek(SeekFrom::Start(before))?;
        let mut size = [0; 8];
        self.input.read_exact(&mut size)?;
        if u64::from_le_bytes(size) != length(N, count)? || range.end > count {
            return Err(malformed("an array has another size than its points"));
        }
        let skipped = i64::try_from(length(N, range.start)?);
        self.input.seek_relative(skipped.map_err(|_| malformed("an array is too large"))?)?;
        Ok(range.map(|_| {
            let mut numbers = [[0; 8]; N];
            self.input.read_exact(numbers.as_flattened_mut())?;
            Ok(numbers)
        }))
    }
}

/// Vectors that are read one by one.
pub trait VectorSource: Iterator<Item = Result<[f64; 3], ExportError>> {}

impl<I: Iterator<Item = Result<[f64; 3], ExportError>>> VectorSource for I {}

/// Position of an array in the appended data: the number of arrays before it, and the count of
/// their numbers per point.
struct ArrayBlock {
    arrays: u64,
    parts: usize,
}
