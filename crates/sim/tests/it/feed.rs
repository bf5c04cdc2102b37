//! Fibres that are paid out of a nozzle and taken up.

use crate::common::Run;
use crate::common::books::Books;
use rapunzel_sim::{Scene, World};
use std::f64::consts::{PI, TAU};

const MATTER: &str = "segments: 20, section: Circle(radius: 5e-4),
    material: Elastic(density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6)";

/// A thread that is lowered without a floor in reach hangs by the weight of what is outside, with
/// and without contact, and its books close; drawn in again it lifts what it carries by the work
/// that this takes.
#[test]
fn a_thread_is_lowered_and_drawn_in() {
    let weight = 1000.0 * PI * 5e-4_f64.powi(2) * 9.81;
    let load = 1e-3;
    for contact in
        ["", "contact: (friction: Isotropic(0.0)), objects: [(shape: Plane(normal: (0, 0, 1)))],"]
    {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({MATTER}, length: 0.2,
                root: (position: (0, 0, 1)), tip: Loaded(force: (value: (0, 0, -{load:?}))),
                feed: Some((inside: 0.15, lengths: [(time: 0.5, length: 0.1),
                    (time: 1.0, length: -0.02)])))],
            {contact} stepper: (dt: 2.5e-3), output: (ledger: true, frame_rate: 40.0))"
        );
        let mut books = Books::new(Run::read(&text));
        let mut outside = 0.05;
        for k in 1..=400_u32 {
            books.step();
            let t = f64::from(k) * 2.5e-3;
            outside = 0.05 + if t <= 0.5 { 0.2 * t } else { 0.1 - 0.24 * (t - 0.5) };
            let state = books.run.world.state(0);
            let hung = -state.forces[0].z;
            // Where the rate jumps all that moves is hit.
            if (t - 0.5).abs() > 0.1 {
                let right = load + weight * outside;
                assert!((hung / right - 1.0).abs() < 1e-6, "{t} s: {hung:e} for {right:e}");
            }
            let tip = state.positions[20].z;
            assert!((tip - (1.0 - outside)).abs() < 1e-12, "{tip}");
        }
        assert!(books.whole() < 1e-10, "{:e}", books.whole());
        // In all, 2 cm against the load and the weight of what has gone in, and the change of
        // speed.
        let supports = books.run.world.ledger().expect("kept").supports;
        let mass = 1000.0 * PI * 5e-4_f64.powi(2) * 0.2;
        let kinetic = 0.5 * mass * (0.24_f64.powi(2) - 0.2_f64.powi(2));
        let right =
            load * (0.05 - outside) + 0.5 * weight * (0.05_f64.powi(2) - outside.powi(2)) + kinetic;
        let room = 0.2 * load * 2.5e-3 + mass * 0.44_f64.powi(2);
        assert!((supports - right).abs() < room, "{supports:e} for {right:e}, {room:e}");
    }
}

fn coiling(extra: &str) -> String {
    format!(
        "(format: 1, duration: 3.0, fibers: [(length: 0.4, segments: 100,
            section: Circle(radius: 8e-4),
            material: Elastic(density: 1180.0, youngs_modulus: 1.3e6, shear_modulus: 4.3e5),
            damping_time: 5e-3,
            root: (position: (0, 0, 0.06), orientation: Along(direction: (0.02, 0.01, -1))),
            feed: Some((inside: 0.35, rate: 0.1)))],
        objects: [(shape: Plane(normal: (0, 0, 1)) {extra})],
        contact: (friction: Isotropic(0.6)), environment: (viscosity: 1.8e-5),
        stepper: (dt: 5e-3), output: (frame_rate: 20.0))"
    )
}

