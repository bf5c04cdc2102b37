//! Times of the page, which are printed and not judged:
//! `cargo test --release -p rapunzel-view measured -- --ignored --nocapture --test-threads 1`.

#![expect(clippy::print_stdout, reason = "that is what it is for")]

use crate::browser::Browser;
use crate::common::{ROPE, Served};
use crate::page::{gallery, open};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A thousand curls of 48 points.
const THOUSAND: &str = "(
    format: 1, name: \"A thousand\", duration: 1.0, stepper: (dt: 1e-3),
    fibers: [(
        length: 0.25, segments: 47, section: Circle(radius: 4e-5), damping_time: 1e-3,
        shape: Helix(radius: 0.005, pitch: 0.03),
        arrangement: Ellipse(semi_axes: (0.012, 0.012), count: 1000),
    )],
)";
const SPAN: Duration = Duration::from_secs(5);

#[test]
#[ignore = "prints times"]
fn measured_frames_of_a_thousand_fibers() {
    frames("1000 x 48", THOUSAND);
}

#[test]
#[ignore = "prints times"]
fn measured_frames_of_ten_thousand_fibers() {
    let many = THOUSAND.replace("count: 1000", "count: 10000").replace("47", "99");
    frames("10,000 x 100", &many.replace("0.012, 0.012", "0.04, 0.04"));
}

/// Prints how many frames are drawn a second, standing still and running.
fn frames(name: &str, text: &str) {
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), text);
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'live' && rapunzel.isFit");
    // All that can be drawn, from a camera that turns.
    let drawn = browser.value(
        "new Promise((done) => { const [begin, first] = [performance.now(), rapunzel.drawn];
            const turn = () => { rapunzel.camera.turn(1, 0); rapunzel.stale = true;
                if (performance.now() - begin < 5000) requestAnimationFrame(turn);
                else done((1000 * (rapunzel.drawn - first)) / (performance.now() - begin)); };
            turn(); })",
    );
    println!("{name}: {drawn} frames drawn a second, standing still");
    browser.value("document.getElementById('run').click()");
    browser.wait("rapunzel.state.steps > 3");
    let before = [browser.value("rapunzel.drawn"), browser.value("rapunzel.state.steps")];
    sleep(SPAN);
    let after = [browser.value("rapunzel.drawn"), browser.value("rapunzel.state.steps")];
    let rate = |k: usize| {
        (after[k].as_f64().expect("a number") - before[k].as_f64().expect("a number")) / 5.0
    };
    println!("{name}: {} frames and {} steps a second, running", rate(0), rate(1));
    assert!(rate(0) > 0.0);
}

#[test]
#[ignore = "prints times"]
fn measured_cost_of_a_page() {
    for text in [ROPE.to_owned(), THOUSAND.replace("count: 1000", "count: 181")] {
        let folder = tempfile::tempdir().expect("a folder");
        let served = Served::scene(folder.path(), &text);
        let mut page = served.page();
        page.wait("about", |about| about["kind"] == "live");
        page.order(r#"{"do":"speed","value":100.0}"#);
        page.order(r#"{"do":"run"}"#);
        page.wait("state", |state| state["steps"].as_u64() > Some(10));
        let mut rates = [Vec::new(), Vec::new()];
        for round in 0..6 {
            let with = round % 2;
            let mut page = served.page();
            let steps = |page: &mut crate::common::Client| {
                page.wait("state", |state| state["steps"].is_u64())["steps"]
                    .as_f64()
                    .expect("steps")
            };
            let (before, begin) = (steps(&mut page), Instant::now());
            if with == 1 {
                while begin.elapsed() < SPAN {
                    page.text();
                }
            } else {
                drop(page);
                sleep(SPAN);
                page = served.page();
            }
            let took = begin.elapsed().as_secs_f64();
            rates[with].push((steps(&mut page) - before) / took);
        }
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        println!(
            "steps a second without a page {:.1?}, with one {:.1?}: {:.1} %",
            rates[0],
            rates[1],
            100.0 * (mean(&rates[1]) / mean(&rates[0]) - 1.0)
        );
        assert!(mean(&rates[0]) > 0.0 && mean(&rates[1]) > 0.0);
    }
}

#[test]
#[ignore = "prints times"]
fn measured_way_from_the_mouse_to_the_picture() {
    let Some(mut browser) = Browser::start(1000, 640) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let begin = Instant::now();
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    println!("the gallery is there {:.0?} after the command", begin.elapsed());
    let begin = Instant::now();
    open(&mut browser, "mass-spring/rope");
    println!("the first picture of the rope is there {:.0?} after the click", begin.elapsed());
    from_the_mouse(&mut browser, 0);
    browser.value("document.getElementById('to-gallery').click()");
    browser.wait("rapunzel.about.kind === 'gallery'");
    open(&mut browser, "mass-spring/cloth-on-a-line");
    from_the_mouse(&mut browser, 100);
}

/// Prints how long it takes until a node that is pulled is drawn 2 mm away.
fn from_the_mouse(browser: &mut Browser, node: usize) {
    browser.value("document.getElementById('run').click()");
    let mut times = Vec::new();
    for round in 0..12 {
        let (x, y) = crate::page::pixels(browser, node);
        browser.mouse("mousePressed", x, y);
        browser.wait("rapunzel.state.holds");
        browser.value(&format!(
            "window.seen = new Promise((done) => {{
                const at = () => rapunzel.painter.place({node})[0];
                document.getElementById('picture').addEventListener('pointermove', () => {{
                    const [begin, from] = [performance.now(), at()];
                    const look = () => (Math.abs(at() - from) > 0.002 && !rapunzel.stale
                        ? done(performance.now() - begin) : requestAnimationFrame(look));
                    look();
                }}, {{ once: true }}); }}); 0"
        ));
        browser.mouse("mouseMoved", x + if round % 2 == 0 { 100.0 } else { -100.0 }, y);
        times.push(browser.value("window.seen").as_f64().expect("ms"));
        browser.mouse("mouseReleased", x, y);
        browser.wait("!rapunzel.state.holds");
    }
    times.sort_by(f64::total_cmp);
    println!("node {node}, from the mouse to the picture, ms: {times:.0?}");
    assert_eq!(times.len(), 12);
}
