//! Where the energy of a scene goes: all works sum up to what the kinetic and elastic energy gain.

use crate::common::Run;
use crate::common::books::Books;
use rapunzel_sim::Scene;

const HAIRS: &str = "length: 0.06, segments: 20, section: Circle(radius: 3.5e-5), \
                     shape: Helix(radius: 0.005, pitch: 0.02), ";

/// Hairs whose roots swing, in gusts, with viscosity of their own and a force, in gravity that
/// grows.
#[test]
fn the_ledger_of_hairs_that_do_not_touch_closes() {
    for method in ["Staggered()", "BackwardEuler"] {
        let mut books = Books::new(Run::read(&format!(
            "(format: 1, duration: 1.0, fibers: [({HAIRS} damping_time: 1e-3,
                initial: Straight,
                arrangement: Lock(count: 3, radius: 0.003, curvature_variation: 0.1),
                point_forces: [(at: 0.5, value: (1e-6, 0, 0))],
                motion: Swing(angle: 30, radius: 0.05, period: 0.2))],
            environment: (gravity_ramp: 0.05, viscosity: 1.8e-5,
                wind: Gusts(velocity: (0.2, 0, 0), gust: (0, 0.5, 0), period: 0.1)),
            stepper: (dt: 1e-3, method: {method}), output: (ledger: true))"
        )));
        for _ in 0..200 {
            books.step();
        }
        println!("{method}: {:.1e} a step, {:.1e} in all", books.worst, books.whole());
        println!("{:?}", books.run.world.ledger());
        assert!(books.worst < 1e-9 && books.whole() < 1e-12, "{:e}", books.worst);
    }
}

/// Hairs that land on a ball, or on one that flies, by a hand that moves.
#[test]
fn the_ledger_of_hairs_that_touch_closes() {
    let ball = "(shape: Ball(radius: 0.01), position: (0, 0, 0.03))";
    let flying = "(shape: Ball(radius: 0.01), position: (0, 0.004, 0.03), \
                  moves: Free(mass: Mass(1e-5), velocity: (0, 0, 0.5), spin: (0, 50, 20)))";
    let swing = "motion: Swing(angle: 30, radius: 0.05, period: 0.2)";
    for (name, object, rest, compliance) in [
        ("landing", ball, "root_joint: Free", 0.0),
        ("flying", flying, "root_joint: Free", 0.0),
        ("swinging", ball, swing, 0.0),
        ("sinking in", flying, "root_joint: Free", 1e-2),
    ] {
        // Further apart than their coils are wide.
        let places = [(-6, 45), (0, 45), (6, 45), (-6, 51), (0, 51), (6, 51)];
        let hairs = places.map(|(y, z)| {
            format!(
                "(length: 0.06, segments: 20, section: Circle(radius: 3.5e-5),
                shape: Helix(radius: 0.002, pitch: 0.03), damping_time: 1e-3, {rest},
                root: (position: (-0.03, {y}e-3, {z}e-3),
                    orientation: Along(direction: (1, 0, 0))))"
            )
        });
        // What bounces is rigid.
        let restitution = if compliance > 0.0 { 0.0 } else { 0.3 };
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [{}], objects: [{object}],
            contact: (friction: Isotropic(0.3), restitution: {restitution:?},
                compliance: {compliance:?}),
            environment: (viscosity: 1.8e-5), stepper: (dt: 1e-3), output: (ledger: true))",
            hairs.join(", ")
        );
        let mut books = Books::new(Run::read(&text));
        let (mut active, mut given) = (0, 0.0_f64);
        for _ in 0..80 {
            active = active.max(books.step().contact.active);
            given = given.min(books.run.world.contact_work().compliance);
        }
        println!("{name}: {:.1e} a step, {:.1e} in all", books.worst, books.whole());
        println!(
            "{active} contacts; {:?} {:?}",
            books.run.world.ledger(),
            books.run.world.contact_work()
        );
        assert!(active > 2, "{name}: they touch");
        assert!(books.worst < 1e-9, "{name}: {:e}", books.worst);
        assert!((given < 0.0) == (compliance > 0.0), "{name}: {given:e}");
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

