//! Rods at rest that touch objects and each other, against theory.

use approx::assert_relative_eq;
use nalgebra::Vector3;
use rapunzel_sim::statics::{Case, CaseAnswer, CaseContact, TouchedBy, solve};
use std::fs;
use std::path::Path;

pub(crate) fn case(text: &str) -> Case {
    Case::from_ron(text).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn answer(text: &str) -> CaseAnswer {
    solve(&case(text)).unwrap_or_else(|error| panic!("{error}"))
}

/// What contacts obey, of rods of about 1 m.
pub(crate) fn obeyed(contact: &CaseContact) {
    let largest = contact.touches.iter().map(|touch| touch.force).fold(0.0, f64::max);
    assert!(contact.penetration < 1e-9, "{:e}", contact.penetration);
    assert!(contact.slackness < 1e-9 * largest, "{:e}", contact.slackness);
    assert!(contact.unbalanced < 1e-7 * largest, "{:e}", contact.unbalanced);
    for touch in &contact.touches {
        assert!(touch.force >= 0.0 && touch.gap.abs() < 1e-9);
        assert_relative_eq!(Vector3::from(touch.normal).norm(), 1.0, epsilon = 1e-9);
    }
}

fn rod(bending: f64, radius: f64) -> String {
    format!(
        "Measured(bending: ({bending}, {bending}), torsion: {bending}, linear_density: 0, radius: {radius})"
    )
}

/// Level along x.
pub(crate) const LEVEL: &str = "orientation: Along(direction: (1, 0, 0))";

/// A cantilever whose tip a force presses on a floor, bent far: the floor bears what an end that
/// slides along the floor lacks.
#[test]
fn a_tip_is_pressed_on_a_floor() {
    let text = |height: f64, end: &str, more: &str| {
        format!(
            "(format: 1, length: 1.0, gravity: (0, 0, 0), rod: {}, parts: 200, end: {end},
              clamp: (position: (0, 0, {height}), {LEVEL}) {more})",
            rod(0.02, 0.01)
        )
    };
    let slides = "Sliding(position: (0, 0, 0), direction: (1, 0, 0), force: 0)";
    let exact = 0.3 + answer(&text(0.4, slides, "")).equilibria[0].end_force[2];
    let floor = ", objects: [(shape: Plane(normal: (0, 0, 2)), position: (0.3, 0, -0.01))]";
    let found = answer(&text(0.4, "Free(force: (0, 0, -0.3))", floor));
    let contact = found.contact.expect("contacts");
    obeyed(&contact);
    assert_eq!(contact.touches.len(), 1);
    let touch = contact.touches[0];
    assert_eq!((touch.rod, touch.at, touch.by), (0, 1.0, TouchedBy::Object(0)));
    // Segments of 1/200 err by their square.
    assert_relative_eq!(touch.force, exact, max_relative = 1e-4);
    assert_relative_eq!(touch.position[2], -0.01, epsilon = 1e-9);
    assert_eq!(touch.normal, [0.0, 0.0, 1.0]);
}

/// Two cantilevers that cross at 1 m of their lengths: a small force on the upper one there is
/// shared as their stiffnesses are.
#[test]
fn crossed_cantilevers_share_a_force() {
    let found = answer(&format!(
        "(format: 1, length: 1.1, gravity: (0, 0, 0), rod: {}, parts: 110,
          clamp: (position: (0, 0, 0.003), {LEVEL}),
          forces: [(at: 1.0, value: (0, 0, -1e-5))],
          rods: [(length: 1.1, rod: {}, clamp: (position: (1, -1, 0),
                  orientation: Along(direction: (0, 1, 0))))])",
        rod(0.02, 0.002),
        rod(0.06, 0.001)
    ));
    let contact = found.contact.expect("contacts");
    obeyed(&contact);
    assert_eq!(contact.touches.len(), 1);
    let touch = contact.touches[0];
    assert_relative_eq!(touch.force, 1e-5 * 0.06 / 0.08, max_relative = 1e-4);
    assert_relative_eq!(touch.at, 1.0, epsilon = 1e-6);
    let TouchedBy::Rod(1, at) = touch.by else { panic!("{:?}", touch.by) };
    assert_relative_eq!(at, 1.0, epsilon = 1e-6);
    // Both sink by what three quarters of the force do to the stiffer one.
    let sunk = found.equilibria[1].stations[100].position[2];
    assert_relative_eq!(sunk, -1e-5 * 0.75 / (3.0 * 0.06), max_relative = 1e-3);
}

/// A cantilever of length 1 over a bar thinner than a segment at the length `a`, with a small force
/// `f` on its tip: the bar bears `f (3 - a) / 2 a`.
#[test]
fn a_cantilever_is_propped_by_a_thin_bar() {
    let a = 0.501;
    let found = answer(&format!(
        "(format: 1, length: 1.0, gravity: (0, 0, 0), rod: {}, parts: 200,
          clamp: ({LEVEL}), end: Free(force: (0, 0, -1e-5)),
          objects: [(shape: Capsule(length: 1, radius: 0.001), turn: (90, 0, 0),
                     position: ({a}, 0, -0.003))])",
        rod(0.02, 0.002)
    ));
    let contact = found.contact.expect("contacts");
    obeyed(&contact);
    let [touch] = contact.touches[..] else { panic!("{:?}", contact.touches) };
    assert_relative_eq!(touch.force, 1e-5 * (3.0 - a) / (2.0 * a), max_relative = 1e-4);
    assert_relative_eq!(touch.at, a, epsilon = 1e-6);
    assert_relative_eq!(touch.position[2], -0.002, epsilon = 1e-6);
}

