use crate::failure::Failure;
use rapunzel_sim::{Outcome, Summary, in_use};
use std::path::Path;
use std::process::ExitCode;

/// Says how the run in a folder stands.
pub(crate) fn info(folder: &Path, json: bool) -> Result<ExitCode, Failure> {
    let summary = Summary::read(folder).map_err(Failure::of(folder))?;
    let running = in_use(folder);
    if json {
        let object = serde_json::json!({ "running": running, "summary": summary });
        println!("{object}");
    } else {
        print(&summary, running);
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints a summary as text.
pub(crate) fn print(summary: &Summary, running: bool) {
    let outcome = match &summary.outcome {
        Outcome::Unfinished if running => "running; as of its last checkpoint:",
        Outcome::Unfinished => {
            "killed, or the disk was full; it can be resumed with --resume from:"
        }
        Outcome::Complete => "complete",
        Outcome::Cancelled => "interrupted; it can be resumed with --resume from:",
        Outcome::Failed { error } => error,
    };
    let Summary { fibers, nodes, steps, planned_steps, time, frames, halvings, .. } = summary;
    println!("{}", summary.scene);
    println!("  outcome     {outcome}");
    println!("  fibres      {fibers}, with {nodes} nodes");
    println!("  time        {time:.6} s, step {steps} of {planned_steps}, {frames} frames");
    println!(
        "  iterations  {:.2} in the mean, {} at worst, {halvings} steps halved",
        summary.mean_iterations, summary.worst_iterations
    );
    println!(
        "  energy      {:.6e} J, of it kinetic {:.6e} J",
        summary.total_energy, summary.kinetic_energy
    );
}
