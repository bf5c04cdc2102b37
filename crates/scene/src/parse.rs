//! From RON text to values, with the positions of errors.

use super::check::{SceneProblem, TextPlace};
use super::locate;
use ron::error::Error::{
    ExpectedFloat, ExpectedInteger, ExpectedString, IntegerOutOfBounds, MissingStructField,
};
use ron::error::Position;
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;

/// The dialect of RON that is read and written: `Some` may be left out.
pub(crate) fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

/// Reads a value from RON.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, SceneProblem> {
    let at = |position: Position| byte_of(text, position);
    let problem = |path: String, error: ron::error::SpannedError| {
        let span = match error.code {
            // For a value of the wrong kind the parser points beside it.
            ExpectedFloat | ExpectedInteger | ExpectedString | IntegerOutOfBounds => {
                locate::span(text, &path)
            }
            _ => at(error.span.start).min(at(error.span.end))..at(error.span.end),
        };
        let message = match error.code {
            MissingStructField { field, .. } => format!("the field `{field}` is missing"),
            IntegerOutOfBounds => {
                "the integer is too large, or negative where it must not be".into()
            }
            code => match decimal_comma(text, span.end) {
                None => code.to_string(),
                Some(pair) => {
                    format!("{code}; if `{pair}` is one number, write it with a point, not a comma")
                }
            },
        };
        SceneProblem { path, message, place: Some(TextPlace::of(text, span)) }
    };
    let mut deserializer = ron::Deserializer::from_str_with_options(text, &options())
        .map_err(|e| problem(String::new(), e))?;
    let value = serde_path_to_error::deserialize(&mut deserializer).map_err(|e| {
        let path = path_of(e.path());
        problem(path, deserializer.span_error(e.into_inner()))
    })?;
    deserializer.end().map_err(|e| problem(String::new(), deserializer.span_error(e)))?;
    Ok(value)
}

/// The last two digits with a comma and no space between them in the line of a position, up to it.
fn decimal_comma(text: &str, place: usize) -> Option<&str> {
    let start = text[..place].rfind('\n').map_or(0, |end| end + 1);
    let end = text[place..].find([' ', '\n']).map_or(text.len(), |end| place + end);
    let line = &text[start..end];
    let comma = line.as_bytes().windows(3).rposition(|three| {
        three[0].is_ascii_digit() && three[1] == b',' && three[2].is_ascii_digit()
    })?;
    line.get(comma..comma + 3)
}

/// Index of the byte at a line and a column (in characters), which count from 1.
fn byte_of(text: &str, position: Position) -> usize {
    let line_start: usize =
        text.split_inclusive('\n').take(position.line.saturating_sub(1)).map(str::len).sum();
    let column = position.col.saturating_sub(1);
    text[line_start..].char_indices().nth(column).map_or(text.len(), |(i, _)| line_start + i)
}

/// A path in the form that validation uses: without the names of variants.
fn path_of(path: &serde_path_to_error::Path) -> String {
    let mut text = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => text += &format!("[{index}]"),
            Segment::Map { key } if text.is_empty() => text += key,
            Segment::Map { key } => text += &format!(".{key}"),
            Segment::Enum { .. } | Segment::Unknown => {}
        }
    }
    text
}
