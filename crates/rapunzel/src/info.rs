use crate::failure::Failure;
use crate::words::say;
use rapunzel_sim::{LeftOut, Outcome, Summary, in_use};
use std::path::Path;
use std::process::ExitCode;

/// Says how the run in a folder stands.
pub(crate) fn info(folder: &Path, json: bool) -> Result<ExitCode, Failure> {
    let summary = Summary::read(folder).map_err(Failure::of(folder))?;
    let running = in_use(folder);
    if json {
        let object = serde_json::json!({ "running": running, "summary": summary });
        say(&object.to_string())?;
    } else {
        say(&report(&summary, running))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A summary as text.
pub(crate) fn report(summary: &Summary, running: bool) -> String {
    let outcome = match &summary.outcome {
        Outcome::Unfinished if running => "running; as of its last checkpoint:",
        Outcome::Unfinished => {
            "killed, or the disk was full; it can be resumed with --resume from:"
        }
        Outcome::Complete => "complete",
        Outcome::Cancelled => "interrupted; it can be resumed with --resume from:",
        Outcome::Failed { error } => error,
    };
    let Summary { fibers, nodes, dt, steps, planned_steps, time, frames, halvings, .. } = summary;
    let mut lines = vec![
        summary.scene.clone(),
        format!("  outcome     {outcome}"),
        match fibers {
            0 => format!("  nodes       {nodes}, of a mass-spring system"),
            _ => format!("  fibres      {fibers}, with {nodes} nodes"),
        },
        format!("  time        {time:.6} s, step {steps} of {planned_steps}, {frames} frames"),
        format!("  step        {dt:.6e} s, halved {halvings} times for a fibre"),
        format!(
            "  iterations  {:.2} in the mean, {} at worst",
            summary.mean_iterations, summary.worst_iterations
        ),
        format!(
            "  energy      {:.6e} J: kinetic {:.6e}, elastic {:.6e}, gravitational {:.6e}",
            summary.total_energy,
            summary.kinetic_energy,
            summary.elastic_energy,
            summary.gravitational_energy
        ),
    ];
    lines.extend(summary.left_out.iter().map(|left_out| match left_out {
        LeftOut::ObjectsInHair => {
            "  left out    the objects in .hair, which holds fibres alone".into()
        }
    }));
    if let Some(contact) = &summary.contact {
        let (listed, active) = (contact.listed, contact.active);
        let (parts, lists) = (contact.parts, contact.lists);
        let (solves, iterations) = (contact.solves, contact.iterations);
        lines.push(format!(
            "  contacts    at most {active} of {listed} listed bore something; {parts} parts of \
             steps, {lists} lists, {solves} solves, {iterations} iterations"
        ));
        lines.push(format!(
            "  errors      Coulomb residual {:.1e}, normal velocity {:.1e} m/s, slip {:.1e} m/s, \
             creep {:.1e} m/s, penetration {:.1e} m, all at most",
            contact.residual,
            contact.normal_error,
            contact.slip_error,
            contact.creep,
            contact.depth
        ));
        if contact.unresolved > 0 {
            lines.push(format!(
                "  unresolved  {} parts of steps missed the tolerances of `contact`",
                contact.unresolved
            ));
        }
        if let Some(first) = contact.first_unresolved {
            let segment = first.segment.map(|s| format!(", segment {s}")).unwrap_or_default();
            lines.push(format!(
                "              first at {} s: {}{}, {:.1e} m deep in {}",
                first.time, first.sides[0], segment, first.depth, first.sides[1]
            ));
        }
    }
    if let Some(charge) = &summary.charge {
        lines.push(format!(
            "  charge      {:.4e} C, {:.3e} C drained; mean field {:.3e} V/m, lift at most {:.3} weights",
            charge.charge, charge.drained, charge.mean_field, charge.lift
        ));
        lines.push(format!(
            "  rest        {} evaluations of the forces, {} retreats; residual at most {:.1e}",
            charge.evaluations, charge.retreats, charge.residual
        ));
        if charge.equilibria > 0 {
            lines.push(format!(
                "  equilibria  {} by the ways of dealing that are compared, at most {:.1e} m apart",
                charge.equilibria, charge.apart
            ));
        }
        if charge.unsettled > 0 {
            lines.push(format!(
                "  unsettled   {} steps did not come to rest within the tolerance of `charging`",
                charge.unsettled
            ));
        }
    }
    if summary.missed > 0 {
        lines.push(format!("  tolerance   missed {} times by the smallest step", summary.missed));
    }
    lines.join("\n")
}
