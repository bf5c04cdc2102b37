//! Repeats the figures of the thesis's section 3.3 and compares what it says of them with our
//! numbers; its search by simulated annealing is here for the comparison only.
//!
//! `cargo xtask repro ch3-static` runs it. Each figure is an SVG with its numbers as CSV.

mod annealing;
mod ends;
mod minima;

use rapunzel_repro::{Fallible, Figure, FigureEntry};
use std::process::ExitCode;

type Draw = fn() -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 6] = [
    FigureEntry { number: "3.3", title: "Annealing for a position", draw: ends::position },
    FigureEntry { number: "3.5", title: "Annealing for position and tangent", draw: ends::tangent },
    FigureEntry { number: "3.9", title: "A force that follows the tip", draw: minima::followers },
    FigureEntry {
        number: "3.10",
        title: "A force that keeps its direction",
        draw: minima::dead_load,
    },
    FigureEntry {
        number: "3.11",
        title: "Natural curvatures in gravity",
        draw: minima::curvatures,
    },
    FigureEntry { number: "3.12", title: "A wound fiber at two places", draw: minima::places },
];

fn main() -> ExitCode {
    rapunzel_repro::main(&FIGURES, std::env::args().skip(1), |draw| draw())
}
