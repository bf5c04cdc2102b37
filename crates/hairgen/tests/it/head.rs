//! The parametric head, its scalp and its surfaces of hair.

use nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;
use rapunzel_collision::field::{DistanceField, Mesh, MeshDistance};
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::head::{HairVolume, Hairline, HeadMeasures, ParametricHead};
use std::collections::BTreeMap;

fn head(measures: HeadMeasures) -> ParametricHead {
    ParametricHead::new(measures, Hairline::default()).expect("a head")
}

#[test]
fn the_head_is_a_solid_of_its_measures() {
    let measures = HeadMeasures { length: 0.180, breadth: 0.144, height: 0.205 };
    let mesh = Mesh::new(head(measures).mesh()).expect("a solid");
    let [low, high] = mesh.bounds();
    // From the occiput to the forehead above the nose, in the plane of symmetry.
    let forehead = head(measures).surface(&Unit::new_normalize(Vector3::new(0.0, 0.25, 1.0)));
    let length = forehead.z - low.z;
    assert!((length - measures.length).abs() < 0.02 * measures.length, "{length} m");
    // Above the ears.
    let side = Unit::new_normalize(Vector3::new(1.0, 0.3, 0.0));
    let breadth = 2.0 * head(measures).surface(&side).x;
    assert!((breadth - measures.breadth).abs() < 0.03 * measures.breadth, "{breadth} m");
    // The chin ends about as far below the vertex as its height tells.
    let chin = head(measures).surface(&Unit::new_normalize(Vector3::new(0.0, -1.0, 0.72)));
    let height = high.y - chin.y;
    assert!((height - measures.height).abs() < 0.05 * measures.height, "{height} m");
}

#[test]
fn the_scalp_is_a_disc_on_the_head() {
    let head = head(HeadMeasures::default());
    let scalp = head.scalp(96, 28).expect("a scalp");
    let mut sides = BTreeMap::new();
    for &[a, b, c] in &scalp.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert!(sides.insert((from, to), ()).is_none(), "an edge in one direction twice");
        }
    }
    let rim = sides.keys().filter(|(a, b)| !sides.contains_key(&(*b, *a))).count();
    let edges = (sides.len() + rim) / 2;
    // V - E + F of a disc.
    assert_eq!(scalp.vertices.len() + scalp.triangles.len() - edges, 1);
    assert_eq!(rim, 96);
    let mesh = Mesh::new(head.mesh()).expect("a solid");
    let distance = MeshDistance::new(&mesh);
    for vertex in &scalp.vertices {
        // The head's triangles of 3.5 mm are chords of a surface with radii of 4 cm or more, but
        // for the fillets of the ears, 9 mm.
        assert!(distance.value(vertex).abs() < 0.5e-3, "{vertex}");
    }
    // Of the data's scalp of a head of this size 580 cm^2 are told, with a hairline of its own.
    let area: f64 = scalp
        .triangles
        .iter()
        .map(|&t| {
            let [a, b, c] = t.map(|v| scalp.vertices[v as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        })
        .sum();
    assert!((0.045..0.075).contains(&area), "{area} m^2");
}

#[test]
fn hair_is_around_the_head() {
    let head = head(HeadMeasures::default());
    for (name, volume) in [
        ("short", HairVolume::SHORT),
        ("bob", HairVolume::BOB),
        ("long", HairVolume::LONG),
        ("afro", HairVolume::AFRO),
        ("tufts", HairVolume::TUFTS),
    ] {
        let hull = Mesh::new(head.hull(&volume).expect("a hull")).expect("a solid");
        let distance = MeshDistance::new(&hull);
        let scalp = head.scalp(48, 16).expect("a scalp");
        let deepest = scalp.vertices.iter().map(|p| -distance.value(p)).fold(0.0, f64::max);
        // Chords of the hull cut off some tenths of a millimeter where it lies on the skin.
        assert!(scalp.vertices.iter().all(|p| distance.value(p) < 0.4e-3), "{name}");
        assert!(deepest > 0.6 * volume.crown.min(volume.sides), "{name}: {deepest} m");
    }
}

#[test]
fn what_is_no_head_is_refused() {
    let flat = HeadMeasures { breadth: 0.0, ..HeadMeasures::default() };
    let refused = ParametricHead::new(flat, Hairline::default()).expect_err("no breadth");
    assert_eq!(refused, HairgenError::Measure { what: "breadth", value: 0.0 });
    let millimeters = HeadMeasures { length: 195.0, ..HeadMeasures::default() };
    let refused = ParametricHead::new(millimeters, Hairline::default()).expect_err("195 m");
    assert!(refused.to_string().contains("give meters"));
    let nothing = HeadMeasures { height: f64::NAN, ..HeadMeasures::default() };
    ParametricHead::new(nothing, Hairline::default()).expect_err("no number");
    let head = head(HeadMeasures::default());
    head.scalp(2, 5).expect_err("no disc");
    head.hull(&HairVolume { crown: f64::NAN, ..HairVolume::BOB }).expect_err("no depth");
    head.hull(&HairVolume { hem: Some(0.2), ..HairVolume::BOB }).expect_err("hangs upward");
    for points in [
        vec![],
        vec![[0.0, 40.0], [180.0, -40.0]],
        vec![[0.0, 40.0], [90.0, 0.0], [90.0, 0.0], [180.0, -40.0]],
        vec![[10.0, 40.0], [90.0, 0.0], [180.0, -40.0]],
        vec![[0.0, 40.0], [90.0, f64::NAN], [180.0, -40.0]],
        vec![[0.0, 80.0], [90.0, 80.0], [180.0, 79.0]],
    ] {
        let refused = Hairline::new(points.clone()).expect_err("no hairline");
        assert!(matches!(refused, HairgenError::Hairline { .. }), "{points:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// The rim runs through the points, and what is nearer to the middle of the scalp is within.
    #[test]
    fn the_rim_runs_through_its_points(heights in prop::array::uniform3(-15.0..15.0_f64)) {
        let points = vec![
            [0.0, 42.0],
            [60.0, 10.0 + heights[0]],
            [100.0, heights[1]],
            [140.0, -30.0 + heights[2]],
            [180.0, -42.0],
        ];
        let line = Hairline::new(points.clone()).expect("a hairline");
        for [azimuth, height] in points {
            for side in [1.0, -1.0] {
                let (a, h) = (f64::to_radians(azimuth * side), f64::to_radians(height));
                let d = Vector3::new(a.sin() * h.cos(), h.sin(), a.cos() * h.cos());
                let d = Unit::new_normalize(d);
                prop_assert!(line.within(&d).abs() < 1e-9);
                let inward = Unit::new_normalize(d.into_inner() + 0.1 * line.axis().into_inner());
                prop_assert!(line.within(&inward) > 0.0);
            }
        }
        prop_assert!(line.within(&-line.axis()) < 0.0);
    }
}

#[test]
fn the_scalp_grows_with_the_head() {
    let measures = HeadMeasures::default();
    let twice = HeadMeasures {
        length: 2.0 * measures.length,
        breadth: 2.0 * measures.breadth,
        height: 2.0 * measures.height,
    };
    let [small, large] = [measures, twice].map(|m| head(m).scalp(24, 8).expect("a scalp"));
    for (a, b) in small.vertices.iter().zip(&large.vertices) {
        let grown = Point3::from(2.0 * a.coords);
        assert!((grown - b).norm() < 1e-9, "{a} {b}");
    }
}
