//! The net: explicit steps of a large one, with the traffic to memory that bounds them timed in the
//! same run, and implicit steps of a smaller one far above the stability limit.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use rapunzel_mass_spring::{Cells, ImplicitEuler, Lattice, Leapfrog, PlaceMatrix, System};
use std::hint::black_box;
use std::time::Duration;

fn hung(side: usize, frequency: f64) -> System<3> {
    let place = PlaceMatrix::line(side, side).expect("a size");
    let net = Lattice::net(place, frequency, Cells::Rectangular);
    let mut system = net.build(Point3::origin()).expect("a net");
    system.set_gravity(Vector3::new(0.0, 0.1, -9.81)).expect("finite");
    system
}

fn explicit(c: &mut Criterion) {
    let mut group = c.benchmark_group("net");
    group.sample_size(10).measurement_time(Duration::from_secs(6));
    let mut system = hung(1000, 10.0);
    let mut leapfrog = Leapfrog::new();
    group.bench_function("explicit 1000 x 1000, 4 steps", |b| {
        b.iter(|| leapfrog.advance(&mut system, 1.0 / 240.0, 4).expect("stable"));
    });
    // What a step cannot do without: positions and velocities read and written.
    let mut columns = vec![1.0_f64; 6_000_000];
    group.bench_function("traffic of 1000 x 1000, 4 steps", |b| {
        b.iter(|| {
            for _ in 0..4 {
                black_box(&mut columns).iter_mut().for_each(|x| *x = 1.0 - *x);
            }
        });
    });
}

fn implicit(c: &mut Criterion) {
    let mut group = c.benchmark_group("net");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    let frequency = 40.0;
    let mut system = hung(200, frequency);
    // Into the fall, so that the step is one of motion.
    for _ in 0..6 {
        ImplicitEuler::default().step(&mut system, 1.0 / 60.0).expect("converges");
    }
    group.bench_function("implicit 200 x 200, 1/60 s", |b| {
        b.iter_batched_ref(
            || system.clone(),
            |system| ImplicitEuler::default().step(system, 1.0 / 60.0).expect("converges"),
            criterion::BatchSize::LargeInput,
        );
    });
}

criterion_group!(benches, explicit, implicit);
criterion_main!(benches);
