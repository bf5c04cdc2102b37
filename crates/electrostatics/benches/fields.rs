//! Fields of points and forces of segments, one call from positions to results.

#[allow(dead_code, reason = "it takes what it needs")]
#[path = "../tests/it/common/mod.rs"]
mod common;

use common::{charges, cube, hair};
use criterion::{Criterion, criterion_group, criterion_main};
use rapunzel_electrostatics::{Accuracy, ChargedFibers, Direct, Method, Multipole, MultipolePlan};
use rapunzel_fiber::Layout;
use std::hint::black_box;

fn points(c: &mut Criterion) {
    let mut group = c.benchmark_group("points");
    group.sample_size(10);
    let cube = cube(100_000, 1);
    let hair = hair(300, 333, 2).concat();
    for (name, points, mixed) in [("uniform", cube, true), ("hair", hair, false)] {
        let charges = charges(points.len(), mixed, 3);
        for tolerance in [4e-4, 7e-7] {
            let accuracy = Accuracy::Tolerance(tolerance);
            let method = Multipole { accuracy };
            group.bench_function(format!("{name} 100,000 first, {tolerance:e}"), |b| {
                b.iter(|| method.fields(black_box(&points), &charges, &points));
            });
            group.bench_function(format!("{name} 100,000 repeat, {tolerance:e}"), |b| {
                // Here, so that a filter for another one does not wait for it.
                let plan = MultipolePlan::new(&points, &points, accuracy).expect("valid");
                b.iter(|| plan.fields(black_box(&charges)));
            });
        }
        let targets = &points[..1000];
        group.bench_function(format!("direct sum, {name} 1e8 pairs"), |b| {
            b.iter(|| Direct.fields(black_box(&points), &charges, targets));
        });
    }
}

fn segments(c: &mut Criterion) {
    let layout = Layout::new([100; 300]);
    let nodes = hair(300, 101, 2).concat();
    let charges = vec![7.7e-14; layout.segments()];
    let radii = [40e-6; 300];
    let accuracy = Accuracy::Tolerance(1e-4);
    let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
    let mut group = c.benchmark_group("segments");
    group.sample_size(10);
    group.bench_function("tress of 30,000, 1e-4", |b| b.iter(|| fibers.forces(black_box(&nodes))));
}

criterion_group!(benches, points, segments);
criterion_main!(benches);
