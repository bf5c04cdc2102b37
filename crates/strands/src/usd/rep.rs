//! Values of the binary form: 8 bytes that hold a small value or tell where a large one is.

use super::layer::{UsdSamples, UsdValue};
use super::packed::integers;
use crate::StrandsError;
use crate::bytes::{ByteReader, singles};

/// A value, still to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rep(pub(super) u64);

/// What values are made of: the file and its tables of strings.
pub(super) struct Values<'a> {
    pub(super) bytes: ByteReader<'a>,
    /// Second number of the version.
    pub(super) minor: u8,
    pub(super) tokens: Vec<String>,
    /// Token of every string.
    pub(super) strings: Vec<u32>,
}

/// Types of a single number.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Component {
    Byte,
    Int,
    Half,
    Single,
    Double,
}

/// Numbers of the types that are not made of numbers.
const STRING: u8 = 10;
const TOKEN: u8 = 11;
const ASSET: u8 = 12;
const MATRIX: u8 = 15;
const TOKENS: u8 = 41;
pub(super) const TIME_SAMPLES: u8 = 46;
const DOUBLES: u8 = 48;
const STRINGS: u8 = 50;

impl Rep {
    pub(super) fn kind(self) -> u8 {
        self.0.to_le_bytes()[6]
    }

    fn is_array(self) -> bool {
        self.0 >> 63 == 1
    }

    fn is_inlined(self) -> bool {
        self.0 >> 62 & 1 == 1
    }

    fn is_packed(self) -> bool {
        self.0 >> 61 & 1 == 1
    }

    /// Where the value is, or the value.
    fn payload(self) -> u64 {
        self.0 & 0xffff_ffff_ffff
    }

    /// The four bytes of an inlined value.
    fn inlined(self) -> [u8; 4] {
        let [a, b, c, d, ..] = self.0.to_le_bytes();
        [a, b, c, d]
    }

    /// The type of the numbers of the value, and how many of them make one.
    fn numbers(self) -> Option<(Component, usize)> {
        use Component::{Byte, Double, Half, Int, Single};
        Some(match self.kind() {
            1 | 2 => (Byte, 1),
            // Of whole numbers, and of specifiers.
            3 | 4 | 42 => (Int, 1),
            7 => (Half, 1),
            8 => (Single, 1),
            9 | 56 => (Double, 1),
            MATRIX => (Double, 16),
            kind @ 16..=18 => ([Double, Single, Half][usize::from(kind - 16)], 4),
            kind @ 19..=30 => {
                let place = usize::from(kind - 19);
                ([Double, Single, Half, Int][place % 4], 2 + place / 4)
            }
            _ => return None,
        })
    }

    fn is_quaternion(self) -> bool {
        matches!(self.kind(), 16..=18)
    }
}

