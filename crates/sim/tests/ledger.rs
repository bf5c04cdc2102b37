//! Where the energy of a scene goes: all works sum up to what the kinetic and elastic energy gain.

#![expect(clippy::print_stdout, reason = "a test tells what it measured")]

mod common;

use common::Run;
use rapunzel_sim::{Scene, StepReport, World};

/// Energy gained since the start of a step, its works, and how far they are apart.
struct Books {
    run: Run,
    start: f64,
    /// Largest gap in a step, in parts of its works, and sum of all that those were.
    worst: f64,
    moved: f64,
}

fn works(world: &World) -> [f64; 9] {
    let works = world.works().expect("the scene asks for it");
    let contacts = world.contact_work();
    [
        works.gravity,
        works.loads,
        works.drag,
        works.damping,
        works.supports,
        works.integrator,
        contacts.friction,
        contacts.normal,
        contacts.led,
    ]
}

fn held(world: &World) -> f64 {
    let energy = world.energy();
    energy.kinetic + energy.elastic
}

impl Books {
    fn new(text: &str) -> Self {
        let run = Run::read(text);
        let start = held(&run.world);
        Self { run, start, worst: 0.0, moved: 0.0 }
    }

    fn step(&mut self) -> StepReport {
        let (before, energy) = (works(&self.run.world), held(&self.run.world));
        let report = self.run.step();
        let after = works(&self.run.world);
        let changes: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let gap = held(&self.run.world) - energy - changes.iter().sum::<f64>();
        let moved: f64 = changes.iter().map(|x| x.abs()).sum();
        self.moved += moved;
        self.worst = self.worst.max(gap.abs() / moved);
        report
    }

    /// The gap over the whole run, in parts of all that was moved.
    fn whole(&self) -> f64 {
        let sum: f64 = works(&self.run.world).iter().sum();
        (held(&self.run.world) - self.start - sum).abs() / self.moved
    }
}

const HAIRS: &str = "length: 0.06, segments: 20, section: Circle(radius: 3.5e-5), \
                     shape: Helix(radius: 0.005, pitch: 0.02), ";

/// Hairs whose roots swing, in gusts, with viscosity of their own and a force, in gravity that grows.
#[test]
fn the_ledger_of_hairs_that_do_not_touch_closes() {
    for method in ["Staggered()", "BackwardEuler"] {
        let mut books = Books::new(&format!(
            "(format: 1, duration: 1.0, fibers: [({HAIRS} damping_time: 1e-3,
                initial: Straight,
                arrangement: Lock(count: 3, radius: 0.003, curvature_variation: 0.1),
                point_forces: [(at: 0.5, value: (1e-6, 0, 0))],
                motion: Swing(angle: 30, radius: 0.05, period: 0.2))],
            environment: (gravity_ramp: 0.05, viscosity: 1.8e-5,
                wind: Gusts(velocity: (0.2, 0, 0), gust: (0, 0.5, 0), period: 0.1)),
            stepper: (dt: 1e-3, method: {method}), output: (ledger: true))"
        ));
        for _ in 0..200 {
            books.step();
        }
        println!("{method}: {:.1e} a step, {:.1e} in all", books.worst, books.whole());
        println!("{:?}", books.run.world.works());
        assert!(books.worst < 1e-6 && books.whole() < 1e-8, "{:e}", books.worst);
    }
}

/// Hairs that land on a ball, or on one that flies, by a hand that moves.
#[test]
fn the_ledger_of_hairs_that_touch_closes() {
    let free = "motion: Fixed";
    let ball = "(shape: Ball(radius: 0.01), position: (0, 0, 0.03))";
    let flying = "(shape: Ball(radius: 0.01), position: (0, 0.004, 0.03), \
                  moves: Free(mass: Mass(1e-5), velocity: (0, 0, 0.5), spin: (0, 50, 20)))";
    let swing = "motion: Swing(angle: 30, radius: 0.05, period: 0.2)";
    for (name, objects, joint, motion) in [
        ("landing", ball, "Free", free),
        ("flying", flying, "Free", free),
        ("swinging", ball, "Clamped", swing),
    ] {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({HAIRS} damping_time: 1e-3, root_joint: {joint},
                root: (position: (-0.03, 0, 0.045), orientation: Along(direction: (1, 0, 0))),
                arrangement: Lock(count: 8, radius: 0.004, curvature_variation: 0.1), {motion})],
            objects: [{objects}], contact: (friction: Isotropic(0.3), restitution: 0.3),
            environment: (viscosity: 1.8e-5),
            stepper: (dt: 1e-3), output: (ledger: true))"
        );
        let mut books = Books::new(&text);
        let mut active = 0;
        for _ in 0..80 {
            active = active.max(books.step().contact.active);
        }
        println!("{name}: {:.1e} a step, {:.1e} in all", books.worst, books.whole());
        println!(
            "{active} contacts; {:?} {:?}",
            books.run.world.works(),
            books.run.world.contact_work()
        );
        assert!(active > 3, "{name}: they touch");
        assert!(books.worst < 1e-6, "{name}: {:e}", books.worst);
    }
}

