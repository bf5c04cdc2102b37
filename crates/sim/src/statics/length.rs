//! "How long must it be."

use super::answer::{Equilibrium, Length};
use super::case::{Case, Wish, Wished};
use crate::SimError;
use nalgebra::Vector3;
use rapunzel_rod_static::StaticError;

/// Lengths that are tried before the first that does is narrowed down.
const TRIED: u32 = 32;
/// A held rod is at least so much longer than the way between its ends, in parts of it: stretched
/// straight it has no definite force.
const SLACK: f64 = 1e-4;
/// How often the bracket is halved: to 1e-9 of its length.
const HALVINGS: usize = 30;

impl Case {
    /// The shortest length that does what is wished, among lengths as far apart as a 32nd of the
    /// range, and then narrowed down.
    pub(super) fn find_length(&self, wish: &Wish) -> Result<Length, SimError> {
        let from = Vector3::from(self.clamp.position);
        let way = self.end.position().map_or(0.0, |end| (Vector3::from(end) - from).norm());
        let shortest = self.length.max(way * (1.0 + SLACK));
        let of = |length: f64| -> Option<f64> {
            let case = Self { length, all_with_turns: None, ..self.clone() };
            let found = case.equilibria().ok()?;
            Some(wish.so_that.measure(found.first()?))
        };
        let does = |length: f64| of(length).is_some_and(|x| wish.so_that.is_met(x));
        let at = |i: u32| shortest + (wish.longest - shortest) * f64::from(i) / f64::from(TRIED);
        let first = (0..=TRIED).find(|i| does(at(*i)));
        let first = first.ok_or(SimError::NoLength { shortest, longest: wish.longest })?;
        let mut length = at(first);
        if first > 0 {
            let mut short = at(first - 1);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (short + length);
                *if does(middle) { &mut length } else { &mut short } = middle;
            }
        }
        let reached = of(length).ok_or(StaticError::NotFound)?;
        Ok(Length { length, reached })
    }
}

impl Wished {
    /// What the wish is about.
    fn measure(self, found: &Equilibrium) -> f64 {
        match self {
            Self::Curvature(_) => found.sharpest.curvature,
            Self::Sag(_) => found.sag,
            Self::ClampForce(_) => Vector3::from(found.clamp_force).norm(),
            Self::ClampMoment(_) => Vector3::from(found.clamp_moment).norm(),
        }
    }

    fn is_met(self, measure: f64) -> bool {
        match self {
            Self::Sag(wished) => measure >= wished,
            Self::Curvature(wished) | Self::ClampForce(wished) | Self::ClampMoment(wished) => {
                measure <= wished
            }
        }
    }
}