/// A rod that is fed onto a floor lies down in coils of the size that weight and stiffness give it,
/// and nothing of it goes through the floor; from what is saved in the midst of that it goes on to
/// the same bits.
#[test]
fn a_rod_coils_on_a_floor() {
    let text = coiling("");
    let mut run = Run::read(&text);
    let mut saved = None;
    let (mut angle, mut before) = (0.0, 0.0);
    let landed = 0.7;
    while run.world.time() < 3.0 - 1e-9 {
        run.step();
        let nodes = run.positions(0);
        let lowest = nodes.iter().map(|node| node.z).fold(f64::INFINITY, f64::min);
        assert!(lowest > 0.75 * 8e-4, "{lowest}");
        if saved.is_none() && run.world.time() > 1.5 {
            saved = Some(run.world.snapshot());
        }
        // The way it is laid down turns.
        let touch = (1..=100).find(|&a| nodes[a].z < 3.0 * 8e-4);
        if let (Some(a), true) = (touch, run.world.time() > landed) {
            let along = nodes[a] - nodes[a - 1];
            let now = along.y.atan2(along.x);
            angle += (now - before + PI).rem_euclid(TAU) - PI;
            before = now;
        }
    }
    // 0.23 m in circles of about 19 mm, the first of them still on its way.
    let turns = (angle / TAU).abs();
    println!("{turns} turns");
    assert!((0.7..3.0).contains(&turns), "{turns}");
    let mut again = World::build(&Scene::from_ron(&text).expect("a scene")).expect("a world");
    again.restore(&saved.expect("saved")).expect("own numbers");
    while again.time() < 3.0 - 1e-9 {
        again.step(run.dt).expect("a step");
    }
    assert!(again.state(0) == run.world.state(0));
}

/// On a belt as fast as the feed it lies down straight.
#[test]
fn a_rod_is_laid_on_a_belt() {
    let belt = ", motion: Translate(velocity: (0.1, 0, 0), until: 9.0)";
    let mut run = Run::read(&coiling(belt));
    while run.world.time() < 3.0 - 1e-9 {
        run.step();
    }
    let nodes = run.positions(0);
    // What was laid down before it had found its way apart.
    let laid: Vec<_> = nodes.iter().filter(|node| node.z < 1e-3).take(30).collect();
    assert!(laid.len() == 30, "{nodes:?}");
    let (first, last) = (laid[0], laid[29]);
    let aside = laid.iter().map(|node| (node.y - first.y).abs()).fold(0.0, f64::max);
    assert!(aside < 5e-3 && (last.x - first.x) > 0.9 * 29.0 * 4e-3, "{aside} {first} {last}");
}

/// The template is fed, with contact.
#[test]
fn the_template_of_coiling_sets_out() {
    let text = include_str!("../../../../scenes/contact/coiling.ron");
    let mut run = Run::new(&Scene::from_ron(text).expect("it ships"));
    run.steps(20);
    let out = 0.13 - run.positions(0)[300].z;
    // It leans by a fortieth.
    let right = 0.12 + 20.0 * 5e-3 * 0.06;
    assert!((out / right - 1.0).abs() < 1e-3, "{out} for {right}");
}

#[test]
fn feeds_that_a_scene_cannot_follow_are_refused() {
    let refused = |feed: &str, more: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [({MATTER}, length: 0.2, feed: Some(({feed})),
                {more})], stepper: (dt: 1e-2), output: (frame_rate: 100.0))"
        );
        Scene::from_ron(&text).expect_err("nonsense").to_string()
    };
    for (feed, more, field, why) in [
        ("inside: 0.1, rate: 0.2", "", "fibers[0].feed", "only 0.1"),
        ("inside: 0.1, rate: -0.2", "", "fibers[0].feed", "last segment"),
        ("inside: 0.1, rate: 2.0, until: 0.02", "", "fibers[0].feed", "more than a segment"),
        (
            "inside: 0.1, lengths: [(time: 2.0, length: 0.1), (time: 1.0, length: 0.2)]",
            "",
            "feed.lengths[1].time",
            "later",
        ),
        (
            "inside: 0.1, rate: 0.01, lengths: [(time: 2.0, length: 0.1)]",
            "",
            "feed.lengths",
            "beside",
        ),
        ("inside: 0.1", "root_joint: Free", "root_joint", "Clamped"),
        ("inside: 0.1", "shape: Curved(curvature: (1, 0, 0))", "initial", "Straight"),
        ("inside: 0.1", "closed: Some(())", "feed", "joined"),
    ] {
        let error = refused(feed, more);
        assert!(error.contains(field) && error.contains(why), "{feed}: {error}");
    }
}
