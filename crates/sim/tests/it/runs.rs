//! Runs in folders: their files, and what interruptions and errors leave.

use rapunzel_sim::{
    Cancel, Control, CouplingError, Existing, Outcome, RunFolder, Scene, SimError, Summary, World,
    run,
};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Three short hairs that swing: 0.2 s in 40 steps, 11 frames.
const SCENE: &str = "(
    format: 1, name: \"test\", duration: 0.2,
    fibers: [(
        length: 0.05, segments: 8, section: Circle(radius: 4e-5), damping_time: 1e-3,
        shape: Helix(radius: 0.005, pitch: 0.02),
        arrangement: Lock(count: 2, radius: 0.003, curvature_variation: 0.1),
        motion: Swing(angle: 30, radius: 0.05, period: 0.2),
    )],
    stepper: (dt: 0.005),
    output: (frame_rate: 50, formats: [Usd, Hair, Pov, Mitsuba], probes: [(quantity: Velocity)]),
)";

fn scene() -> Scene {
    Scene::from_ron(SCENE).expect("a sound scene")
}

/// Runs and is cancelled once `stop` steps are done.
fn run_until(
    scene: &Scene,
    path: &Path,
    existing: Existing,
    stop: u64,
) -> Result<Summary, SimError> {
    let cancel = Cancel::new();
    let mut folder = RunFolder::open(path, existing)?;
    let mut progress = |now: &rapunzel_sim::Progress| {
        if now.steps >= stop {
            cancel.ask();
        }
    };
    let mut frames = 0;
    let mut sync_is_due = || {
        frames += 1;
        frames % 3 == 0
    };
    let (sync_is_due, progress) = (&mut sync_is_due, &mut progress);
    let control = Control { sync_is_due, cancel: &cancel, progress, stopwatch: None };
    run(scene, World::build(scene)?, &mut folder, control)
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for folder in [folder, &folder.join("frames")] {
        for file in fs::read_dir(folder).expect("a folder") {
            let path = file.expect("a file").path();
            if path.is_file() && !path.ends_with(".lock") {
                found.insert(path.display().to_string(), fs::read(&path).expect("readable"));
            }
        }
    }
    let folder = folder.display().to_string();
    found.into_iter().map(|(path, bytes)| (path.replace(&folder, ""), bytes)).collect()
}

#[test]
fn a_run_leaves_all_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let summary = run_until(&scene(), folder.path(), Existing::Refuse, u64::MAX).expect("runs");
    assert_eq!((summary.outcome, summary.steps, summary.frames), (Outcome::Complete, 40, 11));
    let files = files(folder.path());
    let count = |extension: &str| files.keys().filter(|name| name.ends_with(extension)).count();
    assert_eq!((count(".vtp"), count(".hair"), count(".pov")), (11, 11, 11));
    assert_eq!((count(".xml"), count(".txt"), count(".obj")), (11, 11, 0));
    for name in
        ["scene.ron", "checkpoint.bin", "summary.json", "preview.png", "plots.svg", "fibers.usda"]
    {
        assert!(files.contains_key(&format!("/{name}")), "{name} in {:?}", files.keys());
    }
    assert_eq!(count(".partial"), 0);
    let text = |name: &str| String::from_utf8(files[name].clone()).expect("text");
    assert_eq!(Scene::from_ron(&text("/scene.ron")).expect("sound"), scene());
    assert_eq!(text("/frames.pvd").matches("frames/frame-").count(), 11);
    let energies = text("/energies.csv");
    assert_eq!(energies.lines().count(), 42, "a header and a row for each instant");
    assert!(energies.starts_with("time (s),kinetic (J),elastic (J),"), "{energies}");
    assert!(energies.lines().last().expect("a row").starts_with("0.2,"), "{energies}");
    assert!(text("/probes.csv").contains("fiber 0 tip vx (m/s)"));
    assert_eq!(Summary::read(folder.path()).expect("reads back").steps, 40);
}

