//! Point sets and edges in PLY.
//!
//! The points of strands are in rows, one strand after the other, and a file has no place of its
//! own for their numbers. They are, in this order: given by the caller; in a comment or `obj_info`
//! such as `points_per_strand 100`; in an element `strand` with an integer property `points`; or
//! they follow from the edges of an element `edge`.

use crate::chains::joined;
use crate::raw::RawStrands;
use crate::{ReadOptions, StrandsError};
use nalgebra::Point3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, Header, PropertyType, ScalarType};

pub(crate) const NAME: &str = "PLY";

pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawStrands, StrandsError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<DefaultElement>::new().read_header(&mut reader).map_err(said)?;
    // Nothing in the file bounds how many there are of what takes no place.
    if let Some((name, _)) = header.elements.iter().find(|(_, e)| e.properties.is_empty()) {
        return Err(refuse(format!("the element `{name}` has no properties")));
    }
    let mut payload = Payload { bytes, rest: reader.into_inner(), encoding: header.encoding };
    let (mut vertices, mut edges, mut strands) = (Vec::new(), Vec::new(), Vec::new());
    for (name, definition) in &header.elements {
        match name.as_str() {
            "vertex" => vertices = payload.rows(definition, ["x", "y", "z", "radius"])?,
            "edge" => edges = payload.rows(definition, ["vertex1", "vertex2"])?,
            "strand" => strands = payload.rows(definition, ["points"])?,
            _ => _ = payload.rows(definition, [])?,
        }
    }
    if !payload.rest.trim_ascii_start().is_empty() {
        return Err(payload.refuse("it goes on after the elements that its head tells of"));
    }

    let vertex = header.elements.get("vertex");
    let has_radii = vertex.is_some_and(|own| own.properties.contains_key("radius"));
    let count = vertices.len();
    let points: Vec<_> = vertices.iter().map(|&[x, y, z, _]| Point3::new(x, y, z)).collect();
    let radii = vertices.iter().filter(|_| has_radii);
    let widths: Vec<_> = radii.map(|&[.., radius]| 2.0 * radius).collect();
    let counts = match options.points_per_strand.map_or_else(|| stated(&header), |n| Ok(Some(n)))? {
        Some(each) if count % each != 0 => {
            let problem = format!("{count} vertices are no multiple of {each} points per strand");
            return Err(refuse(problem));
        }
        Some(each) => vec![each; count / each],
        None if !strands.is_empty() => {
            let counts = strands.iter().map(|&[points]| whole(points, count)).collect();
            let counts: Option<Vec<_>> = counts;
            counts.ok_or_else(|| refuse(format!("a strand has more than its {count} vertices")))?
        }
        None if !edges.is_empty() => {
            let end = |x| whole(x, count.checked_sub(1)?).and_then(|end| u32::try_from(end).ok());
            let edges = edges.iter().map(|&[a, b]| Some([end(a)?, end(b)?]));
            let edges: Option<Vec<_>> = edges.collect();
            let edges = edges.ok_or_else(|| refuse("an edge joins a vertex that is not there"))?;
            return Ok(joined(&edges, &points, &widths));
        }
        None if count == 0 => Vec::new(),
        None => {
            return Err(refuse(
                "it does not say how many points a strand has; give points_per_strand, or write a \
                 comment `points_per_strand 100`",
            ));
        }
    };
    let needed = counts.iter().try_fold(0_usize, |sum, &n| sum.checked_add(n));
    if needed != Some(count) {
        return Err(refuse(format!("its strands do not add up to its {count} vertices")));
    }
    Ok(RawStrands { counts, points, widths, ..RawStrands::default() })
}

/// The number after the words `points_per_strand` in a comment or `obj_info`.
fn stated(header: &Header) -> Result<Option<usize>, StrandsError> {
    let separates = |c: char| c.is_whitespace() || matches!(c, ':' | '=' | ',');
    for line in header.comments.iter().chain(&header.obj_infos) {
        let mut words = line.split(separates).filter(|word| !word.is_empty());
        if words.any(|word| word == "points_per_strand") {
            let number = words.next().and_then(|word| word.parse().ok()).filter(|&n| n > 0);
            let problem = || refuse(format!("`{line}` has no positive number of points"));
            return number.ok_or_else(problem).map(Some);
        }
    }
    Ok(None)
}

