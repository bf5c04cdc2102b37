use crate::common::{CHARGED, HAIRS, Served, bump};
use crate::page::shipped;
use std::fs;

/// Distance of a place from the nearest point of the last frame, m.
fn nearest(page: &crate::common::Client, place: &[f64]) -> f64 {
    let to = |point: usize| {
        let (at, _) = page.position(point);
        (0..3).map(|k| (at[k] - place[k]).powi(2)).sum::<f64>().sqrt()
    };
    (0..page.points()).map(to).fold(f64::INFINITY, f64::min)
}

#[test]
fn contacts_are_shown_on_demand_where_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), &bump());
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live" && about["has_contacts"] == true);
    for _ in 0..40 {
        page.order(r#"{"do":"step"}"#);
    }
    let state = page.wait("state", |state| state["steps"] == 40);
    let active = state["contacts"].as_u64().expect("a number");
    assert!(active > 0, "{state}");
    page.wait_frame(|page| page.extras()[0].is_empty());
    page.order(r#"{"do":"show","contacts":true,"volumes":null,"field":false}"#);
    page.wait_frame(|page| !page.extras()[0].is_empty());
    let [pushes, boxes, lines] = page.extras();
    assert!(pushes.len() as u64 <= active && boxes.is_empty() && lines.is_empty());
    for push in &pushes {
        // Segments are 5 mm long: no place of a fibre is farther from a node than half of that.
        let off = nearest(&page, &push[..3]);
        assert!(off < 2.6e-3, "{off}");
        let ball = page.object(0);
        let out: f64 = (0..3).map(|k| (push[k] - ball[k]) * push[3 + k]).sum();
        let force = push[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(force > 0.0 && out > 0.0, "the ball pushes outward: {push:?}");
    }
    page.order(r#"{"do":"show","contacts":false,"volumes":null,"field":false}"#);
    page.wait_frame(|page| page.extras()[0].is_empty());
}

#[test]
fn contacts_of_a_body_of_springs_are_shown_on_the_ground() {
    let ring = shipped().into_iter().find(|scene| scene.name == "mass-spring/ring").expect("ships");
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), &ring.text);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live" && about["has_touches"] == true);
    page.order(r#"{"do":"show","contacts":true,"volumes":null,"field":false}"#);
    page.order(r#"{"do":"run"}"#);
    page.wait_frame(|page| !page.extras()[0].is_empty());
    let [pushes, ..] = page.extras();
    for push in &pushes {
        // In singles, at the height of the ground, which pushes upward.
        assert!(push[2].abs() < 1e-7 && push[5] > 0.0, "{push:?}");
    }
}

#[test]
fn bounding_volumes_hold_what_they_are_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), HAIRS);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live");
    for (level, count) in [(0, 60), (1, 4), (9, 1)] {
        let show = format!(r#"{{"do":"show","contacts":false,"volumes":{level},"field":false}}"#);
        page.order(&show);
        page.wait_frame(|page| {
            let boxes = page.extras()[1].len();
            boxes == count || (level == 1 && (4..=10).contains(&boxes))
        });
        let boxes = &page.extras()[1];
        for point in 0..page.points() {
            let (at, error) = page.position(point);
            // Positions come in 16 bits and boxes in singles.
            let slack = error + 1e-7;
            let holds = |corners: &Vec<f64>| {
                (0..3).all(|k| corners[k] - slack <= at[k] && at[k] <= corners[3 + k] + slack)
            };
            assert!(boxes.iter().any(holds), "{level} {at:?}");
        }
    }
}

#[test]
fn field_lines_lead_away_from_charged_hairs() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), CHARGED);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "live");
    assert_eq!((&about["has_charge"], &about["can_pull"]), (&true.into(), &false.into()));
    let knobs = about["knobs"].as_array().expect("sliders");
    assert!(knobs.iter().any(|knob| knob["name"] == "fiber_charge"), "{knobs:?}");
    page.order(r#"{"do":"show","contacts":false,"volumes":null,"field":true}"#);
    // Nothing is dealt yet, and so there is no field.
    page.wait_frame(|page| page.extras()[2].is_empty());
    page.order(r#"{"do":"step"}"#);
    page.wait_frame(|page| !page.extras()[2].is_empty());
    let lines = &page.extras()[2];
    let farthest = lines.iter().map(|point| nearest(&page, point)).fold(0.0, f64::max);
    assert!(lines.len() > 50 && farthest > 0.05, "{} {farthest}", lines.len());
    // Half the charge from the start on is half the charge in the end.
    page.order(r#"{"do":"restart"}"#);
    page.wait("state", |state| state["steps"] == 0);
    page.order(r#"{"do":"set","knob":"fiber_charge","value":5e-12}"#);
    page.wait("state", |state| state["values"]["fiber_charge"] == 5e-12);
    page.order(r#"{"do":"save"}"#);
    let saved = page.wait("saved", |_| true);
    let text = fs::read_to_string(saved["file"].as_str().expect("a path")).expect("a scene");
    assert!(text.contains("-5e-12") && saved["exact"] == true, "{text}");
}
