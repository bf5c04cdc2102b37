//! "How long must it be."

use super::answer::{Equilibrium, Length};
use super::solve::equilibria;
use crate::SimError;
use nalgebra::Vector3;
use rapunzel_rod_static::StaticError;
use rapunzel_scene::case::{Case, Wish, Wished};

/// Lengths that are tried before the first that does is narrowed down.
const TRIED: u32 = 32;
/// A held rod is at least so much longer than the way between its ends, in parts of it: stretched
/// straight it has no definite force.
const SLACK: f64 = 1e-4;
/// How often the bracket is halved: to 1e-9 of its length.
const HALVINGS: usize = 30;

/// The shortest length that does what is wished, among lengths as far apart as a 32nd of the
/// range, and then narrowed down.
pub(super) fn find_length(case: &Case, wish: &Wish) -> Result<Length, SimError> {
    let from = Vector3::from(case.clamp.position);
    let way = case.end.position().map_or(0.0, |end| (Vector3::from(end) - from).norm());
    let shortest = case.length.max(way * (1.0 + SLACK));
    let of = |length: f64| -> Option<f64> {
        let case = Case { length, all_with_turns: None, ..case.clone() };
        let found = equilibria(&case).ok()?;
        Some(measure(wish.so_that, found.first()?))
    };
    let does = |length: f64| of(length).is_some_and(|x| is_met(wish.so_that, x));
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

/// What a wish is about.
fn measure(wished: Wished, found: &Equilibrium) -> f64 {
    match wished {
        Wished::Curvature(_) => found.sharpest.curvature,
        Wished::Sag(_) => found.sag,
        Wished::ClampForce(_) => Vector3::from(found.clamp_force).norm(),
        Wished::ClampMoment(_) => Vector3::from(found.clamp_moment).norm(),
    }
}

fn is_met(wished: Wished, measure: f64) -> bool {
    match wished {
        Wished::Sag(wished) => measure >= wished,
        Wished::Curvature(wished) | Wished::ClampForce(wished) | Wished::ClampMoment(wished) => {
            measure <= wished
        }
    }
}
