//! Words to the user. Unlike `println!`, they do not bring the program down where they cannot be
//! written.

use crate::failure::Failure;
use std::io::{self, ErrorKind, Write};

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
