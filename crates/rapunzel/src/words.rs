//! Words to the user. Unlike `println!`, they do not bring the program down where they cannot be
//! written.

use crate::failure::{Failure, SceneReport, as_json};
use miette::NamedSource;
use rapunzel_sim::SimError;
use rapunzel_sim::scene::SceneError;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;

/// Prints lines to the standard output. A reader that has gone, as `head` does, has read enough.
pub(crate) fn say(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::File(format!("cannot write to the standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints lines to the standard error; nobody is left to hear that it failed.
pub(crate) fn complain(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

impl Failure {
    /// Tells the user, and gives the exit code.
    pub(crate) fn tell(&self, json: bool) -> ExitCode {
        let code = self.code();
        if json {
            let problems: Vec<_> = self.problems().iter().map(as_json).collect();
            let object = serde_json::json!({
                "error": self.to_string(), "exit_code": code, "problems": problems,
            });
            // The failure to tell of is the first.
            let _ = say(&object.to_string());
        } else if let Self::Sim {
            error: SimError::Scene(SceneError { source_text, problems }),
            scene,
        } = self
        {
            let name = scene.display().to_string();
            for problem in problems {
                let report = SceneReport {
                    source: NamedSource::new(&name, source_text.clone()),
                    problem: problem.clone(),
                };
                complain(&format!("{:?}", miette::Report::new(report)));
            }
        } else {
            complain(&format!("error: {self}"));
        }
        ExitCode::from(code)
    }
}
