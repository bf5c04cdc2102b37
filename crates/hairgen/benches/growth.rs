//! The growth region of a half sphere with about as many triangles as a scanned scalp, and the
//! distance field of a head.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point3;
use rapunzel_collision::field::{Mesh, Soup, shapes};
use rapunzel_hairgen::growth::{
    ConvexWeights, DiscMap, GrowthOptions, GrowthRegion, HeadAxes, ScalpMesh,
};
use rapunzel_hairgen::head::{HeadMeasures, ParametricHead};
use rapunzel_hairgen::{FieldResolution, SurfaceField};
use std::hint::black_box;

/// 10,404 triangles.
fn half_sphere() -> ScalpMesh {
    let mut soup = shapes::sphere(0.095, 51);
    let upper = |p: &Point3<f64>| p.y > -1e-9;
    let Soup { vertices, triangles } = &mut soup;
    triangles.retain(|t| t.iter().all(|&v| upper(&vertices[v as usize])));
    ScalpMesh::new(soup).expect("a disc")
}

fn growth(c: &mut Criterion) {
    let scalp = half_sphere();
    let axes = HeadAxes::default();
    let mut group = c.benchmark_group("growth");
    group.sample_size(10);
    group.bench_function("disc map", |b| {
        b.iter(|| DiscMap::new(black_box(&scalp), ConvexWeights::MeanValue, &axes));
    });
    let region = GrowthRegion::new(scalp.clone(), GrowthOptions::default()).expect("a region");
    for count in [100_000, 200_000] {
        let name = format!("{count} pores");
        group.bench_function(name, |b| b.iter(|| region.pores(black_box(count), 1)));
    }
    group.finish();
}

/// The distance of our own head, 1 mm near it and 8 mm far from it, on all threads.
fn fields(c: &mut Criterion) {
    let head = ParametricHead::new(HeadMeasures::default(), Default::default()).expect("a head");
    let mesh = Mesh::new(head.mesh()).expect("closed");
    let mut group = c.benchmark_group("field");
    group.sample_size(10);
    group.bench_function("the head at 1 mm", |b| {
        b.iter(|| SurfaceField::solid("the head", black_box(&mesh), FieldResolution::default()));
    });
    group.finish();
}

criterion_group!(benches, growth, fields);
criterion_main!(benches);
