//! Guides between two balls.

use crate::balls::{BALLS, HEAD, pores, pre_guides};
use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;
use rapunzel_collision::field::Ball;
use rapunzel_hairgen::thesis::simplex_guides;
use rapunzel_hairgen::{
    DensityModel, GuideHairs, GuideOptions, GuideWeights, HairDensity, HairgenError, Pore, Region,
    VoxelFrame, dips_by_height, grow_pre_guides, place_guides,
};

fn options() -> GuideOptions {
    GuideOptions { segments: 30, ..GuideOptions::default() }
}

/// On 200 pores the quasi-Newton method goes as low as the simplex method, which searches without
/// derivatives, to where both stop, in about a fiftieth of its equilibria.
#[test]
fn the_optimum_is_as_low_as_without_derivatives() {
    let options = GuideOptions { tolerance: 2.5e-8, ..options() };
    let (pre, pores) = (pre_guides(1.2, 0.08, &options), pores(200, 1.2, 0.08));
    let hairs = place_guides(&pores, &pre, BALLS, None, &options).expect("guides");
    assert!(hairs.without_place.is_empty(), "{:?}", hairs.without_place);
    let simplex = simplex_guides(&pores, &pre, BALLS, None, &options, 4000).expect("guides");
    let (mut own, mut other, mut worst) = (0, 0, 0.0_f64);
    for guide in &hairs.guides {
        let searched = simplex[guide.pore].expect("an equilibrium");
        own += guide.equilibria;
        other += searched.equilibria;
        worst = worst.max(guide.value / searched.value - 1.0);
        assert!(guide.equilibria <= options.equilibria);
    }
    assert!(worst < 1e-4, "{worst:e}");
    assert!(45 * own < other, "{own} {other}");
}

/// All of a pre-guide is as deep as asked for, and none in the head; forces push toward it.
#[test]
fn pre_guides_dip_below_the_hull() {
    let options = options();
    let pores = pores(300, 1.2, 0.08);
    let heights: Vec<f64> = pores.iter().map(|pore| pore.position.y).collect();
    let dips = dips_by_height(&heights, 0.1, 0.6);
    let pre = grow_pre_guides(&pores, &dips, BALLS, &options).expect("pre-guides");
    for ((guide, pore), dip) in pre.iter().zip(&pores).zip(&dips) {
        assert!(guide.placed, "{pore:?}");
        let deep = guide.shape.positions()[1..].iter().map(|point| {
            let [inside, outside] = BALLS.depths(point);
            assert!(inside <= 0.0, "{point}");
            outside / (inside + outside)
        });
        let least = deep.fold(1.0, f64::min);
        assert!(least >= dip - 1e-12, "{least} {dip}");
        assert!(guide.load.force.dot(&pore.normal) < 0.0 && guide.load.couple.norm() == 0.0);
        assert!(guide.load.force.dot(&pore.direction).abs() < 1e-12 * guide.load.force.norm());
    }
    assert_eq!(dips_by_height(&[1.0, 3.0, 2.0], 0.2, 0.4), [0.4, 0.2, 0.30000000000000004]);
    assert_eq!(dips_by_height(&[2.0, 2.0], 0.2, 0.4), [0.2, 0.2]);
}

/// With a density too, the guides are the same to the last bit on any number of threads.
#[test]
fn guides_do_not_depend_on_the_threads() {
    let options = GuideOptions { segments: 12, batch: 16, ..options() };
    let (pre, pores) = (pre_guides(1.0, 0.07, &options), pores(60, 1.0, 0.07));
    let corner = Point3::new(0.13, 0.13, 0.13);
    let frame = VoxelFrame::new(-corner, corner, 0.004).expect("voxels");
    let laid = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut density = HairDensity::new(frame, DensityModel::Continuous { most: 0.1 });
        let hairs = pool.install(|| {
            place_guides(&pores, &pre, BALLS, Some(&mut density), &options).expect("guides")
        });
        (hairs.guides.into_iter().map(|guide| guide.curve).collect::<Vec<_>>(), density)
    };
    assert_eq!(laid(1), laid(3));
}

