//! Automation of the workspace, run as `cargo xtask <command>`.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that reports")]

mod bench;
mod ci;
mod formats;
mod fuzz;
mod peers;
mod reference;
mod repro;
mod structure;
mod tidy;

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask <command>
  ci        everything a change must pass: formatting, clippy, tidy, tests, documentation, a run
  tidy      the house rules that no other tool checks
  reference write docs/scene.md, all that a scene and a case can say, from the types that read it
  bench     the benchmarks as one table: measured, budget, thesis
  repro     draw the figures of the thesis anew and compare (repro CHAPTER, or all; what follows
            CHAPTER goes to it: --full for the sizes of the thesis in ch7 and ch8, or numbers of
            figures)
  formats   write sample files and open them with the programs they are for (Python packages
            vtk and usd-core; skipped, with a word, where they are missing)
  peers     draw the same hair with Mitsuba and Blender's Cycles and compare means and times (Python
            packages mitsuba and bpy; skipped, with a word, where they are missing)
  fuzz      feed every reader of files with mutated ones for a minute each (fuzz READER SECONDS)";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    match (arguments.next().as_deref(), arguments.next()) {
        (Some("ci"), None) => ci::run(),
        (Some("tidy"), None) => tidy::run(),
        (Some("reference"), None) => reference::run(),
        (Some("bench"), None) => bench::run(),
        (Some("repro"), chapter) => {
            let chapter = chapter.filter(|chapter| chapter != "all");
            repro::run(chapter.as_deref(), &arguments.collect::<Vec<_>>())
        }
        (Some("formats"), None) => formats::run(),
        (Some("peers"), None) => peers::run(),
        (Some("fuzz"), reader) => {
            fuzz::run(&reader.into_iter().chain(arguments).collect::<Vec<_>>())
        }
        _ => bail!("{USAGE}"),
    }
}

/// The root of the workspace.
fn root() -> Result<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    Ok(here.parent().context("xtask lies in the workspace")?.to_owned())
}
