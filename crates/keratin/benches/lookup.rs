//! What it costs to ask a hair for a property, and to take a step of a law.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, LinearLaw, Material, Section, SectionLaw};
use rapunzel_keratin::law::{MaxwellElement, Relaxation, Viscoelastic};
use rapunzel_keratin::surface::{Direction, Wetness, friction};
use rapunzel_keratin::{Climate, Hair, HairType};
use rapunzel_rod_dynamic::{
    Conditions, Instant, Rod, RodStepReport, SectionLaws, StaggeredBatch, Steady,
};
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

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
    let branches = [0.1, 1.0, 10.0].map(|time| MaxwellElement { modulus: 0.2, time }).to_vec();
    let relaxation = Relaxation::new(0.4, branches).expect("a model");
    let law = Viscoelastic::new(stiffness, &relaxation, 1e-3).expect("a law");
    step(&mut group, "viscoelastic_step", &law, &strain);
    group.finish();
}

/// Steps of eight hairs of 100 segments that fall from the level, elastic and viscoelastic: the
/// time a hair.
fn rods(c: &mut Criterion) {
    let mut group = c.benchmark_group("keratin");
    group.sample_size(10).measurement_time(Duration::from_secs(4));
    let level = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    let pose = Isometry3::from_parts(Vector3::zeros().into(), level);
    let section = Section::Circle { radius: 35e-6 };
    let fiber = Fiber::uniform(0.3, 100, section, &Material::HAIR).expect("a hair").with_root(pose);
    let branches = [0.1, 1.0, 10.0].map(|time| MaxwellElement { modulus: 0.2, time }).to_vec();
    let relaxation = Relaxation::new(0.4, branches).expect("a model");
    let law = Viscoelastic::new(fiber.nodes()[0].stiffness, &relaxation, 1e-3).expect("a law");
    let elastic = Rod::damped(fiber, 1e-3);
    let laws = SectionLaws::Same(Arc::new(law));
    let viscoelastic = Rod { damping_time: 0.0, laws, ..elastic.clone() };
    let hold = Steady(Instant::clamped(pose, Vector3::new(0.0, 0.0, -9.81)));
    for (name, rod) in [("elastic", elastic), ("viscoelastic", viscoelastic)] {
        let conditions: [&dyn Conditions; 8] = [&hold; 8];
        let mut reports = [RodStepReport::default(); 8];
        let fresh = || StaggeredBatch::new(vec![rod.clone(); 8], 0.3).expect("rods");
        let mut batch = fresh();
        group.bench_function(format!("{name} rod of 8"), |b| {
            b.iter_custom(|count| {
                let mut time = Duration::ZERO;
                for _ in 0..count {
                    if batch.time() > 4.0 {
                        batch = fresh();
                    }
                    let clock = std::time::Instant::now();
                    batch.step(1e-2, &conditions, &mut reports).expect("a step");
                    time += clock.elapsed();
                }
                time / 8
            });
        });
    }
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

criterion_group!(benches, lookup, rods);
criterion_main!(benches);
