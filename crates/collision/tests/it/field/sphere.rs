//! The error of the interpolant on a sphere is bounded by `h² / (4 R)`.

use crate::geometry::random::Random;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{Ball, DistanceField, Grid, GridFrame, LevelSet, Sample};

const RADIUS: f64 = 0.05;
const BAND: f64 = 4e-3;

fn ball() -> Ball {
    Ball { center: Point3::new(1e-3, 2e-3, -3e-3), radius: RADIUS }
}

fn grid(spacing: f64) -> Grid {
    let corner = Vector3::repeat(0.06);
    let center = ball().center;
    let frame = GridFrame::new(center - corner, center + corner, spacing).expect("a lattice");
    Grid::sample(&ball(), frame, BAND).expect("a grid").smooth(RADIUS - BAND)
}

/// A point within the valid band of the ball.
fn point(random: &mut Random, grid: &Grid) -> Point3<f64> {
    let depth = random.range(-1.0, 1.0) * grid.band();
    ball().center + (RADIUS + depth) * random.unit_vector()
}

#[test]
fn the_error_is_within_the_bound_of_a_smooth_surface() {
    for spacing in [0.14 / 127.0, 0.7e-3] {
        let grid = grid(spacing);
        let mut random = Random::new(1);
        let mut worst: f64 = 0.0;
        for _ in 0..200_000 {
            let p = point(&mut random, &grid);
            let Sample { value, gradient } = grid.sample(&p);
            let exact = ball().sample(&p);
            worst = worst.max((value - exact.value).abs());
            // The derivative of a linear interpolant is off by half a spacing times the curvature.
            let steepest = 0.5 * 3.0_f64.sqrt() * spacing / (RADIUS - BAND);
            assert!((gradient - exact.gradient).norm() <= 1.5 * steepest);
        }
        let bound = spacing * spacing / (4.0 * (RADIUS - BAND));
        println!("spacing {spacing:e}: error {worst:e}, bound {bound:e}");
        assert!(worst <= 1.001 * bound && worst >= 0.8 * bound, "{worst:e} for {bound:e}");
        assert!(worst <= grid.error());
        assert!((1.0..1.02).contains(&grid.lipschitz()));
    }
}

#[test]
fn samples_one_by_one_and_at_once_are_the_same_bits() {
    let grid = grid(1e-3);
    let mut random = Random::new(2);
    let mut points: Vec<_> = (0..1000).map(|_| random.point(0.08)).collect();
    points.extend((0..100).map(|_| point(&mut random, &grid)));
    let mut samples = vec![Sample { value: 0.0, gradient: Vector3::zeros() }; points.len()];
    grid.samples(&points, &mut samples);
    for (point, sample) in points.iter().zip(samples) {
        assert_eq!(sample, grid.sample(point));
    }
}

/// Far away the value is clipped, but has the right sign, and nowhere exceeds the distance.
#[test]
fn beyond_the_band_the_value_is_a_bound() {
    let grid = grid(1e-3);
    let mut random = Random::new(3);
    for _ in 0..100_000 {
        let (p, step) = (random.point(0.15), random.vector(1e-2));
        let (value, exact) = (grid.value(&p), ball().value(&p));
        if exact.abs() > grid.band() + grid.error() {
            assert_eq!(value.is_sign_negative(), exact.is_sign_negative());
            assert!(value.abs() >= grid.band());
        }
        assert!(value.abs() <= exact.abs() + grid.error() + 1e-12);
        let change = (grid.value(&(p + step)) - value).abs();
        assert!(change <= grid.lipschitz() * step.norm() + 1e-9);
    }
    assert!(grid.value(&ball().center) < 0.0);
}

#[test]
fn what_is_no_number_gives_a_number() {
    let grid = grid(1e-3);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for p in [Point3::new(bad, 0.0, 0.0), Point3::new(0.0, 0.0, bad)] {
            let Sample { value, gradient } = grid.sample(&p);
            assert!(!value.is_nan() && gradient.norm().is_finite());
        }
    }
}

#[test]
fn few_blocks_are_stored() {
    let grid = grid(1e-3);
    let [stored, all] = grid.blocks();
    // A shell of four radii of the sphere holds them.
    assert!(stored < all / 2 && stored > all / 8, "{stored} of {all}");
    println!("{stored} of {all} blocks, {} bytes", grid.bytes());
}

#[test]
fn a_level_set_is_a_surface() {
    let grid = LevelSet { field: grid(1e-3), level: 2e-3 };
    let p = ball().center + (RADIUS + 2e-3) * Vector3::x();
    assert!(grid.value(&p).abs() <= grid.error());
}

#[test]
fn a_box_that_does_not_hold_the_surface_is_refused() {
    let corner = Vector3::repeat(0.053);
    let frame = GridFrame::new((-corner).into(), corner.into(), 1e-3).expect("a lattice");
    assert!(Grid::sample(&ball(), frame, BAND).is_err());
    let p = Point3::origin();
    for (low, high, spacing) in [
        (p, p, 1.0),
        (p, Point3::new(1.0, 1.0, f64::NAN), 1.0),
        (p, Point3::new(1.0, 1.0, 1.0), 0.0),
        (p, Point3::new(1.0, 1.0, 1.0), 1e-4),
    ] {
        assert!(GridFrame::new(low, high, spacing).is_err());
    }
}
