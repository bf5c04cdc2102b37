//! Rods at rest from the command line: the cases that ship, and cases that are wrong.

use crate::common::rapunzel;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/static").join(name)
}

/// Solves a case into a folder, and reads the answer.
fn answer(case: &Path, folder: &Path) -> Value {
    let out = folder.join("out");
    let output =
        rapunzel().args(["solve", "--json", "--out"]).args([&out, case]).output().expect("runs");
    let words = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{words}");
    let object: Value = serde_json::from_str(&words).expect("JSON");
    let saved = fs::read_to_string(out.join("answer.json")).expect("an answer");
    assert_eq!(serde_json::from_str::<Value>(&saved).expect("JSON"), object["answer"]);
    for (i, found) in list(&object["answer"]["equilibria"]).iter().enumerate() {
        let table = fs::read_to_string(out.join(format!("rod-{i}.csv"))).expect("a table");
        assert_eq!(table.lines().count(), 1 + list(&found["stations"]).len());
    }
    for file in ["rods.vtp", "preview.png"] {
        assert!(fs::metadata(out.join(file)).is_ok_and(|m| m.len() > 1000), "{file}");
    }
    object["answer"].clone()
}

fn solved(name: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    answer(&shipped(name), folder.path())
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(value: &Value) -> [f64; 3] {
    let list = list(value);
    [0, 1, 2].map(|i| number(&list[i]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn a_hose_is_as_long_as_it_must_be() {
    let answer = solved("hose-between-flanges.ron");
    let found = &answer["equilibria"][0];
    assert_eq!(found["stability"], "Stable");
    assert!((number(&found["sharpest"]["curvature"]) - 3.5).abs() < 1e-6, "{}", found["sharpest"]);
    assert!((number(&answer["wish"]["reached"]) - 3.5).abs() < 1e-6);
    let length = number(&answer["length"]);
    assert!((0.651..1.0).contains(&length), "{length}");
    let end = list(&found["stations"]).last().expect("an end");
    assert!(distance(vector(&end["position"]), [0.6, 0.0, 0.25]) < 1e-9);
    assert!(distance(vector(&end["frame"][2]), [1.0, 0.0, 0.0]) < 1e-8);
    // Both flanges together carry the weight.
    let carried = number(&found["clamp_force"][2]) - number(&found["end_force"][2]);
    assert!((carried + 0.45 * 9.81 * length).abs() < 1e-9, "{carried}");
}

#[test]
fn the_root_of_a_tress_carries_hair_and_bead() {
    let answer = solved("tress-root.ron");
    let found = &answer["equilibria"][0];
    assert_eq!(found["stability"], "Stable");
    let weight = 9.81 * (1300.0 * std::f64::consts::PI * 12e-10 * 0.3 + 2e-5);
    let force = vector(&found["clamp_force"]);
    assert!(distance(force, [0.0, 0.0, -weight]) < 1e-6 * weight, "{force:?} {weight}");
    // The moment at the root is that of all weights about it.
    let stations = list(&found["stations"]);
    let part = 9.81 * 1300.0 * std::f64::consts::PI * 12e-10 * 0.3 / 300.0;
    let arm = |i: usize| vector(&stations[i]["position"])[0];
    // Simpson's rule along the stations.
    let along: f64 = (0..150).map(|i| arm(2 * i) + 4.0 * arm(2 * i + 1) + arm(2 * i + 2)).sum();
    let moment = part * along / 3.0 + 9.81 * 2e-5 * arm(150);
    let own = vector(&found["clamp_moment"])[1];
    assert!((own / moment - 1.0).abs() < 1e-5, "{own} {moment}");
}

#[test]
fn a_following_force_stays_across_the_tip() {
    let answer = solved("follower-load.ron");
    let found = &answer["equilibria"][0];
    assert_eq!(found["stability"], "Unknown");
    let (force, clamp) = (vector(&found["end_force"]), vector(&found["clamp_force"]));
    assert!(distance(force, clamp) < 1e-9);
    let tip = list(&found["stations"]).last().expect("a tip");
    assert!(dot(force, vector(&tip["frame"][2])).abs() < 1e-6);
    assert!((dot(force, force).sqrt() - 20.0).abs() < 1e-9);
    // Beyond the direction of the force: the tip points down.
    assert!(vector(&tip["frame"][2])[2] < 0.0);
}

#[test]
fn an_upright_rod_beyond_greenhills_length_leans() {
    let answer = solved("upright-rod.ron");
    let all = list(&answer["equilibria"]);
    assert_eq!(all[0]["stability"], "Stable");
    let last = &all[all.len() - 1];
    assert_eq!(last["stability"]["Unstable"], 2);
    let weight = 7850.0 * std::f64::consts::PI * 1e-6 * 9.81 * 3.1;
    let straight = number(&last["load_energy"]);
    assert!((straight / (0.5 * weight * 3.1) - 1.0).abs() < 1e-9, "{straight}");
    assert!(all.len() <= 3, "turned copies are told once: {}", all.len());
}

#[test]
fn a_fiber_nestles_against_two_places() {
    let answer = solved("two-places.ron");
    let found = &answer["equilibria"][0];
    let stations = list(&found["stations"]);
    let middle = vector(&stations[50]["position"]);
    assert!(distance(middle, [0.12, 0.02, 0.02]) < 1e-9, "{middle:?}");
    let tip = vector(&stations[100]["position"]);
    let pull = vector(&found["place_forces"][1]);
    let place = [0.22, -0.03, 0.1];
    let spring = [0, 1, 2].map(|i| 10.0 * (place[i] - tip[i]));
    assert!(distance(spring, pull) < 1e-9, "{spring:?} {pull:?}");
}

/// A cable between two joints on one level: the wished sag, and the wished pull on the clamp.
#[test]
fn a_cable_is_as_long_as_it_is_wished() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cable.ron");
    for (wish, value, read) in [("Sag", 0.2, "sag"), ("ClampForce", 6.0, "clamp_force")] {
        let text = format!(
            "(
                format: 1, length: 1.02, parts: 200,
                rod: Measured(
                    bending: (0.02, 0.02), torsion: 0.02, linear_density: 0.5, radius: 0.004,
                ),
                clamp: (orientation: Along(direction: (1, 0, -0.5))),
                end: Joint(position: (1, 0, 0)),
                wish: (so_that: {wish}({value:?}), longest: 1.5),
            )"
        );
        fs::write(&path, text).expect("writable");
        let answer = answer(&path, folder.path());
        let found = &answer["equilibria"][0][read];
        let reached = found.as_f64().unwrap_or_else(|| dot(vector(found), vector(found)).sqrt());
        assert!((reached - value).abs() < 1e-6 * value, "{wish}: {reached}");
        assert!(number(&answer["length"]) > 1.02);
    }
}

/// A force down on the end of a level rod without weight turns it by a right angle near the clamp,
/// where its moment is that of the force at `sqrt(2 EI / P)`; what is zero by symmetry is zero.
#[test]
fn a_strong_force_on_the_end_hangs_the_rod() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.ron");
    for force in [1e3_f64, 1e5, 1e7] {
        let text = format!(
            "(
                format: 1, length: 1.0, gravity: (0, 0, 0),
                rod: Measured(bending: (1, 1), torsion: 0.8, linear_density: 0.0, radius: 0.001),
                clamp: (orientation: Along(direction: (1, 0, 0))),
                end: Free(force: (0, 0, {:?})),
            )",
            -force
        );
        fs::write(&path, text).expect("writable");
        let answer = answer(&path, folder.path());
        let found = &answer["equilibria"][0];
        assert_eq!(found["stability"], "Stable");
        let tip = vector(&list(&found["stations"]).last().expect("a tip")["position"]);
        let away = (2.0 / force).sqrt();
        // The rod is infinitely long to `exp(-sqrt(P L^2 / EI))`.
        assert!((tip[0] / away - 1.0).abs() < 1e-8, "{force}: {tip:?}");
        let moment = vector(&found["clamp_moment"]);
        assert!((moment[1] / (force * away) - 1.0).abs() < 1e-8, "{force}: {moment:?}");
        assert_eq!([tip[1], moment[0], moment[2]], [0.0; 3]);
        assert_eq!(vector(&found["end_moment"]), [0.0; 3]);
    }
}

