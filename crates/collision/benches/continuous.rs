//! Continuous detection of two segments of hair: slow and fast, near and far.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rapunzel_collision::continuous::MovingSegment;
use std::hint::black_box;

const REACH: f64 = 70e-6;
const COUNT: usize = 1000;

fn vector(random: &mut Pcg64Mcg, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| size * (f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0))
}

/// Segments of 3 mm around the origin; the ends of each move by up to `motion`, together up to a
/// tenth of it.
fn pairs(spread: f64, motion: f64) -> Vec<[MovingSegment; 2]> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut segment = || {
        let start = Point3::from(vector(&mut random, spread));
        let before = [start, start + 3e-3 * vector(&mut random, 1.0).normalize()];
        let shift = vector(&mut random, motion);
        let after = before.map(|p| p + shift + vector(&mut random, 0.1 * motion));
        MovingSegment { before, after }
    };
    (0..COUNT).map(|_| [segment(), segment()]).collect()
}

/// A thousand queries, one after the other.
fn queries(c: &mut Criterion) {
    let mut group = c.benchmark_group("continuous");
    for (name, spread, motion) in [
        ("slow and near", 1e-3, 20e-6),
        ("fast and near", 1e-3, 2e-3),
        ("slow and far", 10e-3, 20e-6),
    ] {
        let pairs = pairs(spread, motion);
        group.bench_function(format!("1000 queries {name}"), |b| {
            let all = |pairs: &Vec<[MovingSegment; 2]>| {
                pairs.iter().filter_map(|[a, b]| a.impact(b, REACH, 1e-3 * REACH)).count()
            };
            b.iter_batched_ref(
                || pairs.clone(),
                |pairs| black_box(all(pairs)),
                BatchSize::LargeInput,
            );
        });
    }
}

criterion_group!(benches, queries);
criterion_main!(benches);