/// A limp rod that a force draws around a cylinder: of a tension `T` in its free part, bending
/// takes `B / 2 R^2` where it lies on the cylinder, and what is left presses by `/ R`.
#[test]
fn a_rod_is_drawn_around_a_cylinder() {
    let (bending, force, radius): (f64, f64, f64) = (1e-3, 1.0, 0.2);
    let found = answer(&format!(
        "(format: 1, length: 1.0, gravity: (0, 0, 0), rod: {}, parts: 200,
          clamp: (position: (0, 0, 0.2), {LEVEL}), end: Free(force: (0, 0, -{force})),
          objects: [(shape: Capsule(length: 1, radius: 0.19), turn: (90, 0, 0))])",
        rod(bending, 0.01)
    ));
    let contact = found.contact.expect("contacts");
    obeyed(&contact);
    let tension = force - 0.5 * bending / (radius * radius);
    let middle = contact.touches.iter().filter(|touch| (0.1..0.2).contains(&touch.at));
    let middle: Vec<_> = middle.collect();
    assert_eq!(middle.len(), 20);
    for touch in middle {
        assert_relative_eq!(touch.force, tension / radius * 0.005, max_relative = 2e-3);
    }
    // All together they turn the tension around.
    let sum = contact.touches.iter().map(|touch| touch.force * Vector3::from(touch.normal));
    let sum: Vector3<f64> = sum.sum();
    let clamp = Vector3::from(found.equilibria[0].clamp_force);
    assert!((sum + Vector3::new(0.0, 0.0, -force) - clamp).norm() < 1e-9, "{sum} {clamp}");
}

/// The case that ships: a cable over a bar, a wire and the floor. What pushes and holds carries the
/// weight, and the answer is written.
#[test]
fn a_cable_lies_on_a_bar_a_wire_and_the_floor() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/static/laid-on-a-bar.ron");
    let case = case(&fs::read_to_string(path).expect("a case"));
    let found = solve(&case).unwrap_or_else(|error| panic!("{error}"));
    let contact = found.contact.as_ref().expect("contacts");
    obeyed(contact);
    let mut carried = 0.0;
    for touch in &contact.touches {
        // Forces between rods carry nothing together.
        let lifts = matches!(touch.by, TouchedBy::Object(_));
        carried += if lifts { touch.force * touch.normal[2] } else { 0.0 };
    }
    carried -= found.equilibria.iter().map(|rod| rod.clamp_force[2]).sum::<f64>();
    assert_relative_eq!(carried, 9.81 * (1.4 * 0.06 + 0.5 * 0.02), max_relative = 1e-9);
    for by in [TouchedBy::Object(0), TouchedBy::Object(1)] {
        assert!(contact.touches.iter().any(|touch| touch.rod == 0 && touch.by == by), "{by:?}");
    }
    assert!(contact.touches.iter().any(|touch| matches!(touch.by, TouchedBy::Rod(1, _))));
    let folder = tempfile::tempdir().expect("a folder");
    found.save(folder.path(), &case).expect("written");
    let table = fs::read_to_string(folder.path().join("contacts.csv")).expect("a table");
    assert_eq!(table.lines().count(), 1 + contact.touches.len());
    assert!(fs::metadata(folder.path().join("rod-1.csv")).is_ok());
}

#[test]
fn what_starts_in_something_or_is_held_by_nothing_is_told() {
    let solved = |more: &str| {
        let text = format!(
            "(format: 1, length: 1.0, rod: Measured(bending: (1, 1), torsion: 1, \
              linear_density: 0.1, radius: 0.01), {more})"
        );
        solve(&case(&text)).map(|_| ()).expect_err(more).to_string()
    };
    let ball = "objects: [(shape: Ball(radius: 0.1), position: (0.5, 0, 0))]";
    let message = solved(&format!("clamp: ({LEVEL}), {ball}"));
    assert!(message.contains("rod of the case starts inside objects[0]"), "{message}");
    let message = solved(&format!(
        "clamp: ({LEVEL}), rods: [(length: 1, rod: Measured(bending: (1, 1), torsion: 1,
          linear_density: 0.1, radius: 0.01), clamp: (position: (0.5, -0.5, 0),
          orientation: Along(direction: (0, 1, 0))))]"
    ));
    assert!(message.contains("rod of the case starts in rods[0]"), "{message}");
    let floor = "objects: [(shape: Plane(normal: (0, 0, 1)))]";
    let message = solved(&format!("root: Free, clamp: (position: (0, 0, 0.1), {LEVEL}), {floor}"));
    assert!(message.contains("nothing holds the rod of the case"), "{message}");
}

#[test]
fn what_makes_no_sense_of_contacts_is_refused() {
    for (more, word) in [
        ("root: Free", "root"),
        ("objects: [(shape: Ball(radius: 0.1), moves: Free(mass: Mass(1)))]", "moves"),
        (
            "objects: [(shape: Ball(radius: 0.1), motion: Shake(amplitude: (0, 0, 1), frequency: 1))]",
            "motion",
        ),
        ("objects: [(shape: Ball(radius: 0.1), friction: Isotropic(0.2))]", "friction"),
        ("objects: [(shape: Ball(radius: -0.1))]", "radius"),
        ("objects: [(shape: Ball(radius: 0.1))], all_with_turns: 0", "all_with_turns"),
        (
            "objects: [(shape: Ball(radius: 0.1))], forces: [(at: 1, value: (1, 0, 0), frame: Follower)]",
            "follows",
        ),
        ("objects: [(shape: Ball(radius: 0.1))], end: Ring()", "end"),
    ] {
        let text = format!(
            "(format: 1, length: 1.0, rod: Measured(bending: (1, 1), torsion: 1, \
              linear_density: 0.1, radius: 0.01), {more})"
        );
        let message = Case::from_ron(&text).expect_err(more).to_string();
        assert!(message.contains(word), "{more}: {message}");
    }
}
