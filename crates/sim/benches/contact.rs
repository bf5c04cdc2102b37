//! Steps of hair that touches: a lock in its fall onto a ball, with and without its ledger, the
//! reference scene (thesis 8.6.2), and a pack of hair with a million contacts.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use rapunzel_sim::{Scene, World};
use std::time::Duration;

const LOCK: &str = include_str!("../../../scenes/contact/lock-on-ball.ron");
const REFERENCE: &str = include_str!("../../../scenes/contact/helical-bundle-on-ball.ron");

/// Steps that are timed at once.
const STEPS: usize = 10;

fn lock(c: &mut Criterion) {
    let mut group = c.benchmark_group("contact");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    for (name, ledger) in [("", false), (" with a ledger", true)] {
        let mut scene = Scene::from_ron(LOCK).expect("it ships");
        scene.output.ledger = ledger;
        steps(&mut group, &format!("lock on a ball, 10 steps{name}"), &scene, 150);
    }
}

/// In the middle of its 700 steps.
fn reference(c: &mut Criterion) {
    let mut group = c.benchmark_group("contact");
    group.sample_size(10);
    let scene = Scene::from_ron(REFERENCE).expect("it ships");
    steps(&mut group, "reference scene, 10 steps", &scene, 350);
}

/// Times steps of a scene that has come so many steps far, always the same.
fn steps(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, scene: &Scene, before: usize) {
    let mut world = after(scene, before);
    let start = world.snapshot();
    group.bench_function(name, |b| {
        b.iter(|| {
            world.restore(&start).expect("its own");
            for _ in 0..STEPS {
                world.step(scene.stepper.dt).expect("a step");
            }
        });
    });
}

/// One step after the other of a pack that has come to rest, and as it slides where gravity then
/// turns by 45 degrees.
fn million(c: &mut Criterion) {
    let mut group = c.benchmark_group("contact");
    group.sample_size(10);
    let mut scene = pack(288, 12);
    let mut world = after(&scene, 10);
    for turned in [false, true] {
        let mut name = "pack at rest, 10^6 contacts, a step";
        if turned {
            name = "pack that slides, 10^6 contacts, a step";
            scene.environment.gravity = [6.94, 0.0, -6.94];
            let rest = world.snapshot();
            world = World::build(&scene).expect("a world");
            world.restore(&rest).expect("its own");
        }
        group.bench_function(name, |b| {
            b.iter(|| {
                let report = world.step(scene.stepper.dt).expect("a step");
                let listed = report.contact.listed;
                assert!(listed >= 1_000_000, "it has {listed} contacts");
            });
        });
    }
}

fn after(scene: &Scene, steps: usize) -> World {
    let mut world = World::build(scene).expect("a world");
    for _ in 0..steps {
        world.step(scene.stepper.dt).expect("a step");
    }
    world
}

/// Free hairs of 100 segments that lie in layers on the floor between two walls, each upon the gap
/// between two, a thousandth of their diameter apart.
fn pack(across: usize, layers: usize) -> Scene {
    const RADIUS: f64 = 3.5e-5;
    let spacing = 2.0 * RADIUS * 1.001;
    let mut scene = Scene::from_ron(&format!(
        "(format: 1, name: \"A pack\", duration: 1.0, fibers: [(length: 0.3, segments: 100, \
         section: Circle(radius: {RADIUS}), root: (orientation: Along(direction: (1, 0, 0))), \
         root_joint: Free)], objects: [(shape: Plane(normal: (0, 0, 1)), position: (0, 0, {floor})), \
         (shape: Plane(normal: (0, 1, 0)), position: (0, {floor}, 0)), \
         (shape: Plane(normal: (0, -1, 0)), position: (0, {wall}, 0))], \
         contact: (friction: Isotropic(0.5)), stepper: (dt: 1e-3))",
        floor = -RADIUS,
        wall = (across as f64 - 0.5) * spacing + RADIUS,
    ))
    .expect("a scene");
    let hair = scene.fibers[0].clone();
    scene.fibers = (0..layers * across)
        .map(|i| {
            let mut hair = hair.clone();
            let (layer, place) = (i / across, i % across);
            let y = (place as f64 + 0.5 * (layer % 2) as f64) * spacing;
            hair.root.position = [0.0, y, layer as f64 * spacing * 0.75_f64.sqrt()];
            hair
        })
        .collect();
    scene
}

criterion_group!(benches, lock, reference, million);
criterion_main!(benches);
