//! "How long must it be."

use super::answer::{CaseEquilibrium, Length};
use super::equilibria::{equilibria, near};
use crate::SimError;
use crate::case_error::CaseError;
use nalgebra::Vector3;
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
    // From one length to the next the rod changes little: a search from all starts is the last
    // resort.
    let of = |length: f64, beside: Option<&CaseEquilibrium>| -> Option<CaseEquilibrium> {
        let case = Case { length, all_with_turns: None, ..case.clone() };
        let found = beside.and_then(|beside| near(&case, beside));
        found.or_else(|| equilibria(&case).ok()?.into_iter().next())
    };
    let does = |found: &CaseEquilibrium| is_met(wish.so_that, measure(wish.so_that, found));
    let at = |i: u32| shortest + (wish.longest - shortest) * f64::from(i) / f64::from(TRIED);
    let mut tried = (0..=TRIED).map(|i| (i, of(at(i), None)));
    let first = tried.find_map(|(i, found)| Some((i, found.filter(&does)?)));
    let (first, mut found) =
        first.ok_or(CaseError::NoLength { shortest, longest: wish.longest })?;
    let mut length = at(first);
    if first > 0 {
        let mut short = at(first - 1);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (short + length);
            match of(middle, Some(&found)).filter(&does) {
                Some(better) => (length, found) = (middle, better),
                None => short = middle,
            }
        }
    }
    let reached = measure(wish.so_that, &found);
    Ok(Length { length, reached })
}

/// What a wish is about.
fn measure(wished: Wished, found: &CaseEquilibrium) -> f64 {
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
