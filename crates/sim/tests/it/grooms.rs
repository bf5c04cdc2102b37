//! Fibres along the curves of a groom: what is read is what is simulated and written, and it rests.

use nalgebra::{Point3, Vector3};
use rapunzel_export::{Frame, Strand, data, hair, obj, ply};
use rapunzel_sim::{MemoryEstimate, Scene, SimError, World};
use std::path::Path;

/// Strands that stand off a ball of 5 cm and droop, at most `length` long, in the frame of a file:
/// meters, y up.
fn droop(count: usize, length: f64) -> Vec<Vec<Point3<f64>>> {
    let strand = |k: usize| {
        let turn = 2.399_963 * k as f64;
        let lean = 0.2 + 0.8 * (k as f64 + 0.5) / count as f64;
        let out = [lean.sin() * turn.cos(), lean.cos(), lean.sin() * turn.sin()];
        let length = length * (1.0 - 0.3 * (k % 3) as f64 / 2.0);
        let point = |i: u32| {
            let s = length * f64::from(i) / 30.0;
            let drop = 2.0 * s * s;
            let r = 0.05 + s;
            Point3::new(r * out[0], r * out[1] - drop, r * out[2])
        };
        (0..=30).map(point).collect()
    };
    (0..count).map(strand).collect()
}

/// Writes strands as OBJ lines.
fn write(path: &Path, strands: &[Vec<Point3<f64>>]) {
    let mut text = String::new();
    let mut first = 1;
    for strand in strands {
        for p in strand {
            text += &format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z);
        }
        let numbers: Vec<_> = (first..first + strand.len()).map(|n| n.to_string()).collect();
        text += &format!("l {}\n", numbers.join(" "));
        first += strand.len();
    }
    std::fs::write(path, text).expect("a file");
}

/// A scene of the groom in `folder/groom.obj`.
fn scene(folder: &Path, groom: &str, rest: &str) -> Scene {
    let text = format!(
        "(format: 1, duration: 0.1,
        fibers: [(groom: (from: Strands(file: \"groom.obj\"), {groom}), segments: 20,
            section: Circle(radius: 3.5e-5), damping_time: 1e-3)],
        {rest})"
    );
    Scene::from_ron(&text).expect("a scene").seen_from(folder)
}

/// Largest distance of a node from where it starts within `steps` of `dt`, s, over the length of
/// its fibre.
fn motion(world: &mut World, steps: usize, dt: f64) -> f64 {
    let count = world.assembly().fibers().len();
    let before: Vec<_> = (0..count).map(|i| world.state(i).positions).collect();
    let mut largest = 0.0_f64;
    for _ in 0..steps {
        world.step(dt).expect("a step");
        for (i, start) in before.iter().enumerate() {
            let ways = world.state(i).positions;
            let ways = ways.iter().zip(start).map(|(a, b)| (a - b).norm());
            let length = world.assembly().fibers()[i].length();
            largest = largest.max(ways.fold(0.0, f64::max) / length);
        }
    }
    largest
}

/// z up, as scenes have it.
fn upright(p: &Point3<f64>) -> Point3<f64> {
    Point3::new(p.x, -p.z, p.y)
}

#[test]
fn a_groom_keeps_number_order_and_roots() {
    let folder = tempfile::tempdir().expect("a folder");
    let strands = droop(20, 0.08);
    write(&folder.path().join("groom.obj"), &strands);
    let scene = scene(folder.path(), "natural: Drawn", "stepper: (dt: 1e-3)");
    let world = World::build(&scene).expect("a world");
    assert_eq!(world.assembly().fibers().len(), strands.len());
    for (i, strand) in strands.iter().enumerate() {
        let state = world.state(i);
        assert!((state.positions[0] - upright(&strand[0])).norm() < 1e-12, "root {i}");
        let tip = state.positions.last().expect("nodes");
        assert!((tip - upright(&strand[30])).norm() < 1e-9, "tip {i}");
    }
    let estimate = MemoryEstimate::new(&scene).expect("an estimate");
    assert!(estimate.parts[0].what.starts_with("20 fibres of 20 segments"), "{estimate:?}");
}

/// Handed to the dynamics, nothing moves: 0.1 s, every node less than 1e-6 of its length.
#[test]
fn a_groom_rests_from_the_start() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder.path().join("groom.obj"), &droop(12, 0.05));
    for natural in ["SagFree()", "EndLoads()"] {
        for method in ["Staggered(rho_infinity: 0.9)", "BackwardEuler"] {
            let rest = format!("stepper: (dt: 1e-3, method: {method})");
            let scene = scene(folder.path(), &format!("natural: {natural}"), &rest);
            let mut world = World::build(&scene).expect("a world");
            let moved = motion(&mut world, 100, 1e-3);
            assert!(moved < 1e-6, "{natural} {method}: {moved:e} {:?}", world.notes());
        }
    }
    // Drawn without a weight in mind, they sag.
    let scene = scene(folder.path(), "natural: Drawn", "stepper: (dt: 1e-3)");
    let moved = motion(&mut World::build(&scene).expect("a world"), 100, 1e-3);
    assert!(moved > 1e-3, "{moved:e}");
}

