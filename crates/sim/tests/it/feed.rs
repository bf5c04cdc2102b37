//! Fibres that are paid out of a nozzle and taken up.

use crate::common::Run;
use crate::common::books::Books;
use rapunzel_sim::Scene;
use std::f64::consts::PI;

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
