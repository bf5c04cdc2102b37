//! Repeats the performance tests of the thesis's hierarchies (chapter 7.4, figures 7.7 to 7.15) and
//! compares what it says of them with our numbers.
//!
//! `cargo xtask repro ch7` runs it. Each figure is an SVG with its numbers as CSV. Models are
//! scaled down so that all takes some two minutes; `--full` takes those of the thesis, and hours.
//! Times are the least of several runs, and belong to the machine that drew them; checks prefer
//! counts.

mod measure;
mod models;
mod motion;
mod still;
mod sweep;

use models::Size;
use rapunzel_repro::{Fallible, Figure, FigureEntry};
use std::process::ExitCode;

type Draw = fn(Size) -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 7] = [
    FigureEntry { number: "7.7", title: "The models", draw: models::all },
    FigureEntry { number: "7.9", title: "The static bundle test", draw: still::bundle },
    FigureEntry { number: "7.11", title: "The dynamic test", draw: motion::looping },
    FigureEntry { number: "7.12", title: "Ways to update", draw: motion::updates },
    FigureEntry { number: "7.13", title: "All trees, all models", draw: still::table },
    FigureEntry { number: "7.14", title: "Tests and volumes", draw: still::counts },
    FigureEntry { number: "7.15", title: "How many faces a k-DOP should have", draw: sweep::faces },
];

fn main() -> ExitCode {
    let (full, others): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|argument| argument == "--full");
    let size = if full.is_empty() { Size::Scaled } else { Size::Full };
    rapunzel_repro::main(&FIGURES, others.into_iter(), |draw| draw(size))
}
