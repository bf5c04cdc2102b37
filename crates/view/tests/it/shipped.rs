use crate::browser::Browser;
use crate::common::{BALL, HAIRS, Served, alone, bump};
use crate::page::{gallery, lit, open, shipped};
use rapunzel_view::Options;
use serde_json::json;

#[test]
fn every_scene_of_the_gallery_opens_and_draws() {
    let Some(mut browser) = Browser::start(900, 600) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'gallery'");
    let cards = browser.value("[...document.querySelectorAll('.card')].map((c) => c.dataset.name)");
    let cards: Vec<_> = cards.as_array().expect("names").iter().map(|name| name.as_str()).collect();
    // Whatever names no style is there.
    let alone = shipped()
        .into_iter()
        .filter(|scene| !scene.text.contains(".ron\""))
        .filter(|scene| !["static/", "style/"].iter().any(|kind| scene.name.starts_with(kind)));
    let alone: Vec<_> = alone.map(|scene| scene.name).collect();
    assert!(alone.len() > 20 && alone.iter().all(|name| cards.contains(&Some(name))), "{cards:?}");
    // All else is named, with why it is not there.
    let others = browser.value("document.querySelector('#gallery section dl').textContent");
    let others = others.as_str().expect("text").to_owned();
    for scene in shipped() {
        let is_told = cards.contains(&Some(&scene.name)) || others.contains(&scene.name);
        assert!(is_told, "{}", scene.name);
    }
    let mut signatures = Vec::new();
    for name in cards.into_iter().flatten() {
        let picture = served.get(&format!("/picture/{name}"));
        assert!(picture.starts_with("HTTP/1.1 200 OK\r\nContent-Type: image/png"), "{name}");
        open(&mut browser, name);
        let (pixels, colors) = lit(&mut browser);
        assert!(pixels > 100 && colors > 4, "{name}: {pixels} pixels, {colors} colors");
        signatures.push((pixels, colors));
        assert_eq!(browser.errors, Vec::<String>::new(), "{name}");
        browser.value("document.getElementById('to-gallery').click()");
        browser.wait("rapunzel.about.kind === 'gallery'");
    }
    // They are not all one picture.
    signatures.sort_unstable();
    signatures.dedup();
    assert!(signatures.len() > 20, "{signatures:?}");
}

#[test]
fn the_same_scene_is_drawn_alike_from_a_fixed_camera() {
    let Some(mut browser) = Browser::start(900, 600) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = gallery(folder.path());
    let mut seen = Vec::new();
    for _ in 0..2 {
        browser.open(&served.url);
        browser.wait("rapunzel.about.kind === 'gallery'");
        open(&mut browser, "lock-under-gravity");
        seen.push(lit(&mut browser));
        browser.value("document.getElementById('to-gallery').click()");
        browser.wait("rapunzel.about.kind === 'gallery'");
    }
    assert_eq!(seen[0], seen[1]);
}

