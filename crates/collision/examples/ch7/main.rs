//! Repeats the performance tests of the thesis's hierarchies (chapter 7.4, figures 7.7 to 7.15) and
//! compares what it says of them with our numbers.
//!
//! `cargo xtask repro ch7` runs it. Each figure is an SVG with its numbers as CSV. Models are scaled
//! down so that all takes some two minutes; `--full` takes those of the thesis, and hours. Times are
//! the least of several runs, and belong to the machine that drew them; checks prefer counts.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program of its own")]

#[path = "../../../sim/examples/repro/drawing.rs"]
mod drawing;
mod measure;
mod models;
mod motion;
#[path = "../../../sim/examples/repro/report.rs"]
mod report;
mod still;
#[path = "../../../sim/examples/repro/svg.rs"]
mod svg;
mod sweep;

use models::Size;
use report::Figure;
use std::path::PathBuf;
use std::process::ExitCode;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// A figure of section 7.4.
struct Entry {
    number: u32,
    title: &'static str,
    draw: fn(Size) -> Fallible<Figure>,
}

impl Entry {
    fn number(&self) -> String {
        format!("7.{}", self.number)
    }
}

const FIGURES: [Entry; 7] = [
    Entry { number: 7, title: "The models", draw: models::all },
    Entry { number: 9, title: "The static bundle test", draw: still::bundle },
    Entry { number: 11, title: "The dynamic test", draw: motion::looping },
    Entry { number: 12, title: "Ways to update", draw: motion::updates },
    Entry { number: 13, title: "All trees, all models", draw: still::table },
    Entry { number: 14, title: "Tests and volumes", draw: still::counts },
    Entry { number: 15, title: "How many faces a k-DOP should have", draw: sweep::faces },
];

fn main() -> ExitCode {
    match run() {
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

/// Draws all figures, or those whose numbers are given after the folder; returns how many checks
/// fail.
fn run() -> Fallible<usize> {
    let (flags, mut arguments): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument == "--full");
    if arguments.is_empty() {
        return Err("usage: ch7 FOLDER [--full] [7.9 ...]".into());
    }
    let size = if flags.is_empty() { Size::Scaled } else { Size::Full };
    let folder = PathBuf::from(arguments.remove(0));
    let mut figures = Vec::new();
    for entry in &FIGURES {
        if arguments.is_empty() || arguments.contains(&entry.number()) {
            println!("{}  {}", entry.number(), entry.title);
            let (time, figure) = measure::least(1, || (entry.draw)(size));
            println!("      {:.0} s", 1e-3 * time);
            figures.push((entry, figure?));
        }
    }
    if figures.is_empty() {
        return Err(format!("no such figure: {}", arguments.join(", ")).into());
    }
    report::write(&folder, &figures)?;
    let (table, failed) = report::table(&figures);
    println!("\n{table}");
    Ok(failed)
}
