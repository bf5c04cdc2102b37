//! Draws the figures of the thesis's chapter 5 on hairstyles anew, and what its sections say
//! without one, and compares both with our numbers.
//!
//! `cargo xtask repro ch5` runs it. Figures have the thesis's numbers, others those of the sections
//! that they show. All but one need nothing but our own head; Beethoven's hair needs a scan that is
//! not part of the project. Styles have fewer hairs and guides, so that all takes a minute or two;
//! `--full` takes as many as the thesis.

mod beethoven;
mod canvas;
mod disc;
mod evenness;
mod grown;
mod guides;
mod influence;
mod search;
mod sections;
mod silhouettes;
mod wisps;

use grown::Size;
use rapunzel_repro::{Fallible, Figure, FigureEntry};
use std::process::ExitCode;

type Draw = fn(Size) -> Fallible<Figure>;

const BEETHOVEN: FigureEntry<Draw> =
    FigureEntry { number: "5.1", title: "Beethoven's hair from a scan", draw: beethoven::hair };

const FIGURES: [FigureEntry<Draw>; 9] = [
    FigureEntry { number: "5.3", title: "Surfaces and styles", draw: silhouettes::styles },
    FigureEntry { number: "5.4", title: "Silhouettes", draw: silhouettes::overlays },
    FigureEntry { number: "5.5", title: "Weights and lengths", draw: influence::variants },
    FigureEntry { number: "5.6", title: "Histograms of density", draw: evenness::histograms },
    FigureEntry { number: "5.7", title: "Sections", draw: sections::cuts },
    FigureEntry { number: "5.3.2", title: "The scalp in the disc", draw: disc::map },
    FigureEntry { number: "5.3.3", title: "Pre-guides and guides", draw: guides::laid },
    FigureEntry { number: "5.3.3-search", title: "Two searches", draw: search::compared },
    FigureEntry { number: "5.3.5", title: "Wisps", draw: wisps::patterns },
];

fn main() -> ExitCode {
    let (full, others): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|argument| argument == "--full");
    let size = if full.is_empty() { Size::Reduced } else { Size::Full };
    let mut figures = Vec::from(FIGURES);
    // Where the scan is missing, this is told.
    if beethoven::scan().is_some() {
        figures.insert(0, BEETHOVEN);
    }
    rapunzel_repro::main(&figures, others.into_iter(), |draw| draw(size))
}
