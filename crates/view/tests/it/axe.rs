//! The page before axe-core, a checker of accessibility that is not part of the repository:
//! `RAPUNZEL_AXE` names its file `axe.min.js`.

use crate::browser::Browser;
use crate::common::{BALL, Served};
use crate::page::{gallery, open};
use crate::recorded::record_of;
use rapunzel_view::Options;
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;
use std::{env, fs};

/// What axe-core finds wrong, however little.
const FINDINGS: &str = "axe.run(document, { resultTypes: ['violations'] }).then((result) =>
    result.violations.map((one) => `${one.impact} ${one.id}: ${one.nodes[0].html.slice(0, 200)}`))";

/// Looks at what is shown in both themes and languages, wide and narrow, with and without help.
fn look(browser: &mut Browser, axe: &str, what: &str) {
    browser.value(&format!("{axe}; 0"));
    for width in [1000, 360] {
        browser.resize(width, 700);
        for (theme, language) in [("light", "en"), ("dark", "de"), ("light", "de"), ("dark", "en")]
        {
            browser.value(&format!(
                "(() => {{ const root = document.documentElement;
                    if (root.dataset.theme !== '{theme}') document.getElementById('theme').click();
                    if (root.lang !== '{language}') document.getElementById('language').click(); }})()"
            ));
            browser.wait("document.getAnimations().length === 0");
            let found = browser.value(FINDINGS);
            assert_eq!(found, json!([]), "{what}, {width}, {theme}, {language}");
        }
        browser.value("document.getElementById('help').click()");
        browser.wait("document.getElementById('sheet').open");
        let found = browser.value(FINDINGS);
        assert_eq!(found, json!([]), "{what}, {width}, the sheet");
        browser.value("document.getElementById('close-sheet').click()");
    }
    browser.resize(1000, 700);
}

#[test]
fn axe_finds_nothing_on_any_page() {
    let Some(path) = env::var_os("RAPUNZEL_AXE").map(PathBuf::from) else {
        let message = b"SKIPPED: RAPUNZEL_AXE names no axe.min.js\n";
        // Not by `eprint`, which the frame of tests keeps to itself.
        let _ = std::io::stderr().write_all(message);
        return;
    };
    let axe = fs::read_to_string(path).expect("axe.min.js");
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    look(&mut browser, &axe, "the gallery");
    for name in ["mass-spring/ring", "contact/lock-on-ball"] {
        open(&mut browser, name);
        look(&mut browser, &axe, name);
        browser.value("document.getElementById('to-gallery').click()");
        browser.wait("rapunzel.about.kind === 'gallery'");
    }
    let run = folder.path().join("run");
    record_of(BALL, &run);
    let broken = folder.path().join("broken.ron");
    fs::write(&broken, BALL.replace("friction", "frictoin")).expect("written");
    let style = folder.path().join("strands.obj");
    fs::write(&style, "v 0 0 0\nv 0 0 0.1\nv 0.01 0 0.2\nl 1 2 3\n").expect("written");
    for (what, kind) in [(run, "recorded"), (broken, "broken"), (style, "recorded")] {
        let told = what.display().to_string();
        let options = Options { what: Some(what), ..Options::local(folder.path().to_owned()) };
        let served = Served::new(options);
        browser.open(&served.url);
        browser.wait(&format!("rapunzel.about.kind === '{kind}'"));
        look(&mut browser, &axe, &told);
    }
}
