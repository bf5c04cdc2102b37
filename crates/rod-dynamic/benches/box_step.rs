//! Whole steps of the box scheme on the reference hair, released horizontally.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator, Steady};
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

const STEPS: usize = 60;
const STEP: f64 = 1.0 / 30.0;

fn hair() -> BoxIntegrator {
    let horizontal = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    let fiber = Fiber::uniform(0.3, 100, Section::Circle { radius: 35e-6 }, &Material::HAIR)
        .expect("a valid hair")
        .with_root(Isometry3::from_parts(Vector3::zeros().into(), horizontal));
    BoxIntegrator::new(Rod::new(fiber), BoxOptions::default()).expect("valid options")
}

/// Two seconds; returns the iterations.
fn fall(integrator: &mut BoxIntegrator) -> usize {
    let root = *integrator.rod().fiber.root();
    let conditions = Steady(Instant::clamped(root, Vector3::new(0.0, 0.0, -9.81)));
    (0..STEPS).map(|_| integrator.step(STEP, &conditions).expect("the hair falls").iterations).sum()
}

fn box_step(c: &mut Criterion) {
    let mut numbers = Vec::new();
    let mut integrator = hair();
    integrator.save(&mut numbers);
    let mut group = c.benchmark_group("box");
    group.throughput(criterion::Throughput::Elements(STEPS as u64));
    let name = "hair, 100 segments, 60 steps of 1/30 s";
    group.sample_size(30).bench_function(name, |b| {
        b.iter(|| {
            integrator.restore(&numbers).expect("its own numbers");
            black_box(fall(&mut integrator))
        });
    });
    group.finish();
}

criterion_group!(benches, box_step);
criterion_main!(benches);
