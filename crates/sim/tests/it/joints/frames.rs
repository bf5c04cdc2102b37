//! Frames of fibres that are joined stiffly, what their works are, and what is refused.

use super::{MATTER, fiber, run};
use crate::common::Run;
use crate::common::books::Books;
use rapunzel_sim::{Scene, World};
use std::f64::consts::PI;

const SIDE: f64 = 0.1;
const SEGMENTS: usize = 16;

/// A square of four rods, joined stiffly, that two forces (N) press at the middles of two sides.
fn frame(force: f64) -> Run {
    let corners = [[0.0, 0.0, 0.0], [SIDE, 0.0, 0.0], [SIDE, SIDE, 0.0], [0.0, SIDE, 0.0]];
    let sides: Vec<String> = (0..4)
        .map(|i| {
            let (from, to) = (corners[i], corners[(i + 1) % 4]);
            let along = [0, 1, 2].map(|k| to[k] - from[k]);
            let press = match i {
                0 => force,
                2 => -force,
                _ => 0.0,
            };
            let more = format!(
                "root_joint: Free, damping_time: 0.02,
                 point_forces: [(at: 0.5, value: (0, {press:?}, 0))]"
            );
            fiber(SIDE, SEGMENTS, from, along, &more)
        })
        .collect();
    let joints: Vec<String> = (0..4)
        .map(|i| {
            let next = (i + 1) % 4;
            format!(
                "(hold: Stiff, first: (fiber: {i}, at: Tip), second: (fiber: {next}, at: Root))"
            )
        })
        .collect();
    let joints: Vec<&str> = joints.iter().map(|joint| &**joint).collect();
    let around = "environment: (gravity: (0, 0, 0)), output: (ledger: true),
        stepper: (dt: 0.02, method: BackwardEuler)";
    run(&sides, &joints, around)
}

/// Two forces `P` that press a square frame bend it by `3 P a / 16` where they act, and the other
/// way by `P a / 16` in the corners and the sides between (theory of frames).
#[test]
fn a_square_frame_is_stiff() {
    let bending = 1e7 * PI / 4.0 * 5e-4_f64.powi(4);
    let force = 1e-3 * bending / (SIDE * SIDE);
    let mut run = frame(force);
    run.steps(1500);
    let unit = force * SIDE / (16.0 * bending);
    let bent = |fiber: usize| run.world.state(fiber).curvatures[SEGMENTS / 2].xy().norm() / unit;
    let found = [0, 1, 2, 3].map(bent);
    println!("moments {found:?} in P a / 16");
    for (found, right) in found.into_iter().zip([3.0, 1.0, 3.0, 1.0]) {
        // Moments are linear along the sides, and joints at the corners as stiff as what they stand
        // for, but for the lever of the middles of segments: of second order.
        assert!((found - right).abs() < 0.5 / SEGMENTS as f64, "{found} for {right}");
    }
}

/// The works on a frame sum up to what it gains, step by step.
#[test]
fn the_ledger_of_joined_fibres_closes() {
    let bending = 1e7 * PI / 4.0 * 5e-4_f64.powi(4);
    let mut books = Books::new(frame(0.5 * bending / (SIDE * SIDE)));
    for _ in 0..40 {
        books.step();
    }
    println!("worst {:e}, whole {:e}", books.worst, books.whole());
    assert!(books.worst < 1e-9, "{:e}", books.worst);
    assert!(books.whole() < 1e-10, "{:e}", books.whole());
}

/// What a scene of fibres and joints is refused with.
fn refused(fibers: &str, joints: &str, more: &str) -> String {
    let text = format!(
        "(format: 1, duration: 1.0, fibers: [{fibers}], joints: [{joints}], stepper: (dt: 1e-3), {more})"
    );
    let scene = match Scene::from_ron(&text) {
        Ok(scene) => scene,
        Err(error) => return error.to_string(),
    };
    match World::build(&scene) {
        Ok(_) => panic!("is not refused: {text}"),
        Err(error) => error.to_string(),
    }
}

/// What makes no sense is refused with what it is, and where.
#[test]
fn joints_that_make_no_sense_are_refused() {
    let free = "root_joint: Free";
    let two = [
        fiber(0.1, 10, [0.0; 3], [1.0, 0.0, 0.0], free),
        fiber(0.1, 10, [0.1, 0.0, 0.0], [1.0, 0.0, 0.0], free),
    ]
    .join(", ");
    let held = [
        fiber(0.1, 10, [0.0; 3], [1.0, 0.0, 0.0], ""),
        fiber(0.1, 10, [0.1, 0.0, 0.0], [1.0, 0.0, 0.0], ""),
    ]
    .join(", ");
    let joint = |hold: &str, first: &str, second: &str| {
        format!("(hold: {hold}, first: (fiber: 0, at: {first}), second: (fiber: 1, at: {second}))")
    };
    let good = joint("Spliced", "Tip", "Root");
    let twice = format!("{good}, {}", joint("Ball", "Tip", "Root"));
    let open = format!(
        "(length: 0.62, segments: 40, {MATTER}, initial: Helix(radius: 0.1, pitch: 0.0),
          root_joint: Free, closed: ())"
    );
    let contact = "contact: (friction: Isotropic(0.3))";
    let on_objects =
        |at: &str| format!("{contact}, object_joints: [(fiber: 0, at: {at}, object: 0)]");
    let cases = [
        (&*two, twice, "", "joints[1] joins what joints[0] joins already"),
        (&*two, joint("Ball", "Tip", "Node(3)"), "", "joints[0] starts open by 3.00e-2 m"),
        (&*held, good.clone(), "", "joints[0].second: is a root that is held"),
        (&*two, joint("Spliced", "Root", "Root"), "", "joints[0].hold: is Spliced"),
        (&*two, joint("Ball", "Node(11)", "Root"), "", "joints[0].first.at: is 11"),
        (&*two, good.replace("fiber: 1", "fiber: 2"), "", "joints[0].second.fiber: is 2"),
        (
            &*two,
            String::new(),
            "object_joints: [(fiber: 0, at: Tip, object: 0)]",
            "object_joints: needs",
        ),
        (&*held, String::new(), &*on_objects("Root"), "object_joints[0]: is a root that is held"),
        (&*two, String::new(), &*on_objects("Node(11)"), "object_joints[0].at: is 11"),
        (
            &*two,
            String::new(),
            &*on_objects("Tip"),
            "object_joints[0].object: is 0, but there is no",
        ),
        (&*open, String::new(), "", "fibre 0 of fibers[0], which is closed, starts open by"),
    ];
    for (fibers, joints, more, told) in cases {
        let message = refused(fibers, &joints, more);
        assert!(message.contains(told), "{message}\ndoes not tell: {told}");
    }
}
