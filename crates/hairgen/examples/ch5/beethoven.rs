//! Figure 5.1: the hair of a scanned bust of Beethoven.

use crate::canvas::{Canvas, SKIN, View, images};
use crate::grown::{Size, grow};
use crate::silhouettes::{bust, kept, overlaps, overlay, portrait};
use rapunzel_hairgen::style::{GuideSpec, HairSource, HeadSource, ScalpField, Style};
use rapunzel_hairgen::{GuideOptions, HairOptions, HairPattern};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use std::path::PathBuf;
use std::time::Instant;

/// Height of the chin in the template's frame, m: the bust below is not compared.
const CHIN: f64 = -0.1;
const SCALP: [f64; 3] = [0.75, 0.66, 0.60];

/// The scan, if it is there.
pub(crate) fn scan() -> Option<PathBuf> {
    rapunzel_oracles::data("beethoven/bust.ply")
}

/// The head fitted to the scan, the style grown in it, and the silhouettes of both.
pub(crate) fn hair(size: Size) -> Fallible<Figure> {
    let file = scan().ok_or("there is no scan of Beethoven's bust")?;
    let head = HeadSource::Scan {
        file,
        template: None,
        hairline: Default::default(),
        options: Default::default(),
    };
    // Curls that stand off the head: locks that widen to fill the gaps between guides, up to the
    // surface.
    let pattern = HairPattern::Wisps { tip: 4.0, turns: 3.0 };
    let options = GuideOptions { margin: 0.001, ..GuideOptions::default() };
    let style = Style {
        head,
        hair: HairSource::Scan,
        hairs: Some(size.of(90_000, 20_000)),
        guides: size.of(3000, 400),
        length: ScalpField::Constant(0.09),
        tilt: Some(ScalpField::Constant(10.0)),
        dips: [0.0, 0.3],
        guide: GuideSpec { options, ..GuideSpec::default() },
        strands: HairOptions { pattern, ..HairOptions::default() },
        ..Style::default()
    };
    let start = Instant::now();
    let grown = grow(&style)?;
    let seconds = start.elapsed().as_secs_f64();
    let fit = grown.report.fit.clone().ok_or("a scan is fitted")?;
    let lowest = fit.similarity.translation.y + fit.similarity.scale * CHIN;
    let (pictures, mut checks) = overlaps("Beethoven", &grown, lowest);
    checks.extend(kept("Beethoven", &grown));
    let told =
        |what: &str, value: f64, unit, thesis| check(what, value, unit, Criterion::Told, thesis);
    let manual = "the head under the hair was made by hand";
    checks.extend([
        told("time with the fit", seconds, "s", "150 s on a Pentium IV, without a fit"),
        told("face of the fitted head off the scan", 1e3 * fit.deformed_rms, "mm", manual),
        told("least depth of the hair", 1e3 * fit.depth[0], "mm", manual),
        told("largest depth of the hair", 1e3 * fit.depth[1], "mm", manual),
    ]);
    let hull = &grown.surfaces.hull;
    let mut bald = Canvas::around(View::oblique(), &hull.vertices, lowest);
    bald.solid(&grown.surfaces.head, SKIN);
    bald.surface(&grown.surfaces.scalp, SCALP);
    let views = [View::oblique(), View::FRONT, View::BACK];
    let mut shown = vec![
        bust(hull, View::oblique(), lowest, "the scan"),
        bald.image("the fitted head and its scalp"),
    ];
    let style_in =
        |view: View| portrait(&grown, view, lowest, &format!("the style, {}", view.name));
    shown.extend(views.map(style_in));
    shown.push(bust(hull, View::BACK, lowest, "the scan, back"));
    Ok(Figure {
        scene: "beethoven/bust.ply (Three D Scans), above the chin",
        parameters: "20,000 hairs of 9 cm in wound wisps of 400 guides, --full 90,000 of 3,000",
        drawings: vec![
            images("5.1 Beethoven's hair", "seen from half front if not told", 3, shown),
            overlay("5.4 Beethoven: silhouettes of scan and style", pictures),
        ],
        checks,
    })
}
