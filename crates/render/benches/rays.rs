//! Rays on cubic curves: the scene that renderers are compared by, one thread.

#[path = "../tests/it/wavy.rs"]
mod wavy;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use rapunzel_render::{CurveForm, Curves, PathRandom, Ray};
use std::hint::black_box;

const RAYS: u32 = 1 << 14;

/// Rays of a camera 48 cm in front, of 36 degrees, through random places of the picture.
fn primary() -> Vec<Ray> {
    let mut random = PathRandom::new(1, 0, 0);
    let half = 18.0_f64.to_radians().tan();
    let mut ray = || {
        let [x, y] = random.pair().map(|u| (2.0 * u - 1.0) * half);
        let direction = Vector3::new(x, 1.0, y).normalize();
        Ray { origin: Point3::new(0.0, -0.48, 0.15), direction, time: 0.0 }
    };
    (0..RAYS).map(|_| ray()).collect()
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("rays");
    group.sample_size(10);
    let (rays, range) = (primary(), [0.0, f64::INFINITY]);
    for count in [1000, 10_000] {
        let fibers = wavy::wavy(count, 48);
        let curves = Curves::new(CurveForm::Cubic, None, &fibers).expect("sound");
        let hits = || rays.iter().filter(|ray| curves.hit(black_box(ray), range).is_some()).count();
        group.throughput(Throughput::Elements(u64::from(RAYS)));
        group.bench_function(format!("primary/{count}"), |b| b.iter(hits));
        group.throughput(Throughput::Elements(u64::from(count) * 47));
        group.bench_function(format!("build/{count}"), |b| {
            b.iter(|| Curves::new(CurveForm::Cubic, None, &fibers));
        });
    }
    // As much as a head of hair has.
    let fibers = wavy::wavy(100_000, 100);
    group.throughput(Throughput::Elements(100_000 * 99));
    group.bench_function("build/100000", |b| {
        b.iter_with_large_drop(|| Curves::new(CurveForm::Cubic, None, &fibers));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
