//! Rods at rest on boxes, on themselves and on many others: what pushes and holds them
//! is in balance.

use crate::resting::{LEVEL, answer, obeyed};
use approx::assert_relative_eq;
use nalgebra::Vector3;
use rapunzel_sim::statics::{CaseAnswer, TouchedBy};

/// The forces on the rods of an answer but at their clamps, N, and their moments on the origin, N
/// m: weights of `density` (kg/m), lumped on nodes, and contacts of objects.
fn loads(found: &CaseAnswer, density: f64) -> [Vector3<f64>; 2] {
    let contact = found.contact.as_ref().expect("contacts");
    let objects = contact.touches.iter().filter(|touch| matches!(touch.by, TouchedBy::Object(_)));
    let pushes = objects.map(|touch| {
        let force = touch.force * Vector3::from(touch.normal);
        [force, Vector3::from(touch.position).cross(&force)]
    });
    let weights = found.equilibria.iter().flat_map(|rod| {
        let last = rod.stations.len() - 1;
        let spacing = rod.stations[1].s;
        rod.stations.iter().enumerate().map(move |(i, station)| {
            let share = if i == 0 || i == last { 0.5 } else { 1.0 };
            let weight = Vector3::new(0.0, 0.0, -9.81 * density * spacing * share);
            [weight, Vector3::from(station.position).cross(&weight)]
        })
    });
    let zero = [Vector3::zeros(); 2];
    pushes.chain(weights).fold(zero, |[a, b], [force, moment]| [a + force, b + moment])
}

/// The same of what the clamps carry.
fn carried(found: &CaseAnswer) -> [Vector3<f64>; 2] {
    let zero = [Vector3::zeros(); 2];
    found.equilibria.iter().fold(zero, |[a, b], rod| {
        let [force, moment] = [rod.clamp_force, rod.clamp_moment].map(Vector3::from);
        let at = Vector3::from(rod.stations[0].position);
        [a + force, b + moment + at.cross(&force)]
    })
}

/// Forces are in balance to their rounding, moments to what the search leaves on each node and to
/// the heights of segments over their chords, by which places of contacts err.
fn balanced(found: &CaseAnswer, density: f64) {
    let [load, carried] = [loads(found, density), carried(found)];
    let force = (load[0] - carried[0]).norm();
    assert!(force < 1e-12 * (1.0 + load[0].norm()), "{force:e}");
    let nodes: usize = found.equilibria.iter().map(|rod| 2 * rod.stations.len()).sum();
    let contact = found.contact.as_ref().expect("contacts");
    let bends = found.equilibria.iter().map(|rod| rod.sharpest.curvature);
    let height = 0.005_f64.powi(2) / 8.0 * bends.fold(0.0, f64::max);
    let pushes: f64 = contact.touches.iter().map(|touch| touch.force).sum();
    let most = contact.unbalanced * nodes as f64 + height * pushes;
    let moment = (load[1] - carried[1]).norm();
    assert!(moment < most, "{moment:e} {most:e}");
}

/// A heavy cantilever hangs over the edge of a box at its clamp, and of one farther down.
#[test]
fn a_cantilever_lies_on_boxes() {
    for (shape, place) in [
        ("Cuboid(sides: (0.4, 0.4, 0.2))", [0.2, -0.11]),
        ("Cuboid(sides: (0.1, 0.4, 0.2))", [0.5, -0.15]),
    ] {
        let [x, z] = place;
        let found = answer(&format!(
            "(format: 1, length: 1.0, parts: 200, clamp: ({LEVEL}),
              rod: Measured(bending: (0.001, 0.001), torsion: 0.001, linear_density: 0.05,
                  radius: 0.005),
              objects: [(shape: {shape}, position: ({x:?}, 0, {z:?}))])"
        ));
        let contact = found.contact.as_ref().expect("contacts");
        obeyed(contact);
        assert!(!contact.touches.is_empty());
        balanced(&found, 0.05);
    }
}

/// A coil whose turns a force on its end presses on each other: from turn to turn the force in the
/// rod changes by those of the contacts between.
#[test]
fn the_turns_of_a_coil_press_on_each_other() {
    let found = answer(
        "(format: 1, length: 1.0, gravity: (0, 0, 0), parts: 200,
          rod: Measured(bending: (0.01, 0.01), torsion: 0.01, linear_density: 0, radius: 0.005),
          natural_curvature: (0, 12.566, 0.5), clamp: (orientation: Along(direction: (1, 0, 0))),
          end: Free(force: (0, -0.05, 0)),
          objects: [(shape: Plane(normal: (0, 0, 1)), position: (0, 0, -5))])",
    );
    let contact = found.contact.as_ref().expect("contacts");
    obeyed(contact);
    let mut pushing = 0;
    for touch in &contact.touches {
        let TouchedBy::Rod(0, _) = touch.by else { panic!("{touch:?}") };
        pushing += usize::from(touch.force > 1e-6);
    }
    assert!(pushing > 0);
    for station in &found.equilibria[0].stations {
        // Contacts act in the middles of segments.
        let beyond = |at: f64| if at > station.s { 1.0 } else { 0.0 };
        let near = |at: f64| (at - station.s).abs() < 0.006;
        let mut force = Vector3::new(0.0, -0.05, 0.0);
        let mut is_near = false;
        for touch in &contact.touches {
            let TouchedBy::Rod(_, other) = touch.by else { continue };
            is_near |= near(touch.at) || near(other);
            let push = touch.force * Vector3::from(touch.normal);
            force += push * (beyond(touch.at) - beyond(other));
        }
        if !is_near {
            let error = (force - Vector3::from(station.force)).norm();
            assert!(error < 1e-8, "{} {error:e}", station.s);
        }
    }
}

/// Cantilevers along x and as many along y that lie on them, all heavy.
#[test]
fn ten_rods_lie_on_each_other() {
    let (count, density) = (5, 0.01);
    let place = |i: usize| 0.1 + 0.8 * (i as f64) / (count - 1) as f64;
    let one = |i: usize, x: bool| {
        let (at, height) = (place(i), if x { 0.0 } else { 0.005 });
        let [position, along] = if x {
            [format!("(0, {at:?}, {height})"), "(1, 0, 0)".to_owned()]
        } else {
            [format!("({at:?}, 0, {height})"), "(0, 1, 0)".to_owned()]
        };
        format!(
            "length: 1.0, rod: Measured(bending: (0.02, 0.02), torsion: 0.02,
             linear_density: {density}, radius: 0.002),
             clamp: (position: {position}, orientation: Along(direction: {along}))"
        )
    };
    let others = (1..count).map(|i| one(i, true)).chain((0..count).map(|i| one(i, false)));
    let others: Vec<_> = others.map(|one| format!("({one})")).collect();
    let found = answer(&format!(
        "(format: 1, parts: 100, {}, rods: [{}])",
        one(0, true),
        others.join(", ")
    ));
    let contact = found.contact.as_ref().expect("contacts");
    obeyed(contact);
    assert!(contact.touches.len() >= count);
    balanced(&found, density);
    // Those along y lie on the others: nothing draws them down.
    let lifted = contact.touches.iter().map(|touch| touch.force * touch.normal[2]);
    let lifts: Vec<f64> = lifted.collect();
    assert!(lifts.iter().all(|lift| *lift <= 0.0), "{lifts:?}");
    let weight = 2.0 * f64::from(u32::try_from(count).expect("few")) * density * 9.81;
    assert_relative_eq!(carried(&found)[0].z, -weight, max_relative = 1e-9);
}
