//! Figures 5.3 and 5.4: surfaces of hair, the styles grown in them, and how their silhouettes
//! overlap.

use crate::canvas::{Canvas, HULL, LOWEST, SKIN, View, images};
use crate::grown::{Size, grow, shipped};
use rapunzel_collision::field::Soup;
use rapunzel_hairgen::style::{Hairstyle, Style};
use rapunzel_repro::plot::{Drawing, Image};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use std::time::Instant;

/// The thesis's two: a ball of curls, and long straight hair; with its numbers of hairs and times.
const STYLES: [(&str, usize, &str); 2] = [
    ("afro", 90_000, "150 s for 90,000 hairs of 3,000 guides, Pentium IV"),
    ("long", 60_000, "90 s for 60,000 hairs of 3,000 guides, Pentium IV"),
];
const SCENE: &str = "scenes/style/afro.ron and long.ron";
const PARAMETERS: &str =
    "20,000 hairs of 400 guides; --full takes the thesis's 90,000 and 60,000 of 3,000";
/// Colors of a silhouette: in both, only in the surface, only in the style.
const BOTH: [f64; 3] = [0.75, 0.75, 0.75];
const ONLY_HULL: [f64; 3] = [0.0, 0.45, 0.70];
const ONLY_STYLE: [f64; 3] = [0.84, 0.37, 0.0];
const BARE: [f64; 3] = [0.88, 0.88, 0.88];
const OVERLAY_LEGEND: &str =
    "grey: both, light where the bald head is; blue: only the surface; orange: only the style";

fn style(name: &str, hairs: usize, size: Size) -> Fallible<Style> {
    let (hairs, guides) = (Some(size.of(hairs, 20_000)), size.of(3000, 400));
    Ok(Style { hairs, guides, ..shipped(name)? })
}

/// A style on its head in a view, without what is lower than a height, m.
pub(crate) fn portrait(style: &Hairstyle, view: View, lowest: f64, caption: &str) -> Image {
    let canvas = Canvas::around(view, &style.surfaces.hull.vertices, lowest);
    canvas.haired(&style.surfaces.head, style.hairs.iter()).image(caption)
}

/// A surface in a view, without what is lower than a height, m.
pub(crate) fn bust(surface: &Soup, view: View, lowest: f64, caption: &str) -> Image {
    let mut canvas = Canvas::around(view, &surface.vertices, lowest);
    canvas.surface(surface, HULL);
    canvas.image(caption)
}

/// Figure 5.3: both surfaces, and their styles.
pub(crate) fn styles(size: Size) -> Fallible<Figure> {
    let (mut pictures, mut checks) = (Vec::new(), Vec::new());
    for (name, hairs, time) in STYLES {
        let style = style(name, hairs, size)?;
        let start = Instant::now();
        let grown = grow(&style)?;
        let seconds = start.elapsed().as_secs_f64();
        pictures.push(bust(
            &grown.surfaces.hull,
            View::oblique(),
            LOWEST,
            &format!("{name}: surface"),
        ));
        pictures.push(portrait(&grown, View::oblique(), LOWEST, &format!("{name}: style")));
        pictures.push(portrait(&grown, View::BACK, LOWEST, &format!("{name}: from the back")));
        checks.push(check(format!("{name}: time"), seconds, "s", Criterion::Told, time));
        checks.extend(kept(name, &grown));
    }
    Ok(Figure {
        scene: SCENE,
        parameters: PARAMETERS,
        drawings: vec![images(
            "5.3 Surfaces of hair and styles",
            "seen from half front and back",
            3,
            pictures,
        )],
        checks,
    })
}

/// What must hold of every style.
pub(crate) fn kept(name: &str, grown: &Hairstyle) -> Vec<ClaimCheck> {
    let report = &grown.report;
    let without = report.hairs.without_place.len() as f64 / report.count as f64;
    vec![
        check(
            format!("{name}: segments in the head, by its field"),
            report.hairs.in_head as f64,
            "",
            Criterion::AtMost(0.0),
            "none (figure 5.7)",
        ),
        check(
            format!("{name}: length outside of the surface"),
            100.0 * report.hairs.outside / report.hairs.length,
            "%",
            Criterion::AtMost(0.1),
            "hairs are cut where they leave it",
        ),
        check(
            format!("{name}: pores without a hair"),
            100.0 * without,
            "%",
            Criterion::Told,
            "not told",
        ),
    ]
}

