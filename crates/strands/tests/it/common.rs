//! Frames of random strands, and files of them.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use proptest::prelude::*;
use rapunzel_export::ply::PlyEncoding;
use rapunzel_export::{Frame, Strand, data, hair, obj, ply};
use rapunzel_strands::{ReadOptions, StrandFile, StrandFormat};

/// A strand through these points with these radii, m.
pub(crate) fn strand(points: Vec<Point3<f64>>, radii: Vec<f64>) -> Strand {
    let (nodes, segments) = (points.len(), points.len() - 1);
    Strand {
        points,
        radii,
        velocities: vec![Vector3::zeros(); nodes],
        frames: vec![Rotation3::from_matrix_unchecked(Matrix3::identity()); segments],
        curvatures: vec![Vector3::zeros(); nodes],
        forces: vec![Vector3::zeros(); segments],
        contact_forces: vec![Vector3::zeros(); nodes],
        charges: vec![0.0; nodes],
    }
}

/// Hairs on a head: roots within 15 cm of the origin, segments of 1 to 10 mm in any direction.
pub(crate) fn frame() -> impl Strategy<Value = Frame> {
    let root = prop::array::uniform3(-0.15..0.15_f64);
    let segment = (prop::array::uniform3(-1.0..1.0_f64), 1e-3..1e-2_f64, 2e-5..5e-5_f64);
    let hair = (root, prop::collection::vec(segment, 1..20)).prop_map(|(root, segments)| {
        let mut points = vec![Point3::from(root)];
        let mut radii = vec![4e-5];
        for (direction, length, radius) in segments {
            let direction = Vector3::from(direction).try_normalize(1e-3).unwrap_or(Vector3::x());
            points.push(points[points.len() - 1] + length * direction);
            radii.push(radius);
        }
        strand(points, radii)
    });
    prop::collection::vec(hair, 1..8).prop_map(|strands| Frame { index: 0, time: 0.0, strands })
}

/// The frame in every format that holds strands and nothing else, each with its name and whether it
/// has radii.
pub(crate) fn files(frame: &Frame) -> Vec<(StrandFormat, bool, Vec<u8>)> {
    let mut files = Vec::new();
    let mut bytes = Vec::new();
    hair::write(&mut bytes, frame).expect("a frame");
    files.push((StrandFormat::Hair, true, std::mem::take(&mut bytes)));
    data::write(&mut bytes, frame).expect("a frame");
    files.push((StrandFormat::Data, false, std::mem::take(&mut bytes)));
    obj::write(&mut bytes, frame).expect("a frame");
    files.push((StrandFormat::Obj, false, std::mem::take(&mut bytes)));
    for encoding in [PlyEncoding::Text, PlyEncoding::Binary] {
        ply::write(&mut bytes, frame, encoding).expect("a frame");
        files.push((StrandFormat::Ply, true, std::mem::take(&mut bytes)));
    }
    files.push((StrandFormat::Usd, true, usda(frame)));
    files.push((StrandFormat::Usd, true, crate::usdc::written(frame)));
    files
}

/// The layer of fibres that a run leaves of a single frame.
pub(crate) fn usda(frame: &Frame) -> Vec<u8> {
    use rapunzel_export::usd::{Prim, PrimShape, Strands, Timeline};
    use rapunzel_export::vtp;
    use std::io::Cursor;
    let mut file = Cursor::new(Vec::new());
    vtp::write(&mut file, frame).expect("a frame");
    let bytes = file.into_inner();
    let shape = PrimShape::Curves { strands: 0..frame.strands.len(), guide: false };
    let prim = Prim { name: "Lock".into(), shape, color: [0.3, 0.2, 0.1] };
    let timeline = Timeline { frames: 1, rate: 24.0, end: 0.0 };
    let layer = Strands::new(timeline, "Fibers", vec![prim], |_| Ok(Cursor::new(bytes.clone())));
    let mut out = Vec::new();
    layer.expect("a layer").write(&mut out, None).expect("memory");
    out
}

/// Reads a file that can be read.
pub(crate) fn read(bytes: &[u8]) -> StrandFile {
    StrandFile::read(bytes, None, &ReadOptions::default()).expect("a file of strands")
}