#[test]
fn tables_hold_what_the_world_does() {
    let folder = tempfile::tempdir().expect("a folder");
    run_until(&scene(), folder.path(), Existing::Refuse, u64::MAX).expect("runs");
    let rows = |file: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(folder.path().join(file)).expect("readable");
        let number = |cell: &str| cell.parse().expect("a number");
        text.lines().skip(1).map(|row| row.split(',').map(number).collect()).collect()
    };
    let (energies, probes) = (rows("energies.csv"), rows("probes.csv"));
    let mut world = World::build(&scene()).expect("a sound scene");
    for (step, (energies, probe)) in energies.iter().zip(&probes).enumerate() {
        // Numbers are written so that they read back as the same bits.
        let energy = world.energy();
        let (time, velocity) = (world.time(), world.state(0).velocities[8]);
        assert_eq!(
            energies[..],
            [time, energy.kinetic, energy.elastic, energy.gravitational, energy.total()]
        );
        assert_eq!(probe[..], [time, velocity.x, velocity.y, velocity.z], "step {step}");
        world.step(0.005).expect("converges");
    }
    let last = fs::read(folder.path().join("frames/frame-000010.vtp")).expect("readable");
    let last = rapunzel_export::vtp::read(&mut &last[..]).expect("a frame");
    assert_eq!(last.strands[0].velocities[8].as_slice(), &probes[40][1..]);
}

/// Also of fibres that lie on something, or are hit by a ball that flies: what touched is part of a
/// checkpoint, and so are the ball and the ledger.
#[test]
fn interruptions_change_no_byte() {
    let free = "shape: Ball(radius: 0.01), moves: Free(mass: Mass(1e-5), velocity: (0, 0, 0.8), \
                spin: (0, 500, 0))";
    let flying = touching().replace("shape: Plane(normal: (0, 0, 1))", free);
    let flying = flying.replace("frame_rate", "ledger: true, frame_rate");
    for text in [SCENE.into(), touching(), flying] {
        interrupt(&Scene::from_ron(&text).expect("a sound scene"));
    }
}

/// The scene with contacts, above a plane that the hairs reach.
fn touching() -> String {
    let floor = "objects: [(shape: Plane(normal: (0, 0, 1)), position: (0, 0, -0.046))], \
                 contact: (friction: Isotropic(0.3)), stepper:";
    SCENE.replace("stepper:", floor).replace("dt: 0.005", "dt: 0.001")
}

fn interrupt(scene: &Scene) {
    let [whole, parts] = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
    run_until(scene, whole.path(), Existing::Refuse, u64::MAX).expect("runs");
    // At the start, within a frame, on a frame, on a checkpoint, and just before the end.
    for stop in [0, 1, 6, 8, 12, 23, 39] {
        let summary = run_until(scene, parts.path(), Existing::Resume, stop).expect("runs");
        assert_eq!((summary.outcome, summary.steps), (Outcome::Cancelled, stop));
    }
    // What a killed run may leave beyond its checkpoint.
    let table = parts.path().join("energies.csv");
    let longer = fs::read_to_string(&table).expect("readable") + "0.19,half of a r";
    fs::write(&table, longer).expect("writable");
    fs::write(parts.path().join("frames/frame-000010.vtp.partial"), "half").expect("writable");
    // The second time, the run is at its end already.
    for _ in 0..2 {
        run_until(scene, parts.path(), Existing::Resume, u64::MAX).expect("runs");
    }
    let (whole, parts) = (files(whole.path()), files(parts.path()));
    assert_eq!(whole.keys().collect::<Vec<_>>(), parts.keys().collect::<Vec<_>>());
    for (name, bytes) in &whole {
        assert!(bytes == &parts[name], "{name} differs");
    }
}

