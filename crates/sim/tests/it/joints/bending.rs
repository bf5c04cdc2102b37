//! Joints that are no balls, of fibres that may touch.

use super::{MATTER, apart, fiber, run};
use crate::common::Run;
use crate::common::books::Books;
use std::f64::consts::{PI, TAU};

/// Radius of the sections, m, and mass of a length, kg/m.
const SECTION: f64 = 5e-4;
const MASS: f64 = 1000.0 * PI * SECTION * SECTION;
const GRAVITY: f64 = 9.81;

/// A fibre that is closed to a ring about an axis, with other fields.
fn ring(radius: f64, segments: usize, root: &str, more: &str) -> String {
    format!(
        "(length: {:?}, segments: {segments}, {MATTER}, initial: Helix(radius: {radius:?}, pitch: 0.0),
          root: ({root}), root_joint: Free, {more})",
        TAU * radius
    )
}

/// Fibres with joints that swing or are thrown, with `more` in the scene.
fn moving(which: &str, more: &str) -> Run {
    let more = format!("stepper: (dt: 1e-3, method: BackwardEuler), {more}");
    let oval = |text: String| {
        let flat = "section: Ellipse(a: 7e-4, b: 4e-4)";
        text.replace("section: Circle(radius: 5e-4)", flat)
    };
    let joint = |hold: &str, first: &str, second: &str| {
        format!("(hold: {hold}, first: (fiber: 0, at: {first}), second: (fiber: 1, at: {second}))")
    };
    match which {
        "spliced" => {
            let rods = [
                fiber(0.05, 8, [0.0; 3], [1.0, 0.3, -0.2], ""),
                fiber(0.05, 8, along(0.05), [1.0, 0.3, -0.2], "root_joint: Free"),
            ];
            run(&rods, &[&joint("Spliced", "Tip", "Root")], &more)
        }
        "stiff" => {
            let rods = [
                fiber(0.05, 6, [0.0; 3], [1.0, 0.0, 0.0], "damping_time: 1e-3"),
                fiber(0.04, 6, [0.05, 0.0, 0.0], [0.2, 1.0, 0.0], "root_joint: Free"),
            ];
            run(&rods.map(oval), &[&joint("Stiff", "Tip", "Root")], &more)
        }
        "thrown" => {
            let bent = "root_joint: Free, velocity: (0.1, 0, 0.3), initial: Straight,
                shape: Curved(curvature: (8.0, 3.0, 2.0))";
            let rods = [
                fiber(0.1, 10, [-0.05, 0.0, 0.0], [1.0, 0.0, 0.0], bent),
                fiber(0.1, 10, [0.0, -0.05, 0.0], [0.0, 1.0, 0.0], bent),
            ];
            let more = format!("environment: (gravity: (0, 0, 0)), {more}");
            run(&rods, &[&joint("Stiff", "Node(5)", "Node(5)")], &more)
        }
        _ => {
            let pushed = "closed: (turns: 1.0), damping_time: 1e-3, velocity: (0, 0, 0.1),
                point_forces: [(at: 0.3, value: (1e-3, 2e-3, 2e-3))]";
            run(&[ring(0.03, 24, "", pushed)], &[], &more)
        }
    }
}

/// A place so far along the spliced fibres, m.
fn along(way: f64) -> [f64; 3] {
    let norm = 1.13_f64.sqrt();
    [1.0, 0.3, -0.2].map(|x| way * x / norm)
}

const MOVING: [&str; 4] = ["spliced", "stiff", "thrown", "closed"];

/// m/s
const SLIP: f64 = 1e-6;

fn contact() -> String {
    format!(
        "contact: (friction: Isotropic(0.3), slip: {SLIP:?}, residual: 1e-8, iterations: 100000)"
    )
}

/// Where fibres may touch but do not, joints that bend are what they are without contact, to the
/// tolerances of its solver; and what they do is in the ledger.
#[test]
fn joints_of_fibres_that_may_touch_are_the_same() {
    for which in MOVING {
        let more = format!("{}, output: (ledger: true)", contact());
        let mut books = Books::new(moving(which, &more));
        let mut other = moving(which, "output: (ledger: true)");
        let (mut off, mut stored, mut iterations) = (0.0_f64, 0.0_f64, 0);
        for _ in 0..100 {
            iterations = books.step().worst_iterations.max(iterations);
            other.step();
            for i in 0..other.fibers() {
                off = off.max(apart(&books.run.positions(i), &other.positions(i)));
            }
            let [a, b] = [&books.run, &other].map(|run| run.world.energy());
            stored = stored.max((a.elastic - b.elastic).abs() / b.elastic.abs());
        }
        let [a, b] = [&books.run, &other].map(|run| run.world.momentum().expect("told"));
        println!(
            "{which}: off {off:e}, elastic {stored:e}, books {:e}, {iterations} iterations",
            books.worst
        );
        // Errors of the velocity add up, at most, over the run.
        assert!(off < 10.0 * SLIP * 0.1, "{which}: {off:e}");
        assert!(stored < 1e-3, "{which}: {stored:e}");
        assert!(books.worst < 1e-9, "{which}: {:e}", books.worst);
        let turned = (a.angular - b.angular).norm() / b.angular.norm();
        assert!(turned < 1e-3, "{which}: {turned:e}");
    }
}

