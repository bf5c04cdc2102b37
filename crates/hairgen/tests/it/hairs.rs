//! Cuts, wisps, hairs between guides, and how evenly they fill the region.

use crate::balls::{BALLS, HEAD, HULL, pores, pre_guides, sideways};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::field::{Ball, HalfSpace};
use rapunzel_hairgen::{
    DensityHistogram, DensityModel, GuideHair, GuideOptions, GuideWeights, HairCurves, HairDensity,
    HairOptions, HairPattern, HairReport, HairgenError, Pore, Region, VoxelFrame, cut, grow_hairs,
    grow_pre_guides, place_guides,
};

fn straight(from: Point3<f64>, to: Point3<f64>, segments: usize) -> Vec<Point3<f64>> {
    let at = |i: usize| from + (to - from) * (i as f64 / segments as f64);
    (0..=segments).map(at).collect()
}

fn length(points: &[Point3<f64>]) -> f64 {
    points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
}

/// Planes are met where they are, exactly: fields are linear.
#[test]
fn a_hair_is_cut_where_it_leaves() {
    let plane =
        |height: f64| HalfSpace { point: Point3::new(0.0, height, 0.0), normal: Vector3::y_axis() };
    let (head, hull) = (plane(0.0), plane(0.1));
    let region = Region { head: &head, hull: &hull };
    let up = straight(Point3::origin(), Point3::new(0.0, 0.13, 0.0), 13);
    // Out for 3 cm: cut at 10 cm unless that is tolerated.
    let kept = cut(&up, region, 0.01);
    assert!((length(&kept) - 0.1).abs() < 1e-12, "{kept:?}");
    assert_eq!(cut(&up, region, 0.04), up);
    // Out for 2 cm and back again, then into the head.
    let tip = Point3::new(0.08, 0.11, 0.0);
    let mut way = straight(Point3::origin(), tip, 9);
    way.extend(straight(tip, Point3::new(0.16, -0.02, 0.0), 11).drain(1..));
    let out = (0.01 / 0.11) * (tip - Point3::origin()).norm()
        + (0.01 / 0.13) * Vector3::new(0.08, -0.13, 0.0).norm();
    let short = cut(&way, region, 0.999 * out);
    assert!((short[short.len() - 1].y - 0.1).abs() < 1e-12 && length(&short) < 0.13, "{short:?}");
    let long = cut(&way, region, 1.001 * out);
    assert!(long[long.len() - 1].y.abs() < 1e-12 && long.len() > short.len(), "{long:?}");
    // Down into the head at once, and nothing to cut.
    let down = straight(Point3::origin(), Point3::new(0.0, -0.1, 0.0), 5);
    assert_eq!(cut(&down, region, 0.01), [Point3::origin()]);
    assert!(cut(&[], region, 0.01).is_empty());
}

proptest! {
    /// What is kept is a part of the way, and only its end is new.
    #[test]
    fn a_cut_keeps_the_way(
        steps in prop::collection::vec(prop::array::uniform3(-0.02..0.02_f64), 1..30),
        outside in prop_oneof![Just(0.0), 0.0..0.05_f64],
        gap in prop_oneof![Just(0.0), 0.0..0.03_f64],
    ) {
        let hull = Ball { radius: HEAD.radius + gap, ..HEAD };
        let region = Region { head: &HEAD, hull: &hull };
        let mut way = vec![Point3::new(0.0, HEAD.radius, 0.0)];
        for step in steps {
            way.push(way[way.len() - 1] + Vector3::from(step));
        }
        let kept = cut(&way, region, outside);
        prop_assert!(!kept.is_empty() && length(&kept) <= length(&way) + 1e-12);
        let same = kept.iter().zip(&way).take_while(|(a, b)| a == b).count();
        prop_assert!(same + 1 >= kept.len());
        let lowest = kept[1..].iter().map(|point| point.coords.norm()).fold(1.0, f64::min);
        // A chord between two crossings of the way sags by less than its length squared over 8 R.
        prop_assert!(lowest >= HEAD.radius - 2e-3, "{lowest}");
    }
}

/// Guides of a round style.
fn guides(count: usize) -> (Vec<Pore>, Vec<GuideHair>) {
    let options = GuideOptions { segments: 30, ..GuideOptions::default() };
    let (pre, pores) = (pre_guides(1.2, 0.08, &options), pores(count, 1.2, 0.08));
    let hairs = place_guides(&pores, &pre, BALLS, None, &options).expect("guides");
    (pores, hairs.guides)
}

fn hairs(pattern: HairPattern, pores: &[Pore], own: &[Pore], guides: &[GuideHair]) -> HairCurves {
    let options = HairOptions { pattern, ..HairOptions::default() };
    grow_hairs(pores, guides, own, BALLS, &options).expect("hairs")
}

/// None in the head, none far outside of the hull, segments of one length, roots in their pores.
#[test]
fn hairs_stay_in_the_region() {
    let (own, guides) = guides(150);
    let pores = pores(4000, 1.2, 0.075);
    for pattern in [
        HairPattern::Wisps { tip: 0.3, turns: 0.0 },
        HairPattern::Wisps { tip: 1.0, turns: 3.0 },
        HairPattern::Between,
    ] {
        let curves = hairs(pattern, &pores, &own, &guides);
        assert_eq!(curves.count(), pores.len());
        let report = HairReport::of(&curves, BALLS, 1e-3);
        assert_eq!(report.in_head, 0, "{pattern:?}: {report:?}");
        assert!(report.outside <= 1e-3 * report.length, "{pattern:?}: {report:?}");
        assert!(report.without_place.is_empty(), "{pattern:?}: {report:?}");
        for (curve, pore) in curves.iter().zip(&pores) {
            assert_eq!(curve[0], pore.position);
            let sizes: Vec<f64> = curve.windows(2).map(|e| (e[1] - e[0]).norm()).collect();
            // All but the last, which may be cut.
            for size in &sizes[..sizes.len() - 1] {
                assert!((size - sizes[0]).abs() < 1e-12, "{pattern:?}: {sizes:?}");
            }
            assert!(length(curve) <= pore.length + 1e-12);
        }
    }
}

