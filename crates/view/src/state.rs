//! What pages are told in words: what is shown, and how it stands.

use crate::GalleryScene;
use crate::drag::ObjectDrag;
use crate::frame::Colors;
use crate::knobs::KNOBS;
use crate::live::Live;
use crate::modes::{self, Kind};
use crate::recorded::Recorded;
use crate::stage::{Broken, Showing};
use rapunzel_scene::{Moves, Scene, Wind};
use serde_json::{Value, json};
use std::time::Instant;

/// What is shown, as JSON: its title, what it is, its sliders, or the gallery.
pub(crate) fn about(stage: &Showing, title: &str, gallery: &[GalleryScene], name: &str) -> String {
    let mut about = json!({ "is": "about", "title": title, "has_gallery": !gallery.is_empty() });
    let more = match stage {
        Showing::Gallery => {
            json!({ "kind": "gallery", "scenes": scenes(gallery), "left_out": left_out(gallery) })
        }
        Showing::Live(live) => json!({
            "kind": "live",
            "scene": live.scene.name,
            "duration": live.scene.duration,
            "knobs": knobs(&live.scene),
            "readings": live.world.stepper().energy_columns(),
            "has_modes": modes::next(gallery, name).is_some(),
            "can_pull": live.scene.charging.is_none(),
            "can_drag": live.scene.charging.is_none()
                && live.scene.objects.iter().any(|object| object.moves == Moves::Led),
            "can_hold": live.scene.mass_spring.is_some(),
            "has_contacts": live.scene.contact.is_some(),
            "has_touches": live.scene.contact.is_some()
                || live.scene.mass_spring.as_ref().is_some_and(|springs| springs.contacts.is_some()),
            "ground": live.scene.mass_spring.as_ref()
                .and_then(|springs| springs.contacts.as_ref()?.ground),
            "has_charge": live.scene.charging.is_some(),
            "notes": live.world.notes(),
            "warning": live.unkept.clone().or_else(|| live.world.warning(live.plan.dt)),
        }),
        Showing::Recorded(recorded) => json!({
            "kind": "recorded",
            "frames": recorded.count(),
            "two": recorded.first_of_two().is_some(),
            "has_pushes": true,
        }),
        Showing::Broken(Broken { message, problems }) => {
            let problems: Vec<_> = problems
                .iter()
                .map(|problem| {
                    let place = problem.place.as_ref();
                    json!({
                        "path": problem.path,
                        "message": problem.message,
                        "line": place.map(|place| place.line),
                        "column": place.map(|place| place.column),
                    })
                })
                .collect();
            json!({ "kind": "broken", "message": message, "problems": problems })
        }
    };
    merge(&mut about, more);
    about.to_string()
}

/// How what is shown stands, as JSON.
pub(crate) fn state(stage: &mut Showing, colors: &Colors, pages: usize, now: Instant) -> String {
    let mut state = json!({ "is": "state", "pages": pages, "colored": colors.by.is_some() });
    let more = match stage {
        Showing::Live(live) => live_state(live, now),
        Showing::Recorded(recorded) => recorded_state(recorded, now),
        Showing::Gallery | Showing::Broken(_) => json!({}),
    };
    merge(&mut state, more);
    state.to_string()
}

fn live_state(live: &mut Live, now: Instant) -> Value {
    let time = live.world.time();
    let measured = live.pace.measured(now, time);
    let energy = live.world.energy();
    let contact = &live.report.contact;
    let wind = match &live.scene.mass_spring {
        Some(springs) => springs.wind,
        None => live.scene.environment.wind,
    };
    json!({
        "time": time,
        "steps": live.world.steps(),
        "dt": live.plan.dt,
        "runs": live.pace.runs(),
        "speed": live.pace.speed(),
        "measured": measured,
        "lag": live.pace.lag(),
        "step_ms": live.step_time.as_secs_f64() * 1e3,
        "iterations": live.report.worst_iterations,
        "halvings": live.report.halvings,
        "kinetic": energy.kinetic,
        "elastic": energy.elastic,
        "gravitational": energy.gravitational,
        "contacts": contact.active,
        "unresolved": contact.unresolved,
        "residual": contact.residual,
        "readings": live.world.stepper().energy_row(),
        "failure": live.failure,
        "holds": live.hand.as_ref().map(|hand| [hand.strand, hand.node]),
        "drags": live.drag.as_ref().map(ObjectDrag::object),
        "changed": live.is_changed(),
        "wind": (wind != Wind::default()).then(|| <[f64; 3]>::from(wind.at(time))),
        "values": values(&live.scene),
    })
}

fn recorded_state(recorded: &mut Recorded, now: Instant) -> Value {
    let time = recorded.now.frame.time;
    let measured = recorded.pace.measured(now, time);
    json!({
        "time": time,
        "second": recorded.second().map(|(time, _)| time),
        "over": recorded.second().map(|(_, over)| over),
        "frame": recorded.index,
        "frames": recorded.count(),
        "runs": recorded.pace.runs(),
        "speed": recorded.pace.speed(),
        "measured": measured,
    })
}

/// The scenes of the gallery that stand alone.
fn scenes(gallery: &[GalleryScene]) -> Vec<Value> {
    let own = gallery.iter().filter_map(|item| Some((item, item.scene()?)));
    let told = own.map(|(item, scene)| {
        json!({ "name": item.name, "title": scene.name, "kind": Kind::of(&scene).name() })
    });
    told.collect()
}

/// What else ships, and why it is not in the gallery.
fn left_out(gallery: &[GalleryScene]) -> Vec<Value> {
    let others = gallery.iter().filter_map(|item| Some((item, item.left_out()?)));
    others.map(|(item, why)| json!({ "name": item.name, "why": why.name() })).collect()
}

fn knobs(scene: &Scene) -> Vec<Value> {
    let own = KNOBS.iter().filter_map(|knob| Some((knob, (knob.read)(scene)?)));
    let told = own.map(|(knob, value)| {
        json!({
            "name": knob.name, "unit": knob.unit, "low": knob.low, "high": knob.high,
            "by_factors": knob.by_factors, "value": value,
        })
    });
    told.collect()
}

fn values(scene: &Scene) -> Value {
    let own = KNOBS.iter().filter_map(|knob| Some((knob.name.to_owned(), (knob.read)(scene)?)));
    own.map(|(name, value)| (name, json!(value))).collect::<serde_json::Map<_, _>>().into()
}

fn merge(into: &mut Value, more: Value) {
    if let (Value::Object(into), Value::Object(more)) = (into, more) {
        into.extend(more);
    }
}
