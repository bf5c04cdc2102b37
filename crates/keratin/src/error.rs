use rapunzel_fiber::FiberError;
use thiserror::Error;

/// What can be wrong with a question about keratin.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum KeratinError {
    /// A relative humidity that is none.
    #[error("the relative humidity is {0}, but must lie in [0, 1]; give a fraction, not per cent")]
    Humidity(f64),
    /// A temperature that is none.
    #[error("the temperature is {0} C, but must be finite and above -273.15 C")]
    Temperature(f64),
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite; give it in SI units")]
    NotPositive {
        /// Which quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A quantity that must be finite and at least zero is not.
    #[error("{quantity} is {value}, but must be finite and not negative")]
    Negative {
        /// Which quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A part of something that is none.
    #[error("{quantity} is {value}, but must lie in [0, 1]")]
    Part {
        /// Which quantity.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A name that no type, treatment or product has.
    #[error("there is no {what} \"{name}\"; did you mean {}?", nearest.join(" or "))]
    Unknown {
        /// What was asked for.
        what: &'static str,
        /// The name that was given.
        name: String,
        /// The names nearest to it.
        nearest: Vec<&'static str>,
    },
    /// A value was asked for where nobody measured.
    #[error(
        "{quantity} is measured for {of} in [{}, {}], not at {value}; ask there, or allow \
         extrapolation (in the library: Outside::Mark)", range[0], range[1]
    )]
    Outside {
        /// The quantity.
        quantity: &'static str,
        /// What it depends on, with its unit.
        of: &'static str,
        /// Where it was asked for.
        value: f64,
        /// Where it is measured.
        range: [f64; 2],
    },
    /// The thesis has no value for this.
    #[error("the thesis has no {quantity} of {of}; the tables list what there is")]
    NotMeasured {
        /// The quantity.
        quantity: &'static str,
        /// Of what.
        of: String,
    },
    /// Too few readings for a protocol.
    #[error("{protocol} needs {needed} readings, but has {found}; record longer or more often")]
    Readings {
        /// The protocol.
        protocol: &'static str,
        /// How many it needs at least.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// The fibre that was described is none.
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

/// The value of this name, without regard to case, or an error with the nearest names.
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

/// How many letters must be changed, added or left out to make `a` of `b`.
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
