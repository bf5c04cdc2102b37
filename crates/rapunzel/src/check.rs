use crate::failure::Failure;
use crate::words::say;
use rapunzel_sim::{Plan, Scene};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;

/// Reads the scene in a file, with the paths in it as they are from anywhere: a run keeps them.
pub(crate) fn read(path: &Path) -> Result<Scene, Failure> {
    let scene = Scene::from_ron(&read_text(path, "scene")?).map_err(Failure::of(path))?;
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    Ok(scene.seen_from(whole.parent().unwrap_or(&whole)))
}

/// Reads the text of a file; `what` it is to be is for the message.
pub(crate) fn read_text(path: &Path, what: &str) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| {
        let advice = match error.kind() {
            ErrorKind::InvalidData => format!("; a {what} is text, as `rapunzel new` writes it"),
            _ => "; check the path".to_owned(),
        };
        Failure::File(format!("cannot read the {what} {}: {error}{advice}", path.display()))
    })
}

/// Says what a scene would do.
pub(crate) fn check(path: &Path, json: bool) -> Result<ExitCode, Failure> {
    let scene = read(path)?;
    let world = scene.build().map_err(Failure::of(path))?;
    let plan = Plan::new(&scene);
    let (fibers, nodes) = (world.assembly().fibers().len(), world.nodes());
    let warning = world.warning(plan.dt);
    if json {
        let object = serde_json::json!({
            "scene": scene.name, "fibers": fibers, "nodes": nodes, "dt": plan.dt,
            "steps": plan.steps, "frames": plan.frames(), "warning": warning,
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
        ];
        lines.extend(warning.map(|warning| format!("  warning   {warning}")));
        say(&lines.join("\n"))?;
    }
    Ok(ExitCode::SUCCESS)
}