fn refuse(problem: impl Into<String>) -> StrandsError {
    StrandsError::Read { format: NAME, place: "the file".into(), problem: problem.into() }
}

/// What the reader says, in one line.
fn said(error: ParseError) -> StrandsError {
    let place = error.line().map_or_else(|| "the file".into(), |line| format!("line {line}"));
    let text = error.to_string();
    let words = text.split_once(": ").filter(|_| error.line().is_some());
    let problem = words.map_or(&*text, |(_, words)| words);
    let problem = problem.split_whitespace().collect::<Vec<_>>().join(" ");
    StrandsError::Read { format: NAME, place, problem }
}

/// A whole number from zero to `most`.
fn whole(number: f64, most: usize) -> Option<usize> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is in range")]
    let is_whole = || number as usize;
    ((0.0..=most as f64).contains(&number) && number.fract() == 0.0).then(is_whole)
}

/// What follows the head.
struct Payload<'a> {
    /// The whole file.
    bytes: &'a [u8],
    rest: &'a [u8],
    encoding: Encoding,
}

impl Payload<'_> {
    /// The properties of these names of every item of an element; what it lacks is not a number.
    fn rows<const N: usize>(
        &mut self,
        element: &ElementDef,
        names: [&str; N],
    ) -> Result<Vec<[f64; N]>, StrandsError> {
        let place = |name: &String| names.iter().position(|own| own == name);
        let properties = element.properties.iter();
        let columns: Vec<_> = properties.map(|(name, own)| (place(name), &own.data_type)).collect();
        let mut rows = Vec::new();
        for _ in 0..element.count {
            let mut row = [f64::NAN; N];
            for (place, kind) in &columns {
                match kind {
                    PropertyType::Scalar(kind) => {
                        let number = self.number(kind)?;
                        if let Some(place) = place {
                            row[*place] = number;
                        }
                    }
                    PropertyType::List(size, kind) => {
                        let count = whole(self.number(size)?, self.rest.len());
                        let count = count.ok_or_else(|| self.refuse("a list is too long"))?;
                        for _ in 0..count {
                            self.number(kind)?;
                        }
                    }
                }
            }
            rows.push(row);
        }
        Ok(rows)
    }

    /// The next number.
    fn number(&mut self, kind: &ScalarType) -> Result<f64, StrandsError> {
        use ScalarType::{Char, Double, Float, Int, Short, UChar, UInt, UShort};
        if self.encoding == Encoding::Ascii {
            let text = self.rest.trim_ascii_start();
            let length = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
            let (word, rest) = text.split_at(length);
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
            let number = number.ok_or_else(|| self.refuse("a number is expected"))?;
            self.rest = rest;
            return Ok(number);
        }
        let is_little = self.encoding == Encoding::BinaryLittleEndian;
        Ok(match kind {
            Char => i8::from_le_bytes(self.ordered(is_little)?).into(),
            UChar => u8::from_le_bytes(self.ordered(is_little)?).into(),
            Short => i16::from_le_bytes(self.ordered(is_little)?).into(),
            UShort => u16::from_le_bytes(self.ordered(is_little)?).into(),
            Int => i32::from_le_bytes(self.ordered(is_little)?).into(),
            UInt => u32::from_le_bytes(self.ordered(is_little)?).into(),
            Float => f32::from_le_bytes(self.ordered(is_little)?).into(),
            Double => f64::from_le_bytes(self.ordered(is_little)?),
        })
    }

    /// The next bytes, the lowest one first.
    fn ordered<const N: usize>(&mut self, is_little: bool) -> Result<[u8; N], StrandsError> {
        let Some((&(mut bytes), rest)) = self.rest.split_first_chunk() else {
            return Err(self.refuse("it ends before the elements that its head tells of"));
        };
        self.rest = rest;
        if !is_little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// An error at what comes next.
    fn refuse(&self, problem: &str) -> StrandsError {
        let read = &self.bytes[..self.bytes.len() - self.rest.len()];
        let place = if self.encoding == Encoding::Ascii {
            format!("line {}", read.iter().filter(|&&byte| byte == b'\n').count() + 1)
        } else {
            format!("byte {}", read.len())
        };
        StrandsError::Read { format: NAME, place, problem: problem.to_owned() }
    }
}
