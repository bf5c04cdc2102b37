//! Ball joints.

use super::{fiber, run};
use nalgebra::{Matrix2, Vector2};

const LENGTH: f64 = 0.1;
const SEGMENTS: usize = 5;

/// A double pendulum of two rods so stiff that they hardly bend, at these small angles (rad).
fn pendulum(angles: [f64; 2], stepper: &str) -> crate::common::Run {
    let stiff = "section: Circle(radius: 2e-3),
        material: Elastic(density: 1000.0, youngs_modulus: 1e13, shear_modulus: 4e12)";
    let along = angles.map(|angle| [angle.sin(), 0.0, -angle.cos()]);
    let middle = along[0].map(|x| LENGTH * x);
    let rods = [
        fiber(LENGTH, SEGMENTS, [0.0; 3], along[0], "root_joint: Ball()"),
        fiber(LENGTH, SEGMENTS, middle, along[1], "root_joint: Free"),
    ];
    let rods = rods.map(|rod| rod.replace(super::MATTER, stiff));
    let joint = "(hold: Ball, first: (fiber: 0, at: Tip), second: (fiber: 1, at: Root))";
    run(&rods, &[joint], stepper)
}

/// Squared frequencies and modes of the small motions of the two angles: rods whose mass is at
/// their nodes.
fn modes() -> [(f64, Vector2<f64>); 2] {
    // For rods of mass and length 1: moments of the mass at the nodes and of the sections.
    let n = SEGMENTS as f64;
    let section = 0.25 * (2e-3 / LENGTH) * (2e-3 / LENGTH);
    let inertia = 1.0 / 3.0 + 1.0 / (6.0 * n * n) + section;
    let mass = Matrix2::new(inertia + 1.0, 0.5, 0.5, inertia);
    let stiffness = Matrix2::new(1.5, 0.0, 0.0, 0.5) * (9.81 / LENGTH);
    // M is positive definite: of M^-1 K the eigenvalues are real.
    let system = mass.try_inverse().expect("definite") * stiffness;
    let (trace, det) = (system.trace(), system.determinant());
    let root = (0.25 * trace * trace - det).sqrt();
    [0.5 * trace - root, 0.5 * trace + root].map(|square| {
        let mode = Vector2::new(-system.m12, system.m11 - square).normalize();
        (square, mode)
    })
}

/// Both small motions of a double pendulum have the frequencies of rods at a ball joint.
#[test]
fn a_double_pendulum_swings_as_rods_do() {
    for (square, mode) in modes() {
        let period = std::f64::consts::TAU / square.sqrt();
        let dt = period / 400.0;
        let angles = [1e-3 * mode.x, 1e-3 * mode.y];
        let mut run = pendulum(
            angles,
            &format!("stepper: (dt: {dt:?}, method: Staggered(rho_infinity: 0.9))"),
        );
        let (mut last, mut time, mut crossings) = (run.positions(0)[SEGMENTS].x, 0.0, Vec::new());
        while crossings.len() < 3 {
            run.step();
            time += dt;
            let x = run.positions(0)[SEGMENTS].x;
            if x * last < 0.0 {
                crossings.push(time - dt * x / (x - last));
            }
            last = x;
        }
        let found = crossings[2] - crossings[0];
        println!("period {found} for {period}");
        // Of second order in the step: (omega dt)^2 / 12 = 2e-5.
        assert!((found / period - 1.0).abs() < 1e-4, "{found} for {period}");
    }
}

/// With the midpoint rule a double pendulum that swings wide keeps its energy.
#[test]
fn a_double_pendulum_keeps_its_energy() {
    let mut run = pendulum([1.0, 1.5], "stepper: (dt: 1e-3, method: Staggered(rho_infinity: 1.0))");
    let energy = |run: &crate::common::Run| run.world.energy().total();
    let start = energy(&run);
    let (mut low, mut high) = (start, start);
    for _ in 0..500 {
        run.step();
        low = low.min(energy(&run));
        high = high.max(energy(&run));
    }
    let kinetic = run.world.energy().kinetic;
    println!("energy {start:e} from {low:e} to {high:e}, kinetic {kinetic:e}");
    let weight = start.abs();
    assert!((high - low) < 2e-3 * weight, "{low:e} {high:e} of {weight:e}");
}

/// Fibres that are joined in their middles and at ends and unbend as they fly keep their momentum
/// to rounding, and angular momentum to the order of the method; joints stay closed to rounding.
#[test]
fn joined_fibres_keep_their_momentum() {
    let bent = "root_joint: Free, velocity: (0.1, 0, 0.3), initial: Straight,
        shape: Curved(curvature: (8.0, 3.0, 2.0))";
    let rods = [
        fiber(0.1, 10, [-0.05, 0.0, 0.0], [1.0, 0.0, 0.0], bent),
        fiber(0.1, 10, [0.0, -0.05, 0.0], [0.0, 1.0, 0.0], bent),
        fiber(0.05, 6, [0.05, 0.0, 0.0], [0.0, 0.0, 1.0], bent),
    ];
    for hold in ["Ball", "Stiff"] {
        let joint = |first: &str, second: &str| {
            format!("(hold: {hold}, first: (fiber: {first}), second: (fiber: {second}))")
        };
        let joints =
            [joint("0, at: Node(5)", "1, at: Node(5)"), joint("2, at: Root", "0, at: Tip")];
        let joints = joints.each_ref().map(|joint| &**joint);
        let turned = [(1e-4, 200), (5e-5, 400)].map(|(dt, steps): (f64, usize)| {
            let around = format!("environment: (gravity: (0, 0, 0)), stepper: (dt: {dt:?})");
            let mut run = run(&rods, &joints, &around);
            let before = run.world.momentum().expect("told");
            let elastic = run.world.energy().elastic;
            run.steps(steps);
            let after = run.world.momentum().expect("told");
            let linear = (after.linear - before.linear).norm() / before.linear.norm();
            let positions = [0, 1, 2].map(|fiber| run.positions(fiber));
            let open = (positions[0][5] - positions[1][5]).norm();
            let open = open.max((positions[0][10] - positions[2][0]).norm());
            // About the center, which flies straight: of the momentum of what unbends.
            let mass = before.linear.norm() / 0.1_f64.hypot(0.3);
            let scale = 0.1 * (2.0 * elastic * mass).sqrt();
            let angular = (after.angular - before.angular).norm() / scale;
            println!("{hold} {dt}: linear {linear:e}, angular {angular:e}, open {open:e}");
            assert!(linear < 1e-9, "{hold}: {linear:e}");
            assert!(open < 1e-12, "{hold}: {open:e}");
            angular
        });
        assert!(turned[0] < 1e-2 && turned[1] < 0.5 * turned[0], "{hold}: {turned:?}");
    }
}

/// A run with joints goes on from what was saved to the same bits.
#[test]
fn joined_fibres_resume_to_the_same_bits() {
    let stepper = "stepper: (dt: 1e-3), output: (ledger: true)";
    let mut run = pendulum([0.5, 0.1], stepper);
    run.steps(20);
    let saved = run.world.snapshot();
    run.steps(20);
    let whole = run.world.snapshot();
    let mut again = pendulum([0.5, 0.1], stepper);
    again.world.restore(&saved).expect("the same world");
    again.steps(20);
    assert!(again.world.snapshot() == whole);
}
