//! Figure 5.6: how many segments are in the voxels, without and with the models of density.

use crate::grown::{Ground, Size, voxels};
use nalgebra::Point3;
use rapunzel_hairgen::head::HairVolume;
use rapunzel_hairgen::{
    DensityHistogram, DensityModel, GuideOptions, GuideWeights, HairDensity, HairOptions,
    grow_hairs, place_guides,
};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// Sides of the voxels in which segments are counted, and of those of the binary model, m.
const COUNTED: f64 = 4e-3;
const BINARY: f64 = 2e-3;
/// The thesis's histograms end at so many segments.
const MOST: usize = 50;

/// Histograms of the guides' segments, with the coefficients of Gini of guides and hairs.
pub(crate) fn histograms(size: Size) -> Fallible<Figure> {
    let hairs = size.of(90_000, 10_000);
    let ground = Ground::new(&HairVolume::BOB, 0.24, hairs)?;
    let own = &ground.pores[..size.of(3000, 400)];
    let weights = GuideWeights { density: 1.0, ..GuideWeights::default() };
    let options = GuideOptions { weights, ..GuideOptions::default() };
    let (corners, region) = (ground.hull.vertices(), ground.region());
    let models = [
        ("without a model", None),
        ("binary model (BBM)", Some((DensityModel::Binary { radius: 0.003 }, BINARY))),
        ("continuous model (KDM)", Some((DensityModel::Continuous { most: 0.1 }, COUNTED))),
    ];
    let (mut curves, mut ginis, mut fullest) = (Vec::new(), Vec::new(), Vec::new());
    for (name, model) in models {
        let mut density = match model {
            Some((model, side)) => Some(HairDensity::new(voxels(corners, side)?, model)),
            None => None,
        };
        let laid = place_guides(own, &ground.pre, region, density.as_mut(), &options)?.guides;
        let all = grow_hairs(&ground.pores, &laid, own, region, &HairOptions::default())?;
        let counted = |curves: &mut dyn Iterator<Item = &[Point3<f64>]>| -> Fallible<_> {
            Ok(DensityHistogram::of(curves, region, voxels(corners, COUNTED)?))
        };
        let histogram = counted(&mut laid.iter().map(|guide| &guide.curve[..]))?;
        fullest.push(histogram.voxels.len() as f64 - 1.0);
        ginis.push([histogram.gini(), counted(&mut all.iter())?.gini()]);
        let shown = histogram.voxels.iter().take(MOST + 1).enumerate().skip(1);
        let points = shown.map(|(count, voxels)| [count as f64, *voxels as f64]).collect();
        curves.push(Curve { name: name.into(), points });
    }
    let mut checks = Vec::new();
    for ((name, _), count) in models.iter().zip(&fullest).skip(1) {
        checks.push(check(
            format!("most segments of guides in a voxel over those without a model, {name}"),
            count / fullest[0],
            "",
            Criterion::AtMost(1.0),
            "a picture",
        ));
    }
    // The models see guides; hairs follow them.
    for (what, k, criterion) in
        [("guides", 0, Criterion::AtMost(1.0)), ("hairs", 1, Criterion::Told)]
    {
        let none = ginis[0][k];
        checks.push(check(
            format!("coefficient of Gini of the {what}, without a model"),
            none,
            "",
            Criterion::Told,
            "a picture",
        ));
        for ((name, _), gini) in models.iter().zip(&ginis).skip(1) {
            checks.push(check(
                format!("the same over that, {what}, {name}"),
                gini[k] / none,
                "",
                criterion,
                "voxels are filled more evenly with either model",
            ));
        }
    }
    Ok(Figure {
        scene: "the bob on the parametric head",
        parameters: "400 guides and 10,000 hairs, --full 3,000 and 90,000; voxels of 4 mm; the \
                     weight of density is 1 beside 0.9 of all others",
        drawings: vec![Drawing::Chart(Chart {
            title: "5.6 Voxels by the number of the guides' segments in them".into(),
            x: "segments in a voxel",
            y: "voxels",
            log_from: Some(0.5),
            curves,
        })],
        checks,
    })
}
