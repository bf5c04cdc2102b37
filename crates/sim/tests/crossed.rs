//! A fibre that lies across a bar: the references of `e_contact.json`.
//!
//! The crossed beams of that file are of linear theory, with deflections of a tenth to a quarter of
//! the length and supports that slide: rods of constant length cannot show them, but the tests of the
//! crate `contact` run them with bodies of that theory.

use nalgebra::Vector3;
use rapunzel_sim::Scene;
use serde::Deserialize;
use std::path::PathBuf;

#[derive(Deserialize)]
struct File {
    cases: Vec<serde_json::Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
struct Crossed {
    name: String,
    #[serde(rename = "G")]
    weight: f64,
    support_axis: [f64; 2],
    sum_of_radii: f64,
    #[serde(rename = "contact_force_EI_over_L2")]
    contact_force: f64,
    contact_arclength: f64,
    contact_theta: f64,
    stations: Vec<Station>,
}

#[derive(Deserialize)]
struct Station {
    s: f64,
    x: f64,
    y: f64,
}

fn cases() -> Vec<Crossed> {
    let folder = std::env::var_os("RAPUNZEL_ORACLES").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../contact/tests/data")),
        PathBuf::from,
    );
    let path = folder.join("e_contact.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    let file: File = serde_json::from_str(&text).expect("the schema");
    let crossed = file.cases.into_iter().filter(|case| case.get("support_axis").is_some());
    crossed.map(|case| serde_json::from_value(case).expect("a crossed fibre")).collect()
}

/// Force, place and shape, once at rest: a rod of 1 m and 1 N m^2, half of the radii its own.
fn errors(case: &Crossed, segments: usize) -> [f64; 4] {
    let radius = 0.5 * case.sum_of_radii;
    let modulus = 4.0 / (std::f64::consts::PI * radius.powi(4));
    let density = case.weight / (9.81 * std::f64::consts::PI * radius * radius);
    let [x, y] = case.support_axis;
    let text = format!(
        "(format: 1, duration: 1.0, fibers: [(length: 1.0, segments: {segments},
        section: Circle(radius: {radius:?}), material: Elastic(density: {density:?},
        youngs_modulus: {modulus:?}, shear_modulus: {modulus:?}),
        root: (orientation: Along(direction: (1, 0, 0))))],
        objects: [(shape: Capsule(length: 1.0, radius: {radius:?}),
        position: ({x:?}, 0.0, {y:?}), turn: (90.0, 0.0, 0.0))],
        contact: (friction: Isotropic(0.0), residual: 1e-9, slip: 1e-9, depth: 1e-6),
        stepper: (dt: 0.1))"
    );
    let scene = Scene::from_ron(&text).expect("a sound scene");
    let mut world = scene.build().expect("a world");
    let mut stepper = scene.stepper_of(&world).expect("a stepper");
    for _ in 0..250 {
        stepper.step(&mut world, 0.1).expect("a step");
    }
    let state = world.state(0);
    let fastest = state.velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(fastest < 1e-7, "{}: {fastest} m/s", case.name);
    let contacts: Vec<_> = world.contacts().collect();
    // Where it lies flat to within the search's tolerance it is held at two points.
    assert!((1..=2).contains(&contacts.len()), "{}: {contacts:?}", case.name);
    let force: Vector3<f64> = contacts.iter().map(|contact| contact.force).sum();
    let moment: f64 = contacts.iter().map(|c| c.at[0] * c.force.norm()).sum();
    let place = moment / force.norm();
    let h = 1.0 / segments as f64;
    let slope = force.x.atan2(force.z);
    let shape = case.stations.iter().map(|station| {
        let at = station.s / h;
        #[expect(clippy::cast_possible_truncation, reason = "a node")]
        let node = (at as usize).min(segments - 1);
        let place = state.positions[node].lerp(&state.positions[node + 1], at - node as f64);
        (place.x - station.x).hypot(place.z - station.y)
    });
    [
        force.norm() / case.contact_force - 1.0,
        place * h - case.contact_arclength,
        -slope - case.contact_theta,
        shape.fold(0.0, f64::max),
    ]
}

#[test]
fn a_fiber_across_a_bar() {
    for case in cases() {
        let [force, place, slope, shape] = errors(&case, 50);
        // The bar meets a chain of straight segments of 0.02: its height is off by h^2 kappa / 8,
        // and the force is across one segment.
        assert!(force.abs() < 5e-3 && shape < 3e-4, "{}: {force} {shape}", case.name);
        assert!(place.abs() < 0.01 && slope.abs() < 0.03, "{}: {place} {slope}", case.name);
    }
}
