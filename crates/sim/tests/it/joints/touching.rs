//! Ball joints of fibres that touch, and of fibres with objects.

use super::{apart, fiber, run};
use crate::common::Run;
use crate::common::books::Books;
use std::f64::consts::TAU;

const GRAVITY: f64 = 9.81;
const BALL: &str = "(hold: Ball, first: (fiber: 0, at: Tip), second: (fiber: 1, at: Root))";

/// Two limp fibres, joined tip to root, that swing, with `more` in the scene.
fn chain(more: &str) -> Run {
    let rods = [
        fiber(0.1, 8, [0.0; 3], [0.6, 0.0, -0.8], "root_joint: Ball()"),
        fiber(0.1, 8, [0.06, 0.0, -0.08], [1.0, 0.0, 0.0], "root_joint: Free"),
    ];
    run(&rods, &[BALL], &format!("{more}, stepper: (dt: 1e-3, method: BackwardEuler)"))
}

/// Where fibres may touch but do not, joints are what they are without contact, to the tolerances
/// of its solver; and what they do is in the ledger.
#[test]
fn joints_of_fibres_that_may_touch_are_the_same() {
    // m/s
    let slip = 1e-6;
    let contact = format!(
        "contact: (friction: Isotropic(0.3), slip: {slip:?}, residual: 1e-8, iterations: 100000)"
    );
    let mut books = Books::new(chain(&format!("{contact}, output: (ledger: true)")));
    let mut other = chain("output: (ledger: true)");
    let (mut off, mut open) = (0.0_f64, 0.0_f64);
    for _ in 0..150 {
        books.step();
        other.step();
        let (one, two) = (books.run.positions(0), books.run.positions(1));
        open = open.max((one[8] - two[0]).norm());
        off = off.max(apart(&one, &other.positions(0))).max(apart(&two, &other.positions(1)));
    }
    println!("open {open:e}, off {off:e}, books {:e}", books.worst);
    // In a step of dt a joint opens by no more than the slip that is let be along each direction.
    assert!(open < 2.0 * slip * 1e-3, "{open:e}");
    // Errors of the velocity add up, at most, over the run.
    assert!(off < 10.0 * slip * 0.15, "{off:e}");
    assert!(books.worst < 1e-9, "{:e}", books.worst);
}

/// What balls of fibres that may touch bear goes on after a restart, to the last bit.
#[test]
fn balls_in_contact_resume_to_the_same_bits() {
    let more = "objects: [(shape: Plane(normal: (0, 0, 1)), position: (0, 0, -0.09))],
        contact: (friction: Isotropic(0.3))";
    let mut run = chain(more);
    run.steps(60);
    assert!(run.world.contacts().next().is_some(), "it touches the floor");
    let saved = run.world.snapshot();
    run.steps(10);
    let whole = run.world.snapshot();
    let mut again = chain(more);
    again.world.restore(&saved).expect("the same world");
    again.steps(10);
    assert!(again.world.snapshot() == whole);
}

/// A chain of fibres with joints that falls on the floor comes to rest there, still joined.
#[test]
fn a_chain_falls_on_the_floor() {
    let rods = [0, 1, 2].map(|i| {
        fiber(0.05, 6, [0.05 * f64::from(i), 0.0, 0.002], [1.0, 0.0, 0.0], "root_joint: Free")
    });
    let joint = |i: usize| {
        let next = i + 1;
        format!("(hold: Ball, first: (fiber: {i}, at: Tip), second: (fiber: {next}, at: Root))")
    };
    let joints = [joint(0), joint(1)];
    let joints = joints.each_ref().map(|joint| &**joint);
    let floor = "objects: [(shape: Plane(normal: (0, 0, 1)))], contact: (friction: Isotropic(0.3)),
        stepper: (dt: 1e-3)";
    let mut run = run(&rods, &joints, floor);
    for _ in 0..100 {
        run.step();
        for i in 0..2 {
            let open = (run.positions(i)[6] - run.positions(i + 1)[0]).norm();
            assert!(open < 1e-6, "{open:e}");
        }
    }
    let speed = run.momentum().norm();
    assert!(speed < 1e-6, "{speed:e}");
    for i in 0..3 {
        let low = run.positions(i).iter().map(|node| node.z).fold(f64::INFINITY, f64::min);
        assert!((low - 5e-4).abs() < 5e-5, "{low}");
    }
}

