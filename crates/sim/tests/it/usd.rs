//! Runs that leave a USD stage, whatever their frame rate, step and kind.

use proptest::prelude::*;
use rapunzel_sim::{
    Cancel, Control, Existing, Outcome, RunFolder, Scene, SimError, Summary, World, run,
};
use std::fs;
use std::path::Path;

fn run_in(path: &Path, text: &str, existing: Existing) -> Result<Summary, SimError> {
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let mut folder = RunFolder::open(path, existing)?;
    let control = Control {
        sync_is_due: &mut || false,
        cancel: &Cancel::new(),
        progress: &mut |_| (),
        stopwatch: None,
    };
    run(&scene, World::build(&scene)?, &mut folder, control)
}

/// A number of the head of a layer.
fn head(text: &str, name: &str) -> f64 {
    let (_, rest) = text.split_once(&format!("\n    {name} = ")).expect("it is in the head");
    rest.lines().next().expect("a line").parse().expect("a number")
}

/// The time codes of an attribute.
fn codes(text: &str, attribute: &str) -> Vec<f64> {
    let (_, rest) = text.split_once(&format!("{attribute}.timeSamples = {{\n")).expect("samples");
    let (rows, _) = rest.split_once("\n            }").expect("an end");
    let code = |row: &str| row.trim().split(':').next().expect("one").parse().expect("a number");
    rows.lines().map(code).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Every layer has the range and the rate of the scene, and a sample for each frame; the last
    /// is where the run ends.
    #[test]
    fn every_rate_and_step_has_a_stage(
        rate in prop_oneof![
            Just(24.0), Just(30.0), Just(60.0), Just(25.0), Just(29.97), Just(1000.0), 1.0_f64..2000.0
        ],
        dt in prop_oneof![Just(1e-3), Just(7e-4), Just(3e-3), 1e-4_f64..1e-2],
        frames in 0.3..6.0_f64,
    ) {
        let duration = (frames / rate).min(400.0 * dt);
        let folder = tempfile::tempdir().expect("a folder");
        let summary = run_in(
            folder.path(),
            &format!(
                "(format: 1, duration: {duration:?},
                  fibers: [(length: 0.05, segments: 4, section: Circle(radius: 3.5e-5))],
                  objects: [(shape: Ball(radius: 0.02), position: (0, 0, -0.2),
                             motion: Translate(velocity: (1, 0, 0), until: 1))],
                  contact: (friction: Isotropic(0.2)),
                  stepper: (dt: {dt:?}), output: (frame_rate: {rate:?}, formats: [Usd]))"
            ),
            Existing::Refuse,
        ).expect("runs");
        prop_assert_eq!(summary.outcome, Outcome::Complete);
        let stage = fs::read_to_string(folder.path().join("scene.usda")).expect("a stage");
        prop_assert!(stage.contains("@./fibers.usda@,\n        @./objects.usda@"), "{}", stage);
        let end = duration * rate;
        for (file, attribute) in
            [("fibers.usda", "point3f[] points"), ("objects.usda", "double3 xformOp:translate")]
        {
            let text = fs::read_to_string(folder.path().join(file)).expect("a layer");
            for layer in [&text, &stage] {
                prop_assert_eq!(head(layer, "timeCodesPerSecond"), rate);
                prop_assert_eq!(head(layer, "framesPerSecond"), rate);
                prop_assert_eq!(head(layer, "startTimeCode"), 0.0);
                // A rest of the duration that is a rounding is no frame of its own.
                prop_assert!((head(layer, "endTimeCode") - end).abs() < 1e-5, "{}", end);
            }
            let codes = codes(&text, attribute);
            prop_assert_eq!(codes.len() as u64, summary.frames);
            prop_assert_eq!(codes[codes.len() - 1], head(&text, "endTimeCode"));
            let whole = codes[..codes.len() - 1].iter().enumerate();
            prop_assert!(whole.into_iter().all(|(k, code)| *code == k as f64), "{:?}", codes);
        }
    }
}