#[test]
fn contacts_volumes_and_pictures_are_shown_and_a_ball_is_dragged() {
    let Some(mut browser) = Browser::start(1000, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), &bump());
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'live' && rapunzel.isFit");
    let (plain, _) = lit(&mut browser);
    browser.value(
        "(() => { document.getElementById('contacts').click();
            const volumes = document.getElementById('volumes');
            volumes.value = '1';
            volumes.dispatchEvent(new Event('change')); })()",
    );
    for _ in 0..40 {
        browser.key(".");
    }
    browser.wait("rapunzel.state.steps === 40");
    browser.wait(
        "rapunzel.painter.frame.pushes.length > 0 && rapunzel.painter.frame.boxes.length > 0",
    );
    browser.wait("!document.getElementById('force').hidden");
    let (shown, _) = lit(&mut browser);
    assert!(shown > plain + 100, "{plain} {shown}");
    browser.picture("contacts");
    // By the color of the forces of contacts, and by that of charge where there is any.
    let colors = browser.value("[...document.getElementById('color').options].map((o) => o.value)");
    assert!(colors.as_array().is_some_and(|all| all.contains(&json!("contact"))), "{colors}");
    browser.value(
        "(() => { const color = document.getElementById('color');
            color.value = 'contact';
            color.dispatchEvent(new Event('change')); })()",
    );
    browser.wait("rapunzel.state.colored && !document.getElementById('legend').hidden");
    // The ball is taken where it is seen, and follows the mouse.
    browser.key("h");
    let at = browser.value(
        "(() => { const c = document.getElementById('picture'), box = c.getBoundingClientRect();
            const [x, y] = rapunzel.camera.project([0.025, 0, -0.07], c.clientWidth, c.clientHeight);
            return [x + box.left, y + box.top]; })()",
    );
    let (x, y) = (at[0].as_f64().expect("x"), at[1].as_f64().expect("y"));
    let before = browser.value("rapunzel.painter.frame.poses[0]").as_f64().expect("m");
    browser.mouse("mousePressed", x, y);
    browser.wait("rapunzel.state.drags === 0");
    for part in 1..=10 {
        browser.mouse("mouseMoved", x + 8.0 * f64::from(part), y);
    }
    browser.value("document.getElementById('run').click()");
    browser.wait(&format!("rapunzel.painter.frame.poses[0] > {before} + 0.005"));
    browser.mouse("mouseReleased", x + 80.0, y);
    browser.wait("rapunzel.state.drags === null");
    browser.value("document.getElementById('run').click()");
    browser.wait("!rapunzel.state.runs");
    // A picture by paths of light comes in, and goes when the camera moves.
    browser.value("document.getElementById('trace').click()");
    browser.wait("rapunzel.traced.done >= 4 && !document.getElementById('traced').hidden");
    let size = browser.value(
        "document.getElementById('traced').decode().then(() =>
            [document.getElementById('traced').naturalWidth, document.getElementById('picture').clientWidth])",
    );
    assert_eq!(size[0], size[1]);
    browser.picture("traced");
    browser.key("1");
    browser.wait("document.getElementById('traced').hidden && !rapunzel.traced.isOn");
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn a_browser_without_webgl2_gets_pictures_from_the_program() {
    let Some(mut browser) = Browser::start_with(900, 600, &["--disable-gpu", "--disable-3d-apis"])
    else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), HAIRS);
    browser.open(&served.url);
    browser.wait("rapunzel.painter.isPlain && rapunzel.about.kind === 'live'");
    browser.wait("document.getElementById('message').textContent.includes('WebGL2')");
    browser.wait("rapunzel.traced.done > 0 && !document.getElementById('traced').hidden");
    // What is drawn is not empty: hair is dark before what is behind it.
    let lit = browser.value(
        "(async () => { const image = document.getElementById('traced');
            await image.decode();
            const canvas = document.createElement('canvas');
            [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
            const ink = canvas.getContext('2d');
            ink.drawImage(image, 0, 0);
            const data = ink.getImageData(0, 0, canvas.width, canvas.height).data;
            return new Set(new Uint32Array(data.buffer)).size; })()",
    );
    assert!(lit.as_u64() > Some(50), "{lit}");
    browser.picture("without-webgl2");
    // It follows what moves, and the camera.
    let number = browser.value("rapunzel.traced.number").as_u64().expect("a number");
    browser.key(".");
    browser.wait(&format!("rapunzel.state.steps === 1 && rapunzel.traced.number > {number}"));
    browser.wait("rapunzel.traced.done > 0");
    let number = browser.value("rapunzel.traced.number").as_u64().expect("a number");
    browser.key("1");
    browser.wait(&format!("rapunzel.traced.number > {number} && rapunzel.traced.done > 0"));
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn every_slider_of_the_page_changes_its_parameter() {
    let Some(mut browser) = Browser::start(900, 700) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let own = [alone("charged", crate::common::CHARGED), alone("ball", BALL)];
    let gallery = shipped().into_iter().chain(own).collect();
    let served = Served::new(Options { gallery, ..Options::local(folder.path().to_owned()) });
    browser.open(&served.url);
    let mut seen = Vec::new();
    for name in
        ["mass-spring/ring", "mass-spring/rope-in-wind", "mass-spring/cube", "ball", "charged"]
    {
        browser.wait("rapunzel.about.kind === 'gallery'");
        open(&mut browser, name);
        let knobs = browser
            .value("[...document.querySelectorAll('[data-knob]')].map((k) => k.dataset.knob)");
        for knob in knobs.as_array().expect("names").iter().filter_map(|knob| knob.as_str()) {
            // To a third of its way, where none of them begins.
            let set = browser.value(&format!(
                "(() => {{ const knob = document.querySelector('[data-knob=\"{knob}\"]');
                    const range = knob.querySelector('[type=range]');
                    range.value = 333;
                    range.dispatchEvent(new Event('input'));
                    return Number(knob.querySelector('[type=number]').value); }})()"
            ));
            let value = set.as_f64().expect("a number");
            // Some are whole numbers.
            browser.wait(&format!(
                "Math.abs(rapunzel.state.values['{knob}'] - {value}) <= Math.max(0.5 * ('{knob}' === 'substeps'), 1e-9 * Math.abs({value}))"
            ));
            seen.push(knob.to_owned());
        }
        browser.value("document.getElementById('to-gallery').click()");
    }
    seen.sort_unstable();
    seen.dedup();
    let wanted = [
        "area_control",
        "damping",
        "drag",
        "fiber_charge",
        "frequency",
        "friction",
        "gravity",
        "wind_x",
    ];
    assert!(wanted.iter().all(|knob| seen.iter().any(|own| own == knob)), "{seen:?}");
    assert_eq!(browser.errors, Vec::<String>::new());
}

