use crate::common::{Client, HAIRS, ROPE, Served};
use rapunzel_sim::{Plan, Scene, World};
use rapunzel_view::Options;
use serde_json::Value;
use std::fs;

/// The world of a saved scene after as many steps as were taken on the page.
fn replayed(file: &Value, steps: u64) -> World {
    let text = fs::read_to_string(file.as_str().expect("a path")).expect("the saved scene");
    let scene = Scene::from_ron(&text).expect("a scene");
    let mut world = World::build(&scene).expect("a world");
    let dt = Plan::new(&scene).dt;
    for _ in 0..steps {
        world.step(dt).expect("a step");
    }
    world
}

fn total(state: &Value) -> f64 {
    ["kinetic", "elastic", "gravitational"].iter().map(|of| state[of].as_f64().expect("J")).sum()
}

/// Pulls at a point and carries it through places, two steps at each, then saves, and compares the
/// replay to the last bit.
fn pulled_and_replayed(text: &str, (strand, point): (usize, usize), places: &[[f64; 3]]) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.ron");
    fs::write(&path, text).expect("written");
    let options = Options { what: Some(path), ..Options::local(folder.path().to_owned()) };
    let served = Served::new(options);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live");
    let mut steps = 0;
    let order = |page: &mut Client, order: String| page.order(&order);
    for (k, to) in places.iter().enumerate() {
        let hand = if k == 0 {
            format!(r#"{{"do":"take","strand":{strand},"point":{point},"to":{to:?}}}"#)
        } else {
            format!(r#"{{"do":"move","to":{to:?}}}"#)
        };
        order(&mut page, hand);
        for _ in 0..20 {
            order(&mut page, r#"{"do":"step"}"#.to_owned());
            steps += 1;
        }
    }
    order(&mut page, r#"{"do":"drop"}"#.to_owned());
    for _ in 0..10 {
        order(&mut page, r#"{"do":"step"}"#.to_owned());
        steps += 1;
    }
    let state = page.wait("state", |state| state["steps"].as_u64() == Some(steps));
    assert_eq!(state["failure"], Value::Null);
    page.order(r#"{"do":"save"}"#);
    let saved = page.wait("saved", |_| true);
    assert_eq!(saved["exact"], true);
    let world = replayed(&saved["file"], steps);
    assert_eq!(world.time().to_bits(), state["time"].as_f64().expect("s").to_bits());
    let energy = world.energy();
    let replayed = [energy.kinetic, energy.elastic, energy.gravitational].iter().sum::<f64>();
    assert_eq!(replayed.to_bits(), total(&state).to_bits());
    let still = World::build(&Scene::from_ron(text).expect("a scene")).expect("a world");
    let node = world.stepper().node_of(strand, point);
    (world.node(strand, Some(node)).0 - still.node(strand, Some(node)).0).norm()
}

#[test]
fn a_pulled_rope_repeats_to_the_last_bit() {
    let way = pulled_and_replayed(ROPE, (0, 6), &[[0.1, 0.0, -0.3], [0.2, 0.0, -0.25]]);
    assert!(way > 0.02, "{way}");
}

#[test]
fn the_fixed_end_of_a_rope_is_carried_and_repeats() {
    let way = pulled_and_replayed(ROPE, (0, 0), &[[0.05, 0.0, 0.0], [0.1, 0.0, 0.05]]);
    // It is where it was carried: the square root of 0.1^2 + 0.05^2.
    assert!((way - 0.1118).abs() < 1e-3, "{way}");
}

#[test]
fn a_pulled_hair_repeats_to_the_last_bit() {
    let way = pulled_and_replayed(HAIRS, (1, 15), &[[0.03, 0.0, -0.07], [0.06, 0.0, -0.05]]);
    assert!(way > 0.01, "{way}");
}

#[test]
fn a_node_is_fixed_and_released_by_a_click() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::gallery(folder.path());
    let mut page = served.page();
    page.open("springs/rope");
    // Fixed at both ends it does not stretch under its weight; fixed at none it falls.
    page.order(r#"{"do":"fix","strand":0,"point":9,"fixed":true}"#);
    page.order(r#"{"do":"run"}"#);
    page.wait("state", |state| state["time"].as_f64() > Some(0.3));
    page.wait("state", |state| state["time"].as_f64() > Some(0.5));
    let (upper, lower) = (page.position(0).0, page.position(9).0);
    assert!(upper[2].abs() < 1e-4 && (lower[2] + 0.45).abs() < 1e-4, "{upper:?} {lower:?}");
    for end in [0, 9] {
        page.order(&format!(r#"{{"do":"fix","strand":0,"point":{end},"fixed":false}}"#));
    }
    page.wait("state", |state| state["time"].as_f64() > Some(1.5));
    page.wait("state", |state| state["time"].as_f64() > Some(1.7));
    let fallen = page.position(0).0;
    assert!(fallen[2] < -1.0, "{fallen:?}");
    page.order(r#"{"do":"pause"}"#);
    page.wait("state", |state| state["runs"] == false);
    page.order(r#"{"do":"restart"}"#);
    page.wait("state", |state| state["steps"] == 0);
    page.order(r#"{"do":"save"}"#);
    let saved = page.wait("saved", |_| true);
    let text = fs::read_to_string(saved["file"].as_str().expect("a path")).expect("a scene");
    let again = Scene::from_ron(&text).expect("a scene");
    assert_eq!(again, Scene::from_ron(ROPE).expect("a scene"));
}

#[test]
fn every_slider_changes_its_parameter_and_nonsense_changes_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::gallery(folder.path());
    for name in ["springs/rope", "hairs"] {
        let mut page = served.page();
        page.order(r#"{"do":"control"}"#);
        let about = page.open(name);
        page.order(r#"{"do":"step"}"#);
        let knobs = about["knobs"].as_array().expect("sliders");
        assert!(knobs.len() >= 4, "{about}");
        for knob in knobs {
            let (low, high) = (knob["low"].as_f64(), knob["high"].as_f64());
            let value = (0.25 * high.expect("high") + 0.75 * low.expect("low")).round();
            let value = value.max(low.expect("low"));
            let own = knob["name"].as_str().expect("a name");
            page.order(&format!(r#"{{"do":"set","knob":"{own}","value":{value}}}"#));
            page.wait("state", |state| state["values"][own].as_f64() == Some(value));
        }
        page.order(r#"{"do":"set","knob":"nothing","value":1}"#);
        page.order(r#"{"do":"step"}"#);
        let state = page.wait("state", |state| state["steps"] == 2);
        assert_eq!(state["failure"], Value::Null);
        page.order(r#"{"do":"save"}"#);
        // Sliders were moved after the start.
        assert_eq!(page.wait("saved", |_| true)["exact"], false);
    }
}
