//! Styles from files, grown whole.

use rapunzel_collision::field::{DistanceField, MeshDistance};
use rapunzel_hairgen::fit::FitOptions;
use rapunzel_hairgen::head::HairVolume;
use rapunzel_hairgen::style::{
    FlowSpec, GrowthStage, GuideSpec, HairSource, Hairstyle, HeadSource, ScalpField, Style, Voxel,
};
use rapunzel_hairgen::{DensityModel, GuideOptions, HairOptions, HairgenError};
use ron::extensions::Extensions;
use std::cell::RefCell;
use std::io;
use std::path::Path;

/// A bob of few hairs.
fn small() -> Style {
    Style { hairs: Some(600), guides: 60, length: ScalpField::Constant(0.2), ..Style::default() }
}

fn none(_: &Path) -> io::Result<Vec<u8>> {
    Err(io::Error::new(io::ErrorKind::NotFound, "no such file"))
}

fn grown(style: &Style) -> Hairstyle {
    style.grow(&none, &|_| {}).expect("a style")
}

/// By the exact distance and by winding numbers, not by the grids that made it: no hair is in the
/// head but at its root, and none farther outside of the hair than what it may be.
#[test]
fn hair_is_between_head_and_hull() {
    let style = grown(&small());
    let head = MeshDistance::new(&style.surfaces.head);
    let hull = rapunzel_collision::field::Mesh::new(style.surfaces.hull.clone()).expect("a solid");
    let hull = MeshDistance::new(&hull);
    let (mut inside, mut out, mut whole) = (0, 0.0, 0.0);
    for (number, curve) in style.hairs.iter().enumerate() {
        for (node, ends) in curve.windows(2).enumerate() {
            let (end, length) = (ends[1], (ends[1] - ends[0]).norm());
            whole += length;
            // The scalp's triangles lie on chords of the head's.
            if head.value(&end) < -0.2e-3 {
                inside += 1;
            }
            if hull.value(&end) > 1e-3 {
                out += length;
            }
            if number % 20 == 0 && node % 10 == 5 {
                assert!(head.tree().winding_number(&end) < 0.5, "hair {number}, node {node}");
            }
        }
    }
    assert_eq!(inside, 0);
    assert!(out <= 1e-3 * whole, "{out} m of {whole} m");
    // Most pores have a hair.
    assert!(style.report.hairs.without_place.len() < 600 / 20, "{}", style.report);
}

#[test]
fn the_same_style_has_the_same_bits_for_any_number_of_threads() {
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("a pool");
    let [a, b] = [alone, three].map(|pool| pool.install(|| grown(&small())).hairs);
    assert_eq!(a, b);
}

#[test]
fn every_part_of_the_work_is_told_in_order() {
    let told = RefCell::new(Vec::new());
    small().grow(&none, &|stage| told.borrow_mut().push(stage)).expect("a style");
    let all = [
        GrowthStage::Surfaces,
        GrowthStage::Pores,
        GrowthStage::PreGuides,
        GrowthStage::Guides,
        GrowthStage::Hairs,
    ];
    assert_eq!(told.into_inner(), all);
}

#[test]
fn an_empty_file_is_a_bob_and_styles_survive_writing() {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let empty: Style = options.from_str("()").expect("a style");
    assert_eq!(empty, Style::default());
    let text = options.to_string(&small()).expect("a text");
    assert_eq!(options.from_str::<Style>(&text).expect("a style"), small());
    options.from_str::<Style>("(hair: 3)").expect_err("no hair");
    let bare = "(head: Parametric(hairline: []))";
    assert!(options.from_str::<Style>(bare).expect_err("no line").to_string().contains("points"));
}

