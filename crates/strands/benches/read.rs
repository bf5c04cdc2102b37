//! A groom of 10,000 strands of 100 points from every format, resampled, and put on a scalp.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rapunzel_collision::field::{SurfaceTree, shapes};
use rapunzel_export::ply::PlyEncoding;
use rapunzel_export::usd::{Prim, PrimShape, Strands, Timeline};
use rapunzel_export::{Frame, Strand, data, hair, obj, ply, vtp};
use rapunzel_strands::{ReadOptions, StrandFile, StrandFormat};
use std::f64::consts::TAU;
use std::hint::black_box;
use std::io::Cursor;

#[path = "../tests/it/usdc.rs"]
mod usdc;

const STRANDS: usize = 10_000;
const POINTS: usize = 100;

/// Curls of 20 cm, from a ball of 10 cm outward.
fn groom() -> Frame {
    let strand = |k: usize| {
        let [turn, rise] = [0.618_034 * k as f64, k as f64 / STRANDS as f64];
        let level = (1.0 - rise * rise).sqrt();
        let out = Vector3::new(level * (TAU * turn).cos(), rise, level * (TAU * turn).sin());
        let points = (0..POINTS).map(|i| {
            let s = 0.2 * i as f64 / (POINTS - 1) as f64;
            let curl = Vector3::new((300.0 * s).cos(), (200.0 * s).sin(), (300.0 * s).sin());
            Point3::from((0.1 + s) * out + 0.005 * curl)
        });
        Strand {
            points: points.collect(),
            radii: (0..POINTS).map(|i| 4e-5 - 1e-7 * i as f64).collect(),
            velocities: vec![Vector3::zeros(); POINTS],
            frames: vec![Rotation3::from_matrix_unchecked(Matrix3::identity()); POINTS - 1],
            curvatures: vec![Vector3::zeros(); POINTS],
            forces: vec![Vector3::zeros(); POINTS - 1],
            contact_forces: vec![Vector3::zeros(); POINTS],
            charges: vec![0.0; POINTS],
        }
    };
    Frame { index: 0, time: 0.0, strands: (0..STRANDS).map(strand).collect() }
}

fn usda(frame: &Frame) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    vtp::write(&mut file, frame).expect("a frame");
    let bytes = file.into_inner();
    let shape = PrimShape::Curves { strands: 0..frame.strands.len(), guide: false };
    let prim = Prim { name: "Hair".into(), shape, color: [0.3, 0.2, 0.1] };
    let timeline = Timeline { frames: 1, rate: 24.0, end: 0.0 };
    let layer = Strands::new(timeline, "Fibers", vec![prim], |_| Ok(Cursor::new(&bytes[..])));
    let mut out = Vec::new();
    layer.expect("a layer").write(&mut out, None).expect("memory");
    out
}

/// The frame in every format.
fn all(frame: &Frame) -> Vec<(&'static str, Vec<u8>)> {
    let mut files = vec![("usda", usda(frame)), ("usdc", usdc::written(frame))];
    let mut bytes = Vec::new();
    hair::write(&mut bytes, frame).expect("a frame");
    files.push(("hair", std::mem::take(&mut bytes)));
    data::write(&mut bytes, frame).expect("a frame");
    files.push(("data", std::mem::take(&mut bytes)));
    obj::write(&mut bytes, frame).expect("a frame");
    files.push(("obj", std::mem::take(&mut bytes)));
    for (name, encoding) in [("ply text", PlyEncoding::Text), ("ply binary", PlyEncoding::Binary)] {
        ply::write(&mut bytes, frame, encoding).expect("a frame");
        files.push((name, std::mem::take(&mut bytes)));
    }
    files
}

fn readers(c: &mut Criterion) {
    let files = all(&groom());
    let mut group = c.benchmark_group("read");
    group.sample_size(10);
    for (name, bytes) in &files {
        group.bench_function(*name, |b| {
            b.iter(|| StrandFile::read(black_box(bytes), None, &ReadOptions::default()));
        });
    }
    group.finish();

    let hair = Some(StrandFormat::Hair);
    let file = StrandFile::read(&files[2].1, hair, &ReadOptions::default()).expect("a groom");
    let mut set = file.strands;
    c.bench_function("resample/100 to 64 segments", |b| {
        b.iter(|| black_box(&set).resampled(64));
    });
    let scalp = SurfaceTree::new(&shapes::sphere(0.1, 32)).expect("a surface");
    c.bench_function("snap/10000 roots to 8192 triangles", |b| {
        b.iter(|| black_box(&mut set).snap(&scalp, 1.0));
    });
}

criterion_group!(benches, readers);
criterion_main!(benches);
