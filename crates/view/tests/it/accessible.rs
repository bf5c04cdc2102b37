use crate::browser::Browser;
use crate::page::{gallery, open};
use serde_json::{Value, json};

/// What is wrong with names, roles and contrast of what is shown on the page: a part of what a
/// checker of accessibility looks at, which must be without findings.
const FAULTS: &str = "(() => {
    const shown = [...document.querySelectorAll('*')].filter((one) => {
        const box = one.getBoundingClientRect();
        return box.width > 0 && box.height > 0 && getComputedStyle(one).visibility !== 'hidden';
    });
    const faults = [];
    const told = (what, one) => faults.push(`${what}: ${one.outerHTML.slice(0, 120)}`);
    const name = (one) => one.getAttribute('aria-label') || one.textContent.trim() || one.alt
        || (one.labels?.[0]?.textContent ?? '').trim();
    const ids = [...document.querySelectorAll('[id]')].map((one) => one.id);
    ids.filter((id, k) => ids.indexOf(id) !== k).forEach((id) => faults.push(`twice: ${id}`));
    for (const one of document.querySelectorAll('[aria-controls], [aria-labelledby]')) {
        const of = one.getAttribute('aria-controls') ?? one.getAttribute('aria-labelledby');
        if (!document.getElementById(of)) told('points to nothing', one);
    }
    if (!document.documentElement.lang) faults.push('no language');
    if (!document.title) faults.push('no title');
    if (document.querySelectorAll('h1').length !== 1) faults.push('not one heading');
    for (const one of shown) {
        if (one.matches('button, select, input, [role=img], [role=radio]') && !name(one)) told('no name', one);
        if (one.matches('canvas') && !one.getAttribute('role')) told('no role', one);
        if (one.matches('img') && !one.hasAttribute('alt')) told('no text', one);
        if (one.matches('[role=radio]') && !one.closest('[role=radiogroup]')) told('alone', one);
        if (one.matches('[role=radio]') && !one.hasAttribute('aria-checked')) told('no state', one);
        if (Number(one.getAttribute('tabindex') ?? 0) > 0) told('order of focus', one);
    }
    // Contrast of texts with what is behind them: 4.5 to 1, or 3 to 1 of what is large.
    const numbers = (text) => (text.match(/[\\d.]+/g) ?? []).map(Number);
    const behind = (one) => {
        for (let at = one; at; at = at.parentElement) {
            const [r, g, b, a = 1] = numbers(getComputedStyle(at).backgroundColor);
            if (a > 0.8) return [r, g, b];
        }
        return [255, 255, 255];
    };
    const light = (rgb) => {
        const [r, g, b] = rgb.map((x) => x / 255).map((x) => (x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    for (const one of shown) {
        const own = [...one.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
        if (!own || one.closest('svg, :disabled')) continue;
        const style = getComputedStyle(one);
        const [a, b] = [light(numbers(style.color).slice(0, 3)), light(behind(one))].sort((x, y) => y - x);
        const large = parseFloat(style.fontSize) >= 24;
        if ((a + 0.05) / (b + 0.05) < (large ? 3 : 4.5)) told(`contrast ${((a + 0.05) / (b + 0.05)).toFixed(2)}`, one);
    }
    return faults;
})()";

#[test]
fn names_roles_and_contrast_are_without_faults() {
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    assert_eq!(browser.value(FAULTS), json!([]), "the gallery");
    open(&mut browser, "contact/lock-on-ball");
    browser.wait("rapunzel.state.steps === 0");
    for theme in ["light", "dark"] {
        browser.value(&format!("document.documentElement.dataset.theme = '{theme}'"));
        // Colors of buttons change slowly.
        browser.wait("document.getAnimations().length === 0");
        assert_eq!(browser.value(FAULTS), json!([]), "{theme}");
    }
    browser.value("document.getElementById('language').click()");
    assert_eq!(browser.value(FAULTS), json!([]), "in German");
    // Everything that can be pressed is reached by the keyboard, in the order in which it is shown.
    browser.value("document.body.focus()");
    let reached = browser.value(
        "(() => { const all = [...document.querySelectorAll('button, select, input, canvas, summary')];
            const shown = all.filter((one) => one.offsetParent && !one.disabled && !one.closest('dialog'));
            return shown.filter((one) => { one.focus(); return document.activeElement !== one; })
                .map((one) => one.outerHTML); })()",
    );
    let canvases = reached.as_array().expect("a list");
    // Plots are pictures, which are read but not pressed.
    assert!(
        canvases.iter().all(|html| html.as_str().is_some_and(|h| h.contains("role=\"img\""))),
        "{reached}"
    );
}

/// What can have the focus, as the browser tells readers of screens: role and name.
fn focusable(browser: &mut Browser) -> Vec<(String, String)> {
    let nodes = browser.accessible();
    let nodes = nodes.as_array().expect("nodes").iter();
    let has = |node: &&Value| {
        let properties = node["properties"].as_array();
        node["ignored"] == false
            && properties.is_some_and(|all| {
                all.iter().any(|one| one["name"] == "focusable" && one["value"]["value"] == true)
            })
    };
    let text = |value: &Value| value["value"].as_str().unwrap_or_default().trim().to_owned();
    nodes.filter(has).map(|node| (text(&node["role"]), text(&node["name"]))).collect()
}

