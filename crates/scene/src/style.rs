use super::error::SceneError;
use super::parse::parse;
use rapunzel_hairgen::style::Style;

/// Reads a hairstyle. Its numbers are checked where it grows.
///
/// # Errors
/// [`SceneError`] at line, column and path.
pub fn style_from_ron(text: &str) -> Result<Style, SceneError> {
    parse(text)
        .map_err(|problem| SceneError { source_text: text.to_owned(), problems: vec![problem] })
}