/// What bends between fibres that may touch gives none a push: their momentum is kept to rounding.
#[test]
fn joints_that_bend_keep_the_momentum() {
    let mut run = moving("thrown", &contact());
    let before = run.world.momentum().expect("told");
    run.steps(50);
    let after = run.world.momentum().expect("told");
    let off = (after.linear - before.linear).norm() / before.linear.norm();
    println!("momentum off by {off:e}");
    assert!(off < 1e-9, "{off:e}");
}

/// A run goes on from what was saved to the same bits.
#[test]
fn joints_in_contact_resume_to_the_same_bits() {
    for which in MOVING {
        let more = "contact: (friction: Isotropic(0.3)), output: (ledger: true)";
        let mut run = moving(which, more);
        run.steps(10);
        let saved = run.world.snapshot();
        run.steps(10);
        let whole = run.world.snapshot();
        let mut again = moving(which, more);
        again.world.restore(&saved).expect("the same world");
        again.steps(10);
        assert!(again.world.snapshot() == whole, "{which}");
    }
}

/// A ring that falls on the floor rests there as a ring, on which it lies with its weight.
#[test]
fn a_ring_falls_on_the_floor() {
    let root = "position: (0, 0, 3.8e-3), orientation: Along(direction: (0, 0.1, 1))";
    let own = ring(0.03, 24, root, "closed: (turns: 0.0), damping_time: 2e-3");
    let floor = "objects: [(shape: Plane(normal: (0, 0, 1)))], contact: (friction: Isotropic(0.3)),
        stepper: (dt: 1e-3)";
    let mut run = run(&[own], &[], floor);
    run.steps(400);
    let nodes = run.positions(0);
    let open = (nodes[0] - nodes[24]).norm();
    let weight = MASS * TAU * 0.03 * GRAVITY;
    let borne = -run.world.force_on(0).z / weight;
    let speed = run.momentum().norm() / (MASS * TAU * 0.03);
    let heights = nodes.iter().map(|node| node.z);
    let (low, high) = heights.fold((f64::INFINITY, 0.0_f64), |(a, b), z| (a.min(z), b.max(z)));
    println!("open {open:e}, bears {borne}, {speed:e} m/s, from {low} to {high}");
    assert!(open < 1e-6, "{open:e}");
    assert!(speed < 1e-5, "{speed:e}");
    assert!((borne - 1.0).abs() < 1e-3, "{borne}");
    assert!((low - SECTION).abs() < 5e-5 && (high - SECTION).abs() < 5e-5, "{low} {high}");
}

/// A chain of rings hangs from a bar, which bears it: none goes through another.
#[test]
fn rings_hang_in_each_other() {
    let (count, radius, gap, bar) = (3, 0.01, 2e-5, 2e-3);
    // Each is across to the one above, and hangs in it.
    let lower = 2.0 * (radius - SECTION) - gap;
    let rings: Vec<_> = (0..count)
        .map(|i| {
            let middle = bar + SECTION + gap - radius - lower * f64::from(i);
            // The joint is at the bottom of the rings about x, and at the side of those about y.
            let (place, axis) = if i % 2 == 0 {
                (format!("(0, 0, {:?})", middle - radius), "(1, 0, 0)")
            } else {
                (format!("({radius:?}, 0, {middle:?})"), "(0, 1, 0)")
            };
            let root = format!("position: {place}, orientation: Along(direction: {axis})");
            ring(radius, 20, &root, "closed: (turns: 0.0), damping_time: 2e-3")
        })
        .collect();
    let scene = format!(
        "objects: [(shape: Capsule(length: 0.02, radius: {bar:?}), turn: (0, 90, 0))],
         contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3)"
    );
    let mut run = run(&rings, &[], &scene);
    run.steps(300);
    let weight = f64::from(count) * MASS * TAU * radius * GRAVITY;
    let borne = -run.world.force_on(0).z / weight;
    let speed = run.momentum().norm() / (weight / GRAVITY);
    println!("bears {borne}, {speed:e} m/s");
    assert!((borne - 1.0).abs() < 1e-2, "{borne}");
    let heights: Vec<_> = (0..rings.len())
        .map(|i| {
            let heights = run.positions(i).into_iter().map(|node| node.z);
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)))
        })
        .collect();
    println!("{heights:?}");
    for two in heights.windows(2) {
        let (above, below) = (two[0], two[1]);
        // Nodes are on the circle, the middles of segments are what touches.
        let sagitta = radius * (1.0 - (PI / 20.0).cos());
        let apart = below.1 - above.0;
        assert!((apart - 2.0 * SECTION).abs() < 2.5 * sagitta, "{apart}");
    }
}
