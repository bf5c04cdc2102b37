use crate::common::{HAIRS, Served};
use rapunzel_sim::{Cancel, Control, Existing, RunFolder, Scene, Shown, World, run};
use rapunzel_view::Options;
use std::fs;
use std::path::Path;
use std::time::Duration;

fn record(folder: &Path) {
    let scene = Scene::from_ron(HAIRS).expect("a scene");
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
