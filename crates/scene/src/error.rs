use crate::SceneProblem;
use thiserror::Error;

/// Why a scene or a case was refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the scene has {}:{}", counted(problems.len()), listed(problems))]
pub struct SceneError {
    /// The text that was read, to underline the problems in; empty if there was none.
    pub source_text: String,
    /// Everything that is wrong, in the order of the text.
    pub problems: Vec<SceneProblem>,
}

fn counted(problems: usize) -> String {
    if problems == 1 { "a problem".into() } else { format!("{problems} problems") }
}

fn listed(problems: &[SceneProblem]) -> String {
    problems.iter().map(|p| format!("\n  {p}")).collect()
}