/// With contact, strands that lie on a ball and in each other start out of each other, and every
/// node moves less than 1e-3 of its length in 0.1 s.
#[test]
fn a_groom_in_contact_rests_from_the_start() {
    let folder = tempfile::tempdir().expect("a folder");
    // Close along the ball, from its top to below its middle.
    let strand = |k: usize| -> Vec<Point3<f64>> {
        let turn = 2.399_963 * k as f64;
        let point = |i: u32| {
            let lean = 0.1 + 1.6 * f64::from(i) / 40.0;
            let r = 0.05 + 4e-5;
            Point3::new(r * lean.sin() * turn.cos(), r * lean.cos(), r * lean.sin() * turn.sin())
        };
        (0..=40).map(point).collect()
    };
    let mut strands: Vec<_> = (0..30).map(strand).collect();
    // Two that cross all others' ways, in each other.
    for height in [0.02, 0.0201] {
        let ring = |i: u32| {
            let (r, turn) = (0.05_f64.powi(2) - height * height, 0.1 * f64::from(i));
            let r = r.sqrt() + 5e-5;
            Point3::new(r * turn.cos(), height, r * turn.sin())
        };
        strands.push((0..=30).map(ring).collect());
    }
    write(&folder.path().join("groom.obj"), &strands);
    let rest = "objects: [(shape: Ball(radius: 0.0499))], contact: (friction: Isotropic(0.3)),
                stepper: (dt: 1e-3)";
    let scene = scene(folder.path(), "natural: SagFree()", rest);
    let mut world = World::build(&scene).expect("a world");
    let moved = motion(&mut world, 100, 1e-3);
    assert!(moved < 1e-3, "{moved:e} {:?}", world.notes());
    assert!(world.contacts().count() > 10, "they lie on the ball");
}

/// A prestressed fibre beside a groom in contact starts where the scene puts it.
#[test]
fn other_fibers_do_not_settle() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder.path().join("groom.obj"), &droop(3, 0.05));
    let text =
        "(format: 1, duration: 0.1, contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3),
        fibers: [
            (groom: (from: Strands(file: \"groom.obj\")), segments: 10,
                section: Circle(radius: 3.5e-5)),
            (length: 0.05, segments: 10, section: Circle(radius: 3.5e-5), initial: Straight,
                shape: Helix(radius: 0.005, pitch: 0.01), root: (position: (0.5, 0, 0))),
        ])";
    let scene = Scene::from_ron(text).expect("a scene").seen_from(folder.path());
    let world = World::build(&scene).expect("a world");
    for (node, p) in world.state(3).positions.iter().enumerate() {
        let straight = Point3::new(0.5, 0.0, -5e-3 * node as f64);
        assert!((p - straight).norm() < 1e-12, "{node}: {p}");
    }
}

