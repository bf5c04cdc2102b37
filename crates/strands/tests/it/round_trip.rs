//! What the writers write is what the readers read.

use crate::common::{files, frame, strand};
use nalgebra::Point3;
use proptest::prelude::*;
use rapunzel_export::{Frame, hair, obj};
use rapunzel_strands::{Origin, ReadOptions, StrandFault, StrandFile, StrandFormat, UpAxis};

proptest! {
    /// Every point within a millionth of the strand's length, every radius within that of itself.
    #[test]
    fn strands_come_back_from_every_format(frame in frame()) {
        for (format, has_radii, bytes) in files(&frame) {
            prop_assert_eq!(StrandFormat::from_bytes(&bytes), Some(format));
            let file = StrandFile::read(&bytes, None, &ReadOptions::default());
            let StrandFile { strands, report } = file.expect("a file of strands");
            prop_assert!(report.refused.is_empty() && report.merged == 0, "{}", report);
            prop_assert_eq!(strands.len(), frame.strands.len());
            let radii: Vec<_> = frame.strands.iter().flat_map(|strand| &strand.radii).collect();
            prop_assert_eq!(strands.radii().map(<[f64]>::len), has_radii.then_some(radii.len()));
            for (read, written) in strands.radii().unwrap_or_default().iter().zip(radii) {
                prop_assert!((read - written).abs() <= 1e-6 * written);
            }
            for (k, written) in frame.strands.iter().enumerate() {
                prop_assert_eq!(strands.strand(k).len(), written.points.len());
                // What single precision leaves of the position of a hair that is 1 mm long.
                let tolerance = 1e-6 * strands.length(k) + 2e-8;
                for (read, written) in strands.strand(k).iter().zip(&written.points) {
                    let is_usd = format == StrandFormat::Usd;
                    // A run's world has z up, and its USD says so.
                    let turned = Point3::new(written.x, written.z, -written.y);
                    let expected = if is_usd { turned } else { *written };
                    prop_assert!((read - expected).norm() <= tolerance);
                }
            }
        }
    }
}

proptest! {
    /// What was read and is written and read again is the same to the last bit.
    #[test]
    fn strands_that_were_read_come_back_exactly(frame in frame()) {
        for (k, (format, _, bytes)) in files(&frame).into_iter().enumerate() {
            // The file of a run has z up, what is read y.
            let options = |up| ReadOptions { up, ..ReadOptions::default() };
            let up = (format == StrandFormat::Usd).then_some(UpAxis::Y);
            let first = StrandFile::read(&bytes, None, &options(up)).expect("a file").strands;
            let strands = first.iter().enumerate().map(|(k, points)| {
                let own = first.radii().map(|radii| radii[first.range(k)].to_vec());
                strand(points.to_vec(), own.unwrap_or_else(|| vec![4e-5; points.len()]))
            });
            let again = Frame { index: 0, time: 0.0, strands: strands.collect() };
            let (_, _, bytes) = files(&again).swap_remove(k);
            let second = StrandFile::read(&bytes, None, &options(up)).expect("a file").strands;
            prop_assert_eq!(first, second, "{:?}", format);
        }
    }
}