#[test]
fn a_step_that_fails_leaves_a_checkpoint() {
    // A straight rod that cannot stretch and is taut when it starts.
    let text =
        SCENE.replace("shape: Helix(radius: 0.005, pitch: 0.02)", "shape: Straight").replace(
            "motion: Swing(angle: 30, radius: 0.05, period: 0.2)",
            "tip: Driven(velocity: (0, 0, 0.1), until: 1)",
        );
    let scene = Scene::from_ron(&text).expect("each number is sound");
    let folder = tempfile::tempdir().expect("a folder");
    let error = run_until(&scene, folder.path(), Existing::Refuse, u64::MAX).expect_err("fails");
    let message = error.to_string();
    assert!(matches!(error, SimError::Coupling(CouplingError::Step { .. })), "{message}");
    assert!(message.contains("fibre 0: tip at t = 0 s: as far from the root"), "{message}");
    let summary = Summary::read(folder.path()).expect("is written");
    assert_eq!((summary.outcome, summary.steps), (Outcome::Failed { error: message }, 0));
    assert!(folder.path().join("checkpoint.bin").exists());
}

/// Limp hairs fall on a plane, and one iteration a solve is not enough for their contacts.
#[test]
fn contacts_that_lead_nowhere_end_a_run_that_keeps_what_it_has() {
    let text = include_str!("../../../../scenes/contact/partly-elastic-limp.ron")
        .replace("count: 40", "count: 8")
        .replace("contact: (", "contact: (solver: Polished, iterations: 1, ")
        .replace("dt: 1e-3", "dt: 4e-3")
        .replace("frame_rate: 50.0", "frame_rate: 250.0");
    let scene = Scene::from_ron(&text).expect("each number is sound");
    let folder = tempfile::tempdir().expect("a folder");
    let error = run_until(&scene, folder.path(), Existing::Refuse, u64::MAX).expect_err("fails");
    let SimError::Coupling(CouplingError::Lost { time, dt, worst: Some(worst) }) = error else {
        panic!("{error}")
    };
    // The shortest part of a step; the lowest hairs reach the plane, 20 mm below them, after 64 ms.
    assert!((64.0 * dt / 4e-3 - 1.0).abs() < 1e-12, "{dt}");
    assert!((0.06..0.08).contains(&time), "{time}");
    let sides = worst.sides.map(|side| side.to_string());
    let told = error.to_string();
    assert!(sides[0].starts_with("fibre") && sides.iter().all(|s| told.contains(s)), "{told}");
    let Summary { outcome, steps, .. } = Summary::read(folder.path()).expect("is written");
    assert_eq!(outcome, Outcome::Failed { error: error.to_string() });
    // A frame a step: what is kept ends less than a step before the part.
    assert!((0.0..4e-3).contains(&(time - 4e-3 * steps as f64)), "{steps}");
    assert!(folder.path().join(format!("frames/frame-{steps:06}.vtp")).exists());
    assert!(folder.path().join("checkpoint.bin").exists());
}

#[test]
fn a_checkpoint_of_another_scene_or_damaged_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let other = Scene::from_ron(&SCENE.replace("0.05, seg", "0.06, seg")).expect("sound");
    run_until(&other, folder.path(), Existing::Refuse, 5).expect("runs");
    let resume = || run_until(&scene(), folder.path(), Existing::Resume, u64::MAX);
    let error = resume().expect_err("another scene");
    assert!(matches!(error, SimError::DifferentScene(_)), "{error}");

    let path = folder.path().join("checkpoint.bin");
    let mut bytes = fs::read(&path).expect("readable");
    *bytes.last_mut().expect("not empty") ^= 1;
    fs::write(&path, &bytes).expect("writable");
    let error = resume().expect_err("a flipped bit").to_string();
    assert!(error.contains("it is damaged; force a new run"), "{error}");
    fs::write(&path, "PK").expect("writable");
    assert!(resume().is_err(), "another file");

    let error = run_until(&scene(), folder.path(), Existing::Refuse, 0).expect_err("occupied");
    assert!(matches!(error, SimError::FolderNotEmpty(_)), "{error}");
    run_until(&scene(), folder.path(), Existing::Overwrite, u64::MAX).expect("starts anew");
}