fn one(pore: Pore, region: Region<'_>, options: &GuideOptions) -> Result<GuideHairs, HairgenError> {
    let pre = grow_pre_guides(&[pore], &[0.3], region, options)?;
    place_guides(&[pore], &pre, region, None, options)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any direction, also along the scalp, along its normal and into the head, any length and any
    /// gap to the hull, also none: a guide lies in the region, or its pore is told.
    #[test]
    fn a_guide_lies_in_the_region_or_is_told(
        direction in prop::array::uniform3(prop_oneof![Just(0.0), -1.0..1.0_f64]),
        length in prop_oneof![0.005..0.02_f64, 0.05..0.5_f64],
        gap in prop_oneof![Just(0.0), 0.0..0.03_f64],
    ) {
        let options = GuideOptions { segments: 16, ..options() };
        let hull = Ball { radius: HEAD.radius + gap, ..HEAD };
        let region = Region { head: &HEAD, hull: &hull };
        let direction = Unit::try_new(Vector3::from(direction), 1e-3).unwrap_or(Vector3::y_axis());
        let position = Point3::new(0.0, HEAD.radius, 0.0);
        let normal = Vector3::y_axis();
        let pore = Pore { position, normal, direction, length, ..pores(1, 0.0, 1.0)[0] };
        let hairs = one(pore, region, &options).expect("a valid pore");
        prop_assert_eq!(hairs.guides.len() + hairs.without_place.len(), 1);
        for guide in hairs.guides {
            let left: f64 = guide.curve.windows(2).map(|e| (e[1] - e[0]).norm()).sum();
            prop_assert!(left >= options.least * length && left <= length + 1e-12);
            for point in &guide.curve[1..] {
                prop_assert!(region.depths(point)[0] <= 1e-15, "{point}");
            }
            prop_assert!(guide.value.is_finite() && guide.value >= 0.0);
        }
    }
}

/// A hair that is longer than the hull allows is cut at the hull; one in no gap finds no place.
#[test]
fn what_is_too_long_is_cut_and_what_has_no_place_is_told() {
    let options = options();
    let pore = Pore { direction: Vector3::y_axis(), length: 0.3, ..pores(1, 0.0, 1.0)[0] };
    let pore = Pore { position: Point3::new(0.0, HEAD.radius, 0.0), ..pore };
    let weights = GuideWeights { direction: 1.0, curvature: 0.0, boundary: 0.0, density: 0.0 };
    let options = GuideOptions { weights, least: 0.05, ..options };
    // Straight out of both balls, for the walls do not count.
    let far = Ball { radius: 1.0, ..HEAD };
    let pre = grow_pre_guides(&[pore], &[0.0], Region { head: &HEAD, hull: &far }, &options);
    let hairs = place_guides(&[pore], &pre.expect("a pre-guide"), BALLS, None, &options);
    let hairs = hairs.expect("a guide");
    let tip = hairs.guides[0].curve[hairs.guides[0].curve.len() - 1];
    assert!((tip.coords.norm() - 0.115).abs() < 1e-4, "{tip}");
    let none = Region { head: &HEAD, hull: &HEAD };
    let hairs = one(pore, none, &options).expect("no guide");
    assert_eq!((hairs.guides.len(), hairs.without_place), (0, vec![0]));
}

#[test]
fn what_is_wrong_is_refused() {
    let (options, pore) = (options(), pores(1, 1.0, 0.05)[0]);
    let bad = [
        Pore { length: 0.0, ..pore },
        Pore { length: f64::NAN, ..pore },
        Pore { position: Point3::new(0.0, f64::INFINITY, 0.0), ..pore },
        Pore { direction: Unit::new_unchecked(Vector3::zeros()), ..pore },
    ];
    for pore in bad {
        let refused = one(pore, BALLS, &options);
        assert!(matches!(refused, Err(HairgenError::Pore { pore: 0, .. })), "{refused:?}");
    }
    let no_weights = GuideWeights { direction: 0.0, curvature: 0.0, boundary: 0.0, density: 0.0 };
    let wrong = [
        GuideOptions { segments: 0, ..options },
        GuideOptions { torsion: 0.0, ..options },
        GuideOptions { margin: f64::NAN, ..options },
        GuideOptions { batch: 0, ..options },
        GuideOptions { least: 2.0, ..options },
        GuideOptions { weights: no_weights, ..options },
        GuideOptions { weights: GuideWeights { density: -0.1, ..no_weights }, ..options },
    ];
    for options in wrong {
        assert!(matches!(one(pore, BALLS, &options), Err(HairgenError::Choice { .. })));
    }
    let dips = grow_pre_guides(&[pore], &[0.1, 0.2], BALLS, &options);
    assert!(matches!(dips, Err(HairgenError::Count { given: 2, wanted: 1, .. })));
    let dip = grow_pre_guides(&[pore], &[1.5], BALLS, &options);
    assert!(matches!(dip, Err(HairgenError::Choice { .. })));
    let none = place_guides(&[pore], &[], BALLS, None, &options);
    assert!(matches!(none, Err(HairgenError::Nothing { what: "pre-guides", .. })));
    let weights = GuideWeights { direction: 3.0, curvature: 1.0, boundary: 4.0, density: 0.0 };
    assert_eq!(weights.normalized(), Ok([0.375, 0.125, 0.5, 0.0]));
}
