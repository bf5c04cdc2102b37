//! What every program that draws figures anew does.

use crate::Fallible;
use crate::report::{self, Figure};
use std::path::PathBuf;
use std::process::ExitCode;

/// A figure of the thesis.
pub(crate) struct Entry<D> {
    /// As the thesis numbers it.
    pub(crate) number: &'static str,
    pub(crate) title: &'static str,
    /// What draws it.
    pub(crate) draw: D,
}

/// Draws all figures into a folder, the first of the arguments, or those whose numbers follow it;
/// fails if a check does.
pub(crate) fn main<D>(
    figures: &[Entry<D>],
    arguments: impl Iterator<Item = String>,
    draw: impl Fn(&D) -> Fallible<Figure>,
) -> ExitCode {
    match run(figures, arguments, draw) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(failed) => {
            eprintln!("{failed} checks fail");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// How many checks fail.
fn run<D>(
    entries: &[Entry<D>],
    mut arguments: impl Iterator<Item = String>,
    draw: impl Fn(&D) -> Fallible<Figure>,
) -> Fallible<usize> {
    let folder = PathBuf::from(arguments.next().ok_or("usage: FOLDER [NUMBER OF A FIGURE ...]")?);
    let wanted: Vec<String> = arguments.collect();
    let mut figures = Vec::new();
    for entry in entries {
        if wanted.is_empty() || wanted.iter().any(|number| number == entry.number) {
            println!("{}  {}", entry.number, entry.title);
            figures.push((entry, draw(&entry.draw)?));
        }
    }
    if figures.is_empty() {
        return Err(format!("no such figure: {}", wanted.join(", ")).into());
    }
    report::write(&folder, &figures)?;
    let (table, failed) = report::table(&figures);
    println!("\n{table}");
    Ok(failed)
}
