//! Steps of hair that touches: a lock in its fall onto a ball, with and without its ledger.

use criterion::{Criterion, criterion_group, criterion_main};
use rapunzel_sim::Scene;
use std::time::Duration;

/// The scene that ships.
const SCENE: &str = include_str!("../../../scenes/contact/lock-on-ball.ron");
/// Steps until the lock has come to lie on the ball.
const BEFORE: usize = 150;
/// Steps that are timed at once.
const STEPS: usize = 10;

fn lock(c: &mut Criterion) {
    let mut group = c.benchmark_group("contact");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    for (name, ledger) in [("", false), (" with a ledger", true)] {
        let mut scene = Scene::from_ron(SCENE).expect("it ships");
        scene.output.ledger = ledger;
        let mut world = scene.build().expect("a world");
        let mut stepper = scene.stepper_of(&world).expect("a stepper");
        let dt = scene.stepper.dt;
        for _ in 0..BEFORE {
            stepper.step(&mut world, dt).expect("a step");
        }
        let start = world.snapshot();
        group.bench_function(format!("lock on a ball, 10 steps{name}"), |b| {
            b.iter(|| {
                world.restore(&start).expect("its own");
                for _ in 0..STEPS {
                    stepper.step(&mut world, dt).expect("a step");
                }
            });
        });
    }
}

criterion_group!(benches, lock);
criterion_main!(benches);