/// How a style's silhouette and that of a surface overlap: areas of their intersection over those
/// of their union.
pub(crate) struct Overlap {
    pub(crate) image: Image,
    /// Of both whole.
    pub(crate) whole: f64,
    /// Of what is not in front of or behind the bald head.
    pub(crate) hair: f64,
}

impl Overlap {
    /// In a view, without what is lower than a height, m.
    pub(crate) fn of(style: &Hairstyle, view: View, lowest: f64) -> Self {
        let hull = &style.surfaces.hull;
        let mut surface = Canvas::around(view, &hull.vertices, lowest);
        let (mut bald, mut haired) = (surface.blank(), surface.blank());
        surface.surface(hull, HULL);
        bald.solid(&style.surfaces.head, SKIN);
        haired = haired.haired(&style.surfaces.head, style.hairs.iter());
        let pixels: Vec<[bool; 3]> = surface
            .covered()
            .zip(haired.covered())
            .zip(bald.covered())
            .map(|((hull, style), bald)| [hull, style, bald])
            .collect();
        let over = |counts: fn(&&[bool; 3]) -> bool| {
            let chosen: Vec<_> = pixels.iter().filter(counts).collect();
            let both = chosen.iter().filter(|[hull, style, _]| *hull && *style).count();
            let any = chosen.iter().filter(|[hull, style, _]| *hull || *style).count();
            both as f64 / any.max(1) as f64
        };
        let (whole, hair) = (over(|_| true), over(|[.., bald]| !bald));
        let color = |pixel: usize| match pixels[pixel] {
            [true, true, true] => BARE,
            [true, true, false] => BOTH,
            [true, false, _] => ONLY_HULL,
            [false, true, _] => ONLY_STYLE,
            _ => [1.0; 3],
        };
        let caption =
            format!("{}: {:.1} % of both, {:.1} % of hair", view.name, 100.0 * whole, 100.0 * hair);
        Self { image: surface.painted(color, caption), whole, hair }
    }
}

/// Overlaps in three views, and what must hold of them.
pub(crate) fn overlaps(
    name: &str,
    grown: &Hairstyle,
    lowest: f64,
) -> (Vec<Image>, Vec<ClaimCheck>) {
    let (mut pictures, mut checks) = (Vec::new(), Vec::new());
    for view in [View::FRONT, View::SIDE, View::TOP] {
        let Overlap { image, whole, hair } = Overlap::of(grown, view, lowest);
        pictures.push(image);
        checks.push(check(
            format!("{name}, {}: intersection over union of both silhouettes", view.name),
            100.0 * whole,
            "%",
            Criterion::AtLeast(95.0),
            "all that the volume dictates is reproduced",
        ));
        checks.push(check(
            format!("{name}, {}: the same beside the bald head", view.name),
            100.0 * hair,
            "%",
            Criterion::Told,
            "gaps are where hair is too short",
        ));
    }
    (pictures, checks)
}

/// The silhouettes of a style side by side.
pub(crate) fn overlay(title: &str, pictures: Vec<Image>) -> Drawing {
    images(title, OVERLAY_LEGEND, 3, pictures)
}

/// Figure 5.4: both styles over their surfaces.
pub(crate) fn overlays(size: Size) -> Fallible<Figure> {
    let (mut drawings, mut checks) = (Vec::new(), Vec::new());
    for (name, hairs, _) in STYLES {
        let grown = grow(&style(name, hairs, size)?)?;
        let (pictures, found) = overlaps(name, &grown, LOWEST);
        drawings.push(overlay(&format!("5.4 {name}: silhouettes of surface and style"), pictures));
        checks.extend(found);
    }
    Ok(Figure { scene: SCENE, parameters: PARAMETERS, drawings, checks })
}
