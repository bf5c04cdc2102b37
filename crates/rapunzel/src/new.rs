use crate::arguments::NewOptions;
use crate::failure::Failure;
use crate::templates;
use crate::words::say;
use rapunzel_sim::write_atomically;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Writes a scene that ships into a file.
pub(crate) fn new(options: &NewOptions, json: bool) -> Result<ExitCode, Failure> {
    let name = &options.template;
    let verb = match name.split('/').next() {
        Some("static") => "solve",
        Some("style") => "grow",
        _ => "run",
    };
    // It is copied here, not into a folder of its own.
    let file = name.rsplit('/').next().unwrap_or(name);
    let path = options.file.clone().unwrap_or_else(|| PathBuf::from(format!("{file}.ron")));
    let text = templates::text(name)
        .ok_or_else(|| Failure::File(format!("there is no template {name}")))?;
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
    if options.force {
        write_atomically(&path, |to| to.write_all(text.as_bytes())).map_err(Failure::of(&path))?;
    } else {
        let mut file = File::create_new(&path).map_err(failed)?;
        file.write_all(text.as_bytes()).map_err(failed)?;
    }
    if json {
        say(&serde_json::json!({ "file": path }).to_string())?;
    } else {
        say(&format!("{}: {verb} it with `rapunzel {verb} {}`", path.display(), path.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}
