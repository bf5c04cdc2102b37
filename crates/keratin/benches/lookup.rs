//! What it costs to ask a hair for a property, and to take a step of a law.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use rapunzel_fiber::{LinearLaw, SectionLaw};
use rapunzel_keratin::law::{Branch, Relaxation, Viscoelastic};
use rapunzel_keratin::surface::{Direction, Wetness, friction};
use rapunzel_keratin::{Climate, Hair, HairType};
use std::hint::black_box;

fn lookup(c: &mut Criterion) {
    let hair = Hair::of(HairType::Chinese);
    let climate = Climate::new(0.8, 23.0).expect("a climate");
    let mut group = c.benchmark_group("keratin");
    group.bench_function("bending_modulus", |b| {
        b.iter(|| black_box(&hair).bending_modulus(black_box(&climate)));
    });
    group.bench_function("shear_modulus", |b| {
        b.iter(|| black_box(&hair).shear_modulus(black_box(&climate)));
    });
    group.bench_function("section", |b| {
        b.iter(|| black_box(&hair).section(black_box(&climate)));
    });
    group.bench_function("friction", |b| {
        b.iter(|| friction(black_box("hair/nylon"), "", Direction::WithScales, Wetness::Dry));
    });
    let stiffness = Vector3::new(4e-9, 5e-9, 2e-9);
    let strain = Vector3::new(10.0, -3.0, 1.0);
    step(&mut group, "linear_step", &LinearLaw { stiffness }, &strain);
    let branches = [0.1, 1.0, 10.0].map(|time| Branch { modulus: 0.2, time }).to_vec();
    let relaxation = Relaxation::new(0.4, branches).expect("a model");
    let law = Viscoelastic::new(stiffness, &relaxation, 1e-3).expect("a law");
    step(&mut group, "viscoelastic_step", &law, &strain);
    group.finish();
}

fn step(
    group: &mut criterion::BenchmarkGroup<'_, criterion::measurement::WallTime>,
    name: &str,
    law: &dyn SectionLaw,
    strain: &Vector3<f64>,
) {
    let mut memory = vec![Vector3::zeros(); law.memory()];
    group.bench_function(name, |b| {
        b.iter(|| {
            let response = law.response(&memory, black_box(strain), black_box(1e-3));
            law.commit(&mut memory, strain, 1e-3);
            response
        });
    });
}

criterion_group!(benches, lookup);
criterion_main!(benches);