#[test]
fn what_cannot_grow_is_refused() {
    let refused = |style: &Style| style.grow(&none, &|_| {}).expect_err("refused");
    let none = Style { hairs: Some(0), ..small() };
    assert!(matches!(refused(&none), HairgenError::HairCount { count: 0, .. }));
    let bald = Style { density: ScalpField::Constant(0.0), ..small() };
    assert!(matches!(refused(&bald), HairgenError::Bald { .. }));
    let scan = Style { hair: HairSource::Scan, ..small() };
    assert!(matches!(refused(&scan), HairgenError::HairWithoutScan));
    let file = "head.ply".into();
    let missing =
        Style { head: HeadSource::Mesh { file, hairline: Default::default() }, ..small() };
    assert!(refused(&missing).to_string().contains("head.ply: no such file"));
    let other = Style { hair: HairSource::Solid("hair.xyz".into()), ..small() };
    assert!(matches!(refused(&other), HairgenError::File { .. }));
    let thin = HairVolume { crown: 0.0, ..HairVolume::BOB };
    let thin = Style { hair: HairSource::Volume(thin), ..small() };
    assert!(matches!(refused(&thin), HairgenError::Measure { .. }));
}

#[test]
fn numbers_out_of_range_are_refused_before_any_work() {
    let length = |x| Style { length: ScalpField::Constant(x), ..small() };
    let guide = |spec| Style { guide: spec, ..small() };
    let volume = |volume| Style { hair: HairSource::Volume(volume), ..Style::default() };
    let usual = FitOptions::default();
    let scan = |options| HeadSource::Scan {
        file: "head.obj".into(),
        template: None,
        hairline: Default::default(),
        options,
    };
    let fit = |options| Style { head: scan(options), ..small() };
    let shell = |thickness| HairSource::Shell { file: "hair.obj".into(), thickness };
    let whorl = |turn, reach| FlowSpec::Whorl { place: None, turn, reach };
    let model = |density| guide(GuideSpec { density: Some(density), ..GuideSpec::default() });
    let voxel = |side| guide(GuideSpec { voxel: Voxel(side), ..GuideSpec::default() });
    for style in [
        length(0.0),
        length(-0.1),
        length(f64::NAN),
        length(11.0),
        Style { density: ScalpField::Constant(-1.0), ..small() },
        Style { tilt: Some(ScalpField::Constant(110.0)), ..small() },
        Style { hairs: Some(0), ..small() },
        Style { hairs: Some(usize::MAX), ..small() },
        Style { guides: 0, ..small() },
        Style { guides: usize::MAX, ..small() },
        Style { pre_guides: f64::NAN, ..small() },
        Style { pre_guides: -1.0, ..small() },
        Style { dips: [0.1, 1.5], ..small() },
        Style { flow: whorl(f64::INFINITY, 0.04), ..small() },
        Style { flow: whorl(0.0, 0.0), ..small() },
        Style { flow: FlowSpec::Angle(ScalpField::Constant(f64::NAN)), ..small() },
        Style { hair: shell(0.0), ..small() },
        Style { hair: shell(f64::NAN), ..small() },
        Style { strands: HairOptions { segments: 0, ..HairOptions::default() }, ..small() },
        guide(GuideSpec {
            options: GuideOptions { batch: 0, ..GuideOptions::default() },
            ..GuideSpec::default()
        }),
        model(DensityModel::Binary { radius: 0.0 }),
        model(DensityModel::Binary { radius: 1e9 }),
        model(DensityModel::Continuous { most: f64::NAN }),
        voxel(0.0),
        voxel(1e-9),
        volume(HairVolume { tufts: u32::MAX, ..HairVolume::TUFTS }),
        volume(HairVolume { opening: f64::NAN, ..HairVolume::BOB }),
        volume(HairVolume { hem: Some(0.1), ..HairVolume::BOB }),
        fit(FitOptions { meters_per_unit: Some(f64::NAN), ..usual }),
        fit(FitOptions { sectors: u32::MAX, ..usual }),
        fit(FitOptions { rings: 0, ..usual }),
        fit(FitOptions { margin: -1.0, ..usual }),
    ] {
        let error = style.check().expect_err("out of range");
        let (words, again) =
            (error.to_string(), style.grow(&|_| panic!("no file is read"), &|_| {}));
        assert_eq!(again.expect_err("refused").to_string(), words);
        assert!(["must be", "give", "meters"].iter().any(|w| words.contains(w)), "{words}");
    }
    small().check().expect("in range");
    Style::default().check().expect("in range");
}
