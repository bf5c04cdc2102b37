//! The files of the page, which are part of the program.

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Type and content of the file at a path; nothing else is ever served by a name.
pub(crate) fn asset(path: &str) -> Option<(&'static str, &'static [u8])> {
    macro_rules! page {
        ($name:literal) => {
            include_bytes!(concat!("../page/", $name)).as_slice()
        };
    }
    Some(match path {
        "/" => (HTML, page!("index.html")),
        "/style.css" => ("text/css; charset=utf-8", page!("style.css")),
        "/icon.svg" => ("image/svg+xml", page!("icon.svg")),
        "/main.js" => (SCRIPT, page!("main.js")),
        "/camera.js" => (SCRIPT, page!("camera.js")),
        "/controls.js" => (SCRIPT, page!("controls.js")),
        "/gallery.js" => (SCRIPT, page!("gallery.js")),
        "/gl.js" => (SCRIPT, page!("gl.js")),
        "/hand.js" => (SCRIPT, page!("hand.js")),
        "/hurry.js" => (SCRIPT, page!("hurry.js")),
        "/keys.js" => (SCRIPT, page!("keys.js")),
        "/lines.js" => (SCRIPT, page!("lines.js")),
        "/link.js" => (SCRIPT, page!("link.js")),
        "/look.js" => (SCRIPT, page!("look.js")),
        "/matrix.js" => (SCRIPT, page!("matrix.js")),
        "/mesh.js" => (SCRIPT, page!("mesh.js")),
        "/occlusion.js" => (SCRIPT, page!("occlusion.js")),
        "/overlays.js" => (SCRIPT, page!("overlays.js")),
        "/painter.js" => (SCRIPT, page!("painter.js")),
        "/pick.js" => (SCRIPT, page!("pick.js")),
        "/plot.js" => (SCRIPT, page!("plot.js")),
        "/readings.js" => (SCRIPT, page!("readings.js")),
        "/say.js" => (SCRIPT, page!("say.js")),
        "/shaders.js" => (SCRIPT, page!("shaders.js")),
        "/smooth.js" => (SCRIPT, page!("smooth.js")),
        "/teller.js" => (SCRIPT, page!("teller.js")),
        "/textures.js" => (SCRIPT, page!("textures.js")),
        "/traced.js" => (SCRIPT, page!("traced.js")),
        "/words.js" => (SCRIPT, page!("words.js")),
        _ => return None,
    })
}
