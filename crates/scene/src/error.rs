use crate::SceneProblem;
use thiserror::Error;

/// Problems for which a scene or a case was refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the scene has {}:{}", counted(problems.len()), listed(problems))]
pub struct SceneError {
    /// The text that was read, for a report that underlines the problems; empty if there was none.
    pub source_text: String,
    /// All problems, in the order of the text.
    pub problems: Vec<SceneProblem>,
}

fn counted(problems: usize) -> String {
    if problems == 1 { "a problem".into() } else { format!("{problems} problems") }
}

fn listed(problems: &[SceneProblem]) -> String {
    problems.iter().map(|p| format!("\n  {p}")).collect()
}
