//! Fibres that start along curves, as solved cases, taut, around objects, and in motion.

use crate::common::Run;
use nalgebra::Vector3;
use rapunzel_sim::statics::{Case, solve};
use rapunzel_sim::{Scene, SimError, World};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;
use std::path::Path;

const LENGTH: f64 = 0.1;
const RADIUS: f64 = 5e-4;
const SEGMENTS: u32 = 20;
const MATTER: &str = "length: 0.1, segments: 20, section: Circle(radius: 5e-4),
    material: Elastic(density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6)";

/// What slips more slowly than this sticks, m/s: the default of a scene.
const SLIP: f64 = 4e-5;

/// A scene of one weightless fibre, whose paths are relative to a folder.
fn scene(fields: &str, folder: &Path) -> Scene {
    let text = format!(
        "(format: 1, duration: 10.0, fibers: [({MATTER}, {fields})],
        environment: (gravity: (0, 0, 0)), stepper: (dt: 1e-3))"
    );
    Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error}")).seen_from(folder)
}

fn refused(fields: &str, folder: &Path) -> SimError {
    match World::build(&scene(fields, folder)) {
        Err(error) => error,
        Ok(_) => panic!("{fields} is nonsense"),
    }
}

fn fastest(run: &Run) -> f64 {
    run.world.state(0).velocities.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// A rod that spins about its middle has the angular momentum of a rod, and keeps it.
#[test]
fn a_bundle_spins_as_one_body() {
    let fields = "root: (position: (0.2, 0, -0.05), orientation: Along(direction: (0, 0, 1))),
        root_joint: Free, velocity: (0.1, 0, 0),
        spin: (rate: (0, 360, 720), about: (0.2, 0, 0))";
    let mut run = Run::new(&scene(fields, Path::new("")));
    let mass = 1000.0 * PI * RADIUS * RADIUS * LENGTH;
    // Nodes have the mass of the halves of their segments; sections have inertia of their own.
    let lumps = 1.0 + 2.0 / f64::from(SEGMENTS).powi(2);
    let across = mass * (LENGTH * LENGTH / 12.0 * lumps + RADIUS * RADIUS / 4.0);
    let along = mass * RADIUS * RADIUS / 2.0;
    let moving = mass * Vector3::new(0.1, 0.0, 0.0);
    let right = Vector3::new(0.0, across, 2.0 * along) * 2.0 * PI
        + Vector3::new(0.2, 0.0, 0.0).cross(&moving);
    let start = run.world.momentum().expect("told");
    assert!((start.linear - moving).norm() < 1e-12 * moving.norm(), "{start:?}");
    assert!((start.angular - right).norm() < 1e-9 * right.norm(), "{start:?} for {right:?}");
    run.steps(50);
    let later = run.world.momentum().expect("told");
    assert!((later.linear - moving).norm() < 1e-9 * moving.norm(), "{later:?}");
    // It turns by a third of a turn; nodes go along chords.
    assert!((later.angular - right).norm() < 1e-3 * right.norm(), "{later:?} for {right:?}");
}

/// Velocities of nodes are theirs: the tip end of a straight fibre bends away with them. Those that
/// stretch a segment are refused.
#[test]
fn nodes_start_with_their_velocities() {
    let up = "root: (orientation: Along(direction: (0, 0, 1)))";
    let list = |of: &dyn Fn(f64) -> [f64; 3]| {
        let all = (0..=SEGMENTS).map(|k| {
            let [x, y, z] = of(f64::from(k) / f64::from(SEGMENTS));
            format!("({x:?}, {y:?}, {z:?})")
        });
        all.collect::<Vec<_>>().join(", ")
    };
    let swing = list(&|s| [0.3 * s * s, 0.1 * s * s, 0.0]);
    let run = Run::new(&scene(&format!("{up}, velocities: [{swing}]"), Path::new("")));
    for (k, v) in (0..).zip(&run.world.state(0).velocities) {
        let s = f64::from(k) / f64::from(SEGMENTS);
        assert!((v - s * s * Vector3::new(0.3, 0.1, 0.0)).norm() < 1e-15, "{v:?}");
    }
    let stretch = list(&|s| [0.0, 0.0, s]);
    let error = refused(&format!("{up}, velocities: [{stretch}]"), Path::new("")).to_string();
    assert!(error.contains("fibers[0]") && error.contains("stretch a segment"), "{error}");
    let text = format!(
        "(format: 1, duration: 1, fibers: [({MATTER}, velocities: [(0, 0, 1)])], stepper: (dt: 1))"
    );
    let error = Scene::from_ron(&text).expect_err("too few").to_string();
    assert!(error.contains("fibers[0].velocities") && error.contains("21 nodes"), "{error}");
}

/// A quarter of a circle from a file: nodes on it, the root's frame along it, evenly twisted.
#[test]
fn a_fibre_starts_along_a_curve_in_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let radius = LENGTH / FRAC_PI_2;
    let mut text = String::from("# x y z\n");
    for k in 0..=1000 {
        let angle = FRAC_PI_2 * f64::from(k) / 1000.0;
        let (x, z) = (1e3 * radius * (1.0 - angle.cos()), 1e3 * radius * angle.sin());
        writeln!(text, "{x} 0 {z}").expect("text");
    }
    std::fs::write(folder.path().join("arc.txt"), &text).expect("written");
    let curve = |rest: &str| format!("initial: Curve(file: \"arc.txt\", {rest})");
    let fields = curve("scale: 1e-3, twist: 90") + ", root: (position: (1, 2, 3))";
    let run = Run::new(&scene(&fields, folder.path()));
    let state = run.world.state(0);
    let center = Vector3::new(1.0 + radius, 2.0, 3.0);
    for place in &state.positions {
        let off = (place.coords - center).norm() - radius;
        assert!(off.abs() < 1e-6 * radius, "{off}");
    }
    assert!((state.positions[0].coords - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
    for curvature in &state.curvatures[1..20] {
        assert!((curvature.z * LENGTH - FRAC_PI_2).abs() < 1e-3, "{curvature:?}");
        assert!((curvature.xy().norm() * radius - 1.0).abs() < 1e-3, "{curvature:?}");
    }
    let error = refused(&curve("scale: 2e-3"), folder.path()).to_string();
    assert!(error.contains("0.1999") && error.contains("scale the curve by 0.5000"), "{error}");
    std::fs::write(folder.path().join("arc.txt"), "0 0 0\n0 1\n").expect("written");
    let error = refused(&curve("scale: 1"), folder.path()).to_string();
    assert!(error.contains("arc.txt") && error.contains('2'), "{error}");
}

/// An answer of `solve`, as a start: the fibre stays at rest in it, and there it is within the
/// error of its segments.
#[test]
fn a_solved_case_stays_at_rest() {
    let case = Case::from_ron(
        "(format: 1, length: 0.1, rod: Solid(section: Circle(radius: 5e-4), material: Elastic(
            density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6)),
        clamp: (position: (0, 0, 0.5), orientation: Along(direction: (1, 0, 0), roll: 30)),
        end: Free(force: (1e-4, 2e-4, -3e-4)))",
    );
    let answer = solve(&case.expect("a case")).expect("an answer");
    let table = answer.equilibria[0].table();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("rod-0.csv"), &table).expect("written");
    let text = format!(
        "(format: 1, duration: 10.0, fibers: [({MATTER}, initial: Solved(file: \"rod-0.csv\"),
            tip: Loaded(force: (value: (1e-4, 2e-4, -3e-4))))], stepper: (dt: 1e-3))"
    );
    let scene = Scene::from_ron(&text).expect("a scene").seen_from(folder.path());
    let mut run = Run::new(&scene);
    let tip = answer.equilibria[0].stations.last().expect("stations").position;
    let found = run.world.state(0).positions[20].coords;
    // The chain is off by less than the squared turn of a segment; in all it turns by less than a
    // right angle.
    let bound = (FRAC_PI_2 / f64::from(SEGMENTS)).powi(2) * LENGTH;
    assert!((found - Vector3::from(tip)).norm() < bound, "{found:?} {tip:?}");
    for _ in 0..50 {
        run.steps(1);
        // Newton's method in the equilibrium stops at 1e-13 rad, which acts for a step.
        assert!(fastest(&run) < 1e-8, "{:e}", fastest(&run));
    }
}

