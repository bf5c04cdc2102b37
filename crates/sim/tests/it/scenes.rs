//! The scenes that ship.

use rapunzel_sim::scene::Arrangement;
use rapunzel_sim::{Plan, Scene, World};
use std::fs;
use std::path::PathBuf;

/// Paths and texts of the scenes that stand alone: no style has to be grown for them.
fn shipped() -> Vec<(PathBuf, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let mut paths: Vec<_> =
        [folder.to_owned(), format!("{folder}/contact"), format!("{folder}/joined")]
            .iter()
            .flat_map(|folder| fs::read_dir(folder).expect("a folder of scenes"))
            .map(|file| file.expect("a file").path())
            .collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "ron"));
    paths.sort();
    assert!(paths.len() >= 16, "{paths:?}");
    let texts = paths.into_iter().map(|p| (p.clone(), fs::read_to_string(p).expect("readable")));
    texts.filter(|(_, text)| !text.contains("Style(")).collect()
}

#[test]
fn every_scene_is_sound_and_survives_writing() {
    for (path, text) in shipped() {
        let scene = Scene::from_ron(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(!scene.name.is_empty(), "{} has no title", path.display());
        let written = scene.to_ron().expect("a sound scene");
        assert_eq!(Scene::from_ron(&written).expect("reads back"), scene);
        World::build(&scene).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
}

/// The places of all numbers in a scene, outside of comments and texts.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let is_word = |c: char| c.is_ascii_alphanumeric() || "_.+-".contains(c);
        let length = match first {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        if rest[..length].trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit()) {
            found.push(at..at + length);
        }
        at += length;
    }
    found
}

#[test]
fn values_that_are_no_physics_are_refused_in_every_field() {
    for (path, text) in shipped() {
        let places = numbers(&text);
        assert!(places.len() > 5, "{}", path.display());
        for place in places {
            for value in ["1e308", "-1e308", "1e35"] {
                let changed = format!("{}{value}{}", &text[..place.start], &text[place.end..]);
                let told = &changed[place.start.saturating_sub(60)..place.start + value.len()];
                assert!(Scene::from_ron(&changed).is_err(), "{}: {told}", path.display());
            }
        }
    }
}

#[test]
fn zero_and_less_in_any_field_are_refused_or_have_an_end() {
    for (path, text) in shipped() {
        for place in numbers(&text) {
            for value in ["0", "-1"] {
                let changed = format!("{}{value}{}", &text[..place.start], &text[place.end..]);
                if let Ok(scene) = Scene::from_ron(&changed) {
                    let steps = Plan::new(&scene).steps;
                    assert!((1..1 << 53).contains(&steps), "{}: {steps}", path.display());
                }
            }
        }
    }
}

#[test]
fn every_scene_runs() {
    for (path, text) in shipped() {
        let mut scene = Scene::from_ron(&text).expect("a sound scene");
        for bundle in &mut scene.fibers {
            match &mut bundle.arrangement {
                Arrangement::Lock { count, .. } => *count = 2,
                Arrangement::Ellipse { count, .. } => *count = 12,
                _ => {}
            }
        }
        let mut world = World::build(&scene).expect("a sound scene");
        for _ in 0..12 {
            world.step(Plan::new(&scene).dt).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        }
        for i in 0..world.assembly().fibers().len() {
            let (state, fiber) = (world.state(i), &world.assembly().fibers()[i]);
            let longest = fiber.length() * (1.0 + 1e-9);
            let tip = state.positions[fiber.segments()];
            let reach = (tip - state.positions[0]).norm();
            assert!(reach <= longest, "{}: fibre {i} stretched to {reach} m", path.display());
        }
    }
}

#[test]
fn steps_do_not_depend_on_the_threads() {
    let shipped = shipped();
    let named = shipped.iter().find(|(path, _)| path.ends_with("lock-on-moving-root.ron"));
    let scene = Scene::from_ron(&named.expect("it ships").1).expect("a sound scene");
    let after = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut world = World::build(&scene).expect("a sound scene");
            for _ in 0..3 {
                world.step(1e-3).expect("converges");
            }
            world.snapshot()
        })
    };
    assert_eq!(scene.fibers[0].arrangement.fibers(), 181, "a scene with many groups");
    assert_eq!(after(1), after(3));
}

/// A heap of hairs that falls on the ground, with both solvers: several groups, and contacts
/// between them.
#[test]
fn contacts_do_not_depend_on_the_threads() {
    for solver in ["Splitting", "Polished"] {
        let scene = Scene::from_ron(&format!(
            "(format: 1, duration: 1.0, fibers: [(length: 0.03, segments: 10,
            section: Circle(radius: 3.5e-5), root_joint: Free, shape: Helix(radius: 0.002, pitch: 0.01),
            arrangement: Ellipse(semi_axes: (2e-3, 2e-3), count: 40),
            root: (orientation: Along(direction: (1, 0, 0))))],
            objects: [(shape: Plane(normal: (0, 0, 1)), position: (0, 0, -0.0045))],
            contact: (friction: Isotropic(0.3), solver: {solver}), stepper: (dt: 1e-3))"
        ))
        .expect("a sound scene");
        let after = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| {
                let mut world = World::build(&scene).expect("a sound scene");
                let mut most = 0;
                for _ in 0..40 {
                    let report = world.step(1e-3).expect("a step");
                    most = most.max(report.contact.active);
                }
                (most, world.snapshot())
            })
        };
        let (most, one) = after(1);
        assert!(most > 100, "{solver}: at most {most} contacts");
        for threads in [2, 3] {
            assert!(after(threads).1 == one, "{solver} with {threads} threads");
        }
    }
}