#[test]
fn springs_are_surfaces_of_shared_nodes() {
    for (model, nodes, faces) in [
        // All cells of two rows and three columns of them, by both triangles of each.
        ("Net(place: Flying(rows: 3, columns: 4), spacing: 0.1)", 12, vec![4; 6]),
        (
            "Net(place: Flying(rows: 3, columns: 4), spacing: 0.1, triangular: true)",
            12,
            vec![3; 12],
        ),
        ("Body(shape: Cube, spacing: 0.1)", 100, vec![4; 81]),
        ("Ring(count: 14, radius: 0.3)", 15, vec![3; 14]),
        // An octahedron with every edge cut in two.
        ("Ball(radius: 0.3, fineness: 2)", 18, vec![3; 32]),
        ("Rope(nodes: 5, spacing: 0.1, direction: (1, 0, 0))", 0, vec![]),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let text = format!(
            "(format: 1, duration: 0.1, mass_spring: (model: {model}, mass: 0.01, frequency: 5),
              stepper: (dt: 1e-3), output: (formats: [Usd, Hair, Pov]))"
        );
        run_in(folder.path(), &text, Existing::Refuse).expect("runs");
        let layer = fs::read_to_string(folder.path().join("springs.usda")).expect("a layer");
        let line = |name: &str| layer.lines().find(|line| line.contains(name)).unwrap_or_default();
        if faces.is_empty() {
            assert!(!layer.contains("def Mesh") && !layer.contains("guide"), "{model}: {layer}");
            continue;
        }
        assert!(line("faceVertexCounts").ends_with(&format!("= {faces:?}")), "{model}: {layer}");
        let (_, corners) = line("faceVertexIndices").split_once("= [").expect("a list");
        let corner = |corner: &str| corner.trim().parse::<usize>().expect("a number");
        let most = corners.trim_end_matches(']').split(',').map(corner).max();
        assert_eq!(most, Some(nodes - 1), "{model}");
        assert!(line("purpose").contains("guide"), "{model}: {layer}");
    }
}

/// A file that cannot be written costs itself: all others are there, the run names those that are
/// not, and writes them when it is resumed.
#[test]
fn a_fault_costs_one_file() {
    let text = "(format: 1, duration: 0.1,
        fibers: [(length: 0.05, segments: 4, section: Circle(radius: 3.5e-5))],
        objects: [(shape: Ball(radius: 0.02), position: (0, 0, -0.2))],
        contact: (friction: Isotropic(0.2)),
        stepper: (dt: 1e-3), output: (frame_rate: 50, formats: [Usd, Hair, Pov, Mitsuba]))";
    let [whole, folder] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    run_in(whole.path(), text, Existing::Refuse).expect("runs");
    let path = folder.path();
    // Folders in the places of four files; they come once the run has its own.
    let blocked = [
        "objects.usda",
        "frames/frame-000002.pov",
        "frames/frame-000003.hair",
        "frames/frame-000004.txt",
    ];
    let scene = Scene::from_ron(text).expect("sound");
    let mut run_folder = RunFolder::open(path, Existing::Refuse).expect("empty");
    let mut progress = |now: &rapunzel_sim::Progress| {
        if now.steps == 1 {
            blocked.iter().for_each(|file| fs::create_dir(path.join(file)).expect("a folder"));
        }
    };
    let control = Control {
        sync_is_due: &mut || false,
        cancel: &Cancel::new(),
        progress: &mut progress,
        stopwatch: None,
    };
    let world = World::build(&scene).expect("a world");
    let error =
        run(&scene, world, &mut run_folder, control).expect_err("four files are in the way");
    drop(run_folder);
    let SimError::Unwritten { faults } = &error else { panic!("{error}") };
    assert_eq!(faults.len(), 4, "{error}");
    for file in blocked {
        assert!(error.to_string().contains(file), "{error}");
        fs::remove_dir(path.join(file)).expect("still empty");
    }
    let stage = fs::read_to_string(path.join("scene.usda")).expect("a stage");
    assert!(stage.contains("fibers.usda") && !stage.contains("objects.usda"), "{stage}");
    assert!(path.join("preview.png").exists());
    let summary = run_in(path, text, Existing::Resume).expect("nothing is in the way");
    assert_eq!(summary.outcome, Outcome::Complete);
    let others = ["scene.usda", "fibers.usda", "preview.png", "frames/frame-000004.xml"];
    for file in blocked.into_iter().chain(others).chain(["frames/objects-000000.obj"]) {
        let [a, b] = [whole.path(), path].map(|folder| fs::read(folder.join(file)).expect("there"));
        assert!(a == b, "{file}");
    }
}
