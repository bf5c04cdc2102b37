use crate::common::{BALL, Client, HAIRS, Served, bump};
use rapunzel_sim::{Cancel, Control, Existing, RunFolder, Scene, Shown, World, run};
use rapunzel_view::Options;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::time::Duration;

fn record(folder: &Path) {
    record_of(HAIRS, folder);
}

pub(crate) fn record_of(text: &str, folder: &Path) {
    let scene = Scene::from_ron(text).expect("a scene");
    let mut folder = RunFolder::open(folder, Existing::Refuse).expect("a folder");
    let control = Control {
        sync_is_due: &mut || false,
        cancel: &Cancel::new(),
        progress: &mut |_| (),
        stopwatch: None,
    };
    let world = World::build(&scene).expect("a world");
    run(&scene, world, &mut folder, control).expect("a run");
}

fn shown(path: &Path) -> Served {
    Served::new(Options { what: Some(path.to_owned()), ..Options::local(path.to_owned()) })
}

#[test]
fn a_run_is_sought_to_the_positions_of_its_frames() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    record(&folder);
    let frames = Shown::open(&folder, &|_| ()).expect("a run");
    let served = shown(&folder);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "recorded");
    assert_eq!(about["frames"], 11);
    for index in [7_usize, 0, 10, 3] {
        page.order(&format!(r#"{{"do":"seek","frame":{index}}}"#));
        page.wait("state", |state| state["frame"] == index);
        // The frame may come after the state.
        while page.frame.get(8..16) != Some(&(index as u64).to_le_bytes()) {
            page.order(r#"{"do":"fit_colors"}"#);
            page.wait("state", |_| true);
        }
        let frame = frames.frame(index).expect("a frame").frame;
        let points = frame.strands.iter().flat_map(|strand| &strand.points);
        for (point, expected) in points.enumerate() {
            let (position, error) = page.position(point);
            for axis in 0..3 {
                let off = (position[axis] - expected[axis]).abs();
                assert!(off <= error * (1.0 + 1e-9) + 1e-15, "{index} {point} {axis}: {off}");
            }
        }
    }
}

#[test]
fn a_run_that_is_still_being_written_grows() {
    let place = tempfile::tempdir().expect("a folder");
    let (whole, folder) = (place.path().join("whole"), place.path().join("run"));
    record(&whole);
    fs::create_dir_all(folder.join("frames")).expect("a folder");
    let copy = |index: usize| {
        let name = format!("frames/frame-{index:06}.vtp");
        fs::copy(whole.join(&name), folder.join(&name)).expect("copied");
    };
    (0..3).for_each(copy);
    let served = shown(&folder);
    let mut page = served.page();
    page.wait("state", |state| state["frames"] == 3);
    (3..6).for_each(copy);
    page.wait("state", |state| state["frames"] == 6);
}

#[test]
fn what_cannot_be_shown_is_told_with_its_line_and_shown_when_it_is_mended() {
    let place = tempfile::tempdir().expect("a folder");
    let path = place.path().join("scene.ron");
    fs::write(&path, HAIRS.replace("segments: 20", "segments: 0")).expect("written");
    let served = shown(&path);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "broken");
    let problem = &about["problems"][0];
    assert_eq!((&problem["path"], &problem["line"]), (&"fibers[0].segments".into(), &4.into()));
    // Times of files are coarse on some disks.
    std::thread::sleep(Duration::from_millis(50));
    fs::write(&path, HAIRS).expect("written");
    page.wait("about", |about| about["kind"] == "live");
    let empty = tempfile::tempdir().expect("a folder");
    let mut page = shown(empty.path()).page();
    let about = page.wait("about", |about| about["kind"] == "broken");
    assert!(about["message"].as_str().is_some_and(|message| message.contains("nothing to draw")));
}

#[test]
fn a_run_of_another_version_is_shown_as_far_as_it_is_understood_and_told_if_not() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    record(&folder);
    // Its scene is one that will be: frames are what they were.
    fs::write(folder.join("scene.ron"), "(format: 99, fibres: quantum)").expect("written");
    let served = shown(&folder);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "recorded");
    assert_eq!(about["frames"], 11);
    // Its frames are of another kind.
    for file in fs::read_dir(folder.join("frames")).expect("frames").flatten() {
        fs::write(file.path(), "<VTKFile type=\"Quantum\" version=\"9.9\"/>").expect("written");
    }
    let served = shown(&folder);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "broken");
    assert!(about["message"].as_str().is_some_and(|text| text.contains("frame-000000")), "{about}");
}

/// Places of the first point of each strand of the last frame along x, m.
fn roots(page: &Client, strands: usize) -> Vec<f64> {
    let each = page.points() / strands;
    (0..strands).map(|strand| page.position(strand * each).0[0]).collect()
}

#[test]
fn objects_of_two_runs_lie_beside_each_other() {
    let place = tempfile::tempdir().expect("a folder");
    let [first, second] = ["first", "second"].map(|name| place.path().join(name));
    for folder in [&first, &second] {
        record_of(BALL, folder);
    }
    let options = Options {
        what: Some(first),
        beside: Some(second),
        ..Options::local(place.path().to_owned())
    };
    let served = Served::new(options);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "recorded");
    page.wait_frame(|page| page.points() == 6 * 21);
    let apart = page.object(1)[0] - page.object(0)[0];
    // Balls of a radius of 2 cm, and the hair of the second is not in the ball of the first.
    assert!(apart > 0.06, "{apart}");
}

