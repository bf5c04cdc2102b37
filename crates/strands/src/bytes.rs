use crate::StrandsError;
use nalgebra::Point3;

/// Little-endian numbers from the bytes of a file, none beyond its end.
#[derive(Debug, Clone)]
pub(crate) struct ByteReader<'a> {
    format: &'static str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> ByteReader<'a> {
    pub(crate) fn new(format: &'static str, bytes: &'a [u8]) -> Self {
        Self { format, bytes, at: 0 }
    }

    /// The same file from another place on.
    pub(crate) fn seek(&self, at: u64) -> Result<Self, StrandsError> {
        let at = usize::try_from(at).unwrap_or(usize::MAX);
        if at > self.bytes.len() {
            return Err(self.refuse(format!("it refers to byte {at}, beyond its end")));
        }
        Ok(Self { at, ..*self })
    }

    /// Offset of what comes next, bytes.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// Number of bytes of the file.
    pub(crate) fn size(&self) -> usize {
        self.bytes.len()
    }

    /// Number of bytes that are left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next `count` items of `size` bytes each.
    pub(crate) fn take(
        &mut self,
        what: &'static str,
        count: u64,
        size: usize,
    ) -> Result<&'a [u8], StrandsError> {
        let needed = usize::try_from(count).unwrap_or(usize::MAX).saturating_mul(size);
        let left = &self.bytes[self.at..];
        let Some(taken) = left.get(..needed) else {
            let (format, at) = (self.format, self.at);
            return Err(StrandsError::CutOff { format, what, at, needed, left: left.len() });
        };
        self.at += needed;
        Ok(taken)
    }

    pub(crate) fn array<const N: usize>(
        &mut self,
        what: &'static str,
    ) -> Result<[u8; N], StrandsError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(what, 1, N)?);
        Ok(array)
    }

    pub(crate) fn u32(&mut self, what: &'static str) -> Result<u32, StrandsError> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn u64(&mut self, what: &'static str) -> Result<u64, StrandsError> {
        Ok(u64::from_le_bytes(self.array(what)?))
    }

    pub(crate) fn f32(&mut self, what: &'static str) -> Result<f64, StrandsError> {
        Ok(f32::from_le_bytes(self.array(what)?).into())
    }

    /// An error here.
    pub(crate) fn refuse(&self, problem: impl Into<String>) -> StrandsError {
        let place = format!("byte {}", self.at);
        StrandsError::Read { format: self.format, place, problem: problem.into() }
    }
}

/// Numbers in single precision.
pub(crate) fn singles(bytes: &[u8]) -> impl Iterator<Item = f64> {
    bytes.as_chunks().0.iter().map(|&four| f32::from_le_bytes(four).into())
}

/// Points in single precision.
pub(crate) fn triples(bytes: &[u8]) -> impl Iterator<Item = Point3<f64>> {
    let numbers = bytes.as_chunks::<4>().0.as_chunks::<3>().0;
    numbers.iter().map(|three| three.map(|four| f64::from(f32::from_le_bytes(four))).into())
}
