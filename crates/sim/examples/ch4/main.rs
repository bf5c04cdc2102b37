//! Draws the figures of the thesis's chapter 4 on charged hair anew, and compares what it says of
//! them with our numbers.
//!
//! `cargo xtask repro ch4` runs it. Each figure is an SVG with its numbers as CSV. The tress has
//! fewer fibers, as dense, so that all takes a minute or two; `--full` takes it as it ships, and
//! all hairs of the half head.

mod accuracy;
mod field;
#[path = "../film/mod.rs"]
mod film;
mod half_head;
mod tress;

use rapunzel_repro::{Fallible, Figure, FigureEntry};
use rapunzel_sim::Scene;
use rapunzel_sim::scene::Arrangement;
use std::process::ExitCode;

type Draw = fn(Size) -> Fallible<Figure>;

const FIGURES: [FigureEntry<Draw>; 6] = [
    FigureEntry { number: "4.3", title: "The field of a charged tress", draw: field::plane },
    FigureEntry { number: "4.7", title: "A charged tress, dry and wet", draw: tress::humidity },
    FigureEntry {
        number: "4.8",
        title: "A charged tress without gravity",
        draw: tress::weightless,
    },
    FigureEntry { number: "4.9", title: "Half a head of charged hair", draw: half_head::charged },
    FigureEntry { number: "4.10", title: "Time and error over the terms", draw: accuracy::terms },
    FigureEntry {
        number: "growth",
        title: "Time over the number of points",
        draw: accuracy::growth,
    },
];

fn main() -> ExitCode {
    let (full, others): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|argument| argument == "--full");
    let size = if full.is_empty() { Size::Reduced } else { Size::Full };
    rapunzel_repro::main(&FIGURES, others.into_iter(), |draw| draw(size))
}

/// How large scenes are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Size {
    Reduced,
    /// As they ship.
    Full,
}

impl Size {
    /// A scene of the folder `scenes/charge`; reduced, its tress has 60 fibers, as dense as they
    /// were.
    fn scene(self, name: &str) -> Fallible<Scene> {
        let mut scene = film::scene(&format!("charge/{name}"))?;
        if self == Self::Reduced {
            for bundle in &mut scene.fibers {
                if let Arrangement::Ellipse { semi_axes, count } = &mut bundle.arrangement {
                    let smaller = (60.0 / *count as f64).sqrt();
                    semi_axes.iter_mut().for_each(|axis| *axis *= smaller);
                    *count = 60;
                }
            }
        }
        Ok(scene)
    }
}
