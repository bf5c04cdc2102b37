use crate::common::{Client, HAIRS, PATIENCE, Served};
use std::time::Instant;

fn wish(number: u32, size: [u32; 2], samples: u32) -> String {
    format!(
        r#"{{"do":"picture","number":{number},"eye":[0.1,-0.3,-0.03],"target":[0.0,0.0,-0.05],
            "field":0.6,"thickness":1.0,"plain":false,"size":[{},{}],"samples":{samples}}}"#,
        size[0], size[1]
    )
}

/// Number, samples so far and in the end of a picture, and its width and height.
fn told(picture: &[u8]) -> [u32; 5] {
    let little = |at: usize| u32::from_le_bytes(picture[at..at + 4].try_into().expect("four"));
    assert_eq!(&picture[16..24], b"\x89PNG\r\n\x1a\n");
    let big = |at: usize| u32::from_be_bytes(picture[at..at + 4].try_into().expect("four"));
    [little(4), little(8), little(12), big(32), big(36)]
}

/// Waits for a picture with so many samples.
fn finished(page: &mut Client, number: u32, samples: u32) {
    let begin = Instant::now();
    loop {
        let is = |picture: &Vec<u8>| told(picture)[..2] == [number, samples];
        if page.pictures.iter().any(is) {
            return;
        }
        assert!(begin.elapsed() < PATIENCE, "{:?}", page.pictures.last().map(|p| told(p)));
        page.order(r#"{"do":"fit_colors"}"#);
        page.text().expect("the connection holds");
    }
}

#[test]
fn a_picture_comes_in_pass_by_pass_while_the_scene_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), HAIRS);
    let mut page = served.page();
    let mut other = served.page();
    page.wait("about", |about| about["kind"] == "live");
    page.order(r#"{"do":"run"}"#);
    page.order(&wish(3, [60, 40], 16));
    finished(&mut page, 3, 16);
    let passes: Vec<_> = page.pictures.iter().map(|picture| told(picture)).collect();
    // Of passes that follow each other fast a page may get the last only.
    assert!(passes.windows(2).all(|pair| pair[0][1] < pair[1][1]), "{passes:?}");
    assert!(passes.iter().all(|pass| pass[0] == 3 && pass[2..] == [16, 60, 40]), "{passes:?}");
    let state = page.wait("state", |state| state["steps"].as_u64() > Some(5));
    assert_eq!((&state["runs"], &state["failure"]), (&true.into(), &serde_json::Value::Null));
    // Only the page that asked gets it, and pages without the controls may ask too.
    other.order(&wish(1, [20, 20], 1));
    finished(&mut other, 1, 1);
    assert_eq!(other.pictures.len(), 1);
    // Another takes the place of the one before, and none comes after the end.
    page.pictures.clear();
    page.order(&wish(4, [1000, 1000], 1024));
    page.order(&wish(5, [10, 10], 2));
    finished(&mut page, 5, 2);
    page.order(&wish(6, [1500, 1500], 1024));
    page.order(r#"{"do":"end_picture"}"#);
    page.order(&wish(7, [10, 10], 1));
    finished(&mut page, 7, 1);
    assert!(page.pictures.iter().all(|picture| told(picture)[1] < 1024));
}

#[test]
fn what_cannot_be_drawn_is_told_and_sizes_are_bounded() {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), HAIRS);
    let mut page = served.page();
    page.wait("about", |about| about["kind"] == "live");
    let nowhere = wish(1, [10, 10], 1).replace("[0.0,0.0,-0.05]", "[0.1,-0.3,-0.03]");
    page.order(&nowhere);
    let note = page.wait("complaint", |_| true);
    assert!(note["message"].as_str().is_some_and(|m| m.contains("no picture")), "{note}");
    page.order(&wish(2, [10, 10], 1).replace("0.6", "4.0"));
    page.wait("complaint", |_| true);
    page.order(&wish(3, [0, 4_000_000_000], 1));
    finished(&mut page, 3, 1);
    let picture = page.pictures.last().expect("a picture");
    assert_eq!(told(picture)[3..], [1, 2048]);
}
