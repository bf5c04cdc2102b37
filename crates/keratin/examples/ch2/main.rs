//! Draws what chapter 2 of the thesis says of hair, from the parametric model and from instruments
//! on simulated hairs: curves over humidity, temperature and treatment (figures 2.3 to 2.17).
//!
//! Run it with a folder, and numbers of figures if not all are wanted. Each figure is an SVG with
//! its numbers as CSV; the table compares what the thesis says with our numbers. The thesis's
//! curves are not digitized, so only what it says in words and in tables is compared.

#[allow(dead_code, reason = "it takes what it needs")]
#[path = "../../tests/it/common/mod.rs"]
mod common;
mod curls;
mod sweeps;

use rapunzel_repro::{Fallible, Figure, FigureEntry};
use std::process::ExitCode;

type Draw = fn() -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 7] = [
    FigureEntry { number: "2.3", title: "Stress over strain", draw: sweeps::tension },
    FigureEntry { number: "2.11", title: "Water and swelling", draw: sweeps::water },
    FigureEntry { number: "2.12", title: "Curl retention over humidity", draw: curls::retention },
    FigureEntry { number: "2.14", title: "Young's modulus over temperature", draw: sweeps::warmth },
    FigureEntry { number: "2.16", title: "Moduli over humidity", draw: sweeps::moduli },
    FigureEntry { number: "2.17", title: "Torsion after treatments", draw: sweeps::torsion },
    FigureEntry { number: "2.4.10", title: "Electric resistance", draw: sweeps::resistance },
];

fn main() -> ExitCode {
    rapunzel_repro::main(&FIGURES, std::env::args().skip(1), |draw| draw())
}
