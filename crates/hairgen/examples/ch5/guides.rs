//! Section 5.3.3: pre-guides and guides.

use crate::canvas::{Canvas, HAIR, LOWEST, SKIN, View, images, tinted};
use crate::grown::{Ground, Size};
use nalgebra::Point3;
use rapunzel_hairgen::head::HairVolume;
use rapunzel_hairgen::{GuideOptions, place_guides};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// Color of what has found no place.
const LOST: [f64; 3] = [0.84, 0.37, 0.0];

/// Both on the parametric head in a bob.
pub(crate) fn laid(size: Size) -> Fallible<Figure> {
    let count = size.of(3000, 400);
    let ground = Ground::new(&HairVolume::BOB, 0.24, 3000)?;
    let options = GuideOptions::default();
    let hairs = place_guides(&ground.pores[..count], &ground.pre, ground.region(), None, &options)?;
    let mut room = ground.hull.vertices().to_vec();
    room.extend(ground.pre.iter().flat_map(|guide| guide.shape.positions()));
    let picture = |view: View, lines: &[(&[Point3<f64>], [f64; 3])], caption: &str| {
        let mut canvas = Canvas::around(view, &room, LOWEST);
        canvas.solid(&ground.head, SKIN);
        for (line, color) in lines {
            canvas.hair(line, *color);
        }
        canvas.image(format!("{caption}, {}", view.name))
    };
    let pre: Vec<_> = ground
        .pre
        .iter()
        .enumerate()
        .map(|(i, guide)| {
            let color = if guide.placed { tinted(HAIR, i) } else { LOST };
            (guide.shape.positions(), color)
        })
        .collect();
    let guides: Vec<_> = hairs
        .guides
        .iter()
        .enumerate()
        .map(|(i, guide)| (&guide.curve[..], tinted(HAIR, i)))
        .collect();
    let views = [View::oblique(), View::BACK];
    let mut pictures: Vec<_> = views.map(|view| picture(view, &pre, "pre-guides")).into();
    pictures.extend(views.map(|view| picture(view, &guides, "guides")));
    let placed = ground.pre.iter().filter(|guide| guide.placed).count() as f64;
    let equilibria: usize = hairs.guides.iter().map(|guide| guide.equilibria).sum();
    let legend = "orange: a pre-guide without a place";
    Ok(Figure {
        scene: "the bob on the parametric head, hairs of 24 cm",
        parameters: "a pre-guide on each square centimeter, 400 guides, --full 3,000; no density",
        drawings: vec![images("5.3.3 Pre-guides and guides", legend, 2, pictures)],
        checks: vec![
            check(
                "pre-guides with a place",
                100.0 * placed / ground.pre.len() as f64,
                "%",
                Criterion::Told,
                "all: the load grows until they are deep enough",
            ),
            check(
                "pores without a guide",
                100.0 * hairs.without_place.len() as f64 / count as f64,
                "%",
                Criterion::Told,
                "not told",
            ),
            check(
                "equilibria of a guide",
                equilibria as f64 / hairs.guides.len().max(1) as f64,
                "",
                Criterion::AtMost(options.equilibria as f64),
                "not told",
            ),
        ],
    })
}
