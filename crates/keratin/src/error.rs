use rapunzel_fiber::FiberError;
use thiserror::Error;

/// Errors of properties of keratin.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum KeratinError {
    /// A relative humidity outside `[0, 1]`.
    #[error("the relative humidity is {0}, but must lie in [0, 1]; give a fraction, not per cent")]
    Humidity(f64),
    /// A temperature at or below absolute zero, or not finite.
    #[error("the temperature is {0} C, but must be finite and above -273.15 C")]
    Temperature(f64),
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite; give it in SI units")]
    NotPositive {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A quantity that must be finite and at least zero is not.
    #[error("{quantity} is {value}, but must be finite and not negative")]
    Negative {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A fraction outside `[0, 1]`.
    #[error("{quantity} is {value}, but must lie in [0, 1]")]
    Part {
        /// Name of the quantity.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A name that no type, treatment or product has.
    #[error("there is no {what} \"{name}\"; did you mean {}?", nearest.join(" or "))]
    Unknown {
        /// Kind of name that was looked up.
        what: &'static str,
        /// The unknown name.
        name: String,
        /// The known names nearest to it.
        nearest: Vec<&'static str>,
    },
    /// A value outside the measured range.
    #[error(
        "{quantity} is measured for {of} in [{}, {}], not at {value}; ask there, or allow \
         extrapolation (in the library: Outside::Mark)", range[0], range[1]
    )]
    Outside {
        /// Name of the quantity.
        quantity: &'static str,
        /// Name of the variable it depends on, with its unit.
        of: &'static str,
        /// Value of the variable.
        value: f64,
        /// Measured range of the variable.
        range: [f64; 2],
    },
    /// A quantity for which the thesis has no value.
    #[error("the thesis has no {quantity} of {of}; the tables list what there is")]
    NotMeasured {
        /// Name of the quantity.
        quantity: &'static str,
        /// Name of the material or condition without a value.
        of: String,
    },
    /// Too few readings for a protocol.
    #[error("{protocol} needs {needed} readings, but has {found}; record longer or more often")]
    Readings {
        /// Name of the protocol.
        protocol: &'static str,
        /// Least number of readings that it needs.
        needed: usize,
        /// Number of readings given.
        found: usize,
    },
    /// An invalid description of a fibre.
    #[error(transparent)]
    Fiber(#[from] FiberError),
}

/// Checks that `value` is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, KeratinError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(KeratinError::NotPositive { quantity, value })
    }
}

/// Checks that `value` is finite and not negative.
pub(crate) fn not_negative(quantity: &'static str, value: f64) -> Result<f64, KeratinError> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(KeratinError::Negative { quantity, value })
    }
}

/// The value with the given name, without regard to case, or an error with the nearest names.
pub(crate) fn named<T: Copy>(
    what: &'static str,
    name: &str,
    choices: impl Iterator<Item = (&'static str, T)> + Clone,
) -> Result<T, KeratinError> {
    let asked = name.trim();
    if let Some((_, value)) = choices.clone().find(|(n, _)| n.eq_ignore_ascii_case(asked)) {
        return Ok(value);
    }
    let asked = asked.to_lowercase();
    let mut nearest: Vec<_> =
        choices.map(|(n, _)| (distance(&asked, &n.to_lowercase()), n)).collect();
    nearest.sort_unstable();
    nearest.dedup();
    let nearest = nearest.into_iter().take(2).map(|(_, n)| n).collect();
    Err(KeratinError::Unknown { what, name: name.to_owned(), nearest })
}

/// Edit distance: the least number of letters to change, add or leave out between `a` and `b`.
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.chars().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.chars().count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_names_are_suggested() {
        assert_eq!(distance("kitten", "sitting"), 3);
        let choices = [("bleached", 1), ("dyed blond", 2), ("permed", 3)];
        assert_eq!(named("treatment", " Permed", choices.into_iter()), Ok(3));
        let error = named("treatment", "premed", choices.into_iter()).expect_err("misspelt");
        assert!(error.to_string().contains("did you mean permed"), "{error}");
    }
}
