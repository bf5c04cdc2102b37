//! Layers of USD, as text and binary.

use crate::common::{read, usda};
use nalgebra::Point3;
use rapunzel_strands::{Origin, ReadOptions, StrandFile, StrandFormat, StrandsError, UpAxis};

const TEXT: &[u8] = include_bytes!("../data/groom.usda");
const BINARY: &[u8] = include_bytes!("../data/groom.usdc");

/// Points of all curves at a time, by usd-core.
fn expected(time: &str) -> Vec<Point3<f64>> {
    let rows = include_str!("../data/groom.csv").lines().filter_map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
        line.starts_with(&format!("{time},")).then(|| Point3::from_slice(&numbers[2..]))
    });
    rows.collect()
}

#[test]
fn curves_are_where_their_ancestors_put_them() {
    for (time, rows) in [(None, expected("0")), (Some(1.25), expected("1.25"))] {
        let options = ReadOptions { time, ..ReadOptions::default() };
        for bytes in [TEXT, BINARY] {
            let file = StrandFile::read(bytes, None, &options).expect("a layer");
            assert_eq!(file.strands.len(), 2 + 1 + 28);
            assert_eq!(file.strands.points().len(), rows.len());
            for (own, row) in file.strands.points().iter().zip(&rows) {
                // Quaternions and angles are in single precision.
                assert!((own - row).norm() < 1e-7, "{own} {row}");
            }
        }
    }
}

#[test]
fn text_and_binary_are_one() {
    let [text, binary] = [TEXT, BINARY].map(read);
    assert_eq!(text.strands.sources(), binary.strands.sources());
    for (a, b) in text.strands.points().iter().zip(binary.strands.points()) {
        // Digits are of single precision.
        assert!((a - b).norm() <= 1e-7 * a.coords.norm());
    }
    let radii = [&text, &binary].map(|file| file.strands.radii().expect("radii").to_vec());
    for (a, b) in radii[0].iter().zip(&radii[1]) {
        assert!((a - b).abs() <= 1e-6 * a, "{a} {b}");
    }
    // A width of 0.02 cm, twice as wide by the root and 3^(1/3) times by what is turned.
    let wide = 0.5 * 0.02 * 0.01 * 2.0 * 3.0_f64.cbrt();
    assert!((radii[0][0] / wide - 1.0).abs() < 1e-6, "{} {wide}", radii[0][0]);
    // The one that leaves its ancestors out, 0.25 cm wide, after five points.
    assert!((radii[0][5] - 0.00125).abs() < 1e-12);
    for file in [text, binary] {
        let report = file.report;
        assert_eq!((report.meters_per_unit.value, report.up.value), (0.01, UpAxis::Z));
        assert_eq!(report.up.origin, Origin::Stated);
        assert_eq!((report.found, report.refused.len(), report.merged), (31, 0, 0));
        let mut unread = report.unread;
        unread.sort();
        assert_eq!(unread, ["references of prim /groom/Head", "the sublayer ./other.usda"]);
    }
}

#[test]
fn samples_are_held_before_the_first_and_after_the_last() {
    for bytes in [TEXT, BINARY] {
        let at = |time| {
            let options = ReadOptions { time, ..ReadOptions::default() };
            StrandFile::read(bytes, None, &options).expect("a layer").strands
        };
        assert_eq!(at(Some(-1.0)), at(None));
        assert_eq!(at(Some(9.0)), at(Some(2.0)));
        let between = at(Some(0.5));
        let halfway =
            at(None).points()[0] + 0.5 * (at(Some(1.0)).points()[0] - at(None).points()[0]);
        assert!((between.points()[0] - halfway).norm() < 1e-15);
    }
}

/// Catmull-Rom curves through all control points, 4 points a span; turned about z, then z is up.
#[test]
fn hair_as_blender_lays_it_out() {
    let file = read(include_bytes!("../data/blender.usda"));
    let lengths: Vec<_> = file.strands.iter().map(<[_]>::len).collect();
    assert_eq!(lengths, [9, 13]);
    let place = |x: f64, y: f64, z: f64| Point3::new(-y, 1.5 + z, -x);
    let second = file.strands.strand(1);
    for (k, point) in
        [(0, place(0.0, 0.125, 0.0)), (4, place(0.1, 0.125, 0.1)), (12, place(0.3, 0.125, 0.0))]
    {
        assert!((second[k] - point).norm() < 1e-12, "{k}: {}", second[k]);
    }
    // The middle of the middle span, (9 (b + c) - (a + d)) / 16.
    assert!((second[6] - place(0.15, 0.125, 18.0 / 160.0)).norm() < 1e-12);
    let radii = file.strands.radii().expect("radii");
    assert!((radii[0] - 4e-5).abs() < 1e-12 && (radii[8] - 2e-5).abs() < 1e-12);
    assert_eq!(file.report.meters_per_unit.origin, Origin::Stated);
}

