//! Draws the thesis's figures of motion (chapter 3, 3.15 to 3.24) anew, from the scenes that ship,
//! and compares what it says of them with our numbers.
//!
//! `cargo xtask repro ch3-dynamic` runs it. Each figure is an SVG with its numbers as CSV; the
//! manifest says from which scene it is and what was compared.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program of its own")]

mod drawing;
mod film;
mod locks;
mod report;
mod rods;
mod svg;

use report::Figure;
use std::path::PathBuf;
use std::process::ExitCode;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// A figure of section 3.4.9.
struct Entry {
    number: u32,
    title: &'static str,
    draw: fn() -> Fallible<Figure>,
}

impl Entry {
    fn number(&self) -> String {
        format!("3.{}", self.number)
    }
}

const FIGURES: [Entry; 10] = [
    Entry { number: 15, title: "A wavy rod falls and keeps its waves", draw: rods::wavy },
    Entry { number: 16, title: "A helix under an end load", draw: rods::helix },
    Entry { number: 17, title: "A straight rod with a moment at its end", draw: rods::torque },
    Entry { number: 18, title: "A spring is let go", draw: rods::spring },
    Entry { number: 19, title: "Segments and steps of all sizes", draw: rods::sizes },
    Entry { number: 20, title: "Buckling", draw: rods::buckling },
    Entry { number: 21, title: "A lock is pulled and let go", draw: locks::pulled },
    Entry { number: 22, title: "How the coefficients damp", draw: rods::damping },
    Entry { number: 23, title: "A lock stretches under gravity", draw: locks::falling },
    Entry { number: 24, title: "A lock on a moving root", draw: locks::moving_root },
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
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("usage: repro FOLDER [3.15 ...]")?);
    let wanted: Vec<String> = arguments.collect();
    let mut figures = Vec::new();
    for entry in &FIGURES {
        let number = entry.number();
        if wanted.is_empty() || wanted.contains(&number) {
            println!("{number}  {}", entry.title);
            figures.push((entry, (entry.draw)()?));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_figures_of_motion_are_there_once() {
        let numbers = FIGURES.map(|entry| entry.number);
        assert_eq!(numbers.to_vec(), (15..=24).collect::<Vec<_>>());
    }
}
