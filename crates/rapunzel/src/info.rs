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
    let Summary { fibers, nodes, dt, steps, planned_steps, time, frames, .. } = summary;
    println!("{}", summary.scene);
    println!("  outcome     {outcome}");
    println!("  fibres      {fibers}, with {nodes} nodes");
    println!("  time        {time:.6} s, step {steps} of {planned_steps}, {frames} frames");
    println!("  step        {dt:.6e} s, halved {} times for a fibre", summary.halvings);
    if summary.missed > 0 {
        println!("  tolerance   missed {} times by the smallest step", summary.missed);
    }
    println!(
        "  iterations  {:.2} in the mean, {} at worst",
        summary.mean_iterations, summary.worst_iterations
    );
    println!(
        "  energy      {:.6e} J: kinetic {:.6e}, elastic {:.6e}, gravitational {:.6e}",
        summary.total_energy,
        summary.kinetic_energy,
        summary.elastic_energy,
        summary.gravitational_energy
    );
}