impl Values<'_> {
    /// Reads a value; of types that say nothing of curves it is [`UsdValue::Other`].
    pub(super) fn value(&self, rep: Rep) -> Result<UsdValue, StrandsError> {
        let word =
            |index: u32| self.token(index).map(|word| UsdValue::Words(vec![word.to_owned()]));
        let index = || u32::from_le_bytes(rep.inlined());
        match (rep.kind(), rep.is_array(), rep.is_inlined()) {
            (STRING, false, true) => word(self.string(index())?),
            (TOKEN | ASSET, false, true) => word(index()),
            (TOKEN, true, false) | (TOKENS | STRINGS, false, false) => {
                let words = self.token_indices(rep)?.into_iter();
                let words = words.map(|index| self.token(index).map(str::to_owned));
                Ok(UsdValue::Words(words.collect::<Result<_, _>>()?))
            }
            (DOUBLES, false, false) => {
                let mut at = self.bytes.seek(rep.payload())?;
                let count = at.u64("number of doubles")?;
                let bytes = at.take("doubles", count, 8)?;
                Ok(UsdValue::Numbers(Component::Double.all(bytes)))
            }
            (_, is_array, is_inlined) => match rep.numbers() {
                Some(numbers) if is_array => self.array(rep, numbers),
                Some(numbers) if is_inlined => Ok(inlined(rep, numbers)),
                Some((component, count)) => {
                    let mut at = self.bytes.seek(rep.payload())?;
                    let bytes = at.take("value", count as u64, component.size())?;
                    let mut numbers = component.all(bytes);
                    if rep.is_quaternion() {
                        // The real part is last in the file.
                        numbers.rotate_right(1);
                    }
                    Ok(UsdValue::Numbers(numbers))
                }
                None => Ok(UsdValue::Other),
            },
        }
    }

    /// Reads the tokens of a list of words by their indices.
    pub(super) fn token_indices(&self, rep: Rep) -> Result<Vec<u32>, StrandsError> {
        let mut at = self.bytes.seek(rep.payload())?;
        let count = match (rep.kind(), rep.payload()) {
            (TOKEN, 0) => 0,
            (TOKEN, _) => self.array_size(&mut at)?,
            _ => at.u64("number of words")?,
        };
        let indices = at.take("words", count, 4)?.as_chunks().0;
        let indices = indices.iter().map(|&four| u32::from_le_bytes(four));
        if rep.kind() == STRINGS {
            return indices.map(|index| self.string(index)).collect();
        }
        Ok(indices.collect())
    }

    /// Reads those samples that are wanted.
    pub(super) fn samples(&self, rep: Rep, samples: &mut UsdSamples) -> Result<(), StrandsError> {
        let mut at = jumped(self.bytes.seek(rep.payload())?)?;
        let UsdValue::Numbers(times) = self.value(Rep(at.u64("times of samples")?))? else {
            return Err(at.refuse("the times of samples are no numbers"));
        };
        let mut at = jumped(at)?;
        let count = at.u64("number of samples")?;
        if count != times.len() as u64 {
            return Err(at.refuse(format!("{count} samples have {} times", times.len())));
        }
        let reps = at.take("samples", count, 8)?.as_chunks().0;
        for (&time, &eight) in times.iter().zip(reps) {
            if samples.wants(time) {
                samples.put(time, self.value(Rep(u64::from_le_bytes(eight)))?);
            }
        }
        Ok(())
    }

    pub(super) fn token(&self, index: u32) -> Result<&str, StrandsError> {
        let token = self.tokens.get(index as usize).map(String::as_str);
        token.ok_or_else(|| {
            self.bytes.refuse(format!("it refers to token {index}, which is not there"))
        })
    }

    /// The token of a string.
    fn string(&self, index: u32) -> Result<u32, StrandsError> {
        let string = self.strings.get(index as usize).copied();
        string.ok_or_else(|| {
            self.bytes.refuse(format!("it refers to string {index}, which is not there"))
        })
    }

    fn array_size(&self, at: &mut ByteReader<'_>) -> Result<u64, StrandsError> {
        const WHAT: &str = "size of an array";
        if self.minor < 5 {
            // The number of dimensions, always one.
            at.u32(WHAT)?;
        }
        if self.minor < 7 { at.u32(WHAT).map(u64::from) } else { at.u64(WHAT) }
    }

    fn array(
        &self,
        rep: Rep,
        (component, each): (Component, usize),
    ) -> Result<UsdValue, StrandsError> {
        if rep.payload() == 0 {
            return Ok(UsdValue::Numbers(Vec::new()));
        }
        let mut at = self.bytes.seek(rep.payload())?;
        let count = self.array_size(&mut at)?;
        let numbers = if rep.is_packed() && component == Component::Int {
            integers(&mut at, count)?.into_iter().map(|x| x.cast_signed().into()).collect()
        } else if rep.is_packed() {
            // Whole numbers, or a table with an index for each.
            match at.array("kind of packing")? {
                [b'i'] => {
                    integers(&mut at, count)?.into_iter().map(|x| x.cast_signed().into()).collect()
                }
                [b't'] => {
                    let size = at.u32("size of a table")?;
                    let table = component.all(at.take("table", size.into(), component.size())?);
                    let pick = |index: u32| table.get(index as usize).copied();
                    let numbers = integers(&mut at, count)?.into_iter().map(pick);
                    numbers
                        .collect::<Option<_>>()
                        .ok_or_else(|| at.refuse("a packed number is beyond its table"))?
                }
                _ => return Err(at.refuse("a way of packing numbers that is not known")),
            }
        } else {
            component.all(at.take("array", count, component.size() * each)?)
        };
        Ok(UsdValue::Numbers(numbers))
    }
}

/// Where the distance that is read leads to, from its own place.
fn jumped(mut at: ByteReader<'_>) -> Result<ByteReader<'_>, StrandsError> {
    let start = at.at() as u64;
    let distance = i64::from_le_bytes(at.array("distance to samples")?);
    at.seek(start.wrapping_add_signed(distance))
}

/// A value in its own four bytes: whole numbers in a byte each for vectors and for the diagonal of
/// a matrix, which is zero elsewhere.
fn inlined(rep: Rep, (component, count): (Component, usize)) -> UsdValue {
    let bytes = rep.inlined();
    let small = |k: usize| f64::from(i8::from_le_bytes([bytes[k]]));
    UsdValue::Numbers(match (component, count) {
        (Component::Double, 1) => Component::Single.all(&bytes),
        (Component::Byte, 1) => vec![bytes[0].into()],
        (_, 1) => component.all(&bytes[..component.size()]),
        (_, 16) => (0..16).map(|k| if k % 5 == 0 { small(k / 5) } else { 0.0 }).collect(),
        (_, count) => (0..count).map(small).collect(),
    })
}

impl Component {
    /// Size, bytes.
    fn size(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Half => 2,
            Self::Int | Self::Single => 4,
            Self::Double => 8,
        }
    }

    /// All numbers in bytes.
    fn all(self, bytes: &[u8]) -> Vec<f64> {
        let fours = bytes.as_chunks().0.iter();
        match self {
            Self::Byte => bytes.iter().map(|&byte| byte.into()).collect(),
            Self::Half => bytes.as_chunks().0.iter().map(|&two| half(two)).collect(),
            Self::Int => fours.map(|&four| i32::from_le_bytes(four).into()).collect(),
            Self::Single => singles(bytes).collect(),
            Self::Double => {
                bytes.as_chunks().0.iter().map(|&eight| f64::from_le_bytes(eight)).collect()
            }
        }
    }
}

/// A number in half precision: a sign, five bits of exponent and ten of fraction.
fn half(bytes: [u8; 2]) -> f64 {
    let bits = u16::from_le_bytes(bytes);
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    let size = match i32::from(bits >> 10 & 0x1f) {
        0 => fraction * 2.0_f64.powi(-14),
        31 => f64::NAN,
        exponent => (1.0 + fraction) * 2.0_f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}
