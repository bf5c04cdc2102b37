//! Section 5.3.5: hairs in wisps, straight and wound, and between guides.

use crate::canvas::{Canvas, LOWEST, View, images};
use crate::grown::{Ground, Size};
use rapunzel_hairgen::head::HairVolume;
use rapunzel_hairgen::{
    GuideOptions, HairOptions, HairPattern, HairReport, grow_hairs, place_guides,
};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// The same guides with three patterns of hairs.
pub(crate) fn patterns(size: Size) -> Fallible<Figure> {
    let ground = Ground::new(&HairVolume::BOB, 0.24, size.of(60_000, 15_000))?;
    let (own, region) = (&ground.pores[..200], ground.region());
    let laid = place_guides(own, &ground.pre, region, None, &GuideOptions::default())?.guides;
    let patterns = [
        ("wisps", HairPattern::Wisps { tip: 0.2, turns: 0.0 }),
        ("wound wisps", HairPattern::Wisps { tip: 0.6, turns: 4.0 }),
        ("between guides", HairPattern::Between),
    ];
    let (mut pictures, mut checks) = (Vec::new(), Vec::new());
    for (name, pattern) in patterns {
        let options = HairOptions { pattern, ..HairOptions::default() };
        let hairs = grow_hairs(&ground.pores, &laid, own, region, &options)?;
        let canvas = Canvas::around(View::oblique(), ground.hull.vertices(), LOWEST);
        pictures.push(canvas.haired(&ground.head, hairs.iter()).image(name));
        let report = HairReport::of(&hairs, region, options.outside);
        checks.push(check(
            format!("{name}: segments in the head, by its field"),
            report.in_head as f64,
            "",
            Criterion::AtMost(0.0),
            "none (figure 5.7)",
        ));
        checks.push(check(
            format!("{name}: length outside of the surface"),
            100.0 * report.outside / report.length,
            "%",
            Criterion::AtMost(0.1),
            "guides are cut; of wisps it is not told",
        ));
    }
    Ok(Figure {
        scene: "the bob on the parametric head, hairs of 24 cm",
        parameters: "200 guides, 15,000 hairs, --full 60,000",
        drawings: vec![images(
            "5.3.5 Hairs along the same guides",
            "seen from half front",
            3,
            pictures,
        )],
        checks,
    })
}
