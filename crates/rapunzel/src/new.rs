use crate::arguments::NewOptions;
use crate::failure::Failure;
use crate::templates::{self, Template};
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
    let Template { text, files } = templates::template(name)
        .ok_or_else(|| Failure::File(format!("there is no template {name}")))?;
    let verb = match Scene::from_ron(&text) {
        Ok(_) => "run",
        Err(_) if style_from_ron(&text).is_ok() => "grow",
        Err(_) => "solve",
    };
    let own = name.rsplit_once('/').map_or(name.as_str(), |(_, own)| own);
    let path = options.file.clone().unwrap_or_else(|| PathBuf::from(format!("{own}.ron")));
    write(&path, &text, options.force)?;
    let mut written = vec![path.clone()];
    for (file, text) in files {
        let beside = path.with_file_name(file);
        if options.force || !beside.exists() {
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
