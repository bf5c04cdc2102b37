use crate::arguments::NewOptions;
use crate::failure::Failure;
use crate::templates;
use crate::words::say;
use rapunzel_sim::scene::style_from_ron;
use rapunzel_sim::{Scene, write_atomically};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Writes a scene, a case or a style that ships into a file, and beside it the files that it names.
pub(crate) fn new(options: &NewOptions, json: bool) -> Result<ExitCode, Failure> {
    let name = &options.template;
    let text = templates::text(name)
        .ok_or_else(|| Failure::File(format!("there is no template {name}")))?;
    let scene = Scene::from_ron(text).ok();
    let verb = match &scene {
        Some(_) => "run",
        None if style_from_ron(text).is_ok() => "grow",
        None => "solve",
    };
    // It is copied here, not into a folder of its own.
    let (folder, own) = name.rsplit_once('/').unwrap_or(("", name));
    let path = options.file.clone().unwrap_or_else(|| PathBuf::from(format!("{own}.ron")));
    let files: Vec<&Path> = scene.iter().flat_map(Scene::files).collect();
    // What it names lies beside it, wherever it lies among the scenes that ship.
    let named = |text: String, file: &&Path| match (file.to_str(), file.file_name()) {
        (Some(old), Some(new)) => text.replace(old, &new.to_string_lossy()),
        _ => text,
    };
    write(&path, &files.iter().fold(text.to_owned(), named), options.force)?;
    let mut written = vec![path.clone()];
    for file in files {
        let beside = path.with_file_name(file.file_name().unwrap_or_default());
        if let Some(text) = templates::text(&template_of(folder, file))
            && !written.contains(&beside)
            && (options.force || !beside.exists())
        {
            write(&beside, text, options.force)?;
            written.push(beside);
        }
    }
    if json {
        say(&serde_json::json!({ "file": path, "files": written }).to_string())?;
    } else {
        say(&format!("{}: {verb} it with `rapunzel {verb} {}`", path.display(), path.display()))?;
        for beside in &written[1..] {
            say(&format!("{}: belongs to it", beside.display()))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Name of the template that a scene in a folder of the templates names by a path.
fn template_of(folder: &str, file: &Path) -> String {
    let mut parts: Vec<String> = folder.split('/').map(str::to_owned).collect();
    for part in file.with_extension("").iter() {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part.to_string_lossy().into_owned());
        }
    }
    parts.join("/")
}

/// Writes a text into a new file, or by `force` into one that is there.
fn write(path: &Path, text: &str, force: bool) -> Result<(), Failure> {
    let failed = |error: std::io::Error| {
        let advice = match error.kind() {
            std::io::ErrorKind::AlreadyExists => {
                "; name another file, or overwrite it with --force"
            }
            std::io::ErrorKind::NotFound => "; make the folder first, or check the path",
            _ => "",
        };
        Failure::File(format!("cannot write {}: {error}{advice}", path.display()))
    };
    if force {
        write_atomically(path, |to| to.write_all(text.as_bytes())).map_err(Failure::of(path))
    } else {
        let mut file = File::create_new(path).map_err(failed)?;
        file.write_all(text.as_bytes()).map_err(failed)
    }
}
