use crate::common::{BALL, Client, Served};
use nalgebra::{Point3, Vector3};
use rapunzel_sim::{BodyRef, Plan, Scene, World};
use serde_json::Value;
use std::fs;

/// Steps at each place of the hand, more than in which the ball gets there.
const STEPS: u64 = 20;
/// Way of the hand from place to place, m.
const WAY: f64 = 3e-3;

/// Drags the ball through places, some steps at each, saves, and gives the text and the state.
fn dragged(page: &mut Client, places: &[f64]) -> (String, Value) {
    page.wait("about", |about| about["kind"] == "live" && about["can_drag"] == true);
    page.order(r#"{"do":"take_object","object":0,"at":[0.035,0.0,-0.05]}"#);
    let mut steps = 0;
    for x in places {
        page.order(&format!(r#"{{"do":"move","to":[{x},0.0,-0.05]}}"#));
        for _ in 0..STEPS {
            page.order(r#"{"do":"step"}"#);
            steps += 1;
        }
        let state = page.wait("state", |state| state["steps"] == steps);
        assert_eq!((&state["failure"], &state["drags"]), (&Value::Null, &0.into()));
    }
    page.order(r#"{"do":"drop"}"#);
    for _ in 0..STEPS {
        page.order(r#"{"do":"step"}"#);
        steps += 1;
    }
    let state = page.wait("state", |state| state["steps"] == steps);
    assert_eq!(state["drags"], Value::Null);
    page.order(r#"{"do":"save"}"#);
    let saved = page.wait("saved", |_| true);
    assert_eq!(saved["exact"], true);
    let path = saved["file"].as_str().expect("a path");
    (fs::read_to_string(path).expect("a scene"), state)
}

#[test]
fn a_dragged_object_follows_and_the_run_repeats_to_the_last_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), BALL);
    let mut page = served.page();
    let places: Vec<_> = (1..=15).map(|k| 0.035 - WAY * f64::from(k)).collect();
    let (text, state) = dragged(&mut page, &places);
    let number = state["steps"].as_u64().expect("steps");
    page.wait_frame(|page| page.frame[8..16] == number.to_le_bytes());
    // It is where the hand was: the ball was held 0.035 m from its start.
    let place = page.object(0);
    assert!((place[0] + 0.01).abs() < 1e-6 && place[1] == 0.0, "{place:?}");
    let scene = Scene::from_ron(&text).expect("a scene");
    assert!(scene.objects[0].drag.len() > 4, "{text}");
    let mut world = World::build(&scene).expect("a world");
    let dt = Plan::new(&scene).dt;
    let (mut touched, mut worst) = (0, 0.0_f64);
    let stored = |world: &World| {
        let energy = world.energy();
        energy.kinetic + energy.elastic
    };
    let start = stored(&world);
    for _ in 0..number {
        world.step(dt).expect("a step");
        let center = world.poses().next().expect("a ball").translation.vector;
        for contact in world.contacts() {
            let (BodyRef::Fiber(fiber), BodyRef::Object(0)) = contact.sides.into() else {
                continue;
            };
            let place = on_axis(&world, fiber as usize, contact.at[0]);
            let normal = (place.coords - center).normalize();
            let pressed = contact.force.dot(&normal);
            let slides = (contact.force - pressed * normal).norm();
            touched += 1;
            worst = worst.max((slides - 0.3 * pressed) / contact.force.norm());
        }
    }
    assert!(touched > 20, "{touched}");
    // The force is the mean over a step, and the normal here that of its end: meanwhile it turns by
    // the way of the ball in a step, at its fastest, over its radius.
    let turn = WAY / (1.0 / 60.0 - 0.5 * dt) * dt / 0.02;
    assert!(worst < 1.1 * turn, "Coulomb's law is broken by {worst} of the force");
    assert_eq!(world.time().to_bits(), state["time"].as_f64().expect("s").to_bits());
    for (of, replayed) in [
        ("kinetic", world.energy().kinetic),
        ("elastic", world.energy().elastic),
        ("gravitational", world.energy().gravitational),
    ] {
        assert_eq!(replayed.to_bits(), state[of].as_f64().expect("J").to_bits(), "{of}");
    }
    // What the hairs have gained came from somewhere, the hand on the ball included.
    let (ledger, contacts) = (world.ledger().expect("a ledger"), world.contact_work());
    let gained = stored(&world) - start;
    let work = ledger.total() + contacts.total();
    assert!(contacts.kinematic.abs() > 1e-12, "{contacts:?}");
    assert!(
        (gained - work).abs() < 1e-6 * (gained.abs() + ledger.gravity.abs()),
        "{gained} {work}"
    );
    // Back at the start nothing is dragged.
    page.order(r#"{"do":"restart"}"#);
    page.wait("state", |state| state["steps"] == 0 && state["changed"] == false);
    page.wait_frame(|page| (page.object(0)[0] - 0.035).abs() < 1e-9);
}

/// The place of the axis of a fibre at so many segments from its root.
fn on_axis(world: &World, fiber: usize, at: f64) -> Point3<f64> {
    let positions = world.state(fiber).positions;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let segment = (at.floor() as usize).min(positions.len() - 2);
    let fraction = at - segment as f64;
    positions[segment] + fraction * (positions[segment + 1] - positions[segment])
}

#[test]
fn the_work_of_a_hand_is_in_the_ledger() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), BALL);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "live");
    let names = about["readings"].as_array().expect("names").clone();
    page.order(r#"{"do":"take","strand":1,"point":15,"to":[-0.03,0.0,-0.06]}"#);
    for _ in 0..60 {
        page.order(r#"{"do":"step"}"#);
    }
    let state = page.wait("state", |state| state["steps"] == 60);
    assert!(state["holds"].is_array() && state["failure"] == Value::Null, "{state}");
    let reading = |name: &str| {
        let at = names.iter().position(|of| of.as_str().is_some_and(|of| of.contains(name)));
        state["readings"][at.unwrap_or_else(|| panic!("no {name} in {names:?}"))].as_f64()
    };
    let loads = reading("loads").expect("J");
    // The hand did work, and as much as the hairs have gained and lost otherwise.
    let stored = ["kinetic", "elastic"].iter().map(|of| state[of].as_f64().expect("J"));
    let gained: f64 = stored.sum();
    let works = names.iter().zip(state["readings"].as_array().expect("numbers"));
    let works = works.filter(|(name, _)| name.as_str().is_some_and(|name| name.contains("work")));
    let work: f64 = works.map(|(_, number)| number.as_f64().expect("J")).sum();
    assert!(loads > 1e-9, "{loads}");
    assert!((gained - work).abs() < 1e-6 * loads, "{gained} {work} {loads}");
}

/// Distance of a place from a segment, m.
fn apart(place: &Point3<f64>, [a, b]: [&Point3<f64>; 2]) -> f64 {
    let along = b - a;
    let at = ((place - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (place - (a + at * along)).norm()
}

#[test]
fn a_hair_torn_at_a_ball_does_not_cross_it() {
    let folder = tempfile::tempdir().expect("a folder");
    // In a step of 5 ms the hair could go through the ball.
    let served = Served::scene(folder.path(), &BALL.replace("dt: 1e-3", "dt: 5e-3"));
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live");
    let steps = 30;
    // From its tip a hair is torn to the other side of the ball at once.
    page.order(r#"{"do":"take","strand":0,"point":18,"to":[0.09,0.0,-0.07]}"#);
    for _ in 0..steps {
        page.order(r#"{"do":"step"}"#);
    }
    let state = page.wait("state", |state| state["steps"] == steps);
    assert_eq!(state["failure"], Value::Null);
    page.order(r#"{"do":"save"}"#);
    let saved = page.wait("saved", |_| true);
    let text = fs::read_to_string(saved["file"].as_str().expect("a path")).expect("a scene");
    let scene = Scene::from_ron(&text).expect("a scene");
    let mut world = World::build(&scene).expect("a world");
    let (mut nearest, mut fastest) = (f64::INFINITY, 0.0_f64);
    for _ in 0..steps {
        world.step(Plan::new(&scene).dt).expect("a step");
        let center = world.poses().next().expect("a ball").translation.vector.into();
        for fiber in 0..world.assembly().fibers().len() {
            let state = world.state(fiber);
            for pair in state.positions.windows(2) {
                nearest = nearest.min(apart(&center, [&pair[0], &pair[1]]));
            }
            fastest = state.velocities.iter().map(|v| v.norm()).fold(fastest, f64::max);
        }
    }
    // It comes to the ball, whose radius is 0.02 m, and not into it.
    assert!(nearest > 0.02 && nearest < 0.0205, "{nearest}");
    assert!(fastest > 1.0, "{fastest}");
}

#[test]
fn what_cannot_be_dragged_is_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let free = BALL.replace("-0.07))", "-0.07), moves: Free(mass: Density(1000.0)))");
    let served = Served::scene(folder.path(), &free);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "live");
    assert_eq!(about["can_drag"], false);
    for object in [0, 7] {
        let order = format!(r#"{{"do":"take_object","object":{object},"at":[0.0,0.0,0.0]}}"#);
        page.order(&order);
        page.order(r#"{"do":"move","to":[1.0,0.0,0.0]}"#);
    }
    page.order(r#"{"do":"step"}"#);
    let state = page.wait("state", |state| state["steps"] == 1);
    assert_eq!((&state["drags"], &state["failure"]), (&Value::Null, &Value::Null));
    let moved = page.object(0);
    assert!((Vector3::from(moved) - Vector3::new(0.035, 0.0, -0.07)).norm() < 1e-4, "{moved:?}");
}
