//! Mass-spring systems in scenes.

use rapunzel_sim::scene::{Integrator, Model, Motion, Moves, ObjectMass, ObjectShape};
use rapunzel_sim::{
    Cancel, Control, Existing, Outcome, Plan, RunFolder, Scene, SimError, World, run,
};
use std::fs;
use std::path::PathBuf;

fn shipped() -> Vec<(PathBuf, Scene)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/mass-spring");
    let files = fs::read_dir(folder).expect("the folder of the scenes");
    let mut paths: Vec<_> = files.map(|file| file.expect("a file").path()).collect();
    paths.sort();
    let scene = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("readable");
        let scene = Scene::from_ron(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        (path, scene)
    };
    paths.into_iter().map(scene).collect()
}

fn named(name: &str) -> Scene {
    let named = |(path, _): &(PathBuf, Scene)| path.file_stem().is_some_and(|stem| stem == name);
    shipped().into_iter().find(named).expect("a scene that ships").1
}

#[test]
fn every_scene_is_sound_and_stays_finite() {
    let scenes = shipped();
    assert_eq!(scenes.len(), 13);
    for (path, scene) in scenes {
        let path = path.display();
        assert_eq!(Scene::from_ron(&scene.to_ron().expect("sound")).expect("reads back"), scene);
        let mut world = World::build(&scene).unwrap_or_else(|e| panic!("{path}: {e}"));
        let dt = Plan::new(&scene).dt;
        for _ in 0..40 {
            world.step(dt).unwrap_or_else(|e| panic!("{path}: {e}"));
        }
        assert!(world.energy().total().is_finite(), "{path}");
    }
}

#[test]
fn what_is_restored_goes_on_to_the_same_bits() {
    for (path, scene) in shipped() {
        let dt = Plan::new(&scene).dt;
        let mut world = World::build(&scene).expect("sound");
        let steps = |world: &mut World, count| {
            for _ in 0..count {
                world.step(dt).expect("finite");
            }
        };
        steps(&mut world, 70);
        let snapshot = world.snapshot();
        steps(&mut world, 30);
        let mut again = World::build(&scene).expect("sound");
        again.restore(&snapshot).expect("of the same scene");
        steps(&mut again, 30);
        assert_eq!(again.snapshot(), world.snapshot(), "{}", path.display());
        // A system of as many nodes and springs would pass for the same.
        let other =
            named(if World::build(&scene).expect("sound").nodes() == 40 { "cube" } else { "rope" });
        let refused = World::build(&other).expect("sound").restore(&snapshot);
        assert!(refused.is_err(), "{}", path.display());
    }
}

fn run_in(scene: &Scene, folder: &std::path::Path) -> Result<Outcome, SimError> {
    let mut folder = RunFolder::open(folder, Existing::Refuse).expect("an empty folder");
    let (cancel, progress) = (&Cancel::new(), &mut |_: &_| {});
    let control = Control { sync_is_due: &mut || false, cancel, progress, stopwatch: None };
    run(scene, World::build(scene)?, &mut folder, control).map(|summary| summary.outcome)
}

#[test]
fn a_run_gives_frames_probes_energies_and_the_area() {
    let mut scene = named("ring");
    scene.duration = 0.5;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    assert_eq!(run_in(&scene, path).expect("runs"), Outcome::Complete);
    let read = |name: &str| fs::read_to_string(path.join(name)).expect(name);
    let energies = read("energies.csv");
    let header = energies.lines().next().expect("a header");
    assert!(
        header.ends_with(
            "total (J),load (J),dissipation (W),supports (W),wind x (m/s),wind y (m/s),wind z (m/s),\
         area (m^2),area at rest (m^2)"
        ),
        "{header}"
    );
    let areas: Vec<Vec<f64>> = energies
        .lines()
        .skip(1)
        .map(|row| row.split(',').skip(11).map(|x| x.parse().expect("a number")).collect())
        .collect();
    assert_eq!(areas.len(), 31);
    assert!(areas.iter().all(|a| (a[0] / a[1] - 1.0).abs() < 0.3), "{areas:?}");
    assert_eq!(read("probes.csv").lines().count(), 32);
    assert!(read("frames.pvd").contains("frame-000030.vtp") && path.join("preview.png").exists());
}

