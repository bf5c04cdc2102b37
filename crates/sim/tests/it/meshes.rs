//! Meshes in files: their unit, their faults, and what they take of memory.

use rapunzel_sim::{MemoryEstimate, Scene, SimError, World};
use std::fs;

/// A box of 40 in its unit, whose faces are quadrilaterals; the last, if it is there, closes it.
const CLOSED: &str = "v -20 -20 -20\nv 20 -20 -20\nv 20 20 -20\nv -20 20 -20\n\
    v -20 -20 20\nv 20 -20 20\nv 20 20 20\nv -20 20 20\n\
    f 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 7 8\n";

/// A scene in which a hair falls on the box, `more` being said of that.
fn scene(folder: &tempfile::TempDir, mesh: &str, more: &str) -> Scene {
    fs::write(folder.path().join("box.obj"), mesh).expect("writable");
    let text = format!(
        "(format: 1, duration: 0.1, stepper: (dt: 1e-3), contact: (friction: Isotropic(0.3)),
        fibers: [(length: 0.03, segments: 6, section: Circle(radius: 5e-4))],
        objects: [(shape: Mesh(file: \"box.obj\", spacing: 2e-3, {more}), position: (0, 0, -1))])"
    );
    Scene::from_ron(&text).expect("sound").seen_from(folder.path())
}

#[test]
fn a_mesh_in_millimetres_is_told_with_its_size_and_taken_with_its_scale() {
    let folder = tempfile::tempdir().expect("a folder");
    let estimate = MemoryEstimate::new(&scene(&folder, CLOSED, "")).expect("read");
    assert!(estimate.notes[0].contains("40.000 x 40.000 x 40.000 m"), "{:?}", estimate.notes);
    let error = estimate.within(16e9).expect_err("8 10^12 cells").to_string();
    assert!(error.contains("objects[0]") && error.contains("scale: 0.001"), "{error}");

    let scaled = scene(&folder, CLOSED, "scale: 1e-3");
    let estimate = MemoryEstimate::new(&scaled).expect("read");
    estimate.within(1e8).expect("20 cells along each side");
    assert!(estimate.notes.is_empty(), "{:?}", estimate.notes);
    let surface = World::build(&scaled).expect("sound").surfaces().next().expect("an object");
    let top = surface.surface.vertices.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    assert!((top + 0.98).abs() < 1e-15, "{top}");
}

#[test]
fn a_mesh_is_repaired_where_that_is_asked_for_and_it_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let open = CLOSED.trim_end().rsplit_once('\n').expect("lines").0;
    let refused = World::build(&scene(&folder, open, "scale: 1e-3")).map(|_| ());
    assert!(matches!(refused, Err(SimError::Mesh { object: 0, .. })), "{refused:?}");
    let repaired = scene(&folder, open, "scale: 1e-3, repair: true");
    let notes = MemoryEstimate::new(&repaired).expect("read").notes;
    assert_eq!(notes, ["objects[0]: the mesh was repaired; holes closed: 1"]);
    World::build(&repaired).expect("closed");
}

/// Every field that sizes something, so large that it would take more than there is.
#[test]
fn what_takes_too_much_is_refused_before_it_is_built() {
    let scene = |fiber: &str, rest: &str| {
        let text = format!(
            "(format: 1, duration: 0.1, stepper: (dt: 1e-3), fibers: [(length: 0.3, {fiber},
            section: Circle(radius: 4e-5))], {rest})"
        );
        Scene::from_ron(&text).expect("each number is in its range")
    };
    let field = "objects: [(shape: HeightField(sides: (0.4, 1000), spacing: 0.004, amplitude: 0.05,
        wavelength: 0.15))], contact: (friction: Isotropic(0.4))";
    let grid = "charging: (grid: (origin: (0, 0, 0), spacing: (1, 1, 1), counts: (500, 500, 400)))";
    for (fiber, rest, path) in [
        ("segments: 100000, arrangement: Lock(count: 180, radius: 0.01)", "", "fibers[0]"),
        (
            "segments: 100, arrangement: EllipseAtDensity(semi_axes: (1, 1), density: 3e5)",
            "",
            "fibers[0]",
        ),
        ("segments: 10", field, "objects[0]"),
        ("segments: 10", grid, "charging.grid"),
    ] {
        let error = MemoryEstimate::new(&scene(fiber, rest)).expect("sound").within(4e9);
        assert!(
            matches!(&error, Err(SimError::Memory { path: at, .. }) if at == path),
            "{error:?}"
        );
    }
    let small = scene("segments: 100, arrangement: Lock(count: 180, radius: 0.01)", "");
    MemoryEstimate::new(&small).expect("sound").within(1e8).expect("18,281 nodes");
}
