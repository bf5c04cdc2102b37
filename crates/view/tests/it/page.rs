use crate::browser::Browser;
use crate::common::Served;
use rapunzel_view::{GalleryScene, Options};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Number of lit pixels and of colors of the picture, drawn anew with a fixed camera, and with
/// every point: a machine that is busy draws fewer in a hurry.
const LIT: &str = "new Promise((done) => {
    const page = window.rapunzel;
    Object.assign(page.camera, { azimuth: 0.35, elevation: 0.15 });
    page.stale = true;
    requestAnimationFrame(() => requestAnimationFrame(() => {
        const canvas = document.getElementById('picture');
        Object.assign(page.hurry, { cost: 0, drew: false, isOn: true, last: -1e9 });
        page.stale = true;
        requestAnimationFrame(() => {
            const gl = page.painter.gl;
            const pixels = new Uint8Array(4 * canvas.width * canvas.height);
            gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
            const words = new Uint32Array(pixels.buffer);
            const colors = new Map();
            for (const word of words) colors.set(word, (colors.get(word) ?? 0) + 1);
            const most = Math.max(...colors.values());
            done([words.length - most, colors.size]);
        });
    }));
})";

/// Draws `name` and looks at its pixels.
pub(crate) fn lit(browser: &mut Browser) -> (u64, u64) {
    let counts = browser.value(LIT);
    (counts[0].as_u64().expect("pixels"), counts[1].as_u64().expect("colors"))
}

/// All scenes, cases and styles that ship beside the crate.
pub(crate) fn shipped() -> Vec<GalleryScene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scenes = Vec::new();
    for kind in ["mass-spring", "contact", "charge", "joined", "static", "style", ""] {
        let mut files: Vec<_> = fs::read_dir(root.join(kind))
            .expect("scenes ship")
            .flatten()
            .map(|file| file.path())
            .filter(|path| path.extension().is_some_and(|ending| ending == "ron"))
            .collect();
        files.sort();
        for path in files {
            let text = fs::read_to_string(&path).expect("a scene");
            let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let name = if kind.is_empty() { stem } else { format!("{kind}/{stem}") };
            // What it names lies beside it.
            let beside = |name: &str| fs::read_to_string(path.with_file_name(name)).ok();
            let files = ["head.obj"].into_iter().filter(|name| text.contains(name));
            let files = files.filter_map(|name| Some((name.to_owned(), beside(name)?))).collect();
            scenes.push(GalleryScene { name, text, files });
        }
    }
    scenes
}

pub(crate) fn gallery(folder: &Path) -> Served {
    Served::new(Options { gallery: shipped(), ..Options::local(folder.to_owned()) })
}

pub(crate) fn open(browser: &mut Browser, name: &str) {
    browser.value(&format!("document.querySelector('[data-name=\"{name}\"]').click()"));
    browser.wait("rapunzel.about.kind === 'live' && rapunzel.painter.frame && rapunzel.isFit");
    browser.wait("rapunzel.state.steps !== undefined");
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn scenes_of_the_gallery_open_and_draw() {
    let Some(mut browser) = Browser::start(1100, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    browser.wait("document.querySelectorAll('#gallery .card').length > 20");
    browser.wait("document.querySelector('#gallery img').complete");
    browser.picture("gallery");
    for name in [
        "mass-spring/rope",
        "mass-spring/flag",
        "mass-spring/cube",
        "mass-spring/ring",
        "mass-spring/ball",
        "contact/lock-on-ball",
        "lock-under-gravity",
        "straight-rod-with-torque",
    ] {
        open(&mut browser, name);
        let (pixels, colors) = lit(&mut browser);
        assert!(pixels > 500 && colors > 20, "{name}: {pixels} pixels, {colors} colors");
        browser.value("document.getElementById('run').click()");
        browser.wait("rapunzel.state.runs && rapunzel.state.steps > 5");
        if name == "lock-under-gravity" {
            // The picture of the README: the whole one, which comes when nothing moves.
            browser.wait("rapunzel.state.steps > 60");
            browser.value("document.getElementById('run').click()");
            browser.wait("!rapunzel.state.runs && !rapunzel.hurry.isOn");
            browser.picture("live-page");
        }
        browser.picture(&name.replace('/', "-"));
        browser.value("document.getElementById('to-gallery').click()");
        browser.wait("rapunzel.about.kind === 'gallery'");
    }
    assert_eq!(browser.errors, Vec::<String>::new());
}

/// Pixels of a point of the picture.
pub(crate) fn pixels(browser: &mut Browser, point: usize) -> (f64, f64) {
    let at = browser.value(&format!(
        "(() => {{ const c = document.getElementById('picture');
            const box = c.getBoundingClientRect();
            const [x, y] = rapunzel.camera.project(
                rapunzel.painter.place({point}), c.clientWidth, c.clientHeight);
            return [x + box.left, y + box.top]; }})()"
    ));
    (number(&at[0]), number(&at[1]))
}

fn place(browser: &mut Browser, point: usize) -> [f64; 3] {
    let place = browser.value(&format!("rapunzel.painter.place({point})"));
    [0, 1, 2].map(|axis| number(&place[axis]))
}

