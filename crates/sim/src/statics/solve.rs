use super::answer::CaseAnswer;
use super::branch::{critical, sweep};
use super::contact_rest::rest_in_contact;
use super::equilibria::equilibria;
use super::length::find_length;
use crate::SimError;
use rapunzel_scene::SceneError;
use rapunzel_scene::case::Case;

/// Solves the case.
///
/// A rod with dead loads and conditions at its ends only is solved to 1e-9 of its length; one
/// with following forces or places on the way is a chain of at least 400 segments. Rods that touch
/// something are chains of at least 200.
///
/// # Errors
/// [`SimError::Scene`] for a case that makes no sense and [`SimError::Static`] for one without
/// an answer.
pub fn solve(case: &Case) -> Result<CaseAnswer, SimError> {
    let problems = case.problems();
    if !problems.is_empty() {
        return Err(SceneError { source_text: String::new(), problems }.into());
    }
    if case.is_in_contact() {
        return rest_in_contact(case);
    }
    let wish = case.wish.map(|wish| find_length(case, &wish)).transpose()?;
    let case = Case { length: wish.map_or(case.length, |found| found.length), ..case.clone() };
    let (branch, equilibria) = if let Some(asked) = case.sweep {
        let (branch, shown) = sweep(&case, &asked)?;
        (Some(branch), shown)
    } else if let Some(asked) = case.critical {
        let (branch, shown) = critical(&case, asked.of, [asked.first(case.length), asked.up_to])?;
        (Some(branch), shown)
    } else {
        (None, equilibria(&case)?)
    };
    Ok(CaseAnswer {
        name: case.name.clone(),
        length: case.length,
        radius: case.matter().thickest(),
        wish,
        branch,
        equilibria,
        contact: None,
    })
}