/// A hair in the pore of a guide is the guide; a wisp with a tip of no size meets its guide's tip.
#[test]
fn hairs_follow_their_guides() {
    let (own, guides) = guides(60);
    let roots: Vec<Pore> = guides.iter().map(|guide| own[guide.pore]).collect();
    let wisps = HairPattern::Wisps { tip: 0.0, turns: 1.0 };
    let free = Region { head: &Ball { radius: 0.0, ..HEAD }, hull: &Ball { radius: 1.0, ..HULL } };
    for pattern in [wisps, HairPattern::Between] {
        let options = HairOptions { pattern, clearance: 0.0, ..HairOptions::default() };
        let curves = grow_hairs(&roots, &guides, &own, free, &options).expect("hairs");
        for (curve, guide) in curves.iter().zip(&guides) {
            let [tip, end] = [curve[curve.len() - 1], guide.curve[guide.curve.len() - 1]];
            // Resampled twice in segments of 1.6 mm, that bend within a centimeter.
            assert!((tip - end).norm() < 1e-4, "{pattern:?}: {tip} {end}");
        }
    }
    let pores = pores(500, 1.2, 1.0);
    let options = HairOptions { pattern: wisps, clearance: 0.0, ..HairOptions::default() };
    let curves = grow_hairs(&pores, &guides, &own, free, &options).expect("hairs");
    for curve in curves.iter() {
        let tip = curve[curve.len() - 1];
        let near = guides.iter().map(|guide| (guide.curve[guide.curve.len() - 1] - tip).norm());
        assert!(near.fold(1.0, f64::min) < 3e-3, "{tip}");
    }
}

/// Fig. 5.6: where hair flows together, it is spread more evenly with either density model than
/// without. The layers closest to the head cannot be left, so only a part can be evened out.
#[test]
fn density_models_even_out_the_hair() {
    let weights = GuideWeights { density: 1.0, ..GuideWeights::default() };
    let options = GuideOptions { segments: 30, weights, ..GuideOptions::default() };
    let grow = |count: usize| sideways(count, 1.2, 0.08);
    let pre = grow_pre_guides(&grow(300), &[0.3; 300], BALLS, &options).expect("pre-guides");
    let own = grow(400);
    let corner = Point3::new(0.13, 0.13, 0.13);
    let voxels = |spacing| VoxelFrame::new(-corner, corner, spacing).expect("voxels");
    let gini = |model: Option<(DensityModel, f64)>| {
        let mut density = model.map(|(model, spacing)| HairDensity::new(voxels(spacing), model));
        let laid = place_guides(&own, &pre, BALLS, density.as_mut(), &options).expect("guides");
        let pattern = HairPattern::Wisps { tip: 0.3, turns: 0.0 };
        let curves = hairs(pattern, &grow(6000), &own, &laid.guides);
        let crossings = density.map(|density| {
            laid.guides.iter().map(|guide| density.crossings(&guide.curve)).sum::<usize>()
        });
        // All segments of laid guides cross voxels that they have filled.
        assert!(crossings.is_none_or(|count| count >= 29 * laid.guides.len()), "{crossings:?}");
        DensityHistogram::of(curves.iter(), BALLS, voxels(0.004)).gini()
    };
    let none = gini(None);
    let binary = gini(Some((DensityModel::Binary { radius: 0.003 }, 0.002)));
    let continuous = gini(Some((DensityModel::Continuous { most: 0.1 }, 0.004)));
    assert!(binary < 0.993 * none && continuous < 0.985 * none, "{none} {binary} {continuous}");
}

#[test]
fn what_cannot_be_laid_is_told() {
    let options = HairOptions::default();
    let (own, guides) = guides(10);
    let none = grow_hairs(&own, &[], &own, BALLS, &options);
    assert!(matches!(none, Err(HairgenError::Nothing { what: "guides", .. })));
    let few = grow_hairs(&own, &guides, &own[..2], BALLS, &options);
    assert!(matches!(few, Err(HairgenError::Pore { pore: 2, .. })), "{few:?}");
    let nan = Pore { length: f64::NAN, ..own[0] };
    let bad = grow_hairs(&[own[0], nan], &guides, &own, BALLS, &options);
    assert!(matches!(bad, Err(HairgenError::Pore { pore: 1, .. })), "{bad:?}");
    let pattern = HairPattern::Wisps { tip: -1.0, turns: 0.0 };
    let tip = grow_hairs(&own, &guides, &own, BALLS, &HairOptions { pattern, ..options });
    assert!(matches!(tip, Err(HairgenError::Choice { .. })), "{tip:?}");
    let bald = Pore { length: 0.0, ..own[0] };
    let curves = grow_hairs(&[bald], &guides, &own, BALLS, &options).expect("hairs");
    assert_eq!(HairReport::of(&curves, BALLS, 0.0).without_place, [0]);
    for frame in [
        VoxelFrame::new(Point3::origin(), Point3::origin(), 0.1),
        VoxelFrame::new(Point3::origin(), Point3::new(1.0, 1.0, 1.0), 0.0),
        VoxelFrame::new(Point3::origin(), Point3::new(1.0, 1.0, 1.0), 1e-4),
        VoxelFrame::new(Point3::origin(), Point3::new(1.0, 1.0, f64::NAN), 0.1),
    ] {
        assert!(matches!(frame, Err(HairgenError::Voxels { .. })), "{frame:?}");
    }
}