/// What a scene says in place of a groom, what is not there, and what is no fibre.
#[test]
fn what_a_groom_cannot_be_is_told() {
    let refused = |bundle: &str, field: &str| {
        let text = format!(
            "(format: 1, duration: 0.1, stepper: (dt: 1e-3), fibers: [({bundle}, segments: 9,
                section: Circle(radius: 3.5e-5), groom: (from: Strands(file: \"groom.obj\")))])"
        );
        let error = Scene::from_ron(&text).expect_err("a scene that is refused").to_string();
        assert!(error.contains(field), "{bundle}: {error}");
    };
    refused("length: 0.1", "fibers[0].length");
    refused("shape: Helix(radius: 0.01, pitch: 0.01)", "fibers[0].shape");
    refused("initial: Straight", "fibers[0].initial");
    refused("arrangement: Ellipse(semi_axes: (0.1, 0.1), count: 3)", "fibers[0].arrangement");
    refused("root: (orientation: Euler(degrees: (0, 0, 9)))", "fibers[0].root.orientation");
    refused("root_joint: Free", "fibers[0].root_joint");
    refused("tip: Held", "fibers[0].tip");

    let folder = tempfile::tempdir().expect("a folder");
    let plain = |groom: &str| scene(folder.path(), groom, "stepper: (dt: 1e-3)");
    let error = |groom: &str| World::build(&plain(groom)).err().expect("an error");
    assert!(matches!(error(""), SimError::Io { .. }), "no file");
    std::fs::write(folder.path().join("groom.obj"), "v 0 0 0\n").expect("a file");
    assert!(matches!(error(""), SimError::Strands { bundle: 0, .. }), "no strands");
    write(&folder.path().join("groom.obj"), &droop(5, 0.05));
    let far = "roots_within: (center: (1, 1, 1), radius: 0.1)";
    assert!(matches!(error(far), SimError::NoStrands { bundle: 0, .. }), "{}", error(far));
    let mut probed = plain("");
    probed.output.probes = Scene::from_ron(
        "(format: 1, duration: 0.1, stepper: (dt: 1e-3), output: (probes: [(fiber: 5, quantity:
          Position)]), fibers: [(length: 0.1, segments: 9, section: Circle(radius: 3.5e-5),
          arrangement: Ellipse(semi_axes: (0.1, 0.1), count: 9))])",
    )
    .expect("a scene")
    .output
    .probes;
    let error = World::build(&probed).err().expect("an error");
    assert!(
        matches!(error, SimError::Probe { probe: 0, fiber: 5, fibers: 5, nodes: 0 }),
        "{error}"
    );
}

/// A groom that is read, built and written is the same in each format of strands.
#[test]
fn a_groom_goes_through_every_format() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder.path().join("groom.obj"), &droop(7, 0.05));
    let first = scene(folder.path(), "natural: Drawn", "stepper: (dt: 1e-3)");
    let world = World::build(&first).expect("a world");
    let before: Vec<_> = (0..7).map(|i| world.state(i)).collect();
    let strands = before.iter().map(|state| Strand {
        // Back to y up, as these formats have it.
        points: state.positions.iter().map(|p| Point3::new(p.x, p.z, -p.y)).collect(),
        radii: vec![3.5e-5; state.positions.len()],
        velocities: state.velocities.clone(),
        frames: state.frames.clone(),
        curvatures: state.curvatures.clone(),
        forces: state.forces.clone(),
        contact_forces: vec![Vector3::zeros(); state.positions.len()],
        charges: vec![0.0; state.positions.len()],
    });
    let frame = Frame { index: 0, time: 0.0, strands: strands.collect() };
    for ending in ["hair", "data", "obj", "ply"] {
        let mut bytes = Vec::new();
        match ending {
            "hair" => hair::write(&mut bytes, &frame),
            "data" => data::write(&mut bytes, &frame),
            "obj" => obj::write(&mut bytes, &frame),
            _ => ply::write(&mut bytes, &frame, ply::PlyEncoding::Binary),
        }
        .expect("a format");
        let path = folder.path().join(format!("again.{ending}"));
        std::fs::write(&path, bytes).expect("a file");
        let mut again = first.clone();
        let groom = again.fibers[0].groom.as_mut().expect("a groom");
        groom.from =
            rapunzel_sim::scene::GroomSource::Strands { file: path, scale: None, up: None };
        let world = World::build(&again).expect("a world");
        for (i, state) in before.iter().enumerate() {
            let length = world.assembly().fibers()[i].length();
            for (a, b) in world.state(i).positions.iter().zip(&state.positions) {
                assert!((a - b).norm() < 1e-6 * length, "{ending} {i}: {}", (a - b).norm());
            }
        }
    }
}

/// The scenes with styles that ship can be read, and written again; growing them takes longer than
/// a test should.
#[test]
fn scenes_with_styles_that_ship_are_sound() {
    let scenes = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    for name in ["style/tress", "style/shaken-head", "contact/head", "contact/turned-head"] {
        let path = scenes.join(format!("{name}.ron"));
        let text = std::fs::read_to_string(&path).expect("a scene");
        let scene = Scene::from_ron(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(Scene::from_ron(&scene.to_ron().expect("sound")).expect("reads back"), scene);
        for file in scene.seen_from(path.parent().expect("a folder")).files() {
            assert!(file.exists(), "{name}: {}", file.display());
        }
    }
}