#[test]
fn the_ledger_of_a_loaded_beam_closes() {
    let mut scene = named("cube-under-lid");
    (scene.duration, scene.environment.gravity_ramp) = (1.0, 0.0);
    scene.mass_spring.as_mut().expect("a cube").substeps = 16;
    scene.output.record_interval = 0.0;
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_in(&scene, folder.path()).expect("runs");
    let table = fs::read_to_string(folder.path().join("energies.csv")).expect("energies");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|x| x.parse().expect("a number")).collect())
        .collect();
    // Kinetic, elastic, gravitational and that of the loads; what is lost is the integral of the
    // power, by the trapezoidal rule.
    let sum = |row: &[f64]| row[4] + row[5];
    let lost: f64 = rows.windows(2).map(|w| 0.5 * (w[1][0] - w[0][0]) * (w[0][6] + w[1][6])).sum();
    let [first, last] = [&rows[0], &rows[rows.len() - 1]];
    let fallen = sum(first) - sum(last);
    let sunk = first[5] - last[5];
    assert!(lost > 0.1 && sunk > 0.1, "{lost} J lost, {sunk} J from the load");
    assert!((fallen / lost - 1.0).abs() < 0.02, "{fallen} J are gone, {lost} J were lost");
}

#[test]
fn the_wind_is_in_the_table() {
    let mut scene = named("rope-in-wind");
    scene.duration = 1.0;
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_in(&scene, folder.path()).expect("runs");
    let table = fs::read_to_string(folder.path().join("energies.csv")).expect("energies");
    assert!(table.lines().count() > 10);
    for row in table.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|x| x.parse().expect("a number")).collect();
        let gust = 0.5 * (1.0 - (std::f64::consts::TAU * row[0] / 1.5).cos());
        assert!((row[8] - 2.0 - 4.0 * gust).abs() < 1e-9 && row[9..11] == [0.0, 0.0], "{row:?}");
    }
}

#[test]
fn springs_yield_for_good_and_ties_hold_in_a_scene() {
    let mut scene = named("net-beyond-its-limit");
    let offset = |scene: &Scene, steps: u64| {
        let mut world = World::build(scene).expect("sound");
        let dt = Plan::new(scene).dt;
        for _ in 0..steps {
            world.step(dt).expect("finite");
        }
        let at = |node| world.node(0, Some(node)).0;
        ((at(99) - at(9)).norm(), at(55) - at(44))
    };
    let steps = Plan::new(&scene).steps;
    let (start, tied) = offset(&scene, 0);
    let (yielded, later) = offset(&scene, steps);
    assert!((later - tied).norm() < 1e-9, "{tied} became {later}");
    scene.mass_spring.as_mut().expect("a net").yield_strain = None;
    let (sound, _) = offset(&scene, steps);
    assert!(yielded > 1.05 * sound && sound < 1.5 * start, "{start}, {sound}, {yielded}");
    scene.mass_spring.as_mut().expect("a net").ties[0].to = 100;
    let message = World::build(&scene).map(|_| ()).expect_err("no such node").to_string();
    assert!(message.contains("names node 100"), "{message}");
}

#[test]
fn steps_above_the_limit_are_warned_of() {
    let mut scene = named("rope");
    let dt = Plan::new(&scene).dt;
    for integrator in [Integrator::Leapfrog, Integrator::RungeKutta] {
        scene.mass_spring.as_mut().expect("a rope").integrator = integrator;
        let world = World::build(&scene).expect("sound");
        assert_eq!(world.warning(dt), None);
        let warning = world.warning(10.0 * dt).expect("far above the limit");
        assert!(warning.contains("is not below the stability limit of"), "{warning}");
    }
    scene.mass_spring.as_mut().expect("a rope").integrator = Integrator::ImplicitEuler;
    assert_eq!(World::build(&scene).expect("sound").warning(1.0), None);
}

