//! Figures 6.9 and 6.10: hair by the orders of scattering. The order k is light that fibres have
//! scattered up to k + 1 times.

use crate::draw::{chart, curve};
use crate::studio::{Bsdf, KEY, Shot, chiang, front, hair, images, lit, luminance, near, wisp};
use nalgebra::Vector3;
use rapunzel_render::RenderScene;
use rapunzel_repro::plot::Curve;
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_scattering::Pigments;

/// Fibres of the wisp.
const FIBERS: u32 = 10_000;
/// Pixels of a side of the pictures.
const SIDE: u32 = 96;
/// Samples of blond hair, whose numbers are compared, and of other.
const SAMPLES: [u32; 2] = [64, 25];
/// Absorption per radius of blond and of black hair, as other renderers were given it.
const BLOND: Vector3<f64> = Vector3::new(0.06, 0.10, 0.20);
const BLACK: Vector3<f64> = Vector3::new(2.0, 2.6, 3.5);
/// Mean radiance of blond hair at orders 0 to 4 by Mitsuba 3.9.1 (its BSDF `hair`, variant
/// `scalar_rgb`, 64 x 64 pixels, 1500 samples, seed 1), W/(m^2 sr).
const MITSUBA: [[f64; 3]; 5] = [
    [0.03676, 0.03300, 0.02576],
    [0.05978, 0.05243, 0.03882],
    [0.07990, 0.06831, 0.04788],
    [0.09799, 0.08167, 0.05435],
    [0.11396, 0.09260, 0.05873],
];
/// The same at order 31, the last that was tried, with 256 samples.
const MITSUBA_31: [f64; 3] = [0.1819, 0.1266, 0.0666];
/// Side of a pixel of the pictures at the wisp, m: 48 cm away, over 20 degrees.
const PIXEL: f64 = 2.0 * 0.48 * 0.176_327 / SIDE as f64;

/// A wisp in the light of the scene of orders.
fn scene(bsdf: Bsdf) -> Fallible<RenderScene> {
    lit(&wisp(FIBERS), bsdf, KEY, 0.0)
}

/// Orders 0 to 4, and all.
const ORDERS: [Option<u32>; 6] = [Some(0), Some(1), Some(2), Some(3), Some(4), None];

/// Shots at some orders.
fn series(bsdf: Bsdf, orders: &[Option<u32>], samples: u32) -> Fallible<Vec<Shot>> {
    let (scene, camera) = (scene(bsdf)?, front()?);
    let shot = |order: &Option<u32>| Shot::of(&scene, &camera, *order, [SIDE; 2], samples);
    orders.iter().map(shot).collect()
}

/// What of all light is missing at an order, %.
fn missing(shots: &[Shot], order: usize) -> Vector3<f64> {
    shots[order].mean.zip_map(&shots[5].mean, |part, all| 100.0 * (1.0 - part / all))
}

/// Mean radiance of a color over the orders, all of them last.
fn rising(name: &str, shots: &[Shot], color: usize) -> Curve {
    curve(name, shots.iter().enumerate().map(|(k, shot)| [k as f64, shot.mean[color]]))
}

/// Our means of blond hair against those of another renderer.
fn compared(shots: &[Shot]) -> Vec<ClaimCheck> {
    let mut checks = Vec::new();
    for (order, theirs) in MITSUBA.iter().enumerate() {
        let Shot { mean, error, .. } = &shots[order];
        // Theirs has ten times as many paths.
        let noise = 100.0 * error;
        for (color, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let limit = (10.0 * (1.0 + 3.0 * noise)).round() / 10.0;
            checks.push(check(
                format!("blond, order {order}, {name}: mean over Mitsuba's, less 1"),
                100.0 * (mean[color] / theirs[color] - 1.0),
                "%",
                Criterion::Within(-limit, limit),
                "other renderers; 1 % and three standard errors",
            ));
        }
    }
    for (color, name) in ["red", "green", "blue"].into_iter().enumerate() {
        checks.push(check(
            format!("blond, all orders, {name}: mean over Mitsuba's at order 31, less 1"),
            100.0 * (shots[5].mean[color] / MITSUBA_31[color] - 1.0),
            "%",
            Criterion::Told,
            "other renderers",
        ));
    }
    checks
}

