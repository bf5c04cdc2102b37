//! Equilibria of one rod and of many, on one thread except where the name says two.

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_rod_static::{Chain, EndCondition, Piece, Problem, Properties, Shape};
use rayon::ThreadPoolBuilder;
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

fn heavy(g: f64) -> Piece {
    Piece::uniform(
        1.0,
        Properties {
            stiffness: Vector3::new(1.0, 1.0, 0.75),
            natural_curvature: Vector3::zeros(),
            load: Vector3::new(0.0, 0.0, -g),
        },
    )
}

fn cantilever(segments: usize) -> Chain {
    let level = Isometry3::new(Vector3::zeros(), Vector3::y() * FRAC_PI_2);
    Chain::new(&level, &[heavy(10.0)], segments).expect("a chain")
}

/// The chain with forces on its nodes that are all a little different, as charges change them.
fn disturbed(chain: &Chain, part: f64) -> Chain {
    let mut chain = chain.clone();
    let mut forces = chain.forces().to_vec();
    let size = part * forces[1].norm();
    for (i, force) in forces.iter_mut().enumerate() {
        let angle = 0.7 * i as f64 + 10.0 * part;
        *force += Vector3::new(angle.cos(), angle.sin(), (2.0 * angle).sin()) * size;
    }
    chain.set_forces(&forces).expect("forces");
    chain
}

fn chains(c: &mut Criterion) {
    let mut group = c.benchmark_group("chain");
    for segments in [100, 1000, 10_000] {
        let chain = cantilever(segments);
        group.bench_function(format!("{segments} segments from unloaded"), |b| {
            b.iter(|| black_box(&chain).solve().expect("a minimum"));
        });
    }
    let chain = cantilever(100);
    let rest = chain.solve().expect("a minimum").shape;
    let next = disturbed(&chain, 0.05);
    group.bench_function("100 segments warm", |b| {
        b.iter(|| black_box(&next).relax(&rest).expect("a minimum"));
    });
    group.finish();
}

/// The case `with_gravity` of the reference `c_clamped_clamped.json`.
fn boundary(c: &mut Criterion) {
    let end = Isometry3::from_parts(
        Translation3::new(0.6, 0.1, 0.6),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 1.3, 0.3)),
    );
    let problem = Problem::new(&Isometry3::identity(), vec![heavy(6.0)], EndCondition::Held(end));
    let problem = problem.expect("a problem");
    c.bench_function("boundary/full frame with gravity", |b| {
        b.iter(|| black_box(&problem).solve().expect("an equilibrium"));
    });
}

fn batch(c: &mut Criterion) {
    let two = ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    let chain = cantilever(100);
    let rest = chain.solve().expect("a minimum").shape;
    let chains: Vec<Chain> =
        (0..10_000).map(|i| disturbed(&chain, 0.05 + 1e-5 * f64::from(i))).collect();
    let mut group = c.benchmark_group("batch");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    for (name, shape) in [("warm", &rest), ("from unloaded", &chain.natural_shape())] {
        let starts: Vec<Shape> = vec![shape.clone(); chains.len()];
        group.bench_function(format!("10000 fibers {name} on two threads"), |b| {
            b.iter(|| two.install(|| Chain::relax_all(&chains, &starts).expect("starts")));
        });
    }
    group.finish();
}

criterion_group!(benches, chains, boundary, batch);
criterion_main!(benches);
