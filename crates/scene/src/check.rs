use super::locate;
use std::fmt;

/// A problem of a scene, and where it is.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneProblem {
    /// Path of the field, like `fibers[0].section.radius`; empty for the whole scene.
    pub path: String,
    /// Description of the problem, with the value and the allowed range.
    pub message: String,
    /// Position in the text; `None` for a scene that was not read from one.
    pub place: Option<TextPlace>,
}

impl fmt::Display for SceneProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "line {}, column {}: ", place.line, place.column)?;
        }
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        f.write_str(&self.message)
    }
}

/// A position in the text of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextPlace {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Range of bytes in the text.
    pub span: std::ops::Range<usize>,
}

impl TextPlace {
    /// The position of a range of bytes in a text.
    pub fn of(text: &str, span: std::ops::Range<usize>) -> Self {
        let before = &text[..span.start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            line: 1 + before.matches('\n').count(),
            column: 1 + before[line_start..].chars().count(),
            span,
        }
    }
}

/// The values that a number may take. The upper bound, and the lower bound beside zero, depend on
/// the unit.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Allowed {
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
    /// Finite, of either sign.
    Finite,
    /// Between two bounds, which are allowed too.
    Within(f64, f64),
}

/// Smallest (beside zero) and largest sensible values of a quantity with the given unit: beyond
/// them is a typing error, or a number outside the range of the arithmetic.
fn sizes(unit: &str) -> [f64; 2] {
    match unit {
        "m" => [1e-10, 1e4],
        "m^2" => [1e-18, 1e8],
        "m^3" => [1e-27, 1e12],
        "1/m" => [1e-9, 1e7],
        "1/m^2" => [1e-8, 1e14],
        "s" => [1e-9, 1e9],
        "Hz" | "1/s" => [1e-9, 1e9],
        "m/s" | "m/s^2" => [1e-12, 1e6],
        "degrees" => [1e-9, 1e6],
        "degrees/s" => [1e-9, 1e9],
        "kg" => [1e-18, 1e6],
        "kg/m" => [1e-15, 1e6],
        "kg m" => [1e-26, 1e6],
        // Beyond any matter: thin rods are given the stiffness and weight of others.
        "kg/m^3" => [1e-6, 1e15],
        "kg, or kg/m^3" => [1e-18, 1e6],
        "N" | "N m" => [1e-18, 1e9],
        "N/m" | "m/N" => [1e-12, 1e12],
        "N m^2" => [1e-24, 1e12],
        "Pa" => [1e-3, 1e30],
        "Pa s" => [1e-9, 1e9],
        "C" | "C/m" => [1e-21, 1e3],
        "statC/cm" => [1e-12, 1e12],
        "V" | "V/m" => [1e-9, 1e9],
        "F/m" => [1e-18, 1.0],
        "ohm/m" => [1e-9, 1e21],
        _ => [1e-12, 1e12],
    }
}

/// Smallest value of a range from zero on, as a fraction of its upper bound, that is not taken for
/// zero.
const NOTHING: f64 = 1e-12;

impl Allowed {
    /// The bounds, and whether zero is allowed beside the values between them.
    fn bounds(self, unit: &str) -> (f64, f64, bool) {
        let [least, most] = sizes(unit);
        match self {
            Self::Positive => (least, most, false),
            Self::NonNegative => (least, most, true),
            Self::Finite => (-most, most, false),
            Self::Within(0.0, high) => (NOTHING * high, high, true),
            Self::Within(low, high) => (low, high, false),
        }
    }
}

/// Largest number of problems that are reported of a scene.
const MOST_PROBLEMS: usize = 100;

/// Collects the problems of a scene during a walk through its fields.
#[derive(Debug, Default)]
pub(crate) struct Check {
    path: String,
    problems: Vec<SceneProblem>,
}

impl Check {
    /// Walks into a field, whose name is added to the path.
    pub(crate) fn within(&mut self, field: &str, walk: impl FnOnce(&mut Self)) {
        let length = self.path.len();
        self.push(field);
        walk(self);
        self.path.truncate(length);
    }

    /// Walks into the entries of a list.
    pub(crate) fn each<T>(&mut self, field: &str, list: &[T], walk: impl Fn(&mut Self, &T)) {
        for (i, item) in list.iter().enumerate() {
            self.within(&format!("{field}[{i}]"), |c| walk(c, item));
        }
    }

    /// Reports a number outside its range; `unit` is for the range and the message.
    pub(crate) fn number(&mut self, field: &str, value: f64, allowed: Allowed, unit: &str) {
        let (low, high, or_zero) = allowed.bounds(unit);
        if !((low..=high).contains(&value) || or_zero && value == 0.0) {
            let zero = if or_zero { "0, or " } else { "" };
            let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
            let told = |x: f64| if x.abs() < 1e7 { format!("{x:?}") } else { format!("{x:e}") };
            let range = format!("{zero}between {} and {}", told(low), told(high));
            self.refuse(field, format!("is {value:?}, but must be {range}{unit}"));
        }
    }

    /// Reports a vector with a component that is too large.
    pub(crate) fn vector(&mut self, field: &str, value: &[f64; 3], unit: &str) {
        for (i, &x) in value.iter().enumerate() {
            self.number(&format!("{field}[{i}]"), x, Allowed::Finite, unit);
        }
    }

    /// Reports a vector without a direction.
    pub(crate) fn direction(&mut self, field: &str, value: &[f64; 3]) {
        let norm = value.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(1e-12..=1e12).contains(&norm) {
            let message = format!("is {value:?}, but must have a length between 1e-12 and 1e12");
            self.refuse(field, message);
        }
    }

    /// Reports a count outside a range.
    pub(crate) fn count(&mut self, field: &str, value: usize, low: usize, high: usize) {
        if !(low..=high).contains(&value) {
            self.refuse(field, format!("is {value}, but must be between {low} and {high}"));
        }
    }

    /// Reports a problem with a field.
    pub(crate) fn refuse(&mut self, field: &str, message: String) {
        let length = self.path.len();
        self.push(field);
        self.problems.push(SceneProblem { path: self.path.clone(), message, place: None });
        self.path.truncate(length);
    }

    /// The collected problems, with positions where the text is known.
    pub(crate) fn finish(mut self, text: Option<&str>) -> Vec<SceneProblem> {
        let more = self.problems.len().saturating_sub(MOST_PROBLEMS);
        if more > 0 {
            self.problems.truncate(MOST_PROBLEMS);
            self.refuse("", format!("has {more} more problems"));
        }
        if let Some(text) = text {
            for problem in &mut self.problems {
                problem.place = Some(TextPlace::of(text, locate::span(text, &problem.path)));
            }
        }
        self.problems
    }

    fn push(&mut self, field: &str) {
        if !self.path.is_empty() && !field.is_empty() && !field.starts_with('[') {
            self.path.push('.');
        }
        self.path.push_str(field);
    }
}