/// Figure 6.10.
pub(crate) fn orders() -> Fallible<Figure> {
    let [many, few] = SAMPLES;
    let blond = series(chiang(BLOND)?, &ORDERS, many)?;
    let brown = series(chiang(Pigments::BROWN.absorption()?)?, &ORDERS, few)?;
    let black = series(chiang(BLACK)?, &[Some(1), None], few)?;
    let mut pictures = Vec::new();
    for (name, shots, exposure) in [("blond", &blond, 2.0), ("brown", &brown, 3.0)] {
        for (k, shot) in shots.iter().enumerate() {
            let order = if k < 5 { format!("order {k}") } else { "all orders".into() };
            pictures.push(shot.image(format!("{name}, {order}"), exposure));
        }
    }
    let bright = |shots: &[Shot], order: usize| luminance(&shots[order].mean);
    let step = |order: usize| bright(&blond, order) - bright(&blond, order - 1);
    let enough = "brighter up to order three or four, seen by eye";
    let mut checks = compared(&blond);
    for (k, color) in ["red", "green", "blue"].into_iter().enumerate() {
        for order in [3, 4] {
            let name = format!("blond, {color}: what of all light is missing at order {order}");
            let must = Criterion::Within([25.0, 15.0, 7.0][k], 60.0);
            checks.push(check(name, missing(&blond, order)[k], "%", must, enough));
        }
    }
    checks.extend([
        check(
            "blond: luminance at order 1 over order 0",
            bright(&blond, 1) / bright(&blond, 0),
            "",
            Criterion::AtLeast(1.4),
            "a leap from dark to blond",
        ),
        check(
            "blond: what order 2 adds over what order 1 adds",
            step(2) / step(1),
            "",
            Criterion::AtMost(1.0),
            "clearly weaker beyond",
        ),
        check(
            "blond: what order 4 adds over what order 3 adds",
            step(4) / step(3),
            "",
            Criterion::AtMost(1.0),
            "clearly weaker beyond",
        ),
        check(
            "brown: what of all luminance is missing at order 4",
            100.0 * (1.0 - bright(&brown, 4) / bright(&brown, 5)),
            "%",
            Criterion::AtMost(15.0),
            "the order that is needed depends on the pigments",
        ),
        check(
            "black: what of all luminance is missing at order 1",
            100.0 * (1.0 - bright(&black, 0) / bright(&black, 1)),
            "%",
            Criterion::AtMost(3.0),
            "black hair needs no scattering between hairs",
        ),
        check(
            "standard error of the luminance of blond hair, all orders",
            100.0 * blond[5].error,
            "%",
            Criterion::AtMost(2.0),
            "-",
        ),
    ]);
    let mut curves = Vec::new();
    for (name, shots) in [("blond", &blond), ("brown", &brown)] {
        for (k, color) in ["red", "green", "blue"].into_iter().enumerate() {
            curves.push(rising(&format!("{name}, {color}"), shots, k));
        }
    }
    let labels = ["order (5: all)", "mean radiance of hair (W/m^2/sr)"];
    Ok(Figure {
        scene: "10,000 wavy fibres of 30 cm in one directional light",
        parameters: "96 x 96 pixels, 64 samples (brown, black 25); the near field of other \
                     renderers, roughness 0.3",
        drawings: vec![
            images(
                "6.10 Orders of scattering between hairs",
                "blond two stops brighter, brown three",
                PIXEL,
                6,
                pictures,
            ),
            chart("6.10 Mean radiance by orders", labels, curves),
        ],
        checks,
    })
}

/// Figure 6.9: a wisp with scattering between hairs up to order 4, and without.
pub(crate) fn wisps() -> Fallible<Figure> {
    let camera = front()?;
    let (mut pictures, mut ratios) = (Vec::new(), Vec::new());
    for (name, pigments) in [("blond", Pigments::BLOND), ("brown", Pigments::BROWN)] {
        let scene = scene(near(hair(&pigments, 0.3)?)?)?;
        let [with, without] =
            [4, 0].map(|order| Shot::of(&scene, &camera, Some(order), [144; 2], 16));
        let (with, without) = (with?, without?);
        ratios.push(luminance(&with.mean) / luminance(&without.mean));
        pictures.push(with.image(format!("{name}, order 4"), 2.5));
        pictures.push(without.image(format!("{name}, no scattering between hairs"), 2.5));
    }
    Ok(Figure {
        scene: "10,000 wavy fibres of 30 cm in one directional light",
        parameters: "144 x 144 pixels, 16 samples; our near field, roughness 0.3",
        drawings: vec![images(
            "6.9 A wisp with and without scattering between hairs",
            "both two and a half stops brighter",
            PIXEL * f64::from(SIDE) / 144.0,
            4,
            pictures,
        )],
        checks: vec![
            check(
                "blond: mean luminance with order 4 over that without",
                ratios[0],
                "",
                Criterion::AtLeast(1.5),
                "blond hair needs it; the reader is to judge",
            ),
            check(
                "brown over blond: the same, less 1",
                (ratios[1] - 1.0) / (ratios[0] - 1.0),
                "",
                Criterion::AtMost(0.5),
                "fair hair above all",
            ),
        ],
    })
}