#[test]
fn field_lines_and_two_runs_are_drawn() {
    let Some(mut browser) = Browser::start(900, 600) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::scene(folder.path(), crate::common::CHARGED);
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'live' && rapunzel.isFit");
    for _ in 0..4 {
        browser.key(".");
    }
    browser.wait("rapunzel.state.steps === 4");
    let (plain, _) = lit(&mut browser);
    browser.value("document.getElementById('field').click()");
    browser.wait("rapunzel.painter.frame.lines.counts.length > 5");
    let (shown, _) = lit(&mut browser);
    // A line is a pixel wide, and as long as the hair at least.
    assert!(shown > 1000 && shown >= plain, "{plain} {shown}");
    browser.value(
        "(() => { const color = document.getElementById('color');
            color.value = 'charge';
            color.dispatchEvent(new Event('change')); })()",
    );
    browser.wait("rapunzel.state.colored && rapunzel.painter.frame.low < 0");
    browser.picture("field-lines");
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    crate::recorded::record_of(HAIRS, &first);
    crate::recorded::record_of(&HAIRS.replace("0.005, 0.005", "0.002, 0.008"), &second);
    let options = Options {
        what: Some(first),
        beside: Some(second),
        ..Options::local(folder.path().to_owned())
    };
    let served = Served::new(options);
    browser.open(&served.url);
    browser.wait("rapunzel.about.kind === 'recorded' && rapunzel.isFit");
    let width =
        "(() => { const [low, high] = rapunzel.painter.box(); return high[0] - low[0]; })()";
    let beside = browser.value(width).as_f64().expect("m");
    browser.picture("two-runs");
    browser.value("document.getElementById('over').click()");
    browser.wait(&format!("rapunzel.state.over && {width} < 0.7 * {beside}"));
    browser.key("o");
    browser.wait(&format!("!rapunzel.state.over && {width} > 0.9 * {beside}"));
    assert_eq!(browser.errors, Vec::<String>::new());
}