/// Hair that is charged in two portions and then becomes wet goes on to the same bytes, with its
/// fields, also when it is resumed at its end.
#[test]
fn a_charged_run_goes_on_to_the_same_bytes() {
    let scene = Scene::from_ron(
        "(
            format: 1, name: \"charged\", duration: 4, stepper: (dt: 1),
            fibers: [(
                length: 0.1, segments: 12, material: Keratin(type: \"Caucasian\"),
                shape: Curved(curvature: (0, 5, 0)),
                arrangement: Ellipse(semi_axes: (0.002, 0.002), count: 3),
                charge: (amount: Fiber(2e-11)),
            )],
            environment: (climate: (humidity: [(2, 0.65), (3, 1)])),
            charging: (
                dealing: Equal(2),
                grid: (origin: (-0.05, 0, -0.1), spacing: (0.01, 0.01, 0.01), counts: (11, 1, 11)),
            ),
        )",
    )
    .expect("a sound scene");
    let [whole, parts] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let summary = run_until(&scene, whole.path(), Existing::Refuse, u64::MAX).expect("runs");
    assert_eq!((summary.steps, summary.frames), (4, 5), "every step is a frame");
    let charge = summary.charge.expect("it is charged");
    assert!(charge.unsettled == 0 && (charge.charge / 6e-11 - 1.0).abs() < 1e-12, "{charge:?}");
    for (existing, stop) in
        [(Existing::Refuse, 1), (Existing::Resume, 3), (Existing::Resume, 9), (Existing::Resume, 9)]
    {
        run_until(&scene, parts.path(), existing, stop).expect("runs");
    }
    let [whole, parts] = [&whole, &parts].map(|folder| files(folder.path()));
    assert!(whole == parts, "{:?}", differing(&whole, &parts));
    for name in ["/charge.csv", "/frames/field-000000.vti", "/frames/field-000004.vti"] {
        assert!(whole.contains_key(name), "{name} in {:?}", whole.keys());
    }
}

/// A method that hardly damps gives a hair that is shaken energy: the run says so, with the time
/// and which hair, whatever a scene asks to be written. The default damps enough.
#[test]
fn energy_from_nowhere_ends_a_run() {
    let hair = "length: 0.2, segments: 40, section: Circle(radius: 3.5e-5)";
    let along = "orientation: Along(direction: (0, 0, -1))";
    let shaken = |method: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = Scene::from_ron(&format!(
            "(format: 1, duration: 0.1,
            fibers: [({hair}, root: (position: (1, 0, 0), {along})), ({hair}, root: ({along}),
                motion: Shake(amplitude: (0.03, 0, 0), frequency: 10))],
            stepper: (dt: 1e-3{method}), output: (frame_rate: 100))"
        ));
        run_until(&scene.expect("sound"), folder.path(), Existing::Refuse, u64::MAX)
    };
    assert!(shaken("").is_ok());
    let error = shaken(", method: Staggered(rho_infinity: 0.9)").expect_err("it creates energy");
    let SimError::Created { time, created, supplied, fiber: Some(1) } = error else {
        panic!("{error}")
    };
    assert!(time < 0.1 && created > 0.1 * supplied, "{error}");
    let text = error.to_string();
    assert!(text.contains("fibre 1") && text.contains(&format!("t = {time} s")), "{text}");
}

/// The names of files that are not the same.
fn differing<'a>(
    a: &'a BTreeMap<String, Vec<u8>>,
    b: &BTreeMap<String, Vec<u8>>,
) -> Vec<&'a String> {
    a.iter().filter(|(name, bytes)| b.get(*name) != Some(bytes)).map(|(name, _)| name).collect()
}
