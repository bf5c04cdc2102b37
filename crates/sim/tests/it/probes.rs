//! What probes tell, against statics, and the plots of a run.

use nalgebra::Vector3;
use rapunzel_sim::{Cancel, Control, Existing, RunFolder, Scene, World, run};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Runs a scene in a folder.
fn ran(scene: &Scene, path: &Path) {
    let mut folder = RunFolder::open(path, Existing::Refuse).expect("a new folder");
    let (cancel, mut sync_is_due, mut progress) = (Cancel::new(), || false, |_: &_| ());
    let control = Control {
        sync_is_due: &mut sync_is_due,
        cancel: &cancel,
        progress: &mut progress,
        stopwatch: None,
    };
    run(scene, World::build(scene).expect("a world"), &mut folder, control).expect("a run");
}

/// The columns of the last row of a table, by their names.
fn last_row(path: &Path) -> BTreeMap<String, f64> {
    let text = fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let names = lines.next().expect("a head").split(',').map(str::to_owned);
    let last = lines.next_back().expect("a row").split(',');
    names.zip(last.map(|x| x.parse().expect("a number"))).collect()
}

fn vector(row: &BTreeMap<String, f64>, name: &str, unit: &str) -> Vector3<f64> {
    let one = |axis: &str| row[&format!("{name}{axis} ({unit})")];
    Vector3::new(one("x"), one("y"), one("z"))
}

/// A hair that juts out and sags: forces and moments inside it, and those of its clamp, are what
/// its weight asks for, and its energies those of the whole, it being the only one.
#[test]
fn a_hair_at_rest_bears_its_weight() {
    let text = "(format: 1, duration: 400.0, fibers: [(
            length: 0.05, segments: 20, section: Ellipse(a: 5e-5, b: 4e-5), damping_time: 1.0,
            taper: [(at: 0), (at: 1, section: Circle(radius: 2e-5))],
            shape: Helix(radius: 0.004, pitch: 0.02),
            root: (orientation: Along(direction: (1, 0, 0.2))))],
        environment: (gravity: (0, 0, -9.81)),
        stepper: (dt: 2.0, method: BackwardEuler),
        output: (frame_rate: 0.1, probes: [
            (node: At(index: 0), quantity: Reaction), (quantity: Reaction),
            (node: At(index: 7), quantity: Moment), (node: At(index: 7), quantity: Force),
            (node: At(index: 7), quantity: Tension), (node: At(index: 7), quantity: Curvature),
            (node: At(index: 7), quantity: Twist), (quantity: Energy)]))";
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    ran(&scene, &path);
    let row = last_row(&path.join("probes.csv"));
    let energies = last_row(&path.join("energies.csv"));
    // The same again in a world, whose state says where the weights are.
    let mut world = World::build(&scene).expect("a world");
    for _ in 0..200 {
        world.step(2.0).expect("a step");
    }
    let (state, fiber) = (world.state(0), &world.assembly().fibers()[0]);
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let weight = |node: usize| {
        let segments = [node.checked_sub(1), (node < 20).then_some(node)];
        let mass: f64 = segments.into_iter().flatten().map(|s| 0.5 * fiber.segment_mass(s)).sum();
        mass * gravity
    };
    let place = |node: usize| state.positions[node].coords;
    let about = |node: usize| -> Vector3<f64> {
        (node + 1..=20).map(|k| (place(k) - place(node)).cross(&weight(k))).sum()
    };
    let whole: Vector3<f64> = (0..=20).map(weight).sum();
    let close = |found: Vector3<f64>, right: Vector3<f64>, unit: f64, what: &str| {
        // What Newton's method leaves unbalanced.
        assert!((found - right).norm() < 1e-7 * unit, "{what}: {found:?} for {right:?}");
    };
    let (force, moment) = (whole.norm(), whole.norm() * 0.05);
    close(vector(&row, "fiber 0 node 0 reaction ", "N"), -whole, force, "reaction");
    close(vector(&row, "fiber 0 node 0 reaction moment ", "N m"), -about(0), moment, "its moment");
    close(vector(&row, "fiber 0 node 7 moment ", "N m"), about(7), moment, "moment");
    let beyond: Vector3<f64> = (7..=20).map(weight).sum();
    close(vector(&row, "fiber 0 node 7 force ", "N"), beyond, force, "force");
    let along = (place(7) - place(6)).normalize();
    let tension = row["fiber 0 node 7 tension (N)"];
    assert!((tension - along.dot(&beyond)).abs() < 1e-7 * force, "{tension}");
    for (i, found) in state.curvatures[7].iter().enumerate() {
        assert_eq!(row[&format!("fiber 0 node 7 kappa{} (1/m)", i + 1)], *found);
    }
    assert_eq!(row["fiber 0 node 7 twist (rad/m)"], state.curvatures[7].z);
    assert_eq!(vector(&row, "fiber 0 tip reaction ", "N"), Vector3::zeros());
    for energy in ["kinetic", "elastic", "gravitational"] {
        assert_eq!(row[&format!("fiber 0 {energy} (J)")], energies[&format!("{energy} (J)")]);
    }
    // And the picture of it all: energies, then a chart for each unit of the probes.
    let plots = fs::read_to_string(path.join("plots.svg")).expect("plots");
    for words in ["energies.csv", "probes.csv", "kinetic (J)", "fiber 0 node 7 tension (N)"] {
        assert!(plots.contains(words), "{words}");
    }
}

