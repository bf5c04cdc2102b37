use super::super::{Frame, sample, vtp};
use super::*;
use crate::text;
use nalgebra::{Isometry3, Point3};
use proptest::prelude::*;
use std::io::Cursor;

/// Three frames, the last between two time codes.
const TIMELINE: Timeline = Timeline { frames: 3, rate: 30.0, end: 1.75 / 30.0 };

type Opened = Result<Cursor<Vec<u8>>, ExportError>;

fn file(frame: &Frame) -> Cursor<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    vtp::write(&mut out, frame).expect("memory");
    out.set_position(0);
    out
}

fn curves(strands: std::ops::Range<usize>) -> Prim {
    let shape = PrimShape::Curves { strands, guide: false };
    Prim { name: "Bundle_0".to_owned(), shape, color: [0.1; 3] }
}

/// A layer of the sample's frames.
fn layer(prims: Vec<Prim>) -> Result<Strands<impl Fn(usize) -> Opened>, ExportError> {
    Strands::new(TIMELINE, "Fibers", prims, |index| Ok(file(&sample::frame(index))))
}

fn text(write: impl FnOnce(&mut Vec<u8>) -> Result<(), ExportError>) -> String {
    let mut out = Vec::new();
    write(&mut out).expect("memory");
    let text = String::from_utf8(out).expect("text");
    assert_eq!(text.matches('{').count(), text.matches('}').count(), "{text}");
    assert_eq!(text.matches('[').count(), text.matches(']').count(), "{text}");
    text
}

/// The rows of an attribute's samples: time codes and what they are.
fn samples<'a>(text: &'a str, attribute: &str) -> Vec<(f64, &'a str)> {
    let begin = format!("{attribute}.timeSamples = {{\n");
    let (_, rest) = text.split_once(&begin).expect("it has samples");
    let (rows, _) = rest.split_once("\n            }").expect("an end");
    let row = |row: &'a str| row.trim().split_once(": ").expect("a time code");
    rows.lines().map(row).map(|(code, row)| (code.parse().expect("a number"), row)).collect()
}

/// The numbers of a list of vectors.
fn numbers(row: &str) -> Vec<f32> {
    let split = row.split(['[', ']', '(', ')', ',', ' ']);
    split.filter(|x| !x.is_empty()).map(|x| x.parse().expect("a number")).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "the schema is in single precision")]
fn singles<'a>(points: impl Iterator<Item = &'a Point3<f64>>) -> Vec<f32> {
    points.flat_map(|p| p.coords.data.0[0].map(|x| x as f32)).collect()
}

#[test]
fn samples_are_the_frames_in_single_precision() {
    let layer = layer(vec![curves(0..1), curves(1..3)]).expect("a layer");
    let text = text(|out| layer.write(out, None));
    for line in ["startTimeCode = 0\n", "endTimeCode = 1.75\n", "framesPerSecond = 30\n"] {
        assert!(text.contains(line), "{line} in {text}");
    }
    let (first, second) = text.split_at(text.rfind("def BasisCurves").expect("two prims"));
    assert!(first.contains("int[] curveVertexCounts = [6]"), "{first}");
    assert!(second.contains("int[] curveVertexCounts = [9, 12]"), "{second}");
    assert!(second.contains("int[] primvars:id = [1, 2]"), "{second}");
    let points = samples(second, "point3f[] points");
    let codes: Vec<f64> = points.iter().map(|(code, _)| *code).collect();
    assert_eq!(codes, [0.0, 1.0, 1.75]);
    for (index, (_, row)) in points.iter().enumerate() {
        let frame = sample::frame(index);
        assert_eq!(numbers(row), singles(frame.strands[1..].iter().flat_map(|s| &s.points)));
    }
    let velocities = samples(second, "vector3f[] velocities");
    let expected: Vec<_> = sample::frame(2).strands[1..]
        .iter()
        .flat_map(|s| &s.velocities)
        .map(|v| Point3::from(*v))
        .collect();
    assert_eq!(numbers(velocities[2].1), singles(expected.iter()));
    let director = |s: &crate::Strand, i: usize| {
        let segment = i.min(s.frames.len() - 1);
        Point3::from(s.frames[segment].matrix().column(0).into_owned())
    };
    let directors: Vec<_> = sample::frame(2).strands[1..]
        .iter()
        .flat_map(|s| (0..s.points.len()).map(move |i| director(s, i)))
        .collect();
    let written = samples(second, "vector3f[] primvars:d1");
    assert_eq!(numbers(written[2].1), singles(directors.iter()));
    let extent = numbers(samples(second, "float3[] extent")[1].1);
    assert_eq!(extent.len(), 6);
    for p in numbers(points[1].1).chunks(3) {
        assert!((0..3).all(|k| extent[k] < p[k] && p[k] < extent[3 + k]), "{p:?} {extent:?}");
    }
}

