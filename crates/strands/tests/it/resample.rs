//! Points at equal arc lengths.

use crate::common::{files, frame, read};
use nalgebra::Point3;
use proptest::prelude::*;
use rapunzel_strands::StrandsError;
use std::f64::consts::PI;
use std::fmt::Write;

/// An OBJ of one line through these points.
fn line(points: impl IntoIterator<Item = [f64; 3]>) -> rapunzel_strands::StrandSet {
    let mut text = String::new();
    let mut count = 0;
    for [x, y, z] in points {
        count += 1;
        writeln!(text, "v {x} {y} {z}").expect("memory");
    }
    text += "l";
    (1..=count).for_each(|k| write!(text, " {k}").expect("memory"));
    read(text.as_bytes()).strands
}

#[test]
fn a_straight_line_is_divided_exactly() {
    let set = line([[0.0; 3], [0.1, 0.0, 0.0], [0.7, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    let out = set.resampled(4).expect("segments");
    for (k, point) in out.strands.strand(0).iter().enumerate() {
        assert!((point - Point3::new(0.25 * k as f64, 0.0, 0.0)).norm() < 1e-15);
    }
    assert!(out.error < 1e-15 && out.shortening.abs() < 1e-15);
}

/// A corner of two sides of 1 m in three segments: the chord over the corner leaves out the corner
/// of a square of a third on a side.
#[test]
fn a_corner_is_cut_by_what_is_said() {
    let set = line([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    let out = set.resampled(3).expect("segments");
    let third = 1.0 / 3.0;
    assert!((out.error - third / 2.0_f64.sqrt()).abs() < 1e-15);
    let length = 4.0 * third + third * 2.0_f64.sqrt();
    assert!((out.shortening - (1.0 - length / 2.0)).abs() < 1e-15);
    assert!(out.strands.strand(0)[1] == Point3::new(2.0 * third, 0.0, 0.0));
}

/// An arc of radius 1 over 1 rad as 1000 chords: with chords over an angle h the sagitta is
/// 1 - cos(h / 2), and the lost length 1 - sin(h / 2) / (h / 2).
#[test]
fn an_arc_is_resampled_to_a_tolerance() {
    let set = line((0..=1000).map(|k| {
        let angle = f64::from(k) / 1000.0;
        [angle.cos(), angle.sin(), 0.0]
    }));
    let out = set.resampled(10).expect("segments");
    let half = 0.05_f64;
    assert!((out.error / (1.0 - half.cos()) - 1.0).abs() < 1e-3);
    assert!((out.shortening / (1.0 - half.sin() / half) - 1.0).abs() < 1e-3);
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let out = set.resampled_within(tolerance, 1000).expect("enough");
        let segments = out.strands.strand(0).len() - 1;
        assert!(out.error <= tolerance);
        // Fewer by an eighth or by one would be too few.
        let fewer = (segments * 8 / 9).min(segments - 1);
        assert!(1.0 - (0.5 / fewer as f64).cos() > 0.98 * tolerance, "{segments}");
    }
    let error = set.resampled_within(1e-5, 10).expect_err("not enough");
    assert!(matches!(error, StrandsError::Tolerance { most: 10, strand: 0, .. }), "{error}");
}

#[test]
fn what_folds_back_is_told_and_passed_over() {
    let set = line([[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]]);
    assert_eq!(set.resampled(1), Err(StrandsError::Fold { strand: 0, segments: 1 }));
    let out = set.resampled_within(0.01, 100).expect("two segments");
    assert_eq!(out.strands.strand(0).len(), 3);
    for tolerance in [0.0, f64::NAN] {
        assert!(set.resampled_within(tolerance, 9).is_err());
    }
    assert!(set.resampled(0).is_err() && set.resampled_within(1.0, 0).is_err());
}

proptest! {
    /// Ends stay, segments are no longer than their share, and any point of either polyline is
    /// within the stated error of the other.
    #[test]
    fn both_polylines_are_within_the_error(frame in frame(), segments in 1..60_usize) {
        let set = read(&files(&frame)[0].2).strands;
        let out = set.resampled(segments).expect("no folds");
        prop_assert_eq!(out.strands.sources(), set.sources());
        for k in 0..set.len() {
            let (old, new) = (set.strand(k), out.strands.strand(k));
            prop_assert_eq!(new.len(), segments + 1);
            prop_assert_eq!([old[0], old[old.len() - 1]], [new[0], new[segments]]);
            let share = set.length(k) / segments as f64;
            prop_assert!(new.windows(2).all(|p| (p[1] - p[0]).norm() <= share * (1.0 + 1e-9)));
            prop_assert!(out.strands.length(k) >= (1.0 - out.shortening - 1e-12) * set.length(k));
            prop_assert!(apart(old, new) <= out.error + 1e-12);
            prop_assert!(apart(new, old) <= out.error + 1e-12);
        }
        let radii = set.radii().expect("radii");
        let range = |r: &[f64]| {
            r.iter().fold([f64::INFINITY, 0.0_f64], |[a, b], x| [a.min(*x), b.max(*x)])
        };
        let [low, high] = range(out.strands.radii().expect("radii"));
        prop_assert!(low >= range(radii)[0] * (1.0 - 1e-12) && high <= range(radii)[1] * (1.0 + 1e-12));
    }
}

/// Largest distance of points on a polyline, eight for each segment, from another one.
fn apart(one: &[Point3<f64>], other: &[Point3<f64>]) -> f64 {
    let on =
        one.windows(2).flat_map(|p| (0..=8).map(|k| p[0] + f64::from(k) / 8.0 * (p[1] - p[0])));
    on.map(|point| {
        let near = other.windows(2).map(|ends| {
            let side = ends[1] - ends[0];
            let t = (side.dot(&(point - ends[0])) / side.norm_squared()).clamp(0.0, 1.0);
            (point - (ends[0] + t * side)).norm()
        });
        near.fold(f64::INFINITY, f64::min)
    })
    .fold(0.0, f64::max)
}

/// A helix of radius r and pitch 2 pi p has the curvature r / (r² + p²); its chords over an arc h
/// are off by about h² / 8 of that.
#[test]
fn a_curl_keeps_the_error_of_theory() {
    let (radius, pitch) = (0.01, 0.02 / (2.0 * PI));
    let set = line((0..=4000).map(|k| {
        let t = 8.0 * PI * f64::from(k) / 4000.0;
        [radius * t.cos(), pitch * t, radius * t.sin()]
    }));
    let out = set.resampled(200).expect("segments");
    let step = set.length(0) / 200.0;
    let expected = radius / (radius * radius + pitch * pitch) * step * step / 8.0;
    assert!((out.error / expected - 1.0).abs() < 0.02, "{} of {expected}", out.error);
}
