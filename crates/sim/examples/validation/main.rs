//! Published protocols for rods, against values that are computed here from theory.
//!
//! `cargo xtask repro validation` runs them. Rods at rest are those of the staggered chain, in
//! segments; theory is in closed forms and in quadratures that no integrator of the house has a
//! part in. Where a number converges, its order is checked, and what it converges to. Each protocol
//! is an SVG with its numbers as CSV, and all are a page.

#[path = "../../tests/it/belt.rs"]
mod belt;
mod coil;
mod coiling;
mod discrete;
#[path = "../../tests/it/drum.rs"]
mod drum;
#[path = "../../tests/it/greenhill.rs"]
mod greenhill;
mod knot;
mod planar;
mod plectoneme;
mod ply;
#[path = "../../tests/it/pressed.rs"]
mod pressed;
mod pressing;
mod spatial;
mod stability;
mod theory;
mod touching;

use rapunzel_repro::{Fallible, Figure, FigureEntry, NotRun};
use std::process::ExitCode;

type Draw = fn() -> Fallible<Figure>;

const PROTOCOLS: [FigureEntry<Draw>; 18] = [
    FigureEntry {
        number: "cantilever",
        title: "Cantilever under its weight (Romero et al. 2021)",
        draw: planar::cantilever,
    },
    FigureEntry {
        number: "tip-load",
        title: "Cantilever with a force on its end (Bisshopp and Drucker 1945, Mattiasson 1981)",
        draw: planar::mattiasson,
    },
    FigureEntry { number: "taper", title: "A cone under a couple", draw: planar::cone },
    FigureEntry {
        number: "bend-45",
        title: "The 45 degree bend (Bathe and Bolourchi 1979)",
        draw: spatial::bend_of_45_degrees,
    },
    FigureEntry {
        number: "lateral-buckling",
        title: "Lateral buckling (Prandtl, Michell; Romero et al. 2021)",
        draw: spatial::lateral,
    },
    FigureEntry {
        number: "writhing",
        title: "A twisted rod writhes (Greenhill 1883)",
        draw: spatial::writhing,
    },
    FigureEntry {
        number: "localised-helix",
        title: "The localised helix (van der Heijden and Thompson 2000)",
        draw: spatial::localised_helix,
    },
    FigureEntry {
        number: "columns",
        title: "Columns (Euler 1744, Greenhill 1881)",
        draw: stability::buckling,
    },
    FigureEntry {
        number: "bend-twist",
        title: "A hanging curved rod leaves its plane (Romero et al. 2021)",
        draw: stability::bend_twist,
    },
    FigureEntry { number: "snap", title: "A leaning strip snaps at a fold", draw: stability::snap },
    FigureEntry {
        number: "ring",
        title: "A twisted ring leaves its plane (Michell 1889, Zajac 1962)",
        draw: stability::ring,
    },
    FigureEntry { number: "capstan", title: "The capstan", draw: touching::capstan },
    FigureEntry {
        number: "stick-slip",
        title: "Stick and slip on a belt",
        draw: touching::stick_slip,
    },
    FigureEntry {
        number: "pressed-strip",
        title: "Stick-slip of a pressed strip (Sano et al. 2017, Romero et al. 2021)",
        draw: pressing::pressed_strip,
    },
    FigureEntry {
        number: "knot",
        title: "The friction of an overhand knot (Audoly, Clauvelin and Neukirch 2007)",
        draw: knot::overhand,
    },
    FigureEntry {
        number: "drawn-knot",
        title: "An overhand knot is drawn against friction (Audoly, Clauvelin and Neukirch 2007)",
        draw: knot::drawn,
    },
    FigureEntry {
        number: "plectoneme",
        title: "A twisted rod winds up with itself (Clauvelin, Audoly and Neukirch 2009)",
        draw: plectoneme::plectoneme,
    },
    FigureEntry {
        number: "coiling",
        title: "A rod that is fed onto a floor coils (Habibi, Ribe and Bonn 2007)",
        draw: coiling::coiling,
    },
];

/// What is not run, and why.
const NOT_RUN: [NotRun; 1] = [NotRun {
    title: "A long twisted rod followed from its bifurcation to the localised helix",
    why: "the branch is not followed so far; the helix is held at its ends as theory has it instead",
}];

fn main() -> ExitCode {
    rapunzel_repro::main_beside(&PROTOCOLS, &NOT_RUN, std::env::args().skip(1), |draw| draw())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The quick ones among them hold.
    #[test]
    fn cantilevers_converge_to_theory() {
        let names: Vec<_> = PROTOCOLS.iter().map(|entry| entry.number).collect();
        assert_eq!(names.iter().filter(|name| **name == "cantilever").count(), 1);
        let folder = std::env::temp_dir().join(format!("validation-{}", std::process::id()));
        let arguments = [folder.display().to_string(), "cantilever".into(), "taper".into()];
        let code =
            rapunzel_repro::main_beside(&PROTOCOLS, &NOT_RUN, arguments.into_iter(), |d| d());
        let page = std::fs::read_to_string(folder.join("page.html")).expect("a page");
        std::fs::remove_dir_all(&folder).expect("removed");
        assert_eq!(format!("{code:?}"), format!("{:?}", ExitCode::SUCCESS));
        assert!(page.contains("not run") && page.contains("cantilever.svg"), "{page}");
    }
}
