//! Draws the thesis's figures of motion (chapter 3, 3.15 to 3.24) anew, from the scenes that ship,
//! and compares what it says of them with our numbers.
//!
//! `cargo xtask repro ch3-dynamic` runs it. Each figure is an SVG with its numbers as CSV; the
//! manifest says from which scene it is and what was compared.

#[path = "../film/mod.rs"]
mod film;
mod locks;
mod rods;
mod springs;

use rapunzel_repro::{Fallible, Figure, FigureEntry};
use std::process::ExitCode;

type Draw = fn() -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 10] = [
    FigureEntry { number: "3.15", title: "A wavy rod falls and keeps its waves", draw: rods::wavy },
    FigureEntry { number: "3.16", title: "A helix under an end load", draw: rods::helix },
    FigureEntry {
        number: "3.17",
        title: "A straight rod with a moment at its end",
        draw: rods::torque,
    },
    FigureEntry { number: "3.18", title: "A spring is let go", draw: springs::spring },
    FigureEntry { number: "3.19", title: "Segments and steps of all sizes", draw: springs::sizes },
    FigureEntry { number: "3.20", title: "Buckling", draw: rods::buckling },
    FigureEntry { number: "3.21", title: "A lock is pulled and let go", draw: locks::pulled },
    FigureEntry { number: "3.22", title: "How the coefficients damp", draw: rods::damping },
    FigureEntry { number: "3.23", title: "A lock stretches under gravity", draw: locks::falling },
    FigureEntry { number: "3.24", title: "A lock on a moving root", draw: locks::moving_root },
];

fn main() -> ExitCode {
    rapunzel_repro::main(&FIGURES, std::env::args().skip(1), |draw| draw())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_figures_of_motion_are_there_once() {
        let numbers = FIGURES.map(|entry| entry.number.to_owned());
        assert_eq!(numbers.to_vec(), (15..=24).map(|n| format!("3.{n}")).collect::<Vec<_>>());
    }
}
