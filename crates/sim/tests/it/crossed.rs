//! A fibre that lies across a bar: the references of `e_contact.json`.
//!
//! The crossed beams of that file are of linear theory, with deflections of a tenth to a quarter of
//! the length and supports that slide: rods of constant length cannot show them, but the tests of
//! the crate `contact` run them with bodies of that theory.

use crate::common::Run;
use nalgebra::Vector3;
use rapunzel_oracles::cases;
use serde::Deserialize;
use serde_json::Value;

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
    root_curvature: f64,
    stations: Vec<Station>,
}

#[derive(Deserialize)]
struct Station {
    s: f64,
    x: f64,
    y: f64,
    theta: f64,
    kappa: f64,
}

fn crossed() -> Vec<Crossed> {
    let cases: Vec<Value> = cases("e_contact.json").expect("the oracle");
    let crossed = cases.into_iter().filter(|case| case.get("support_axis").is_some());
    crossed.map(|case| serde_json::from_value(case).expect("a crossed fibre")).collect()
}

/// A number of a case: its name, what the file has, and what the stepper finds.
type Field = (String, f64, f64);

/// A case once at rest, as a rod of 1 m and 1 N m^2 on a bar. It is thin: the place where it
/// touches is known only to where gaps differ by a thousandth of its radius.
fn found(case: &Crossed, segments: usize) -> Vec<Field> {
    let radius = 1e-4 * case.sum_of_radii;
    let bar = case.sum_of_radii - radius;
    let modulus = 4.0 / (std::f64::consts::PI * radius.powi(4));
    let density = case.weight / (9.81 * std::f64::consts::PI * radius * radius);
    let [x, y] = case.support_axis;
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [(length: 1.0, segments: {segments},
        section: Circle(radius: {radius:?}), material: Elastic(density: {density:?},
        youngs_modulus: {modulus:?}, shear_modulus: {modulus:?}),
        root: (orientation: Along(direction: (1, 0, 0))))],
        objects: [(shape: Capsule(length: 1.0, radius: {bar:?}),
        position: ({x:?}, 0.0, {y:?}), turn: (90.0, 0.0, 0.0))],
        contact: (friction: Isotropic(0.0), residual: 1e-9, slip: 1e-9, depth: 1e-6),
        stepper: (dt: 0.1))"
    ));
    run.steps(250);
    let state = run.world.state(0);
    let fastest = state.velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(fastest < 1e-7, "{}: {fastest} m/s", case.name);
    let contacts: Vec<_> = run.world.contacts().collect();
    assert_eq!(contacts.len(), 1, "{}: {contacts:?}", case.name);
    let (h, contact) = (1.0 / segments as f64, contacts[0]);
    let mut fields = vec![
        ("force".into(), case.contact_force, contact.force.norm()),
        ("place".into(), case.contact_arclength, h * contact.at[0]),
        ("normal".into(), case.contact_theta, -contact.force.x.atan2(contact.force.z)),
        ("curvature of the root".into(), case.root_curvature, -state.curvatures[0].y),
    ];
    let angle = |segment: usize| {
        let tangent = state.frames[segment] * Vector3::z();
        tangent.z.atan2(tangent.x)
    };
    for station in &case.stations {
        #[expect(clippy::cast_possible_truncation, reason = "stations are nodes")]
        let node = (station.s * segments as f64).round() as usize;
        assert!((h * node as f64 - station.s).abs() < 1e-12, "{} is a node", station.s);
        let [before, behind] = [node.max(1) - 1, node.min(segments - 1)].map(angle);
        // Frames are those of middles of segments: half a segment short of the ends.
        let turned = 0.5 * h * state.curvatures[node].y;
        let slope = match node {
            0 => behind + turned,
            _ if node == segments => before,
            _ => 0.5 * (before + behind),
        };
        let at = state.positions[node];
        fields.extend(
            [
                ("x", station.x, at.x),
                ("y", station.y, at.z),
                ("angle", station.theta, slope),
                ("curvature", station.kappa, -state.curvatures[node].y),
            ]
            .map(|(name, asked, found)| (format!("{name} at {}", station.s), asked, found)),
        );
    }
    fields
}

/// A chain of straight segments touches the bar as much as `h^2 kappa / 8` nearer than an arc
/// would, and its own bending is of second order, as are the mean frame and the curvature at a
/// node: all errors fall as `h^2`. The factors are not derived: they are up to six times what is
/// found. The normal alone may be that of any place of the segment that touches: half of what it
/// turns by, `h kappa / 2`.
#[test]
fn a_fiber_across_a_bar() {
    let cases = crossed();
    assert!(!cases.is_empty(), "a file without crossed fibres");
    for case in cases {
        for segments in [50, 100, 200] {
            let h = 1.0 / f64::from(segments);
            let bent = case.stations.iter().map(|s| s.kappa.abs()).fold(0.0, f64::max);
            for (name, asked, found) in found(&case, segments as usize) {
                let tolerance = match name.split(' ').next() {
                    Some("force") => 3.0 * h * h * asked,
                    Some("normal") => 0.5 * h * bent,
                    Some("curvature") => 6.0 * h * h,
                    _ => 2.0 * h * h,
                };
                let error = found - asked;
                assert!(error.abs() < tolerance, "{} {segments}: {name} off by {error}", case.name);
            }
        }
    }
}
