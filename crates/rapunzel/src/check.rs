use crate::failure::Failure;
use crate::words::{build_stage, say, spinner};
use rapunzel_sim::{MemoryEstimate, Plan, Scene, World, read_text};
use std::path::Path;
use std::process::ExitCode;

/// Reads the scene in a file, with the paths in it as they are from anywhere: a run keeps them.
pub(crate) fn read(path: &Path) -> Result<Scene, Failure> {
    let text = read_text(path).map_err(Failure::of(path))?;
    let scene = Scene::from_ron(&text).map_err(Failure::of(path))?;
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    Ok(scene.seen_from(whole.parent().unwrap_or(&whole)))
}

/// Says what a scene would do.
pub(crate) fn check(path: &Path, memory: f64, json: bool) -> Result<ExitCode, Failure> {
    let scene = read(path)?;
    let estimate = MemoryEstimate::new(&scene).map_err(Failure::of(path))?;
    estimate.within(memory).map_err(Failure::of(path))?;
    let bar = spinner(json);
    let world = World::build_observed(&scene, &|stage| bar.set_message(build_stage(stage)));
    bar.finish_and_clear();
    let world = world.map_err(Failure::of(path))?;
    let plan = Plan::new(&scene);
    let (fibers, nodes) = (world.assembly().fibers().len(), world.nodes());
    let warning = world.warning(plan.dt);
    let notes = [&estimate.notes[..], world.notes()].concat();
    if json {
        let object = serde_json::json!({
            "scene": scene.name, "fibers": fibers, "nodes": nodes, "dt": plan.dt,
            "steps": plan.steps, "frames": plan.frames(), "warning": warning,
            "memory_bytes": estimate.bytes(), "notes": notes,
        });
        say(&object.to_string())?;
    } else {
        let title = if scene.name.is_empty() { "the scene is sound" } else { &scene.name };
        let mut lines = vec![
            title.to_owned(),
            match fibers {
                0 => format!("  nodes     {nodes}, of a mass-spring system"),
                _ => format!("  fibres    {fibers}, with {nodes} nodes"),
            },
            format!(
                "  time      {} s in {} steps of {:.6e} s",
                scene.duration, plan.steps, plan.dt
            ),
            format!("  frames    {}", plan.frames()),
            format!("  memory    some {:.2} GB, and what contacts take", estimate.bytes() * 1e-9),
        ];
        lines.extend(notes.iter().map(|note| format!("  note      {note}")));
        lines.extend(warning.map(|warning| format!("  warning   {warning}")));
        say(&lines.join("\n"))?;
    }
    Ok(ExitCode::SUCCESS)
}
