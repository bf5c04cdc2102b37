//! The map to the unit disc.

use super::{SCALPS, cap, cloth, flat, mesh, scan, spread};
use nalgebra::{Matrix2, Matrix3x2, Point2, Vector3};
use proptest::prelude::*;
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::growth::{ConvexWeights, DiscMap, HeadAxes, ScalpMesh, convex_map};
use std::f64::consts::{FRAC_PI_2, PI};

const BOTH: [ConvexWeights; 2] = [ConvexWeights::ShapePreserving, ConvexWeights::MeanValue];

fn map(scalp: &ScalpMesh, weights: ConvexWeights) -> DiscMap {
    DiscMap::new(scalp, weights, &HeadAxes::default()).expect("a map")
}

/// One-to-one: no triangle is turned over, and all together are the polygon of the border.
fn check_one_to_one(scalp: &ScalpMesh, map: &DiscMap) {
    let twice = |[u, v, w]: [Point2<f64>; 3]| (v - u).perp(&(w - u));
    let areas: Vec<f64> =
        (0..).take(scalp.triangles().len()).map(|face| twice(map.corners(face))).collect();
    assert!(areas.iter().all(|area| *area > 0.0));
    let border: Vec<_> = scalp.border().iter().map(|&v| map.places()[v as usize]).collect();
    assert!(border.iter().all(|p| (p.coords.norm() - 1.0).abs() < 1e-15));
    let ends = border.iter().zip(border.iter().cycle().skip(1));
    let polygon: f64 = ends.map(|(a, b)| a.coords.perp(&b.coords)).sum();
    assert!((areas.iter().sum::<f64>() - polygon).abs() < 1e-12 * areas.len() as f64);
    assert!(map.places().iter().all(|p| p.coords.norm() < 1.0 + 1e-15));
}

/// The stretch of the whole from singular values.
fn stretch(scalp: &ScalpMesh, places: &[Point2<f64>]) -> f64 {
    let (mut squares, mut plane) = (0.0, 0.0);
    for (face, triangle) in (0..).zip(scalp.triangles()) {
        let [a, b, c] = scalp.corners(face);
        let [u, v, w] = triangle.map(|v| places[v as usize]);
        let flat = Matrix2::from_columns(&[v - u, w - u]);
        plane += 0.5 * flat.determinant();
        let affine =
            Matrix3x2::from_columns(&[b - a, c - a]) * flat.try_inverse().expect("regular");
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        squares += area * 0.5 * affine.singular_values().norm_squared();
    }
    (plane * squares).sqrt() / scalp.area()
}

fn check_relaxed(scalp: &ScalpMesh, map: &DiscMap) {
    let history = map.stretch_history();
    assert!(history.windows(2).all(|two| two[1] < two[0]), "{history:?}");
    let last = history[history.len() - 1];
    let expected = stretch(scalp, map.places());
    assert!((last / expected - 1.0).abs() < 1e-9, "{last} for {expected}");
}

/// Points of the surface to the disc and back, and places of the disc to the surface and back.
fn check_round_trip(scalp: &ScalpMesh, map: &DiscMap, points: usize) {
    let count = scalp.triangles().len();
    for k in 0..points {
        let random = spread(k);
        // Any point of any face, by way of the nearest of a mix of its corners.
        let [a, b, c] = scalp.corners(u32::try_from(k % count).expect("few"));
        let (u, v) = (random.x, random.y * (1.0 - random.x));
        let point = scalp.nearest(&(a + u * (b - a) + v * (c - a)));
        let place = map.place(&point);
        let back = map.locate(&place);
        let off = (scalp.position(&back) - scalp.position(&point)).norm();
        assert!(off < 1e-9 * scalp.size(), "{off} at {place}");
        let (radius, angle) = (random.x.sqrt(), 2.0 * PI * random.z);
        let place = radius * Point2::new(angle.cos(), angle.sin());
        let off = (map.place(&map.locate(&place)) - place).norm();
        // Between the polygon and the circle by the height of the segment at most.
        let longest = scalp.border().len();
        let height = 1.0 - (PI / longest as f64 * 4.0).min(FRAC_PI_2).cos();
        assert!(off < if radius < 1.0 - height { 1e-12 } else { height }, "{off} at {place}");
    }
}

#[test]
fn scanned_scalps_are_mapped_one_to_one() {
    for name in SCALPS {
        let Some(scalp) = scan(name) else { continue };
        for weights in BOTH {
            let map = map(&scalp, weights);
            check_one_to_one(&scalp, &map);
            check_relaxed(&scalp, &map);
            let history = map.stretch_history();
            println!("{name}, {weights:?}: {} rounds, {history:.4?}", history.len() - 1);
            // Relaxation matters: of what exceeds 1 a third at least is gone.
            assert!(history[history.len() - 1] - 1.0 < 0.67 * (history[0] - 1.0));
            check_round_trip(&scalp, &map, 100_000);
            // From above, face down, left to the right.
            let at = |x: f64, z: f64| {
                let point = scalp.nearest(&nalgebra::Point3::new(x, 0.1, z));
                map.place(&point)
            };
            assert!(at(0.0, 0.2).y < -0.7 && at(0.0, 0.2).x.abs() < 0.05);
            assert!(at(0.2, 0.0).x > 0.5 && at(-0.2, 0.0).x < -0.5);
        }
    }
}