#[test]
fn two_runs_are_shown_beside_and_over_each_other_at_the_same_time() {
    let place = tempfile::tempdir().expect("a folder");
    let (first, second) = (place.path().join("first"), place.path().join("second"));
    record(&first);
    // Half as many frames, of as many hairs.
    record_of(&HAIRS.replace("frame_rate: 100.0", "frame_rate: 50.0"), &second);
    let options = Options {
        what: Some(first.clone()),
        beside: Some(second),
        ..Options::local(place.path().to_owned())
    };
    let served = Served::new(options);
    let mut page = served.page();
    let about = page.wait("about", |about| about["kind"] == "recorded");
    assert_eq!((&about["frames"], &about["two"]), (&11.into(), &true.into()));
    page.wait_frame(|page| page.points() == 6 * 21);
    let beside = roots(&page, 6);
    let gap = beside[3] - beside[0];
    // Hairs that hang have a width of a centimeter, and are moved by a part of their length.
    assert!(gap > 0.01, "{beside:?}");
    assert!((0..3).all(|k| (beside[3 + k] - beside[k] - gap).abs() < 1e-5), "{beside:?}");
    page.order(r#"{"do":"over","over":true}"#);
    page.wait("state", |state| state["over"] == true);
    page.wait_frame(|page| (roots(page, 6)[3] - beside[0]).abs() < 1e-5);
    // The second is at the last of its frames that is not after that of the first.
    for (index, time) in [(7, 0.06), (10, 0.1), (1, 0.0), (4, 0.04)] {
        page.order(&format!(r#"{{"do":"seek","frame":{index}}}"#));
        let state = page.wait("state", |state| state["frame"] == index);
        let of_second = state["second"].as_f64().expect("a time");
        assert!((of_second - time).abs() < 1e-9, "{index}: {of_second}");
    }
    // The second has a color of its own.
    let strand = |index: usize| {
        let at = 32 + 4 * 6 + 4 * index;
        &page.layout[at..at + 3]
    };
    assert!(strand(0) == strand(2) && strand(3) == strand(5) && strand(0) != strand(3));
}

#[test]
fn contacts_of_a_run_are_shown_at_its_nodes() {
    let place = tempfile::tempdir().expect("a folder");
    let folder = place.path().join("run");
    record_of(&bump(), &folder);
    let served = shown(&folder);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "recorded");
    page.order(r#"{"do":"seek","frame":5}"#);
    page.order(r#"{"do":"show","contacts":true,"volumes":0,"field":true}"#);
    page.wait_frame(|page| !page.extras()[0].is_empty());
    let [pushes, boxes, lines] = page.extras();
    assert_eq!((boxes.len(), lines.len()), (60, 0));
    assert!(pushes.iter().all(|push| push[3..].iter().any(|x| *x != 0.0)), "{pushes:?}");
    // Colored by the forces of contacts, none is below zero and one is above.
    page.order(r#"{"do":"color","by":"contact"}"#);
    page.wait("state", |state| state["colored"] == true);
    page.wait_frame(|page| {
        let number = |at: usize| f64::from_le_bytes(page.frame[at..at + 8].try_into().expect("8"));
        number(56) == 0.0 && number(64) > 0.0
    });
}

#[test]
fn a_file_of_strands_is_a_still() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../strands/tests/data");
    for name in ["groom.usda", "blender.usda"] {
        let served = shown(&data.join(name));
        let mut page = served.page();
        let about = page.wait("about", |about| about["kind"] != "building");
        assert_eq!((&about["kind"], &about["frames"]), (&"recorded".into(), &1.into()), "{about}");
        page.wait_frame(|page| page.points() > 0);
        let expected = Shown::open(&data.join(name), &|_| ()).expect("strands");
        let expected = expected.frame(0).expect("a frame").frame;
        assert_eq!(page.points(), expected.points(), "{name}");
        let points = expected.strands.iter().flat_map(|strand| &strand.points);
        for (point, place) in points.enumerate() {
            let (position, error) = page.position(point);
            for axis in 0..3 {
                let off = (position[axis] - place[axis]).abs();
                assert!(off <= error * (1.0 + 1e-9) + 1e-15, "{name} {point} {axis}: {off}");
            }
        }
    }
    let place = tempfile::tempdir().expect("a folder");
    let path = place.path().join("broken.hair");
    fs::write(&path, b"HAIR and nothing else").expect("written");
    let served = shown(&path);
    let about = served.page().wait("about", |about| about["kind"] != "building");
    assert_eq!(about["kind"], "broken");
}

/// A style of few hairs.
const STYLE: &str = "(
    hair: Volume((crown: 0.028, sides: 0.032, hem: -0.33, opening: 62.0)),
    hairs: 60, length: Constant(0.2), tilt: Constant(65.0), guides: 60, seed: 1,
)";

#[test]
fn a_style_grows_before_the_eyes_and_is_a_still() {
    let place = tempfile::tempdir().expect("a folder");
    let path = place.path().join("style.ron");
    fs::write(&path, STYLE).expect("written");
    let served = shown(&path);
    let mut page = served.page();
    let mut parts = Vec::new();
    let about = page.wait("about", |about| {
        about["kind"] != "building"
            || about["part"]
                .as_str()
                .is_some_and(|part| part == "surfaces" || part == "guides" || part == "hairs")
    });
    parts.push(about["part"].clone());
    let about = if about["kind"] == "building" {
        page.wait("about", |about| about["kind"] != "building")
    } else {
        about
    };
    assert_eq!(about["kind"], "recorded", "{about}");
    // A page that was there in time has seen what grew.
    assert!(parts.iter().any(Value::is_string), "{parts:?}");
    page.wait_frame(|page| page.points() > 60);
    // The head is there too.
    let objects = u32::from_le_bytes(page.layout[28..32].try_into().expect("four bytes"));
    assert_eq!(objects, 1);
}