#[test]
fn a_step_above_the_limit_stops_with_step_and_node() {
    let mut scene = named("flag");
    let springs = scene.mass_spring.as_mut().expect("a net");
    springs.integrator = Integrator::Leapfrog;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let error = run_in(&scene, folder.path()).expect_err("unstable").to_string();
    // Sub-steps are counted from the first also where contacts come between them.
    let mut touching = named("ring");
    let springs = touching.mass_spring.as_mut().expect("a ring");
    (springs.frequency, springs.damping_ratio, springs.substeps) = (1e4, 0.0, 100);
    let mut world = World::build(&touching).expect("sound");
    let late = world.step(0.5).expect_err("unstable").to_string();
    assert!(!late.contains("in step 1:") && late.contains("left all bounds"), "{late}");
    assert!(error.contains("left all bounds in step") && error.contains("node "), "{error}");
    assert!(error.contains("mass_spring, t = "), "{error}");
    // No frame holds what is not finite: the run is as it was at the last good one.
    let summary = fs::read_to_string(folder.path().join("summary.json")).expect("a summary");
    assert!(!summary.contains("null"), "{summary}");
}

#[test]
fn nonsense_is_refused_with_its_place() {
    let mut scene = named("rope");
    let springs = scene.mass_spring.as_mut().expect("a rope");
    springs.mass = 0.0;
    springs.holds[0].until = 0.1;
    let Model::Rope { nodes, .. } = &mut springs.model else { panic!("a rope") };
    *nodes = 1;
    scene.environment.viscosity = 1.8e-5;
    let message = scene.validate().expect_err("four problems").to_string();
    for part in
        ["mass_spring.mass", "mass_spring.model.nodes", "holds[0].until", "environment.viscosity"]
    {
        assert!(message.contains(part), "{part} in {message}");
    }
    let mut scene = named("cloth-on-a-line");
    scene.mass_spring.as_mut().expect("a net").holds[0].node = 100;
    let message = World::build(&scene).map(|_| ()).expect_err("no such node").to_string();
    assert!(message.contains("names node 100") && message.contains("0 to 99"), "{message}");
}

/// A free node of a rope of two, over a plane below it.
fn node_over_a_plane() -> Scene {
    Scene::from_ron(
        r#"(
            format: 1, duration: 1.0, stepper: (dt: 1e-3),
            mass_spring: (
                model: Rope(nodes: 2, spacing: 1.0, direction: (1.0, 0.0, 0.0)),
                mass: 0.1, frequency: 1e-6, contacts: (radius: 0.01),
            ),
            objects: [(
                shape: Plane(normal: (0.0, 0.0, 1.0)), position: (0.0, 0.0, -0.035),
                motion: Translate(velocity: (0.0, 0.0, 0.5), until: 0.08),
            )],
            environment: (gravity: (0.0, 0.0, 0.0)),
        )"#,
    )
    .expect("a sound scene")
}

#[test]
fn an_object_that_moves_pushes_nodes_and_comes_to_rest() {
    let mut world = World::build(&node_over_a_plane()).expect("sound");
    let mut rises = |steps: usize| {
        for _ in 0..steps {
            world.step(1e-3).expect("finite");
        }
        world.node(0, Some(1))
    };
    // The plane meets the node, 2.5 cm above it, after 50 ms, and from then on it has its velocity.
    let (position, velocity) = rises(45);
    assert!(position.z == 0.0 && velocity.z == 0.0, "{position}, {velocity}");
    let (position, velocity) = rises(20);
    assert!((velocity.z - 0.5).abs() < 1e-9, "{velocity}");
    assert!((position.z - 0.0075).abs() < 1e-9, "{position}");
    // When the plane rests, the node flies on.
    let (position, velocity) = rises(35);
    assert!((velocity.z - 0.5).abs() < 1e-9 && (position.z - 0.025).abs() < 1e-9, "{position}");
    // The other node is pinned in the way and stays.
    assert_eq!(world.node(0, Some(0)).0.z, 0.0);
}

#[test]
fn objects_that_nodes_cannot_move_or_touch_are_refused() {
    let mut scene = node_over_a_plane();
    scene.objects[0].shape = ObjectShape::Ball { radius: 0.1 };
    scene.objects[0].motion = Motion::Fixed;
    let (mass, velocity, spin) = (ObjectMass::Mass(1.0), [0.0; 3], [0.0; 3]);
    scene.objects[0].moves = Moves::Free { mass, velocity, spin };
    scene.mass_spring.as_mut().expect("a rope").contacts = None;
    let message = scene.validate().expect_err("two problems").to_string();
    for part in ["objects[0].moves", "nothing touches them"] {
        assert!(message.contains(part), "{part} in {message}");
    }
}
