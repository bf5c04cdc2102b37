//! 100,000 segments: the tree against parry's, candidate lists, distances. One thread, except where
//! the name says two.
//!
//! Refitting goes from one frame to the next one and back, 1 ms of motion.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use rapunzel_collision::thesis::scenes::{self, MovingFibers};
use rapunzel_collision::{Candidates, Capsules, Pair, Tree, contacts, squared_distances};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::{Duration, Instant};

const FIBERS: usize = 1000;
/// Margin of the candidate lists, m.
const MARGIN: f64 = 0.3e-3;

fn threads(count: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(count).build().expect("threads")
}

fn bench(c: &mut Criterion) {
    for (name, scene) in [("wavy", scenes::wavy(FIBERS)), ("clump", scenes::clump(FIBERS))] {
        let moved = scene.advanced(1.0);
        let frames = [&scene, &moved].map(|scene| scene.capsules().expect("valid"));
        parry(c, name, &frames);
        let (one, two) = (threads(1), threads(2));
        ours(c, name, &one, &frames);
        ours(c, &format!("{name} on two threads"), &two, &frames);
        candidates(c, name, &one, &scene);
        distances(c, name, &one, &frames[0]);
    }
}

/// The boxes of parry's single precision, rounded outward.
#[expect(clippy::cast_possible_truncation, reason = "rounded on to the next number")]
fn boxes(capsules: &Capsules) -> Vec<Aabb> {
    let bounds = |segment| {
        let capsule = capsules.get(segment);
        let low = capsule.start.coords.inf(&capsule.end.coords).add_scalar(-capsule.radius);
        let high = capsule.start.coords.sup(&capsule.end.coords).add_scalar(capsule.radius);
        let [x, y, z] = [low.x, low.y, low.z].map(|x| (x as f32).next_down());
        let [u, v, w] = [high.x, high.y, high.z].map(|x| (x as f32).next_up());
        Aabb::new(Vector::new(x, y, z), Vector::new(u, v, w))
    };
    (0..capsules.len()).map(bounds).collect()
}

fn parry(c: &mut Criterion, name: &str, frames: &[Capsules; 2]) {
    let boxes = frames.map(|capsules| boxes(&capsules));
    c.bench_function(&format!("parry3d f32/build/{name}"), |b| {
        b.iter(|| Bvh::from_leaves(BvhBuildStrategy::Binned, black_box(&boxes[0])));
    });
    let mut tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes[0]);
    let (mut workspace, mut pairs, mut frame) = (BvhWorkspace::default(), Vec::new(), 0);
    c.bench_function(&format!("parry3d f32/refit and pairs/{name}"), |b| {
        b.iter(|| {
            frame = 1 - frame;
            for (bounds, id) in boxes[frame].iter().zip(0..) {
                tree.update_partially_if_present(*bounds, id, 0.0);
            }
            tree.refit_without_opt();
            pairs.clear();
            tree.traverse_bvtt_single_tree::<false>(&mut workspace, &mut |i: u32, j: u32| {
                if !frames[0].adjacent(i as usize, j as usize) {
                    pairs.push([i.min(j), i.max(j)]);
                }
            });
            pairs.len()
        });
    });
}

fn ours(c: &mut Criterion, name: &str, pool: &ThreadPool, frames: &[Capsules; 2]) {
    c.bench_function(&format!("tree/build/{name}"), |b| {
        b.iter(|| pool.install(|| Tree::new(black_box(&frames[0]), 0.0)));
    });
    let mut tree = Tree::new(&frames[0], 0.0).expect("valid");
    let (mut pairs, mut frame) = (Vec::new(), 0);
    c.bench_function(&format!("tree/refit and pairs/{name}"), |b| {
        b.iter(|| {
            frame = 1 - frame;
            pool.install(|| {
                tree.refit(&frames[frame], 0.0).expect("the same segments");
                tree.pairs(&mut pairs);
            });
            pairs.len()
        });
    });
}

/// The mean over a hundred steps of 1 ms, in which tips move by a centimetre and neighbours apart
/// by up to two millimetres.
fn candidates(c: &mut Criterion, name: &str, pool: &ThreadPool, scene: &MovingFibers) {
    const STEPS: u32 = 100;
    let frames: Vec<_> = (0..=STEPS).map(|step| scene.advanced(f64::from(step))).collect();
    let frames: Vec<_> = frames.iter().map(|frame| frame.capsules().expect("valid")).collect();
    c.bench_function(&format!("candidates/step/{name}"), |b| {
        b.iter_custom(|rounds| {
            let mut time = Duration::ZERO;
            for _ in 0..rounds {
                let mut list = Candidates::new(0.0, MARGIN).expect("valid");
                list.update(&frames[0]).expect("the same segments");
                time += pool.install(|| {
                    let start = Instant::now();
                    for frame in &frames[1..] {
                        list.update(frame).expect("the same segments");
                    }
                    start.elapsed() / STEPS
                });
            }
            time
        });
    });
}

fn distances(c: &mut Criterion, name: &str, pool: &ThreadPool, capsules: &Capsules) {
    let mut pairs = Vec::new();
    Tree::new(capsules, 0.0).expect("valid").pairs(&mut pairs);
    let mut squared = vec![0.0; pairs.len()];
    c.bench_function(&format!("plain loop/distances of all pairs/{name}"), |b| {
        b.iter(|| {
            for (squared, &pair) in squared.iter_mut().zip(&pairs) {
                *squared = plain_distance(capsules.positions(), pair);
            }
        });
    });
    c.bench_function(&format!("narrow phase/distances of all pairs/{name}"), |b| {
        b.iter(|| pool.install(|| squared_distances(capsules, &pairs, &mut squared)));
    });
    let mut found = Vec::new();
    c.bench_function(&format!("narrow phase/contacts among all pairs/{name}"), |b| {
        b.iter(|| {
            pool.install(|| contacts(capsules, &pairs, 0.0, &mut found)).expect("valid");
            found.len()
        });
    });
}

/// The textbook's closest points of two segments (Ericson 2005, 5.1.9), for fibres of 100 segments.
fn plain_distance(positions: &[Point3<f64>], [i, j]: Pair) -> f64 {
    let ends = |s: u32| {
        let node = s as usize + s as usize / 100;
        (positions[node], positions[node + 1])
    };
    let ((p1, q1), (p2, q2)) = (ends(i), ends(j));
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f, b, c) = (d1.dot(&d1), d2.dot(&d2), d2.dot(&r), d1.dot(&d2), d1.dot(&r));
    let determinant = a * e - b * b;
    let inside = (b * f - c * e) / determinant;
    let mut s = if determinant > 0.0 { inside.clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (b * s + f) / e;
    if t < 0.0 {
        t = 0.0;
        s = (-c / a).clamp(0.0, 1.0);
    } else if t > 1.0 {
        t = 1.0;
        s = ((b - c) / a).clamp(0.0, 1.0);
    }
    (r + s * d1 - t * d2).norm_squared()
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(Duration::from_secs(2));
    targets = bench
}
criterion_main!(benches);