#[test]
fn a_node_follows_the_mouse_and_a_finger_and_lets_go() {
    let Some(mut browser) = Browser::start(1000, 640) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    open(&mut browser, "mass-spring/rope");
    for by_touch in [false, true] {
        let before = place(&mut browser, 20);
        let (x, y) = pixels(&mut browser, 20);
        if by_touch {
            browser.touch("touchStart", &[(x, y)]);
        } else {
            browser.mouse("mousePressed", x, y);
        }
        // It is taken where it hangs, as a busy machine may see it elsewhere when it moves.
        browser.wait("rapunzel.state.holds");
        browser.value("document.getElementById('run').click()");
        browser.wait("rapunzel.state.runs");
        for part in 1..=10 {
            let to = (x + 12.0 * f64::from(part), y);
            if by_touch {
                browser.touch("touchMove", &[to]);
            } else {
                browser.mouse("mouseMoved", to.0, to.1);
            }
        }
        // The rope is pulled aside, by the spring of the hand and against its own.
        let aside = "rapunzel.painter.place(20)[0]";
        browser.wait(&format!("{aside} > {}", before[0] + 0.1));
        browser.picture(if by_touch { "touch" } else { "mouse" });
        if by_touch {
            browser.touch("touchEnd", &[]);
        } else {
            browser.mouse("mouseReleased", x + 120.0, y);
        }
        browser.wait("!rapunzel.state.holds");
        browser.value("document.getElementById('run').click()");
        browser.wait("!rapunzel.state.runs");
        browser.value("document.getElementById('restart').click()");
        browser.wait("rapunzel.state.steps === 0 && rapunzel.painter.frame?.number === 0");
    }
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn buttons_keys_and_sliders_do_what_they_say() {
    let Some(mut browser) = Browser::start(1000, 640) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    open(&mut browser, "mass-spring/thin-beam");
    browser.key(".");
    browser.wait("rapunzel.state.steps === 1");
    browser.value("document.getElementById('step').click()");
    browser.wait("rapunzel.state.steps === 2");
    browser.key(" ");
    browser.wait("rapunzel.state.runs && rapunzel.state.steps > 10");
    browser.key("-");
    browser.wait("rapunzel.state.speed === 0.5");
    browser.key(" ");
    browser.wait("!rapunzel.state.runs");
    browser.key("r");
    browser.wait("rapunzel.state.steps === 0");
    let slid = browser.value(
        "(() => { const knob = document.querySelector('[data-knob=gravity]');
            const range = knob.querySelector('[type=range]');
            range.value = 750;
            range.dispatchEvent(new Event('input'));
            return knob.querySelector('[type=number]').value; })()",
    );
    assert_eq!(slid, "10");
    browser.wait("rapunzel.state.values.gravity === 10");
    browser.key("c");
    browser.wait("rapunzel.state.colored && !document.getElementById('legend').hidden");
    browser.key("m");
    browser.wait("rapunzel.about.title !== 'mass-spring/thin-beam'");
    browser.wait("rapunzel.about.kind === 'live'");
    browser.key("?");
    browser.wait("document.getElementById('sheet').open");
    browser.picture("sheet");
    browser.value("document.getElementById('close-sheet').click()");
    browser.value("document.getElementById('save').click()");
    browser.wait("rapunzel.saved");
    let saved = browser.value("rapunzel.saved.file");
    assert!(fs::metadata(saved.as_str().expect("a path")).is_ok_and(|file| file.len() > 100));
    // In German, and in the other theme.
    let german = browser.value(
        "(() => { document.getElementById('language').click();
            document.getElementById('theme').click();
            return [document.documentElement.lang, document.getElementById('save').textContent];
        })()",
    );
    assert_eq!((german[0].as_str(), german[1].as_str()), (Some("de"), Some("Szene sichern")));
    browser.picture("german");
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn a_narrow_page_is_usable() {
    let Some(mut browser) = Browser::start(360, 640) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    browser.picture("narrow-gallery");
    open(&mut browser, "mass-spring/cloth-on-a-line");
    let (pixels, _) = lit(&mut browser);
    assert!(pixels > 500, "{pixels}");
    browser.picture("narrow");
    browser.value("document.getElementById('panel-toggle').click()");
    browser.picture("narrow-panel");
    // Nothing sticks out, and everything that can be pressed has a name and a size for fingers.
    let found = browser.value(
        "(() => { const all = [...document.querySelectorAll('button, select, input, canvas')];
            const shown = all.filter((one) => one.offsetParent && !one.closest('dialog'));
            const name = (one) => one.getAttribute('aria-label') || one.textContent.trim()
                || one.closest('label')?.textContent.trim();
            const box = (one) => one.getBoundingClientRect();
            const small = (one) => one.tagName === 'BUTTON' && !one.closest('#legend')
                && Math.min(box(one).width, box(one).height) < 30;
            return {
                unnamed: shown.filter((one) => !name(one)).map((one) => one.outerHTML),
                outside: shown.filter((one) => box(one).right > innerWidth + 1)
                    .map((one) => one.outerHTML),
                small: shown.filter(small).map((one) => one.outerHTML),
                wide: document.documentElement.scrollWidth > innerWidth,
            }; })()",
    );
    let nothing = serde_json::json!({ "unnamed": [], "outside": [], "small": [], "wide": false });
    assert_eq!(found, nothing);
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn frames_that_come_between_two_pictures_do_not_make_later_ones_wait() {
    let Some(mut browser) = Browser::start(900, 600) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    open(&mut browser, "mass-spring/rope");
    browser.value("document.getElementById('run').click()");
    browser.wait("rapunzel.state.steps > 5");
    // Pictures are drawn only when they are asked for, each after two frames.
    browser.value("window.requestAnimationFrame = (act) => { window.next = act; }");
    browser.wait("window.next");
    for _ in 0..5 {
        browser.wait("rapunzel.undrawn === 2");
        browser.value("window.next(performance.now())");
    }
    assert_eq!(browser.errors, Vec::<String>::new());
}
