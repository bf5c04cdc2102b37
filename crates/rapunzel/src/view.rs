use crate::arguments::ViewOptions;
use crate::failure::{Failure, INTERRUPTED};
use crate::run::{CANCEL, catch_interrupts, start_threads};
use crate::templates::{self, Template};
use crate::words::say;
use rapunzel_view::{GalleryScene, Options, Server, ViewError};
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};
use std::{env, fs, io};

/// Shows what is asked for, or the gallery, until it is interrupted.
pub(crate) fn view(options: ViewOptions, json: bool) -> Result<ExitCode, Failure> {
    start_threads(options.threads)?;
    catch_interrupts("interrupted: the page has ended")?;
    let ViewOptions { what, beside, listen, run, no_browser, .. } = options;
    for path in what.iter().chain(&beside) {
        fs::metadata(path).map_err(|error| {
            Failure::File(format!("cannot read {}: {error}; check the path", path.display()))
        })?;
    }
    let token = (!listen.ip().is_loopback()).then(token);
    let shipped = |name: &&str| {
        let Template { text, files } = templates::template(name)?;
        let files = files.into_iter().map(|(name, text)| (name, text.to_owned())).collect();
        Some(GalleryScene { name: (*name).to_owned(), text, files })
    };
    let server = Server::listen(Options {
        address: listen,
        token,
        what,
        beside,
        gallery: templates::NAMES.iter().filter_map(shipped).collect(),
        folder: PathBuf::from("."),
        runs: run,
    });
    let failed = |error: ViewError| Failure::File(error.to_string());
    let server = server.map_err(failed)?;
    let url = server.url();
    if json {
        say(&serde_json::json!({ "url": url }).to_string())?;
    } else {
        say(&format!("{url}\nCtrl-C ends it."))?;
    }
    if !no_browser && has_screen() {
        // The address is printed: whoever has no browser knows where to go.
        let _ = open_browser(&url);
    }
    if let Some(kept) = server.run(&|| CANCEL.hear()).map_err(failed)? {
        let kept = kept.display().to_string();
        if json {
            say(&serde_json::json!({ "kept": kept }).to_string())?;
        } else {
            say(&format!("where it stood is kept: rapunzel view {kept} goes on there"))?;
        }
    }
    Ok(ExitCode::from(INTERRUPTED))
}

/// A word that nobody can guess.
fn token() -> String {
    // The state of the hash tables of a program is random, lest others choose what collides.
    (0..2).map(|_| format!("{:016x}", RandomState::new().build_hasher().finish())).collect()
}

/// Whether there is a screen for a browser.
fn has_screen() -> bool {
    let is_set = |name| env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}

fn open_browser(url: &str) -> io::Result<()> {
    let mut command = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        let mut command = Command::new("rundll32");
        command.arg("url.dll,FileProtocolHandler");
        command
    } else {
        Command::new("xdg-open")
    };
    command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().map(drop)
}