/// Two hairs that lie across each other over a floor: what each bears of the other is the same with
/// the other sign, and all that one bears together is its weight.
#[test]
fn what_touches_pushes_both_ways() {
    let hair = |y: f64, z: f64, x: f64| {
        format!(
            "(length: 0.01, segments: 4, section: Circle(radius: 1e-4), root_joint: Free,
            root: (position: ({x:?}, {y:?}, {z:?}), orientation: Along(direction: ({:?}, {:?}, 0))))",
            -x.signum() * f64::from(u8::from(x != 0.0)),
            -y.signum() * f64::from(u8::from(y != 0.0))
        )
    };
    let text = format!(
        "(format: 1, duration: 0.2, fibers: [{}, {}],
        objects: [(shape: Plane(normal: (0, 0, 1)))],
        contact: (friction: Isotropic(0.3)),
        environment: (gravity: (0, 0, -9.81), viscosity: 1e-3), stepper: (dt: 1e-3),
        output: (probes: [
            (fiber: 0, quantity: Contact(with: Fiber(1))),
            (fiber: 1, quantity: Contact(with: Fiber(0))),
            (fiber: 0, quantity: Contact(with: Object(0))),
            (fiber: 1, quantity: Contact(with: Object(0)))]))",
        hair(0.0, 1e-4, -0.005),
        hair(-0.005, 3.001e-4, 0.0)
    );
    let scene = Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error} in {text}"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run");
    ran(&scene, &path);
    let row = last_row(&path.join("probes.csv"));
    let force = |a: usize, b: &str| vector(&row, &format!("fiber {a} force of {b} "), "N");
    let [on, back] = [force(0, "fiber 1"), force(1, "fiber 0")];
    assert_eq!(on, -back);
    assert!(on.z < 0.0, "{on:?}");
    let world = World::build(&scene).expect("a world");
    let weight = world.assembly().fibers()[1].mass() * 9.81;
    let (a, b) = (force(0, "objects[0]"), force(1, "objects[0]"));
    let borne = [on + a, back + b].map(|force| force.z);
    println!("{borne:?} of {weight}");
    // At rest but for what still swings in the air.
    assert!(borne.iter().all(|z| (z / weight - 1.0).abs() < 0.02), "{borne:?} of {weight}");
    assert!(fs::read_to_string(path.join("plots.svg")).expect("plots").contains("contacts.csv"));
}

#[test]
fn probes_of_what_is_not_there_are_refused_with_their_place() {
    let refused = |probe: &str, with: &str, material: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [(length: 0.1, segments: 10, material: {material},
                section: Circle(radius: 1e-4))], stepper: (dt: 1e-3), {with}
                output: (probes: [{probe}]))"
        );
        Scene::from_ron(&text).expect_err("nonsense").to_string()
    };
    let touching = "contact: (friction: Isotropic(0.3)),";
    let remembers = "Keratin(type: \"Caucasian\", law: ThreeElement)";
    let cases = [
        ("(node: At(index: 3), quantity: Reaction)", "", "Hair", "node", "no end"),
        ("(quantity: Moment)", "", remembers, "quantity", "law Elastic"),
        ("(quantity: Contact(with: Object(0)))", "", "Hair", "quantity", "no `contact`"),
        (
            "(quantity: Contact(with: Object(0)))",
            touching,
            "Hair",
            "quantity.with",
            "no such object",
        ),
        ("(quantity: Contact(with: Fiber(1)))", touching, "Hair", "quantity.with", "no such fibre"),
        ("(quantity: Contact(with: Fiber(0)))", touching, "Hair", "quantity.with", "itself"),
    ];
    for (probe, with, material, path, message) in cases {
        let error = refused(probe, with, material);
        assert!(error.contains(&format!("output.probes[0].{path}:")), "{probe}: {error}");
        assert!(error.contains(message), "{probe}: {error}");
    }
    let springs = "(format: 1, duration: 1.0, mass_spring: (model: Rope(nodes: 3, spacing: 0.1,
        direction: (0, 0, -1)), mass: 0.1, frequency: 10), stepper: (dt: 1e-3),
        output: (probes: [(quantity: Tension)]))";
    let error = Scene::from_ron(springs).expect_err("nonsense").to_string();
    assert!(
        error.contains("output.probes[0].quantity") && error.contains("fibres alone"),
        "{error}"
    );
}
