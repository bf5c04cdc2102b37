//! Section 5.3.2: the scalp in the unit disc, before and after the relaxation of its stretch.

use crate::canvas::{Canvas, LOWEST, View, images};
use crate::grown::Size;
use nalgebra::{Point2, Point3};
use rapunzel_collision::field::Soup;
use rapunzel_hairgen::growth::{ConvexWeights, DiscMap, HeadAxes, ScalpMesh, convex_map};
use rapunzel_hairgen::head::{Hairline, HeadMeasures, ParametricHead};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Image};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use std::f64::consts::PI;

/// Stretches from one round to the next: where the last is the largest, it did not fall.
fn largest_rise(history: &[f64]) -> f64 {
    history.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::NEG_INFINITY, f64::max)
}

/// Share of the disc that a triangle has over its share of the scalp.
fn room(scalp: &ScalpMesh, places: &[Point2<f64>]) -> Vec<f64> {
    let twice = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| places[v as usize]);
        (b - a).perp(&(c - a))
    };
    let flat: Vec<f64> = scalp.triangles().iter().map(twice).collect();
    let whole: f64 = flat.iter().sum();
    let areas = flat.iter().zip(scalp.areas());
    areas.map(|(flat, area)| flat / whole * scalp.area() / area).collect()
}

/// The disc as large as the scalp: triangles with little room blue, those with much orange.
fn flat(scalp: &ScalpMesh, places: &[Point2<f64>], caption: &str) -> Image {
    let radius = (scalp.area() / PI).sqrt();
    // Seen from above as the map: the face is below.
    let at = |p: &Point2<f64>| Point3::new(radius * p.x, 0.0, -radius * p.y);
    let vertices: Vec<_> = places.iter().map(at).collect();
    let rooms = room(scalp, places);
    let surface = Soup { vertices, triangles: scalp.triangles().to_vec() };
    let mut canvas = Canvas::around(View::TOP, &surface.vertices, LOWEST);
    canvas.faces(&surface.vertices, &surface.triangles, |face| {
        let log = (0.5 * rooms[face].log2()).clamp(-1.0, 1.0);
        let far = if log < 0.0 { [0.0, 0.45, 0.70] } else { [0.84, 0.37, 0.0] };
        far.map(|c| 1.0 + (c - 1.0) * log.abs())
    });
    for triangle in &surface.triangles {
        let corners = [0, 1, 2, 0].map(|k| surface.vertices[triangle[k] as usize]);
        canvas.line(&corners, [0.45; 3]);
    }
    canvas.image(caption)
}

/// The map of our own scalp, by both weights.
pub(crate) fn map(_: Size) -> Fallible<Figure> {
    let own = ParametricHead::new(HeadMeasures::default(), Hairline::default())?;
    let scalp = ScalpMesh::new(own.scalp(72, 24)?)?;
    let (mut curves, mut pictures, mut checks) = (Vec::new(), Vec::new(), Vec::new());
    let kinds = [
        ("mean-value weights", ConvexWeights::MeanValue),
        ("shape-preserving weights", ConvexWeights::ShapePreserving),
    ];
    for (name, weights) in kinds {
        let map = DiscMap::new(&scalp, weights, &HeadAxes::default())?;
        let border: Vec<_> = scalp.border().iter().map(|&v| map.places()[v as usize]).collect();
        let before = convex_map(&scalp, weights, &border)?;
        let history = map.stretch_history();
        let (first, last) = (history[0], history[history.len() - 1]);
        let flipped =
            |places: &[Point2<f64>]| room(&scalp, places).iter().filter(|r| **r <= 0.0).count();
        let off = (0..).take(scalp.triangles().len()).map(|face: u32| {
            let corners = map.corners(face);
            let middle = corners.iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / 3.0;
            let [a, b, c] = scalp.corners(face).map(|p| p.coords);
            (scalp.position(&map.locate(&middle.into())).coords - (a + b + c) / 3.0).norm()
        });
        let off = off.fold(0.0, f64::max) / scalp.size();
        pictures.push(flat(&scalp, &before, &format!("{name}, stretch {first:.3}")));
        pictures.push(flat(&scalp, map.places(), &format!("relaxed, stretch {last:.3}")));
        checks.extend([
            check(
                format!("{name}: triangles that are turned over, before and after"),
                (flipped(&before) + flipped(map.places())) as f64,
                "",
                Criterion::AtMost(0.0),
                "the map is one-to-one",
            ),
            check(
                format!("{name}: largest change of the stretch in a round"),
                largest_rise(history),
                "",
                Criterion::AtMost(0.0),
                "relaxed until the change is small",
            ),
            check(format!("{name}: stretch before"), first, "", Criterion::Told, "not told"),
            check(
                format!("{name}: stretch after"),
                last,
                "",
                Criterion::Within(1.0, first),
                "not told; that of a similarity is 1",
            ),
            check(
                format!(
                    "{name}: middles of triangles to the disc and back, off by part of the size"
                ),
                off,
                "",
                Criterion::AtMost(1e-9),
                "the map is inverted exactly",
            ),
        ]);
        let points = history.iter().enumerate().map(|(k, stretch)| [k as f64, *stretch]);
        curves.push(Curve { name: name.into(), points: points.collect() });
    }
    let legend = "the disc has the scalp's area, the face is below; blue: a quarter of the room or \
                  less, orange: four times or more";
    Ok(Figure {
        scene: "the scalp of the parametric head",
        parameters: "72 sectors and 24 rings; stretch is a mean by areas, not a sum over vertices",
        drawings: vec![
            images("5.3.2 The scalp in the disc", legend, 2, pictures),
            Drawing::Chart(Chart {
                title: "5.3.2 Stretch of the whole by rounds of relaxation".into(),
                x: "rounds of relaxation",
                y: "stretch; that of a similarity is 1",
                log_from: None,
                curves,
            }),
        ],
        checks,
    })
}