#[test]
fn scenes_without_a_ledger_refuse_it() {
    let text = format!(
        "(format: 1, duration: 1.0, fibers: [({HAIRS})], stepper: (dt: 1e-3, method: Box()),
        output: (ledger: true))"
    );
    let error = Scene::from_ron(&text).expect_err("the box scheme keeps none").to_string();
    assert!(error.contains("output.ledger"), "{error}");
}

/// Two free hairs that collide.
#[test]
fn collisions_keep_momentum() {
    for friction in [0.0, 0.3] {
        for dt in [1e-3, 1e-4, 1e-5] {
            let one = "(length: 0.008, segments: 4, section: Circle(radius: 3.5e-5), root_joint: Free, \
                       root: (orientation: Along(direction: (1, 0, 0))))";
            let other = "(length: 0.008, segments: 4, section: Circle(radius: 3.5e-5), \
                         root_joint: Free, velocity: (0.1, 0.0, -0.3), root: (position: (0.003, -0.005, 8e-5), \
                         orientation: Along(direction: (0.3, 1, 0))))";
            let mut run = Run::read(&format!(
                "(format: 1, duration: 1.0, fibers: [{one}, {other}],
                contact: (friction: Isotropic({friction:?})),
                environment: (gravity: (0, 0, 0)), stepper: (dt: {dt:?}))"
            ));
            let start = run.world.momentum().expect("staggered");
            let (mut touched, mut last) = (0, start);
            let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
            for _ in 0..10 {
                touched += run.step().contact.active;
                let now = run.world.momentum().expect("staggered");
                linear = linear.max((now.linear - last.linear).norm() / start.linear.norm());
                angular = angular.max((now.angular - last.angular).norm() / start.angular.norm());
                last = now;
            }
            let drift = (last.angular - start.angular).norm() / start.angular.norm();
            println!(
                "mu {friction}, dt {dt:e}: {touched} contacts, linear {linear:.1e}, angular {angular:.1e} a step, {drift:.1e} in all"
            );
            assert!(linear < 1e-12);
        }
    }
}

#[test]
fn explore_faults() {
    let crushed = |speed: f64, dt: f64| {
        format!(
        "(format: 1, duration: 1.0, fibers: [(length: 0.03, segments: 30, section: Circle(radius: 3.5e-5), \
          root: (orientation: Along(direction: (0, 0, 1))))],
        objects: [(shape: Plane(normal: (0, 0, -1)), position: (0, 0, 0.0302), \
          motion: Translate(velocity: (0, 0, -{speed:?}), until: 1.0))],
        contact: (friction: Isotropic(0.3)), stepper: (dt: {dt:?}))")
    };
    for (speed, dt) in [(0.1, 1e-3), (0.5, 1e-3), (0.5, 1e-4), (1.0, 1e-3)] {
        let mut run = Run::read(&crushed(speed, dt));
        for step in 0..((0.029 / speed / dt) as usize) {
            match run.stepper.step(&mut run.world, dt) {
                Ok(report) => {
                    let e = run.world.energy().total();
                    if report.contact.unresolved > 0
                        || !e.is_finite()
                        || !report.contact.residual.is_finite()
                        || !report.contact.normal_error.is_finite()
                    {
                        println!("FAULT crushed {speed} {dt} step {step}: {e:e} {report:?}");
                        break;
                    }
                }
                Err(error) => {
                    println!("FAULT crushed {speed} {dt} step {step}: {error}");
                    break;
                }
            }
        }
        println!("FAULT crushed {speed} {dt} ends at {}", run.world.time());
    }
    for (contact, method) in
        [("", ""), ("", ", method: BackwardEuler"), ("contact: (friction: Isotropic(0.3)),", "")]
    {
        for count in [1, 3] {
            let text = format!(
                "(format: 1, duration: 1.0, fibers: [(length: 0.06, segments: 20, section: Circle(radius: 3.5e-5), \
                  root: (orientation: Along(direction: (1, 0, 0))), tip: Held, \
                  arrangement: Lock(count: {count}, radius: 0.003, curvature_variation: 0.0))],
                {contact} stepper: (dt: 1e-3{method}))");
            let scene = match Scene::from_ron(&text) {
                Ok(s) => s,
                Err(e) => {
                    println!("FAULT held {e}");
                    continue;
                }
            };
            let mut run = Run::new(&scene);
            for step in 0..20 {
                match run.stepper.step(&mut run.world, 1e-3) {
                    Ok(_) => {
                        let e = run.world.energy().total();
                        if !e.is_finite() {
                            println!("FAULT held nan {step}");
                            break;
                        }
                    }
                    Err(error) => {
                        println!("FAULT held {contact} {method} {count} step {step}: {error}");
                        break;
                    }
                }
            }
            println!(
                "FAULT held {contact} {method} {count} ends at {} {:?}",
                run.world.time(),
                run.world.energy()
            );
        }
    }
}
