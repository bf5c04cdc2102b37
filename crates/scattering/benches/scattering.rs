//! What it costs to scatter light at one hit.

#[allow(dead_code, reason = "it takes what it needs")]
#[path = "../tests/it/common.rs"]
mod common;

use common::{direction, random};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use rapunzel_fiber::Section;
use rapunzel_scattering::{
    Arrival, ChiangField, FarField, FiberBsdf, FiberOptics, NearField, Pigments,
};
use std::f64::consts::TAU;
use std::hint::black_box;

/// A direction that a path through hair might take.
fn any_direction(random: &mut impl FnMut() -> f64) -> Vector3<f64> {
    direction(2.4 * (random() - 0.5), TAU * random())
}

/// Every part of a hit, with directions that change, so that no branch is foreseen.
fn hits(c: &mut Criterion, name: &str, bsdf: &impl FiberBsdf) {
    let mut group = c.benchmark_group("scattering");
    let mut numbers = random(1);
    let directions: Vec<_> = (0..1024).map(|_| any_direction(&mut numbers)).collect();
    let arrivals: Vec<Arrival> =
        directions.iter().map(|from| bsdf.arrive(2.0 * numbers() - 1.0, from)).collect();
    let mut at = 0;
    let mut next = move || {
        at = (at + 1) % 1023;
        at
    };
    group.bench_function(format!("{name}/arrive"), |b| {
        b.iter(|| bsdf.arrive(black_box(0.3), &directions[next()]));
    });
    group.bench_function(format!("{name}/evaluate"), |b| {
        b.iter(|| {
            let at = next();
            bsdf.evaluate(&arrivals[at], &directions[at + 1])
        });
    });
    group.bench_function(format!("{name}/sample"), |b| {
        b.iter(|| bsdf.sample(&arrivals[next()], &mut numbers));
    });
    group.finish();
}

fn scattering(c: &mut Criterion) {
    let circle = Section::Circle { radius: 35e-6 };
    let ellipse = Section::Ellipse { a: 30e-6, b: 38e-6 };
    let optics = |pigments: Pigments| {
        let sigma = pigments.absorption().expect("hair");
        FiberOptics::hair(sigma, 0.3, 0.3, 3.0_f64.to_radians()).expect("hair")
    };
    let blond = optics(Pigments::BLOND);
    hits(c, "near", &NearField::new(blond, &circle).expect("a fibre"));
    hits(c, "near, ellipse", &NearField::new(blond, &ellipse).expect("a fibre"));
    hits(c, "far", &FarField::new(blond).expect("a fibre"));
    hits(c, "chiang", &ChiangField::new(blond).expect("a fibre"));
    hits(c, "far, black", &FarField::new(optics(Pigments::BLACK)).expect("a fibre"));
    let mut group = c.benchmark_group("scattering");
    group.sample_size(10);
    group.bench_function("build/near", |b| {
        b.iter_batched(|| blond, |of| NearField::new(of, &circle), BatchSize::PerIteration);
    });
    group.bench_function("build/near, ellipse", |b| {
        b.iter_batched(|| blond, |of| NearField::new(of, &ellipse), BatchSize::PerIteration);
    });
    group.bench_function("build/far", |b| {
        b.iter_batched(|| blond, FarField::new, BatchSize::PerIteration);
    });
    group.finish();
}

criterion_group!(benches, scattering);
criterion_main!(benches);