/// Time between two crossings of x = 0 to the same side, of what `place` tells, s.
fn period(run: &mut Run, place: impl Fn(&Run) -> f64) -> f64 {
    let (mut last, mut time, mut crossings) = (place(run), 0.0, Vec::new());
    while crossings.len() < 3 {
        run.step();
        time += run.dt;
        let x = place(run);
        if x * last < 0.0 {
            crossings.push(time - run.dt * x / (x - last));
        }
        last = x;
    }
    crossings[2] - crossings[0]
}

/// A heavy ball that hangs on a light fibre, joined in its center, is a pendulum.
#[test]
fn a_ball_on_a_fibre_is_a_pendulum() {
    let (length, angle) = (0.1_f64, 0.02_f64);
    let along = [angle.sin(), 0.0, -angle.cos()];
    let at = along.map(|x| length * x);
    let cord = fiber(length, 4, [0.0; 3], along, "root_joint: Ball()");
    let object = format!(
        "objects: [(shape: Ball(radius: 0.01), position: ({:?}, 0, {:?}),
            moves: Free(mass: Mass(0.02)))],
         object_joints: [(fiber: 0, at: Tip, object: 0)], contact: (friction: Isotropic(0.3)), stepper: (dt: 5e-4)",
        at[0], at[2]
    );
    let mut run = run(&[cord], &[], &object);
    let found = period(&mut run, |run| run.positions(0)[4].x);
    // The ball turns on its joint by itself; of the fibre nodes have the mass.
    let fiber = 1000.0 * TAU / 2.0 * 5e-4 * 5e-4 * length;
    let n = 4.0_f64;
    let inertia = (0.02 + fiber * (1.0 / 3.0 + 1.0 / (6.0 * n * n))) * length * length;
    let moment = (0.02 + 0.5 * fiber) * GRAVITY * length;
    let exact = TAU * (inertia / moment).sqrt() * (1.0 + angle * angle / 16.0);
    println!("period {found} for {exact}");
    // Backward Euler is slower by (omega dt)^2 / 3, less than 1e-5, and the stiff fibre hardly
    // gives way.
    assert!((found / exact - 1.0).abs() < 1e-3, "{found} for {exact}");
}

/// A bar that hangs from two fibres side by side, and swings, keeps
/// level, and as far from one to the other as it is.
#[test]
fn a_bar_on_two_fibres_keeps_level() {
    let (length, angle) = (0.1_f64, 0.02_f64);
    let along = [angle.sin(), 0.0, -angle.cos()];
    let [x, _, z] = along.map(|x| length * x);
    let cords = [-0.04, 0.04].map(|y| fiber(length, 4, [0.0, y, 0.0], along, "root_joint: Ball()"));
    let object = format!(
        "objects: [(shape: Cuboid(sides: (0.02, 0.1, 0.02)), position: ({x:?}, 0, {:?}),
            moves: Free(mass: Mass(0.05)))],
         object_joints: [(fiber: 0, at: Tip, object: 0), (fiber: 1, at: Tip, object: 0)],
         contact: (friction: Isotropic(0.3)), stepper: (dt: 5e-4)",
        z - 0.01
    );
    let mut run = run(&cords, &[], &object);
    let mut tilt = 0.0_f64;
    for _ in 0..400 {
        run.step();
        let [one, two] = [0, 1].map(|i| run.positions(i)[4]);
        tilt = tilt.max((one.z - two.z).abs());
        // What holds the bar is at its places.
        assert!(((one - two).norm() - 0.08).abs() < 1e-7, "{}", (one - two).norm());
    }
    println!("tilt {tilt:e}");
    assert!(tilt < 1e-6, "{tilt:e}");
}
