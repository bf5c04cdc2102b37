//! Repeats the examples of the thesis's section 8.6, and its curve of combing (2.19), and compares
//! what it says of them with our numbers.
//!
//! `cargo xtask repro ch8` runs it. Each figure is an SVG with its numbers as CSV. Scenes are those
//! that ship, with fewer fibers so that all takes some minutes; `--full` takes them as they are,
//! and hours.

mod chains;
mod comb;
mod elastic;
#[path = "../film/mod.rs"]
mod film;
mod friction;
mod size;

use rapunzel_repro::{Fallible, Figure, FigureEntry};
use size::Size;
use std::process::ExitCode;

type Draw = fn(Size) -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 6] = [
    FigureEntry { number: "2.19", title: "The force of combing", draw: comb::force },
    FigureEntry {
        number: "8.8",
        title: "A bundle on a ball rests or splits",
        draw: friction::split,
    },
    FigureEntry { number: "8.16", title: "Partly elastic impacts", draw: elastic::impacts },
    FigureEntry {
        number: "8.18",
        title: "Fibers with and without stiffness",
        draw: elastic::stiffness,
    },
    FigureEntry {
        number: "8.18-chains",
        title: "Chains with and without bending springs",
        draw: chains::springs,
    },
    FigureEntry {
        number: "8.19",
        title: "Three kinds of friction, Table 8.1",
        draw: friction::volumes,
    },
];

fn main() -> ExitCode {
    let (full, others): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|argument| argument == "--full");
    let size = if full.is_empty() { Size::Reduced } else { Size::Full };
    rapunzel_repro::main(&FIGURES, others.into_iter(), |draw| draw(size))
}