/// The largest change of the linear and of the angular momentum in a step, in parts of them, while
/// two free hairs collide.
fn drifts(friction: f64, dt: f64) -> [f64; 2] {
    let hair = |rest: &str| {
        format!(
            "(length: 0.008, segments: 4, section: Circle(radius: 3.5e-5), root_joint: Free, {rest})"
        )
    };
    let fibers = [
        hair("root: (orientation: Along(direction: (1, 0, 0)))"),
        hair(
            "velocity: (0.1, 0.0, -0.3), root: (position: (0.003, -0.005, 8e-5), \
             orientation: Along(direction: (0.3, 1, 0)))",
        ),
    ];
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [{}], contact: (friction: Isotropic({friction:?})),
        environment: (gravity: (0, 0, 0)), stepper: (dt: {dt:?}))",
        fibers.join(", ")
    ));
    let momentum = |run: &Run| run.world.momentum().expect("backward Euler tells it");
    let (mut before, mut touched, mut worst) = (momentum(&run), 0, [0.0_f64; 2]);
    let scales = [before.linear.norm(), before.angular.norm()];
    for _ in 0..10 {
        touched += run.step().contact.active;
        let now = momentum(&run);
        let changes = [now.linear - before.linear, now.angular - before.angular];
        for k in 0..2 {
            worst[k] = worst[k].max(changes[k].norm() / scales[k]);
        }
        before = now;
    }
    assert!(touched > 0, "they touch");
    worst
}

/// Of a collision the linear momentum is kept to rounding. The angular one is kept to the first
/// order of the step, in which nodes move by chords: levers are off by up to half the way, which is
/// set against half the length. Friction acts on the surfaces, and changes nothing of that.
#[test]
fn collisions_keep_momentum() {
    let steps = [1e-3, 1e-4, 1e-5];
    let [smooth, rough] = [0.0, 0.3].map(|friction| steps.map(|dt| drifts(friction, dt)));
    println!("without friction {smooth:?}, with it {rough:?}");
    for [linear, _] in smooth.iter().chain(&rough) {
        assert!(*linear < 1e-12, "{linear:e}");
    }
    for drifts in [smooth, rough] {
        for ([_, angular], dt) in drifts.iter().zip(steps) {
            assert!(*angular < 0.3 * dt / 0.008, "{drifts:?}");
        }
        assert!(drifts[2][1] < 0.2 * drifts[1][1], "{drifts:?}");
    }
}

/// Curly hairs fall flat onto a plane and each other, without restitution. Two that lie beside each
/// other slid past each other so fast that the step drove them: energy rose.
#[test]
fn hairs_that_fall_together_gain_nothing() {
    let mut run = Run::read(
        "(format: 1, seed: 1, duration: 1.0, fibers: [(length: 0.15, segments: 50,
            section: Circle(radius: 3.5e-5), shape: Helix(radius: 0.006, pitch: 0.02),
            arrangement: Ellipse(semi_axes: (0.0028284271247461905, 0.0028284271247461905), count: 20),
            root: (position: (0.0, -0.04, 0.0), orientation: Along(direction: (0, 1, 0))),
            root_joint: Free)],
        objects: [(shape: Plane(normal: (0.0, 0.0, 1.0)), position: (0.0, 0.0, -0.03))],
        contact: (friction: Isotropic(0.3)), environment: (viscosity: 1.8e-5),
        stepper: (dt: 1e-3))",
    );
    let (mut most, mut before) = (0.0_f64, f64::INFINITY);
    for step in 0..120 {
        run.step();
        let energy = run.world.energy();
        most = most.max(energy.kinetic);
        assert!(energy.total() - before < 1e-6 * most, "step {step}");
        before = energy.total();
    }
    assert!(run.world.energy().kinetic < 0.01 * most, "they have landed");
}