#[test]
fn readers_of_screens_are_told_a_role_and_a_name_of_all_that_can_have_the_focus() {
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    for (name, least) in [("", 20), ("contact/lock-on-ball", 25), ("mass-spring/ring", 25)] {
        if !name.is_empty() {
            open(&mut browser, name);
        }
        let found = focusable(&mut browser);
        assert!(found.len() > least, "{name}: {found:?}");
        for (role, own) in &found {
            let known = [
                "button",
                "link",
                "slider",
                "spinbutton",
                "combobox",
                "checkbox",
                "radio",
                "image",
                "DisclosureTriangle",
                "RootWebArea",
                "listbox",
                "MenuListPopup",
                "option",
            ];
            assert!(known.contains(&role.as_str()), "{name}: {role} {own}");
            assert!(!own.is_empty(), "{name}: a {role} has no name");
        }
        if !name.is_empty() {
            browser.value("document.getElementById('to-gallery').click()");
            browser.wait("rapunzel.about.kind === 'gallery'");
        }
    }
    // What comes by itself is read out, and what counts on is not.
    let live = browser.value(
        "[...document.querySelectorAll('[role=status], [role=alert], [aria-live]')].map((one) => one.id)",
    );
    assert_eq!(live, json!(["status", "tracing", "message"]));
    assert_eq!(browser.errors, Vec::<String>::new());
}

/// Where the focus is: part of the page, and edges of the element, pixels.
const FOCUS: &str = "(() => {
    const one = document.activeElement;
    if (!one || one === document.body) return null;
    const box = one.getBoundingClientRect();
    const scrolled = one.closest('aside')?.scrollTop ?? 0;
    const part = ['HEADER', 'SECTION', 'ASIDE', 'FOOTER'].indexOf(one.closest('header, section, aside, footer')?.tagName);
    const style = getComputedStyle(one);
    const ring = one.matches(':focus-visible') && style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2;
    return { html: one.outerHTML.slice(0, 90), part, ring,
        left: box.left, right: box.right, top: box.top + scrolled, bottom: box.bottom + scrolled };
})()";

#[test]
fn the_focus_goes_through_the_page_as_it_is_read_and_is_seen() {
    let Some(mut browser) = Browser::start(1000, 900) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    open(&mut browser, "mass-spring/rope");
    let mut stops: Vec<Value> = Vec::new();
    for _ in 0..60 {
        browser.key("Tab");
        let stop = browser.value(FOCUS);
        if stop.is_null() {
            break;
        }
        stops.push(stop);
    }
    assert!(stops.len() > 20, "{stops:?}");
    assert!(stops.iter().all(|stop| stop["ring"] == true), "{stops:?}");
    let edge = |stop: &Value, name: &str| stop[name].as_f64().expect("pixels");
    for pair in stops.windows(2) {
        let [one, next] = [&pair[0], &pair[1]];
        let parts = [one, next].map(|stop| stop["part"].as_i64().expect("a part"));
        assert!(parts[0] >= 0 && parts[0] <= parts[1], "{one} {next}");
        // In a part, to the right in a row, or on to what is below.
        let right = edge(next, "left") >= edge(one, "right") - 2.0;
        let below = edge(next, "top") >= edge(one, "bottom") - 2.0;
        let within = edge(next, "top") >= edge(one, "top") && edge(one, "right") > 900.0;
        assert!(parts[0] < parts[1] || right || below || within, "{one} {next}");
    }
}

#[test]
fn the_page_heeds_what_a_person_asks_of_all_pages() {
    let Some(mut browser) = Browser::start(360, 640) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.prefer(&[("prefers-color-scheme", "dark"), ("prefers-reduced-motion", "reduce")]);
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    assert_eq!(browser.value("document.documentElement.dataset.theme"), "dark");
    let moves = "[...document.querySelectorAll('*')].filter((one) => {
        const style = getComputedStyle(one);
        return style.animationName !== 'none' || parseFloat(style.transitionDuration) > 0;
    }).length";
    assert_eq!(browser.value(moves), 0);
    browser
        .prefer(&[("prefers-color-scheme", "light"), ("prefers-reduced-motion", "no-preference")]);
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    assert_eq!(browser.value("document.documentElement.dataset.theme"), "light");
    // At 360 pixels every target is large enough for a finger: 24 pixels, its label included.
    open(&mut browser, "mass-spring/ring");
    browser.value("document.getElementById('panel-toggle').click()");
    let small = browser.value(
        "[...document.querySelectorAll('button, select, input, summary')].filter((one) => {
            if (!one.offsetParent || one.closest('dialog')) return false;
            const box = (one.matches('[type=checkbox]') ? one.closest('label') : one).getBoundingClientRect();
            return Math.min(box.width, box.height) < 24;
        }).map((one) => one.outerHTML)",
    );
    assert_eq!(small, json!([]));
}
