//! Mass-spring systems in scenes.

use rapunzel_sim::scene::{Integrator, Model};
use rapunzel_sim::{
    Control, Existing, MassSprings, Outcome, Plan, RunFolder, Scene, SimError, Stepper, run,
};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

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
    assert!(scenes.len() >= 11);
    for (path, scene) in scenes {
        let path = path.display();
        assert_eq!(Scene::from_ron(&scene.to_ron().expect("sound")).expect("reads back"), scene);
        let mut world = scene.build().unwrap_or_else(|e| panic!("{path}: {e}"));
        let dt = Plan::new(&scene).dt;
        for _ in 0..40 {
            MassSprings.step(&mut world, dt).unwrap_or_else(|e| panic!("{path}: {e}"));
        }
        assert!(world.energy().total().is_finite(), "{path}");
    }
}

#[test]
fn what_is_restored_goes_on_to_the_same_bits() {
    for (path, scene) in shipped() {
        let dt = Plan::new(&scene).dt;
        let mut world = scene.build().expect("sound");
        let steps = |world: &mut _, count| {
            for _ in 0..count {
                MassSprings.step(world, dt).expect("finite");
            }
        };
        steps(&mut world, 70);
        let snapshot = world.snapshot();
        steps(&mut world, 30);
        let mut again = scene.build().expect("sound");
        again.restore(&snapshot).expect("of the same scene");
        steps(&mut again, 30);
        assert_eq!(again.snapshot(), world.snapshot(), "{}", path.display());
        let other = named(if path.ends_with("rope.ron") { "cube" } else { "rope" });
        assert!(other.build().expect("sound").restore(&snapshot).is_err());
    }
}

fn run_in(scene: &Scene, folder: &std::path::Path) -> Result<Outcome, SimError> {
    let folder = RunFolder::open(folder, Existing::Refuse).expect("an empty folder");
    let (cancel, mut silent) = (AtomicBool::new(false), |_: &_| {});
    let control = Control { checkpoint_every: 10, cancel: &cancel, progress: &mut silent };
    run(scene, &folder, control).map(|summary| summary.outcome)
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
    assert!(header.ends_with("total (J),area (m^2),area at rest (m^2)"), "{header}");
    let areas: Vec<Vec<f64>> = energies
        .lines()
        .skip(1)
        .map(|row| row.split(',').skip(5).map(|x| x.parse().expect("a number")).collect())
        .collect();
    assert_eq!(areas.len(), 31);
    assert!(areas.iter().all(|a| (a[0] / a[1] - 1.0).abs() < 0.3), "{areas:?}");
    assert_eq!(read("probes.csv").lines().count(), 32);
    assert!(read("frames.pvd").contains("frame-000030.vtp") && path.join("preview.png").exists());
}

#[test]
fn a_step_above_the_limit_stops_with_step_and_node() {
    let mut scene = named("flag");
    let springs = scene.mass_spring.as_mut().expect("a net");
    springs.integrator = Integrator::Leapfrog;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let error = run_in(&scene, folder.path()).expect_err("unstable").to_string();
    assert!(error.contains("left all bounds in step"), "{error}");
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
    let message = scene.build().map(|_| ()).expect_err("no such node").to_string();
    assert!(message.contains("names node 100") && message.contains("0 to 99"), "{message}");
}