/// Strands of one point on top of another, with equal points in a row, of one segment, of many, and
/// without thickness: each format gives them back or tells their numbers.
#[test]
fn degenerate_strands_come_back_or_are_told() {
    let point = |x: f64| Point3::new(x, 0.25, -0.5);
    let line = |points: usize| (0..points).map(|k| point(2f64.powi(-10) * k as f64)).collect();
    let of = |points: Vec<_>| strand(points.clone(), vec![0.0; points.len()]);
    let strands = vec![
        of(line(2)),
        of(vec![point(0.5); 5]),
        of(vec![point(0.0), point(0.0), point(0.5), point(0.5), point(1.0)]),
        of(line(5000)),
        of(vec![point(1.0); 2]),
    ];
    let frame = Frame { index: 0, time: 0.0, strands };
    let options = ReadOptions { up: Some(UpAxis::Y), ..ReadOptions::default() };
    for (format, _, bytes) in files(&frame) {
        let file = StrandFile::read(&bytes, None, &options).expect("a file of strands");
        let StrandFile { strands, report } = file;
        assert_eq!(strands.sources(), [0, 2, 3], "{format:?}");
        let refused = [1, 4].map(|number| (number, StrandFault::NoLength));
        assert_eq!((report.merged, &report.refused[..]), (2, &refused[..]), "{format:?}");
        assert_eq!(strands.strand(1), [0.0, 0.5, 1.0].map(point), "{format:?}");
        // Text has the shortest digits that tell numbers of single precision apart.
        let long = &frame.strands[3].points;
        assert_eq!(strands.strand(2).len(), long.len(), "{format:?}");
        for (read, written) in strands.strand(2).iter().zip(long) {
            let bound = f64::from(f32::EPSILON) * written.coords.amax();
            assert!((read - written).amax() <= bound, "{format:?}: {read} {written}");
        }
    }
    // A single strand, and none.
    let one = Frame { strands: vec![of(line(2))], ..frame.clone() };
    for (format, _, bytes) in files(&one) {
        let file = StrandFile::read(&bytes, None, &options).expect("a strand");
        assert_eq!(file.strands.strand(0), one.strands[0].points, "{format:?}");
    }
    // USD is not written of none.
    let (mut text, mut binary) = (Vec::new(), Vec::new());
    let none = Frame { strands: vec![], ..frame };
    obj::write(&mut text, &none).expect("a frame");
    hair::write(&mut binary, &none).expect("a frame");
    for (format, bytes) in [(StrandFormat::Obj, text), (StrandFormat::Hair, binary)] {
        let error = StrandFile::read(&bytes, Some(format), &options).expect_err("no strands");
        assert!(error.to_string().contains("it holds no strands"), "{format:?}: {error}");
    }
}

#[test]
fn units_and_axes_are_as_given_stated_or_assumed() {
    let text = b"v 1 2 3\nv 1 2 4\nl 1 2\n";
    let file = crate::common::read(text);
    assert_eq!(file.strands.strand(0)[1], Point3::new(1.0, 2.0, 4.0));
    assert_eq!(file.report.up.origin, Origin::Assumed);
    assert_eq!(
        file.report.to_string(),
        "OBJ: 1 of 1 strands; 1 unit is 1 m (assumed), Y is up (assumed)"
    );
    let options =
        ReadOptions { meters_per_unit: Some(0.01), up: Some(UpAxis::Z), ..ReadOptions::default() };
    let file = StrandFile::read(text, None, &options).expect("lines");
    assert_eq!(file.strands.strand(0)[1], Point3::new(1.0, 4.0, -2.0) * 0.01);
    assert_eq!(file.report.meters_per_unit.origin, Origin::Given);
    let text =
        b"#usda 1.0\n(\n metersPerUnit = 0.1\n upAxis = \"Z\"\n)\ndef BasisCurves \"a\"\n{\n\
        uniform token type = \"linear\"\n int[] curveVertexCounts = [2]\n\
        point3f[] points = [(0, 0, 0), (1, 2, 3)]\n}\n";
    let file = crate::common::read(text);
    assert!((file.strands.strand(0)[1] - Point3::new(0.1, 0.3, -0.2)).norm() < 1e-15);
    assert_eq!(file.report.meters_per_unit.origin, Origin::Stated);
    let file = StrandFile::read(text, None, &options).expect("a layer");
    assert_eq!(file.report.meters_per_unit.value, 0.01);
}

#[test]
fn options_out_of_range_are_refused() {
    let usual = ReadOptions::default;
    for options in [
        ReadOptions { meters_per_unit: Some(0.0), ..usual() },
        ReadOptions { meters_per_unit: Some(f64::NAN), ..usual() },
        ReadOptions { time: Some(f64::INFINITY), ..usual() },
        ReadOptions { points_per_strand: Some(0), ..usual() },
        ReadOptions { points_per_span: 0, ..usual() },
    ] {
        let error = StrandFile::read(b"v 0 0 0\n", None, &options).expect_err("out of range");
        assert!(error.to_string().contains("must be"), "{error}");
    }
}

#[test]
fn formats_have_their_extensions() {
    let format = |extension| StrandFormat::from_extension(extension);
    assert_eq!(format("HAIR"), Some(StrandFormat::Hair));
    assert_eq!(format("data"), Some(StrandFormat::Data));
    assert_eq!(["usd", "usda", "usdc"].map(format), [Some(StrandFormat::Usd); 3]);
    assert_eq!([format("ply"), format("obj")], [Some(StrandFormat::Ply), Some(StrandFormat::Obj)]);
    assert_eq!(format("abc"), None);
    for bytes in [&b""[..], b"hair", b"PK\x03\x04", b"\0\0\0\0", b"vector"] {
        assert_eq!(StrandFormat::from_bytes(bytes), None);
    }
}