#[test]
fn one_width_is_constant() {
    let mut frame = sample::frame(0);
    frame.strands.iter_mut().for_each(|s| s.radii.fill(35e-6));
    let timeline = Timeline { frames: 1, ..TIMELINE };
    let layer = Strands::new(timeline, "Fibers", vec![curves(0..3)], |_| Ok(file(&frame)));
    let text = text(|out| layer.expect("a layer").write(out, None));
    let width = "float[] widths = [0.00007] (\n                interpolation = \"constant\"";
    assert!(text.contains(width), "{text}");
    let layer = self::layer(vec![curves(0..3)]).expect("a layer");
    let text = self::text(|out| layer.write(out, None));
    let widths = text.lines().find(|l| l.contains("widths")).expect("widths");
    assert_eq!(widths.matches(',').count(), 26);
    assert!(text.contains("interpolation = \"vertex\""), "{text}");
}

#[test]
fn smooth_curves_end_at_their_points() {
    let straight = text(|out| layer(vec![curves(0..3)]).expect("a layer").write(out, None));
    let smooth = text(|out| layer(vec![curves(0..3)]).expect("a layer").smooth().write(out, None));
    assert!(straight.contains("type = \"linear\"") && !straight.contains("basis"), "{straight}");
    let form = ["type = \"cubic\"", "basis = \"catmullRom\"", "wrap = \"pinned\""];
    assert!(form.iter().all(|token| smooth.contains(&format!("uniform token {token}\n"))));
    assert_eq!(samples(&smooth, "point3f[] points"), samples(&straight, "point3f[] points"));
}

#[test]
fn a_surface_has_the_points_of_its_strands() {
    let shape =
        PrimShape::Surface { vertices: vec![[0, 1], [1, 8], [2, 0]], faces: vec![vec![0, 1, 2]] };
    let prim = Prim { name: "Surface".to_owned(), shape, color: [0.5; 3] };
    let layer = layer(vec![prim]).expect("a layer");
    let text = text(|out| layer.write(out, None));
    assert!(text.contains("def Mesh \"Surface\""), "{text}");
    assert!(text.contains("int[] faceVertexIndices = [0, 1, 2]"), "{text}");
    let frame = sample::frame(1);
    let [a, b, c] = [[0, 1], [1, 8], [2, 0]].map(|[s, p]| frame.strands[s].points[p]);
    assert_eq!(numbers(samples(&text, "point3f[] points")[1].1), singles([a, b, c].iter()));
}

#[test]
fn a_large_layer_has_its_samples_in_clips() {
    let layer = layer(vec![curves(0..3)]).expect("a layer");
    assert!(layer.clips(usize::MAX).is_empty());
    let clips = layer.clips(6000);
    assert_eq!(clips, [0..2, 2..3]);
    assert_eq!(layer.clips(1), [0..1, 1..2, 2..3]);
    let files: Vec<_> = clips.iter().map(|f| (f.clone(), format!("{}.usda", f.start))).collect();
    let all = Clips { manifest: "manifest.usda".to_owned(), files };
    let whole = text(|out| layer.write(out, None));
    let top = text(|out| layer.write(out, Some(&all)));
    assert!(!top.contains("timeSamples"), "{top}");
    for line in [
        "double2[] active = [(0, 0), (1.75, 1)]",
        "asset[] assetPaths = [@./0.usda@, @./2.usda@]",
        "asset manifestAssetPath = @./manifest.usda@",
        "string primPath = \"/Scene/Fibers\"",
        "double2[] times = [(0, 0), (1.75, 1.75)]",
    ] {
        assert!(top.contains(line), "{line} in {top}");
    }
    for attribute in
        ["point3f[] points", "vector3f[] velocities", "vector3f[] primvars:d1", "float3[] extent"]
    {
        let parts: Vec<_> =
            clips.iter().map(|frames| text(|out| layer.write_clip(out, frames.clone()))).collect();
        let parts: Vec<_> = parts.iter().flat_map(|part| samples(part, attribute)).collect();
        assert_eq!(parts, samples(&whole, attribute));
        let manifest = text(|out| layer.write_manifest(out));
        assert!(manifest.contains(&format!("            {attribute}\n")), "{manifest}");
    }
}

