use super::locate;
use std::fmt;

/// Something wrong with a scene, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Path of the field, like `fibers[0].section.radius`; empty for the whole scene.
    pub path: String,
    /// What is wrong, with the value and the allowed range.
    pub message: String,
    /// Where in the text; `None` for a scene that was not read from one.
    pub place: Option<Place>,
}

impl fmt::Display for Problem {
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

/// A place in the text of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Range of bytes.
    pub span: std::ops::Range<usize>,
}

impl Place {
    /// The place of a range of bytes.
    pub(crate) fn of(text: &str, span: std::ops::Range<usize>) -> Self {
        let before = &text[..span.start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            line: 1 + before.matches('\n').count(),
            column: 1 + before[line_start..].chars().count(),
            span,
        }
    }
}

/// The values that a number may take.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Allowed {
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
    /// Any finite number.
    Finite,
    /// Between two bounds, which belong to it.
    Within(f64, f64),
}

impl Allowed {
    fn admits(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Positive => x > 0.0,
                Self::NonNegative => x >= 0.0,
                Self::Finite => true,
                Self::Within(low, high) => (low..=high).contains(&x),
            }
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Positive => f.write_str("positive and finite"),
            Self::NonNegative => f.write_str("zero or positive, and finite"),
            Self::Finite => f.write_str("finite"),
            Self::Within(low, high) => write!(f, "between {low:?} and {high:?}"),
        }
    }
}

/// Collects what is wrong with a scene while walking through it.
#[derive(Debug, Default)]
pub(crate) struct Check {
    path: String,
    problems: Vec<Problem>,
}

impl Check {
    /// Walks into a field.
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

    /// Refuses a number outside its range; `unit` is for the message.
    pub(crate) fn number(&mut self, field: &str, value: f64, allowed: Allowed, unit: &str) {
        if !allowed.admits(value) {
            let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
            self.refuse(field, format!("is {value:?}, but must be {allowed}{unit}"));
        }
    }

    /// Refuses a vector with a component that is not finite.
    pub(crate) fn vector(&mut self, field: &str, value: &[f64; 3], unit: &str) {
        for (i, &x) in value.iter().enumerate() {
            self.number(&format!("{field}[{i}]"), x, Allowed::Finite, unit);
        }
    }

    /// Refuses a vector without a direction.
    pub(crate) fn direction(&mut self, field: &str, value: &[f64; 3]) {
        let norm = value.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(norm > 1e-100 && norm.is_finite()) {
            self.refuse(field, format!("is {value:?}, but must be finite and not zero"));
        }
    }

    /// Refuses a count outside a range.
    pub(crate) fn count(&mut self, field: &str, value: usize, low: usize, high: usize) {
        if !(low..=high).contains(&value) {
            self.refuse(field, format!("is {value}, but must be between {low} and {high}"));
        }
    }

    /// Notes a problem with a field.
    pub(crate) fn refuse(&mut self, field: &str, message: String) {
        let length = self.path.len();
        self.push(field);
        self.problems.push(Problem { path: self.path.clone(), message, place: None });
        self.path.truncate(length);
    }

    /// What was found, with places where the text is known.
    pub(crate) fn finish(mut self, text: Option<&str>) -> Vec<Problem> {
        if let Some(text) = text {
            for problem in &mut self.problems {
                problem.place = Some(Place::of(text, locate::span(text, &problem.path)));
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
