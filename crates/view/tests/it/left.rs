use crate::common::{BALL, HAIRS, ROPE, Served};
use rapunzel_sim::{Plan, Scene, World};
use rapunzel_view::{GalleryScene, Options};
use serde_json::Value;
use std::fs;

/// Leaves a scene after 30 steps in which a hand pulled, takes it up and goes on for 20 steps: all
/// is as in a run of the saved scene that was never left.
fn left_and_taken_up(text: &str, hand: &str, move_on: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut served = Served::scene(folder.path(), text);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live");
    page.order(hand);
    for _ in 0..15 {
        page.order(r#"{"do":"step"}"#);
    }
    page.order(move_on);
    for _ in 0..15 {
        page.order(r#"{"do":"step"}"#);
    }
    let state = page.wait("state", |state| state["steps"] == 30);
    assert_eq!(state["failure"], Value::Null);
    served.stop();
    let kept = served.kept.clone().expect("the scene is kept");
    let options = Options { what: Some(kept.clone()), ..Options::local(folder.path().to_owned()) };
    let served = Served::new(options);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "live");
    assert_eq!(about["warning"], Value::Null);
    page.wait("state", |state| state["steps"] == 30);
    for _ in 0..20 {
        page.order(r#"{"do":"step"}"#);
    }
    let state = page.wait("state", |state| state["steps"] == 50);
    let scene = Scene::from_ron(&fs::read_to_string(&kept).expect("text")).expect("a scene");
    let mut world = World::build(&scene).expect("a world");
    for _ in 0..50 {
        world.step(Plan::new(&scene).dt).expect("a step");
    }
    let energy = world.energy();
    let replayed = [energy.kinetic, energy.elastic, energy.gravitational];
    for (of, energy) in ["kinetic", "elastic", "gravitational"].iter().zip(replayed) {
        assert_eq!(energy.to_bits(), state[of].as_f64().expect("J").to_bits(), "{of}");
    }
}

#[test]
fn a_rope_that_was_left_goes_on_to_the_same_bits() {
    let hand = r#"{"do":"take","strand":0,"point":6,"to":[0.1,0.0,-0.3]}"#;
    left_and_taken_up(ROPE, hand, r#"{"do":"move","to":[0.2,0.0,-0.25]}"#);
}

#[test]
fn hairs_with_a_dragged_ball_that_were_left_go_on_to_the_same_bits() {
    let hand = r#"{"do":"take_object","object":0,"at":[0.035,0.0,-0.05]}"#;
    left_and_taken_up(BALL, hand, r#"{"do":"move","to":[0.01,0.0,-0.05]}"#);
}

#[test]
fn what_is_kept_of_another_scene_or_damaged_is_told_and_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut served = Served::scene(folder.path(), HAIRS);
    let mut page = served.page();
    page.order(r#"{"do":"step"}"#);
    page.wait("state", |state| state["steps"] == 1);
    served.stop();
    let kept = served.kept.clone().expect("the scene is kept").with_extension("checkpoint");
    for damage in [false, true] {
        if damage {
            fs::write(folder.path().join("scene.checkpoint"), b"RAPUNZEL or not").expect("written");
        } else {
            fs::copy(&kept, folder.path().join("scene.checkpoint")).expect("copied");
        }
        let served = Served::scene(folder.path(), ROPE);
        let mut page = served.page();
        let about = page.wait("about", |about| about["kind"] == "live");
        assert!(about["warning"].is_string(), "{about}");
        page.wait("state", |state| state["steps"] == 0);
    }
}

#[test]
fn nothing_is_kept_of_what_did_not_move() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut served = Served::scene(folder.path(), HAIRS);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live");
    served.stop();
    assert_eq!(served.kept, None);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

/// A scene of the gallery that names a file is saved with it, runs from there to the same bits, and
/// takes the place of no other file of that name.
#[test]
fn a_scene_with_a_file_is_saved_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let block = "v 0 0 0\nv .02 0 0\nv 0 .02 0\nv 0 0 .02\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let text = BALL.replace("Ball(radius: 0.02)", "Mesh(file: \"block.obj\", spacing: 0.002)");
    let files = vec![("block.obj".to_owned(), block.to_owned())];
    let gallery = vec![GalleryScene { name: "block".into(), text, files }];
    let options = Options { gallery, ..Options::local(folder.path().to_owned()) };
    let served = Served::new(options);
    let mut page = served.page();
    page.open("block");
    // What it needs while it is shown is elsewhere.
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    for _ in 0..3 {
        page.order(r#"{"do":"step"}"#);
    }
    let state = page.wait("state", |state| state["steps"] == 3);
    page.order(r#"{"do":"save"}"#);
    let saved = page.wait("saved", |saved| saved["exact"] == true);
    let beside = folder.path().join("block.obj");
    assert_eq!(fs::read_to_string(&beside).expect("text"), block);
    let text = fs::read_to_string(saved["file"].as_str().expect("a path")).expect("text");
    let scene = Scene::from_ron(&text).expect("a scene").seen_from(folder.path());
    let mut world = World::build(&scene).expect("a world");
    for _ in 0..3 {
        world.step(Plan::new(&scene).dt).expect("a step");
    }
    let kinetic = state["kinetic"].as_f64().expect("J");
    assert_eq!(world.energy().kinetic.to_bits(), kinetic.to_bits());
    fs::write(&beside, "another").expect("written");
    page.order(r#"{"do":"save"}"#);
    let complaint = page.wait("complaint", |_| true);
    assert!(complaint["message"].as_str().is_some_and(|text| text.contains("block.obj")));
    assert_eq!(fs::read_to_string(&beside).expect("text"), "another");
}