/// A fibre pulled level by its tip sags as gravity has it, and starts at rest.
#[test]
fn a_taut_fibre_starts_at_rest() {
    let mut run = Run::read(&format!(
        "(format: 1, duration: 10.0, fibers: [({MATTER}, initial: Taut,
            root: (orientation: Along(direction: (1, 0, 0))), root_joint: Ball(),
            tip: Loaded(force: (value: (0.05, 0, 0))))], stepper: (dt: 1e-3))"
    ));
    let state = run.world.state(0);
    // The tip of a cable whose tension is large beside its weight: w L / 2 T.
    let weight = 9.81 * 1000.0 * PI * RADIUS * RADIUS * LENGTH;
    let sag = -state.positions[20].z / LENGTH;
    assert!((sag / (0.5 * weight / 0.05) - 1.0).abs() < 0.05, "{sag}");
    run.steps(50);
    assert!(fastest(&run) < 1e-8, "{:e}", fastest(&run));
}

/// A thin hair that is wrapped on a bar and pulled by its tip starts at rest: from the first step
/// on everything is slower than what counts as sticking. The tension of its root differs from the
/// load by no more than friction can bear, Euler's ratio.
#[test]
fn a_hair_wrapped_on_a_bar_starts_at_rest() {
    let (bar, thin, turn, tension, length) = (5e-3, 5e-5, 0.75, 0.05, 0.08);
    let text = |object: usize, turns: f64, segments: u32| {
        format!(
            "(format: 1, duration: 1.0, fibers: [(length: {length:?}, segments: {segments},
                section: Circle(radius: {thin:?}), material: Elastic(density: 1300.0,
                youngs_modulus: 1e6, shear_modulus: 4e5), damping_time: 1e-3,
                initial: Wrapped(object: {object}, turns: {turns:?}, pitch: 1e-3, lead: 0.02),
                tip: Led(joint: Supported(force: (frame: Follower, value: (0, 0, {tension:?})))))],
            objects: [(shape: Capsule(length: 0.1, radius: {bar:?}), turn: (90, 0, 0))],
            contact: (friction: Isotropic(0.3)), environment: (gravity: (0, 0, 0)),
            stepper: (dt: 1e-4))"
        )
    };
    for segments in [80, 160] {
        let mut run = Run::read(&text(0, turn, segments));
        assert!(run.world.notes().is_empty(), "{:?}", run.world.notes());
        let start = run.world.state(0);
        let mut most = 0.0_f64;
        for _ in 0..50 {
            run.step();
            most = most.max(fastest(&run));
        }
        let state = run.world.state(0);
        let ways = state.positions.iter().zip(&start.positions).map(|(a, b)| (a - b).norm());
        let moved = ways.fold(0.0, f64::max);
        println!("{segments} segments: moved {moved:e} m, fastest {most:e} m/s");
        let root = state.forces[0].norm() / tension;
        let euler = (-0.3 * 2.0 * PI * turn).exp();
        assert!(0.95 * euler < root && root < 1.05 / euler, "{root} beside {euler}");
        assert!(most < SLIP, "{most:e}");
    }
    let nonsense = |object, turns| match Scene::from_ron(&text(object, turns, 160)) {
        Err(error) => error.to_string(),
        Ok(scene) => match World::build(&scene) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("a world"),
        },
    };
    let error = nonsense(3, turn);
    assert!(error.contains("fibers[0].initial.object") && error.contains("no such"), "{error}");
    let error = nonsense(0, 9.0);
    assert!(error.contains("fibers[0]") && error.contains("winding"), "{error}");
}

