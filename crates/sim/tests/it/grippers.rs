//! Grippers that take tips and let them go.

use crate::common::Run;
use crate::common::books::Books;
use nalgebra::Vector3;
use rapunzel_sim::{Scene, World};

const MATTER: &str = "length: 0.1, segments: 10, section: Circle(radius: 5e-4),
    material: Elastic(density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6)";

/// A fibre that falls is taken by its tip in flight, led aside, and let go: it falls freely before
/// and after that, and between its tip is where it was taken, but for the motion, to rounding. Its
/// books close.
#[test]
fn a_falling_fibre_is_taken_and_let_go() {
    let text = format!(
        "(format: 1, duration: 1.0, fibers: [({MATTER}, damping_time: 1e-3, root_joint: Free,
            root: (orientation: Along(direction: (1, 0, 0))),
            grippers: [(from: 0.05, until: 0.15, motion: Translate(velocity: (0, 0.2, 0),
                until: 1.0))])],
        stepper: (dt: 1e-3), output: (ledger: true))"
    );
    let mut books = Books::new(Run::read(&text));
    for _ in 0..50 {
        books.step();
    }
    let taken = books.run.world.state(0).positions[10];
    assert!(taken.z < -0.01, "{taken:?}");
    let mut saved = None;
    for k in 1..=100_u32 {
        books.step();
        let tip = books.run.world.state(0).positions[10];
        let right = taken + f64::from(k) * 1e-3 * Vector3::new(0.0, 0.2, 0.0);
        assert!((tip - right).norm() < 1e-12, "step {k}: {tip:?} for {right:?}");
        if k == 30 {
            saved = Some(books.run.world.snapshot());
        }
    }
    assert!(books.whole() < 1e-10, "{:e}", books.whole());
    // Free again, gravity alone changes its momentum, once the accelerations of the last held step
    // are forgotten.
    for _ in 0..10 {
        books.step();
    }
    let before = books.run.world.momentum().expect("told").linear;
    for _ in 0..50 {
        books.step();
    }
    let change = books.run.world.momentum().expect("told").linear - before;
    let right = Vector3::new(0.0, 0.0, -9.81 * 0.05)
        * (1000.0 * std::f64::consts::PI * 5e-4_f64.powi(2) * 0.1);
    assert!((change - right).norm() < 1e-4 * right.norm(), "{change:?} for {right:?}");
    // From where it was saved while it was held it goes on to the same bits.
    let end = books.run.world.state(0);
    let mut again = World::build(&Scene::from_ron(&text).expect("a scene")).expect("a world");
    again.restore(&saved.expect("saved")).expect("own numbers");
    for _ in 0..130 {
        again.step(1e-3).expect("a step");
    }
    assert!(again.state(0) == end);
}

/// A fibre that falls is taken by its middle, which stops and stays but for what the gripper gives
/// way to, whatever the ends do, and let go; with contact it is the same. Books close, and from
/// where it was saved while it was held it goes on to the same bits.
#[test]
fn a_falling_fibre_is_taken_by_its_middle() {
    for contact in [
        "",
        "contact: (friction: Isotropic(0.0)), objects: [(shape: Plane(normal: (0, 0, 1)),
        position: (0, 0, -1))],",
    ] {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({MATTER}, damping_time: 1e-3, root_joint: Free,
                root: (orientation: Along(direction: (1, 0, 0))),
                grippers: [(node: Node(5), from: 0.05, until: 0.25, joint: Ball())])],
            {contact} stepper: (dt: 1e-3), output: (ledger: true))"
        );
        let mut books = Books::new(Run::read(&text));
        for _ in 0..50 {
            books.step();
        }
        let taken = books.run.world.state(0).positions[5];
        let mut saved = None;
        let mut away = 0.0;
        for k in 1..=200_u32 {
            books.step();
            away = (books.run.world.state(0).positions[5] - taken).norm();
            // The speed of all the fibre, over what resists more than its own inertia.
            assert!(away < 10.0 * 0.5 * 1e-3 / 1e4 * 4.0, "step {k}: {away:e}");
            if k == 30 {
                saved = Some(books.run.world.snapshot());
            }
        }
        // Ten nodes hang on it, and swing.
        assert!(away < 10.0 * 10.0 * 9.81 * 1e-6 / 1e4, "{away:e}");
        let state = books.run.world.state(0);
        assert!(state.positions[0].z < taken.z - 5e-3, "{:?}", state.positions);
        assert!(books.whole() < 1e-8, "{:e}", books.whole());
        for _ in 0..50 {
            books.step();
        }
        let end = books.run.world.state(0);
        assert!(end.positions[5].z < taken.z - 5e-3);
        let mut again = World::build(&Scene::from_ron(&text).expect("a scene")).expect("a world");
        again.restore(&saved.expect("saved")).expect("own numbers");
        for _ in 0..220 {
            again.step(1e-3).expect("a step");
        }
        assert!(again.state(0) == end);
    }
}

/// A free root is taken as a tip is.
#[test]
fn a_free_root_is_taken() {
    let text = format!(
        "(format: 1, duration: 1.0, fibers: [({MATTER}, damping_time: 1e-3, root_joint: Free,
            root: (orientation: Along(direction: (1, 0, 0))),
            grippers: [(node: Root, from: 0.05, until: 0.15)])],
        stepper: (dt: 1e-3), output: (ledger: true))"
    );
    let mut books = Books::new(Run::read(&text));
    for _ in 0..50 {
        books.step();
    }
    let taken = books.run.world.state(0).positions[0];
    for _ in 0..100 {
        books.step();
        let root = books.run.world.state(0).positions[0];
        assert!((root - taken).norm() < 1e-12, "{root} for {taken}");
    }
    for _ in 0..50 {
        books.step();
    }
    let root = books.run.world.state(0).positions[0];
    assert!((root - taken).norm() > 1e-3, "{root} for {taken}");
    assert!(books.whole() < 1e-10, "{:e}", books.whole());
}

#[test]
fn grippers_that_let_go_before_they_take_are_refused() {
    let refused = |grippers: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({MATTER}, grippers: [{grippers}])],
            stepper: (dt: 1e-3))"
        );
        Scene::from_ron(&text).expect_err("nonsense").to_string()
    };
    let error = refused("(from: 0.5, until: 0.25)");
    assert!(error.contains("fibers[0].grippers[0].until"), "{error}");
    assert!(error.contains("0.25") && error.contains("0.5"), "{error}");
    let error = refused("(from: 0.5, joint: Free)");
    assert!(error.contains("grippers[0].joint"), "{error}");
    let error = refused("(from: 0.5), (node: Root, from: 0.5)");
    assert!(error.contains("grippers[1].node") && error.contains("root_joint: Free"), "{error}");
    let error = refused("(node: Node(3), from: 0.5)");
    assert!(error.contains("grippers[0].joint") && error.contains("Ball()"), "{error}");
    let error = refused("(node: Node(11), from: 0.5)");
    assert!(error.contains("grippers[0].node") && error.contains("0 to 10"), "{error}");
    let error = refused("(from: 0.0), (from: 1.0)");
    assert!(error.contains("grippers[1].from") && error.contains("lets go at"), "{error}");
}