/// A prim of these attributes in a layer.
fn prim(attributes: &str) -> String {
    format!("#usda 1.0\ndef BasisCurves \"a\"\n{{\n{attributes}\n}}\n")
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let points = "point3f[] points = [(0, 0, 0), (1, 0, 0)]\n";
    let linear = "uniform token type = \"linear\"\n";
    let curves = format!("{points}{linear}int[] curveVertexCounts = [2]\n");
    let order = |op| format!("{curves}uniform token[] xformOpOrder = [\"{op}\"]\n");
    for (text, place, problem) in [
        (prim(&format!("{points}int[] curveVertexCounts = [3]")), "prim /a", "add up to 3"),
        (prim(&format!("{points}int[] curveVertexCounts = [-1, 3]")), "prim /a", "add up to 2"),
        (prim(points), "prim /a", "add up to 0"),
        (prim("int[] curveVertexCounts = [1]\npoint3f[] points = [(0, 0)]"), "prim /a", "add up"),
        (prim(&format!("{curves}float[] widths = [1, 1, 1]")), "prim /a", "3 widths"),
        (prim(&curves.replace("linear", "hermite")), "prim /a", "hermite"),
        (prim(&format!("{curves}uniform token wrap = \"loose\"")), "prim /a", "loose"),
        (prim(&order("xformOp:translate")), "prim /a", "xformOp:translate is missing"),
        (prim(&format!("{}float xformOp:shear = 1", order("xformOp:shear"))), "prim /a", "shear"),
        (
            prim(&format!("{}float3 xformOp:scale = (0, 1, 1)", order("!invert!xformOp:scale"))),
            "prim /a",
            "inverted",
        ),
        (prim(&curves.replace("(1, 0, 0)", "(1, one, 0)")), "prim /a", "should be numbers"),
        (prim("int a = ]"), "line 4", "value is expected"),
        (prim("int a 5"), "line 5", "expected"),
        ("#usda 1.0\n\ndef Xform \"a\"\n{\n".into(), "line 5", "closed"),
        ("#usda 1.0\n}\n".into(), "line 2", "expected"),
        ("#usda 1.0\ndef Xform a\n{}\n".into(), "line 2", "quotes"),
        ("#usda 1.0\ndef Xform \"a\n{}\n".into(), "line 2", "do not end"),
        ("#usda 1.0\ndef Xform \"a\" {}\n".into(), "the file", "no strands"),
    ] {
        let error = StrandFile::read(text.as_bytes(), None, &ReadOptions::default());
        let Err(StrandsError::Read { place: own, problem: said, .. }) = error else {
            panic!("{text}: {error:?}");
        };
        assert!(own == place && said.contains(problem), "{text}: {own}: {said}");
    }
    let zipped = StrandFile::read(b"PK\x03\x04", Some(StrandFormat::Usd), &ReadOptions::default());
    assert!(zipped.expect_err("zipped").to_string().contains("usdz"));
}

/// The layer of fibres of a run is read; its root tells that they are in there.
#[test]
fn the_root_of_a_run_tells_where_its_fibers_are() {
    use rapunzel_export::usd::{Timeline, root};
    let mut bytes = Vec::new();
    let timeline = Timeline { frames: 1, rate: 24.0, end: 0.0 };
    root(&mut bytes, &timeline, &["fibers.usda"]).expect("memory");
    let error = StrandFile::read(&bytes, None, &ReadOptions::default()).expect_err("no curves");
    assert!(error.to_string().contains("the sublayer ./fibers.usda"), "{error}");
    let points = vec![Point3::new(0.0, 0.0, 0.1), Point3::new(0.0, 0.5, 0.1)];
    let strand = crate::common::strand(points, vec![4e-5, 3e-5]);
    let frame = rapunzel_export::Frame { index: 0, time: 0.0, strands: vec![strand] };
    let file = read(&usda(&frame));
    assert!((file.strands.strand(0)[1] - Point3::new(0.0, 0.1, -0.5)).norm() < 1e-8);
    assert!(file.report.unread.is_empty(), "{}", file.report);
}