/// The template starts at rest and stays there for as long as its thread is held; one that nothing
/// holds starts as it is wound, a note says so, and it springs open.
#[test]
fn a_thread_wound_around_a_bar_waits_until_it_is_let_go() {
    let text = include_str!("../../../../scenes/contact/wrapped.ron");
    // Of its contacts the residual of a scene leaves some 0.1 mm/s.
    let exact = text.replace("Isotropic(0.2)", "Isotropic(0.2), residual: 1e-6");
    let mut run = Run::read(&exact);
    assert!(run.world.notes().is_empty(), "{:?}", run.world.notes());
    let start = run.positions(0);
    for step in 0..200 {
        run.step();
        let now = fastest(&run);
        // Later a contact that is found in another segment may move something for a step.
        assert!(step >= 50 || now < SLIP, "{now:e} m/s in step {step}");
    }
    let ways = run.positions(0).into_iter().zip(start).map(|(a, b)| (a - b).norm());
    let moved = ways.fold(0.0, f64::max);
    println!("moved {moved:e} m in 0.2 s");
    assert!(moved < 0.2 * SLIP, "{moved:e}");
    let saved = run.world.snapshot();
    let mut resumed = Run::read(&exact);
    resumed.world.restore(&saved).expect("a snapshot of this scene");
    run.steps(5);
    resumed.steps(5);
    assert_eq!(run.world.state(0), resumed.world.state(0));
    let mut run = Run::read(&text.replace("grippers: [(from: 0.0, until: 0.5)],", ""));
    let notes = run.world.notes().join(" ");
    assert!(notes.contains("fibers[0] does not rest"), "{notes}");
    run.steps(20);
    assert!(fastest(&run) > 0.1, "{:e}", fastest(&run));
}
