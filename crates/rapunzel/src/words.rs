//! Words to the user. Unlike `println!`, they do not bring the program down where they cannot be
//! written.

use crate::failure::{Failure, SceneReport, as_json};
use indicatif::ProgressBar;
use miette::NamedSource;
use rapunzel_sim::scene::SceneError;
use rapunzel_sim::style::GrowthStage;
use rapunzel_sim::{BuildStage, SimError};
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;
use std::time::Duration;

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

/// A sign of life for work of unknown length; for programs that read `json` it is hidden.
pub(crate) fn spinner(json: bool) -> ProgressBar {
    if json {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// A part of the building of a world, as a bar says it.
pub(crate) fn build_stage(stage: BuildStage) -> String {
    match stage {
        BuildStage::Growing { bundle, stage } => {
            format!("fibers[{bundle}]: {} grow", growth_stage(stage))
        }
        BuildStage::MovingApart => "fibres are moved apart".to_owned(),
        BuildStage::Settling { done, most } => {
            format!("fibres settle, step {done} of at most {most}")
        }
    }
}

/// A part of the growth of a hairstyle, as a bar says it.
pub(crate) fn growth_stage(stage: GrowthStage) -> &'static str {
    match stage {
        GrowthStage::Surfaces => "surfaces",
        GrowthStage::Pores => "pores",
        GrowthStage::PreGuides => "pre-guides",
        GrowthStage::Guides => "guides",
        GrowthStage::Hairs => "hairs",
    }
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
