//! Figure 5.5: the same style with other weights and lengths.

use crate::canvas::{Canvas, LOWEST, View, images};
use crate::grown::{Ground, Size, voxels};
use nalgebra::Vector3;
use rapunzel_hairgen::head::HairVolume;
use rapunzel_hairgen::{
    DensityModel, GuideHair, GuideOptions, GuideWeights, HairDensity, HairOptions, grow_hairs,
    place_guides,
};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// Length of the hairs, m, and weights of curvature and density; zero for no density.
struct Variant {
    name: &'static str,
    length: f64,
    curvature: f64,
    density: f64,
}

const VARIANTS: [Variant; 6] = [
    Variant { name: "plain", length: 0.3, curvature: 0.1, density: 0.0 },
    Variant { name: "similarity 1 for 0.1", length: 0.3, curvature: 1.0, density: 0.0 },
    Variant { name: "longer", length: 0.42, curvature: 0.1, density: 0.0 },
    Variant { name: "density 0.1", length: 0.3, curvature: 0.1, density: 0.1 },
    Variant { name: "density 1", length: 0.3, curvature: 0.1, density: 1.0 },
    Variant { name: "density 10", length: 0.3, curvature: 0.1, density: 10.0 },
];

/// The long style in all variants.
pub(crate) fn variants(size: Size) -> Fallible<Figure> {
    let (mut pictures, mut deviations, mut angles) = (Vec::new(), Vec::new(), Vec::new());
    for Variant { name, length, curvature, density } in VARIANTS {
        let ground = Ground::new(&HairVolume::LONG, length, size.of(60_000, 10_000))?;
        let (own, region) = (&ground.pores[..size.of(3000, 200)], ground.region());
        let weights = GuideWeights { curvature, density, ..GuideWeights::default() };
        let options = GuideOptions { weights, ..GuideOptions::default() };
        let frame = voxels(ground.hull.vertices(), 4e-3)?;
        let model = DensityModel::Continuous { most: 0.1 };
        let mut there = (density > 0.0).then(|| HairDensity::new(frame, model));
        let laid = place_guides(own, &ground.pre, region, there.as_mut(), &options)?.guides;
        let hairs = grow_hairs(&ground.pores, &laid, own, region, &HairOptions::default())?;
        let canvas = Canvas::around(View::oblique(), ground.hull.vertices(), LOWEST);
        pictures.push(canvas.haired(&ground.head, hairs.iter()).image(name));
        let sum: f64 = laid.iter().map(|guide| guide.terms.curvature).sum();
        deviations.push(sum / laid.len().max(1) as f64);
        angles.push(apart(&laid));
    }
    let angle = |k: usize, criterion, thesis| {
        let what = format!("{}: angle to the nearest guide", VARIANTS[k].name);
        check(what, angles[k].to_degrees(), "degrees", criterion, thesis)
    };
    let smoother = "the style looks smoother";
    let wispier = "the larger the weight, the more wisps are seen";
    Ok(Figure {
        scene: "the long style on the parametric head",
        parameters: "hairs of 30 cm, longer ones of 42 cm; 200 guides and 10,000 hairs, --full \
                     3,000 and 60,000; the thesis tells no weights",
        drawings: vec![images("5.5 Weights and lengths", "seen from half front", 3, pictures)],
        checks: vec![
            check(
                "deviation (5.9) with similarity 1 over that with 0.1",
                deviations[1] / deviations[0],
                "",
                Criterion::AtMost(1.0),
                smoother,
            ),
            angle(0, Criterion::Told, "a picture"),
            angle(1, Criterion::AtMost(angles[0].to_degrees()), smoother),
            angle(2, Criterion::Told, "a picture"),
            angle(3, Criterion::Told, wispier),
            angle(4, Criterion::Told, wispier),
            angle(5, Criterion::AtLeast(angles[0].to_degrees()), wispier),
        ],
    })
}

/// Mean angle between the directions of guides and of their nearest neighbors, rad, node by node.
fn apart(guides: &[GuideHair]) -> f64 {
    let root = |guide: &GuideHair| guide.shape.positions()[0];
    let tangents = |guide: &GuideHair| -> Vec<Vector3<f64>> {
        guide.shape.frames().iter().map(|frame| frame * Vector3::z()).collect()
    };
    let mut angles = Vec::new();
    for (i, guide) in guides.iter().enumerate() {
        let others = guides.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other);
        let nearest = others.min_by(|a, b| {
            let off = |other: &GuideHair| (root(other) - root(guide)).norm_squared();
            off(a).total_cmp(&off(b))
        });
        let Some(nearest) = nearest else { continue };
        let pairs = tangents(guide).into_iter().zip(tangents(nearest));
        angles.extend(pairs.map(|(a, b)| a.angle(&b)));
    }
    angles.iter().sum::<f64>() / angles.len().max(1) as f64
}
