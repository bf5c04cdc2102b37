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
use ply_rs_bw::ply::{Header, Property, PropertyAccess, PropertyAccessResult};
use std::io::Read;

pub(crate) const NAME: &str = "PLY";

pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawStrands, StrandsError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Unread>::new().read_header(&mut reader).map_err(said)?;
    // Nothing in the file bounds how many there are of what takes no place.
    if let Some((name, _)) = header.elements.iter().find(|(_, e)| e.properties.is_empty()) {
        return Err(refuse(format!("the element `{name}` has no properties")));
    }
    let (mut vertices, mut edges, mut strands) = (Vec::new(), Vec::new(), Vec::new());
    for (name, definition) in &header.elements {
        let reader = &mut reader;
        match name.as_str() {
            "vertex" => {
                let parser = Parser::<StrandVertex>::new();
                vertices = parser.read_payload_for_element(reader, definition, &header)?;
            }
            "edge" => {
                let parser = Parser::<PlyEdge>::new();
                edges = parser.read_payload_for_element(reader, definition, &header)?;
            }
            "strand" => {
                let parser = Parser::<PointCount>::new();
                strands = parser.read_payload_for_element(reader, definition, &header)?;
            }
            _ => {
                let parser = Parser::<Unread>::new();
                parser.read_payload_for_element(reader, definition, &header)?;
            }
        }
    }
    let mut more = reader.into_inner().bytes();
    if more.any(|byte| !byte.is_ok_and(|b| b.is_ascii_whitespace())) {
        return Err(refuse("it goes on after the elements that its head tells of"));
    }

    let has_radii = header
        .elements
        .get("vertex")
        .is_some_and(|vertex| vertex.properties.contains_key("radius"));
    let count = vertices.len();
    let points: Vec<_> = vertices.iter().map(|v| Point3::new(v.0[0], v.0[1], v.0[2])).collect();
    let radii = vertices.iter().filter(|_| has_radii);
    let widths: Vec<_> = radii.map(|v| 2.0 * v.0[3]).collect();
    let counts = match options.points_per_strand.map_or_else(|| stated(&header), |n| Ok(Some(n)))? {
        Some(each) if count % each != 0 => {
            let problem = format!("{count} vertices are no multiple of {each} points per strand");
            return Err(refuse(problem));
        }
        Some(each) => vec![each; count / each],
        None if !strands.is_empty() => strands.iter().map(|strand| strand.0).collect(),
        None if !edges.is_empty() => {
            let edges: Vec<_> = edges.iter().map(|edge| edge.0).collect();
            if edges.as_flattened().iter().any(|&end| end as usize >= count) {
                return Err(refuse("an edge joins a vertex that is not there"));
            }
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

impl From<ParseError> for StrandsError {
    fn from(error: ParseError) -> Self {
        said(error)
    }
}

/// The position and the radius of a vertex; what is left out is not a number.
struct StrandVertex([f64; 4]);

impl PropertyAccess for StrandVertex {
    fn new() -> Self {
        Self([f64::NAN; 4])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(place) = ["x", "y", "z", "radius"].iter().position(|&own| own == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[place] = match property {
            Property::Float(x) => x.into(),
            Property::Double(x) => x,
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            other => match integer(&other).and_then(|x| i16::try_from(x).ok()) {
                Some(x) => x.into(),
                None => return PropertyAccessResult::UnsupportedType,
            },
        };
        PropertyAccessResult::Set
    }
}

/// The vertices that an edge joins; what is no number of a vertex is the largest one.
struct PlyEdge([u32; 2]);

impl PropertyAccess for PlyEdge {
    fn new() -> Self {
        Self([u32::MAX; 2])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(place) = ["vertex1", "vertex2"].iter().position(|&own| own == name) else {
            return PropertyAccessResult::Ignored;
        };
        let Some(end) = integer(&property) else { return PropertyAccessResult::UnsupportedType };
        self.0[place] = u32::try_from(end).unwrap_or(u32::MAX);
        PropertyAccessResult::Set
    }
}

/// The number of points of a strand.
struct PointCount(usize);

impl PropertyAccess for PointCount {
    fn new() -> Self {
        Self(0)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if name != "points" {
            return PropertyAccessResult::Ignored;
        }
        let Some(count) = integer(&property) else { return PropertyAccessResult::UnsupportedType };
        self.0 = usize::try_from(count).unwrap_or(usize::MAX);
        PropertyAccessResult::Set
    }
}

/// An element of another kind.
struct Unread;

impl PropertyAccess for Unread {
    fn new() -> Self {
        Self
    }
}

fn integer(property: &Property) -> Option<i64> {
    match *property {
        Property::Char(x) => Some(x.into()),
        Property::UChar(x) => Some(x.into()),
        Property::Short(x) => Some(x.into()),
        Property::UShort(x) => Some(x.into()),
        Property::Int(x) => Some(x.into()),
        Property::UInt(x) => Some(x.into()),
        _ => None,
    }
}
