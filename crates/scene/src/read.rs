use super::check::{Check, Place, Problem};
use super::{Scene, SceneError, locate};
use ron::error::Error::{
    ExpectedFloat, ExpectedInteger, ExpectedString, IntegerOutOfBounds, MissingStructField,
};
use ron::error::Position;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;

fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

impl Scene {
    /// Reads and validates a scene.
    ///
    /// # Errors
    /// [`SceneError`] with everything that is wrong, at line, column and path.
    pub fn from_ron(text: &str) -> Result<Self, SceneError> {
        let refuse = |problems| Err(SceneError { source_text: text.to_owned(), problems });
        match parse::<Self>(text) {
            Err(problem) => refuse(vec![problem]),
            Ok(scene) => {
                let problems = scene.problems(Some(text));
                if problems.is_empty() { Ok(scene) } else { refuse(problems) }
            }
        }
    }

    /// The scene as RON with all defaults filled in; reads back as the same scene, bit for bit.
    ///
    /// # Errors
    /// [`SceneError`] if it makes no sense.
    pub fn to_ron(&self) -> Result<String, SceneError> {
        let config = PrettyConfig::new().struct_names(false).compact_arrays(true);
        let text = options().to_string_pretty(self, config).unwrap_or_default() + "\n";
        Self::from_ron(&text).map(|_| text)
    }

    /// Checks every number of a scene that was not read from a text.
    ///
    /// # Errors
    /// [`SceneError`] with everything that is wrong.
    pub fn validate(&self) -> Result<(), SceneError> {
        let problems = self.problems(None);
        let source_text = String::new();
        if problems.is_empty() { Ok(()) } else { Err(SceneError { source_text, problems }) }
    }

    fn problems(&self, text: Option<&str>) -> Vec<Problem> {
        let mut check = Check::default();
        self.check(&mut check);
        check.finish(text)
    }
}

/// Reads a value from RON.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Problem> {
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
        Problem { path, message, place: Some(Place::of(text, span)) }
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

/// The last two digits with a comma and no space between them in the line of a place, up to it.
fn decimal_comma(text: &str, place: usize) -> Option<&str> {
    let start = text[..place].rfind('\n').map_or(0, |end| end + 1);
    let end = text[place..].find([' ', '\n']).map_or(text.len(), |end| place + end);
    let line = &text[start..end];
    let comma = line.as_bytes().windows(3).rposition(|three| {
        three[0].is_ascii_digit() && three[1] == b',' && three[2].is_ascii_digit()
    })?;
    line.get(comma..comma + 3)
}

/// The byte at a line and a column (in characters) that count from 1.
fn byte_of(text: &str, position: Position) -> usize {
    let line_start: usize =
        text.split_inclusive('\n').take(position.line.saturating_sub(1)).map(str::len).sum();
    let column = position.col.saturating_sub(1);
    text[line_start..].char_indices().nth(column).map_or(text.len(), |(i, _)| line_start + i)
}

/// The path as a validation writes it: without the names of variants.
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