#[test]
fn objects_are_meshes_moved_by_their_transforms() {
    let times = [0.0, 1.0, 1.75].map(|code| code / 30.0);
    let frames = times.map(sample::objects);
    let poses: Vec<Vec<Isometry3<f64>>> =
        frames.iter().map(|objects| objects.iter().map(|object| object.pose).collect()).collect();
    let text = text(|out| objects(out, &TIMELINE, &frames[0], &poses));
    let (still, moving) = text.split_at(text.rfind("def Mesh").expect("two prims"));
    assert!(still.contains("double3 xformOp:translate = (0.1, -0.2, 0.3)\n"), "{still}");
    assert!(still.contains("quatd xformOp:orient = ("), "{still}");
    assert!(!still.contains("timeSamples") && still.contains("def Mesh \"Object_0\""), "{still}");
    // A point of a mesh in its own frame is where the pose puts it.
    let (_, own) = moving.split_once("point3f[] points = ").expect("points");
    let own = numbers(own.lines().next().expect("a row"));
    let places = samples(moving, "double3 xformOp:translate");
    assert_eq!(places.iter().map(|(code, _)| *code).collect::<Vec<_>>(), [0.0, 1.0, 1.75]);
    assert_eq!(samples(moving, "quatd xformOp:orient").len(), 3);
    for (frame, pose) in frames.iter().zip(&poses) {
        for (p, expected) in own.chunks(3).zip(&frame[1].surface.vertices) {
            let p = pose[1] * Point3::new(p[0], p[1], p[2]).cast::<f64>();
            // Of 0.7 m, in single precision.
            assert!((p - expected).norm() < 2e-7, "{p} {expected}");
        }
    }
    let missing = objects(&mut Vec::new(), &TIMELINE, &frames[0], &poses[..2]);
    assert!(matches!(missing, Err(ExportError::Series { index: 2, .. })));
    let none = objects(&mut Vec::new(), &TIMELINE, &[], &[]);
    assert!(matches!(none, Err(ExportError::Empty)));
}

#[test]
fn a_root_lists_its_layers() {
    let text = text(|out| root(out, &TIMELINE, &["fibers.usda", "objects.usda"]));
    assert!(text.contains("        @./fibers.usda@,\n        @./objects.usda@\n"), "{text}");
    assert!(text.contains("endTimeCode = 1.75\n"), "{text}");
}

#[test]
fn what_is_no_series_is_refused() {
    let refused = |prims| layer(prims).err().expect("no such strands");
    assert!(matches!(refused(vec![]), ExportError::Empty));
    assert!(matches!(refused(vec![curves(0..4)]), ExportError::Series { .. }));
    assert!(matches!(refused(vec![curves(2..2)]), ExportError::Series { .. }));
    let go = |second: Frame| {
        let open = |i| if i == 1 { Ok(file(&second)) } else { Ok(file(&sample::frame(i))) };
        let layer = Strands::new(TIMELINE, "Fibers", vec![curves(0..3)], open).expect("a layer");
        layer.write(&mut Vec::new(), None)
    };
    assert!(go(sample::frame(1)).is_ok());
    assert!(matches!(go(sample::frame(2)), Err(ExportError::Series { index: 1, .. })));
    let mut fewer = sample::frame(1);
    fewer.strands.pop();
    assert!(matches!(go(fewer), Err(ExportError::Series { index: 1, .. })));
    let mut far = sample::frame(1);
    far.strands[0].points[2].y = 1e39;
    assert!(matches!(go(far), Err(ExportError::Single { value: 1e39 })));
}

proptest! {
    /// Numbers are read back to the bit, and have at most nine digits.
    #[test]
    fn single_precision_survives(x in any::<f32>()) {
        let mut out = Vec::new();
        let written = text::single(&mut out, x.into());
        prop_assert_eq!(written.is_ok(), x.is_finite());
        if x.is_finite() {
            let text = String::from_utf8(out).expect("text");
            prop_assert_eq!(text.parse::<f32>().expect("a number").to_bits(), x.to_bits());
            let mantissa = text.split('e').next().expect("one");
            let digits = mantissa.replace(['-', '.'], "");
            prop_assert!(digits.trim_matches('0').len() <= 9, "{}", text);
        }
    }

    /// Frames stand at whole time codes, in order, and the last where its time is, whatever the
    /// rate and however the time of the end is rounded.
    #[test]
    fn time_codes_rise(
        frames in 1_usize..2000,
        rate in 1e-3..1e6_f64,
        part in 0.01..1.0_f64,
        rounding in -4_i32..=4,
    ) {
        let before = frames.saturating_sub(2) as f64;
        let code = if frames == 1 { 0.0 } else { before + part };
        let end = code / rate * (1.0 + f64::from(rounding) * f64::EPSILON);
        let timeline = Timeline { frames, rate, end };
        let codes: Vec<f64> = (0..frames).map(|frame| timeline.code(frame)).collect();
        prop_assert!(codes.windows(2).all(|pair| pair[0] < pair[1]));
        prop_assert!((0..frames - 1).all(|frame| codes[frame] == frame as f64));
        prop_assert!((codes[frames - 1] - code).abs() <= ROUNDING);
    }
}
