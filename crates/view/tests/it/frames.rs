//! Frames hold where things are, to what they tell.

use crate::common::{CHARGED, HAIRS, ROPE, Served, bump};
use rapunzel_scene::{Plan, Scene};
use rapunzel_sim::World;

const STEPS: u64 = 3;

/// A ring that is closed and touches nothing.
const RING: &str = "(
    format: 1, name: \"A ring\", duration: 1.0, stepper: (dt: 1e-4),
    fibers: [(
        length: 0.06283185307179587, segments: 20, section: Circle(radius: 5e-4),
        initial: Helix(radius: 0.01, pitch: 0.0), root_joint: Free, closed: (turns: 1.0),
    )],
)";

/// A scene after some steps.
fn stepped(text: &str) -> World {
    let scene = Scene::from_ron(text).expect("a scene");
    let mut world = World::build(&scene).expect("a world");
    let dt = Plan::new(&scene).dt;
    for _ in 0..STEPS {
        world.step(dt).expect("a step");
    }
    world
}

#[test]
fn positions_of_all_that_moves_are_off_by_half_a_unit_at_most() {
    let with = |method: &str| HAIRS.replace("dt: 1e-3", &format!("dt: 1e-3, {method}"));
    let texts = [
        HAIRS.to_owned(),
        with("tolerance: 1e-3"),
        with("method: BackwardEuler"),
        with("method: Box()"),
        bump(),
        RING.to_owned(),
        CHARGED.to_owned(),
        ROPE.to_owned(),
    ];
    for text in texts {
        let folder = tempfile::tempdir().expect("a folder");
        let served = Served::scene(folder.path(), &text);
        let mut page = served.page();
        page.wait("about", |about| about["kind"] == "live");
        (0..STEPS).for_each(|_| page.order(r#"{"do":"step"}"#));
        page.wait_frame(|page| page.frame[8..16] == STEPS.to_le_bytes());
        let world = stepped(&text);
        let stepper = world.stepper();
        let mut point = 0;
        for (strand, nodes) in stepper.strand_nodes().into_iter().enumerate() {
            // Springs have no states of fibres.
            let state = stepper.fibers().map(|fibers| fibers.state(strand).positions);
            for node in 0..nodes {
                let expected = state.as_ref().map_or_else(
                    || world.node(strand, Some(stepper.node_of(strand, node))).0,
                    |positions| positions[node],
                );
                let (shown, half) = page.position(point);
                for axis in 0..3 {
                    let error = (shown[axis] - expected[axis]).abs();
                    assert!(error <= half * (1.0 + 1e-9), "{text}: {strand} {node}: {error}");
                }
                point += 1;
            }
        }
        assert_eq!(page.points(), point, "{text}");
    }
}
