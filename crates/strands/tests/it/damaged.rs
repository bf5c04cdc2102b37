//! Files that are cut off or changed are read or refused, never a panic.

use crate::common::{files, frame, strand, usda};
use nalgebra::Point3;
use proptest::prelude::*;
use rapunzel_export::Frame;
use rapunzel_strands::{ReadOptions, StrandFile, StrandFormat, StrandsError};

const LAYERS: [&[u8]; 3] = [
    include_bytes!("../data/groom.usda"),
    include_bytes!("../data/groom.usdc"),
    include_bytes!("../data/blender.usda"),
];

fn all(frame: &Frame) -> Vec<(StrandFormat, Vec<u8>)> {
    let written = files(frame).into_iter().map(|(format, _, bytes)| (format, bytes));
    written.chain(LAYERS.map(|bytes| (StrandFormat::Usd, bytes.to_vec()))).collect()
}

fn small() -> Frame {
    let points = vec![Point3::new(0.1, 0.2, 0.3), Point3::new(0.1, 0.25, 0.3)];
    let strands = vec![strand(points, vec![4e-5; 2]); 3];
    Frame { index: 0, time: 0.0, strands }
}

/// Whatever is left out at the end of a binary file is missed.
#[test]
fn binary_files_cut_off_anywhere_are_refused() {
    for (format, bytes) in all(&small()) {
        let is_text = bytes.starts_with(b"#") || bytes.starts_with(b"ply\nformat ascii");
        if is_text {
            continue;
        }
        for length in 0..bytes.len() {
            let read = StrandFile::read(&bytes[..length], Some(format), &ReadOptions::default());
            assert!(read.is_err(), "{format:?} of {length} bytes");
        }
    }
}

/// Of a text the last braces are missed, or the last number may be shorter.
#[test]
fn texts_cut_off_anywhere_are_read_or_refused() {
    for (format, bytes) in all(&small()) {
        for length in 0..bytes.len() {
            let read = StrandFile::read(&bytes[..length], Some(format), &ReadOptions::default());
            let is_own = bytes.starts_with(b"#usda") && !LAYERS.contains(&&bytes[..]);
            assert!(!is_own || length + 3 > bytes.len() || read.is_err(), "{length}");
        }
    }
}

proptest! {
    #[test]
    fn changed_bytes_are_read_or_refused(
        frame in frame(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
        time in prop::option::of(-1.0..3.0_f64),
    ) {
        let options = ReadOptions { time, ..ReadOptions::default() };
        for (format, mut bytes) in all(&frame) {
            for (place, byte) in &changes {
                *place.get_mut(&mut bytes) = *byte;
            }
            let _ = StrandFile::read(&bytes, Some(format), &options);
            let _ = StrandFile::read(&bytes, None, &options);
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let formats =
            [StrandFormat::Hair, StrandFormat::Data, StrandFormat::Usd, StrandFormat::Ply, StrandFormat::Obj];
        for format in formats {
            let _ = StrandFile::read(&bytes, Some(format), &ReadOptions::default());
        }
    }

    /// Tokens of USD in any order.
    #[test]
    fn any_layer_is_read_or_refused(
        text in "((def|over|BasisCurves|\"a\"|int\\[\\]|points|points.timeSamples|1:|=|None|-1|\
            \\(|\\)|\\[|\\]|\\{|\\}|,|;|@a@|<a>|'|#|xformOpOrder|xformOp:scale|variantSet|\n) ?){0,60}",
    ) {
        let _ = StrandFile::read(format!("#usda 1.0\n{text}").as_bytes(), None, &ReadOptions::default());
        let body = format!("#usda 1.0\ndef BasisCurves \"a\" {{ {text} }}");
        let _ = StrandFile::read(body.as_bytes(), None, &ReadOptions::default());
    }
}

#[test]
fn deep_layers_need_no_deep_stack() {
    let deep = "def \"a\" {".repeat(100_000);
    let error =
        StrandFile::read(format!("#usda 1.0\n{deep}").as_bytes(), None, &ReadOptions::default());
    assert!(matches!(error, Err(StrandsError::Read { .. })));
    let brackets = format!("#usda 1.0\ndef \"a\" {{ int b = {}", "[({".repeat(100_000));
    let error = StrandFile::read(brackets.as_bytes(), None, &ReadOptions::default());
    assert!(matches!(error, Err(StrandsError::Read { .. })));
    assert!(usda(&small()).starts_with(b"#usda"));
}