#[test]
fn a_similarity_has_stretch_one_and_stays() {
    for (weights, scale) in BOTH.into_iter().zip([0.1, 3.0]) {
        let mut soup = flat(24, 5);
        soup.vertices.iter_mut().for_each(|p| *p *= scale);
        let scalp = mesh(soup);
        let map = map(&scalp, weights);
        for stretch in map.stretch_history() {
            assert!((stretch - 1.0).abs() < 1e-12, "{stretch}");
        }
        for (p, place) in scalp.vertices().iter().zip(map.places()) {
            // Seen from above: x to the right, z down.
            assert!((place - Point2::new(p.x, -p.z) / scale).norm() < 1e-12);
        }
    }
}

/// The half sphere, whose best radial map is known: where radii are in the proportion of the
/// angles, neither direction is favored much; it is between that and the one of equal area.
#[test]
fn a_half_sphere_is_evened_out() {
    let scalp = mesh(cap(0.1, FRAC_PI_2, 48, 24));
    for weights in BOTH {
        let map = map(&scalp, weights);
        check_one_to_one(&scalp, &map);
        check_relaxed(&scalp, &map);
        check_round_trip(&scalp, &map, 2000);
        let history = map.stretch_history();
        assert!(history[history.len() - 1] < 1.1, "{history:?}");
        // Rings stay rings.
        for ring in map.places()[1..].chunks(48) {
            let radius = ring[0].coords.norm();
            assert!(ring.iter().all(|p| (p.coords.norm() - radius).abs() < 1e-6));
        }
    }
}

#[test]
fn a_border_that_is_not_convex_or_of_another_size_is_refused() {
    let scalp = mesh(flat(12, 3));
    let border: Vec<_> = scalp.border().iter().map(|&v| scalp.vertices()[v as usize]).collect();
    let mut border: Vec<_> = border.iter().map(|p| Point2::new(p.x, -p.z)).collect();
    assert!(convex_map(&scalp, ConvexWeights::MeanValue, &border).is_ok());
    let short = convex_map(&scalp, ConvexWeights::MeanValue, &border[1..]);
    assert_eq!(short.expect_err("refused"), HairgenError::BorderCount { given: 11, needed: 12 });
    // A dent beyond the middle; clockwise; a place that is none.
    border[4] *= -0.3;
    let dented = convex_map(&scalp, ConvexWeights::MeanValue, &border);
    assert!(matches!(dented.expect_err("refused"), HairgenError::Flipped { .. }));
    border.reverse();
    let turned = convex_map(&scalp, ConvexWeights::MeanValue, &border);
    assert!(matches!(turned.expect_err("refused"), HairgenError::Flipped { .. }));
    border[0].x = f64::NAN;
    assert!(convex_map(&scalp, ConvexWeights::MeanValue, &border).is_err());
}

#[test]
fn axes_must_span_a_plane() {
    let (up, front) = (Vector3::new(0.0, 2.0, 0.0), Vector3::new(0.0, 1.0, 0.1));
    let axes = HeadAxes::new(&up, &front).expect("axes");
    assert!((axes.front().into_inner() - Vector3::z()).norm() < 1e-15);
    assert!((axes.left().into_inner() - Vector3::x()).norm() < 1e-15);
    for bad in [up, Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 1.0), -3.0 * up] {
        assert!(HeadAxes::new(&up, &bad).is_err(), "{bad}");
        assert!(HeadAxes::new(&bad, &up).is_err(), "{bad}");
    }
}

/// A tube that is fifty times as deep as wide: its end would be lost in rounding.
#[test]
fn a_spike_is_mapped_or_refused() {
    let rings: Vec<_> = (1..=300).map(|k| [1.0, -0.5 * f64::from(k)]).collect();
    let scalp = mesh(super::bowl(6, &rings));
    match DiscMap::new(&scalp, ConvexWeights::MeanValue, &HeadAxes::default()) {
        Ok(map) => check_one_to_one(&scalp, &map),
        Err(error) => assert!(matches!(error, HairgenError::Flipped { .. }), "{error}"),
    }
}

proptest! {
    #[test]
    fn rough_cloths_are_mapped_one_to_one(cloth in cloth(2.0), preserving: bool) {
        let scalp = mesh(cloth.soup());
        let map = map(&scalp, BOTH[usize::from(preserving)]);
        check_one_to_one(&scalp, &map);
        check_relaxed(&scalp, &map);
        check_round_trip(&scalp, &map, 50);
    }

    /// Linear precision: a flat mesh whose border stays, stays.
    #[test]
    fn flat_cloths_are_reproduced(cloth in cloth(0.0)) {
        let scalp = mesh(cloth.soup());
        let own: Vec<_> = scalp.vertices().iter().map(|p| Point2::new(p.x, -p.z)).collect();
        let border: Vec<_> = scalp.border().iter().map(|&v| own[v as usize]).collect();
        for weights in BOTH {
            let places = convex_map(&scalp, weights, &border).expect("a map");
            for (place, own) in places.iter().zip(&own) {
                prop_assert!((place - own).norm() < 1e-11, "{place} for {own}");
            }
        }
    }
}