const SOUND: &str = "(
    format: 1,
    length: 1.0,
    rod: Measured(bending: (1, 1), torsion: 0.8, linear_density: 0.1, radius: 0.01),
    end: Joint(position: (0.5, 0.0, -0.3)),
)";

#[test]
fn a_wrong_case_is_underlined() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.ron");
    let joint = "end: Joint(position: (0.5, 0.0, -0.3))";
    for (from, to, message) in [
        ("length: 1.0", "length: 0.0", "length: is 0.0, but must be between"),
        ("length: 1.0", "lenght: 1.0", "Unexpected field named `lenght`"),
        ("bending: (1, 1)", "bending: (-1, 1)", "rod.bending[0]: is -1.0, but must be between"),
        ("torsion: 0.8", "torsion: 0", "rod.torsion: is 0.0, but must be between"),
        ("(0.5, 0.0", "(1.5, 0.0", "is 1.5297058540778354 m from the clamp, but the rod is 1.0 m"),
        ("format: 1", "format: 3", "format: is 3, but this version reads format 1"),
        (joint, "masses: [(at: 2.0, mass: 1)]", "masses[0].at: is 2.0, but must be 0, or between"),
        (
            joint,
            "end: Bearing(position: (0, 0, -0.5), direction: (0, 0, 0))",
            "end.direction: is [0.0, 0.0, 0.0], but must have a length between",
        ),
        (
            joint,
            "end: Clamped(position: (0, 0, -0.5), orientation: Euler(degrees: (0, 0, 0))),
            forces: [(at: 1, value: (1, 0, 0), frame: Follower)]",
            "does not go together with following forces",
        ),
        (joint, "places: [(at: 0.1, position: (0, 0, -0.2))]", "places[0].position: is 0.2 m from"),
        (joint, "wish: (so_that: Sag(-1), longest: 2)", "wish.so_that: is -1.0"),
        (joint, "wish: (so_that: Sag(0.1), longest: 0.5)", "wish.longest: is 0.5"),
        (joint, "parts: 1", "parts: is 1, but must be between 2"),
        (
            joint,
            "natural_curvature: (30, 4294967296, 20)",
            "natural_curvature: is 4294967296.0 1/m in size, but a rod of radius 0.01 m is \
             curved by 100.0 1/m at most",
        ),
    ] {
        assert!(SOUND.contains(from), "{from}");
        fs::write(&path, SOUND.replace(from, to)).expect("writable");
        let output = rapunzel().arg("solve").arg(&path).output().expect("runs");
        let words = String::from_utf8_lossy(&output.stderr).replace("\n  │ ", " ");
        assert_eq!(output.status.code(), Some(3), "{to}: {words}");
        assert!(words.contains(message), "{to}: {words}");
        assert!(words.contains("case.ron:"), "the file, line and column: {words}");
    }
}

#[test]
fn a_case_without_an_answer_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.ron");
    let text =
        SOUND.replace("end: Joint", "wish: (so_that: Curvature(0.01), longest: 1.2), end: Joint");
    fs::write(&path, text).expect("writable");
    let output = rapunzel().arg("solve").arg(&path).output().expect("runs");
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("no length between 1 and 1.2 m does what is wished"), "{words}");
    assert!(!folder.path().join("runs").exists());
}
