//! What a required accuracy asks of expansions.

use crate::ElectrostaticsError;
use crate::harmonics::MAX_ORDER;

/// Required accuracy of a sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accuracy {
    /// Degree of the expansions, from 1 to [`MAX_ORDER`]: the number of terms p of the thesis, less
    /// one.
    Order(usize),
    /// Relative error of the fields over all targets: the root of the sum of their squared errors
    /// over that of their squares. From 1e-12 to 0.1.
    Tolerance(f64),
}

/// Refuses an accuracy that no expansion can give.
pub(crate) fn check_accuracy(accuracy: Accuracy) -> Result<(), ElectrostaticsError> {
    match accuracy {
        Accuracy::Order(order) if !(1..=MAX_ORDER).contains(&order) => {
            let range = "a whole number from 1 to 40";
            Err(ElectrostaticsError::Setting { what: "the order", value: order as f64, range })
        }
        Accuracy::Tolerance(value) if !(1e-12..=0.1).contains(&value) => {
            let range = "from 1e-12 to 0.1";
            Err(ElectrostaticsError::Setting { what: "the tolerance", value, range })
        }
        _ => Ok(()),
    }
}

/// Number of bodies in a leaf at which pairs and expansions cost the same, from measured rates.
pub(super) fn capacity(accuracy: Accuracy) -> usize {
    60 + 8 * guess(accuracy)
}

/// Number of pairs that take as long as one move of an expansion, from measured rates.
pub(super) fn pairs_per_shift(order: usize) -> usize {
    let p = order + 1;
    60 + p * p + p * p * p / 16
}

/// Degree that a tolerance usually needs.
pub(crate) fn guess(accuracy: Accuracy) -> usize {
    match accuracy {
        Accuracy::Order(order) => order,
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 40")]
        Accuracy::Tolerance(tolerance) => {
            ((-tolerance.ln() - 4.5) / SLOPE).ceil().clamp(2.0, MAX_ORDER as f64) as usize
        }
    }
}

/// Logarithm of the factor by which one degree more reduces the error, usually.
pub(super) const SLOPE: f64 = 0.66;

/// Largest ratio of radii to distance at which expansions are used: the fastest of 0.65, 0.72, 0.77
/// and 0.8 for a million uniform points.
const POINT_OPENING: f64 = 0.75;

/// Largest ratio of radii to distance at which expansions are used where much is asked.
const STRICT_OPENING: f64 = 0.6;

/// Largest ratio of the sum of the radii of two cells to their distance at which expansions are
/// used.
///
/// Terms of degree p fall to `(opening / (2 - opening))^p` between cells at the least distance: to
/// 1e-9 at the highest degree with [`POINT_OPENING`], to 2e-15 with [`STRICT_OPENING`].
pub(super) fn opening(accuracy: Accuracy) -> f64 {
    match accuracy {
        Accuracy::Tolerance(tolerance) if tolerance < 1e-8 => STRICT_OPENING,
        _ => POINT_OPENING,
    }
}

/// Tolerance from which on single precision is usually enough: it errs by some 2e-7.
pub(crate) const SINGLE: f64 = 5e-7;

/// Tolerance from which on coordinates of single precision are enough for close pairs.
pub(super) const COARSE_COORDINATES: f64 = 1e-4;

/// Degree from which on single precision is enough where `tolerance` is asked: what higher degrees
/// add is some 1e6 of it.
pub(super) fn low(tolerance: f64) -> usize {
    guess(Accuracy::Tolerance((1e6 * tolerance).min(0.1))) + 1
}

/// Exponent of the share of the degree that distant cells are left. For a tolerance it is less than
/// one, because there are more of them than of close ones: the fastest of 0.6, 0.8 and 1.
pub(crate) fn thinning(accuracy: Accuracy) -> f64 {
    if matches!(accuracy, Accuracy::Tolerance(_)) { 0.8 } else { 0.0 }
}

/// Share of the tolerance that the samples may use up, since they are not all targets.
pub(crate) const MARGIN: f64 = 0.5;
