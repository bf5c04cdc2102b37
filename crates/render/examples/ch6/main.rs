//! Draws the figures of the thesis's chapter 6 on the light of hair anew, and compares what it says
//! of them with our numbers.
//!
//! `cargo xtask repro ch6` runs it. Figures have the thesis's numbers; those it has no picture for
//! have the number of what they belong to. All hair is our own, so Beethoven's stands in no
//! picture. It takes some three minutes of one processor.

mod azimuths;
mod close;
mod draw;
mod ellipse;
mod geometry;
mod lobes;
mod locks;
mod orders;
mod studio;
mod trace;
#[path = "../../tests/it/wavy.rs"]
mod wavy;

use rapunzel_repro::{Fallible, Figure, FigureEntry};
use std::process::ExitCode;

type Draw = fn() -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 11] = [
    FigureEntry { number: "6.2", title: "Light of a single hair", draw: lobes::goniophotometer },
    FigureEntry { number: "6.2-light", title: "Front and back", draw: locks::front_and_back },
    FigureEntry { number: "6.4", title: "Inclination and azimuth", draw: geometry::angles },
    FigureEntry { number: "6.5", title: "The cone of a smooth fibre", draw: geometry::cone },
    FigureEntry { number: "6.6", title: "R, TT and TRT over azimuths", draw: azimuths::curves },
    FigureEntry { number: "6.6-ellipse", title: "Elliptical sections", draw: ellipse::sections },
    FigureEntry { number: "6.7", title: "Near and far field", draw: close::near_and_far },
    FigureEntry { number: "6.8", title: "Offsets of rays", draw: geometry::offsets_of_rays },
    FigureEntry { number: "6.9", title: "Scattering between hairs", draw: orders::wisps },
    FigureEntry { number: "6.10", title: "Orders of scattering", draw: orders::orders },
    FigureEntry { number: "6.11", title: "Locks", draw: locks::curls },
];

fn main() -> ExitCode {
    rapunzel_repro::main(&FIGURES, std::env::args().skip(1), |draw| draw())
}
