use crate::common::{Client, PATIENCE, Served};
use rapunzel_view::{Options, Server, ViewError};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::Message;

fn served() -> (tempfile::TempDir, Served) {
    let folder = tempfile::tempdir().expect("a folder");
    let served = Served::gallery(folder.path());
    (folder, served)
}

#[test]
fn the_page_comes_whole_and_guarded() {
    let (_folder, served) = served();
    let page = served.get("/");
    assert!(page.starts_with("HTTP/1.1 200 OK\r\n"), "{page}");
    for guard in [
        "Content-Security-Policy: default-src 'none'; script-src 'self'",
        "frame-ancestors 'none'",
        "X-Frame-Options: DENY",
        "X-Content-Type-Options: nosniff",
    ] {
        assert!(page.contains(guard), "{guard}");
    }
    let mut bytes = page.len();
    let names = page.match_indices("src=\"").map(|(at, found)| &page[at + found.len()..]);
    let names =
        names.chain(page.match_indices("href=\"").map(|(at, found)| &page[at + found.len()..]));
    let mut names: Vec<String> =
        names.filter_map(|rest| rest.split('"').next()).map(str::to_owned).collect();
    let mut seen = Vec::new();
    // What the page names, and what that names.
    while let Some(name) = names.pop() {
        if seen.contains(&name) || name.starts_with('#') {
            continue;
        }
        let file = served.get(&format!("/{name}"));
        assert!(file.starts_with("HTTP/1.1 200 OK"), "{name}");
        bytes += file.len();
        let imports = file.match_indices("from \"./").map(|(at, found)| &file[at + found.len()..]);
        names.extend(imports.filter_map(|rest| rest.split('"').next()).map(str::to_owned));
        seen.push(name);
    }
    assert!(seen.len() > 12 && bytes < 400_000, "{bytes} bytes in {seen:?}");
}

#[test]
fn nothing_else_is_served() {
    let (folder, served) = served();
    std::fs::write(folder.path().join("scene.ron"), "(format: 1)").expect("written");
    #[cfg(unix)]
    for (to, name) in [("/etc/passwd", "link"), ("/dev/zero", "device")] {
        std::os::unix::fs::symlink(to, folder.path().join(name)).expect("a link");
    }
    for path in [
        "/scene.ron",
        "/link",
        "/device",
        "/../Cargo.toml",
        "/..%2f..%2fetc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/page/index.html",
        "/index.html/..",
        "/picture/../../etc/passwd",
        "/picture/nothing",
        "/picture/",
        "/dev/zero",
        "/socket",
        "/\u{0}",
    ] {
        let answer = served.get(path);
        let refused = ["HTTP/1.1 404", "HTTP/1.1 400"].iter().any(|with| answer.starts_with(with));
        assert!(refused, "{path}: {answer}");
    }
    let post = format!("POST / HTTP/1.1\r\nHost: {}\r\nContent-Length: 0\r\n\r\n", served.host);
    assert!(served.ask(&post).starts_with("HTTP/1.1 405"));
    let picture = served.get("/picture/springs/rope");
    assert!(picture.starts_with("HTTP/1.1 200 OK\r\nContent-Type: image/png"), "{picture}");
}

#[test]
fn other_hosts_and_origins_are_kept_out() {
    let (_folder, served) = served();
    let host = &served.host;
    let foreign = "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n";
    assert!(served.ask(foreign).starts_with("HTTP/1.1 403"));
    let port = host.rsplit(':').next().expect("a port");
    let local = format!("GET / HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n");
    assert!(served.ask(&local).starts_with("HTTP/1.1 200"));
    for (origin, status) in [
        ("Origin: http://evil.example\r\n".to_owned(), "403"),
        ("Origin: null\r\n".to_owned(), "403"),
        (String::new(), "403"),
        (format!("Origin: http://{host}\r\n"), "101"),
    ] {
        let mut stream = TcpStream::connect(host).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        write!(
            stream,
            "GET /socket HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             {origin}\r\n"
        )
        .expect("written");
        let mut start = [0; 12];
        stream.read_exact(&mut start).expect("an answer");
        assert_eq!(start, *format!("HTTP/1.1 {status}").as_bytes(), "{origin}");
    }
}

#[test]
fn other_machines_need_a_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let open = |token: Option<&str>| {
        let address = "0.0.0.0:0".parse().expect("an address");
        let token = token.map(str::to_owned);
        Options { address, token, ..Options::local(folder.path().to_owned()) }
    };
    for none in [None, Some("")] {
        let refused = Server::listen(open(none)).expect_err("it is open to all");
        assert!(matches!(refused, ViewError::Open { .. }), "{refused}");
    }
    let mut served = Served::new(open(Some("secret")));
    served.host = served.host.replace("0.0.0.0", "127.0.0.1");
    assert!(served.get("/").starts_with("HTTP/1.1 403"));
    assert!(served.get("/main.js").starts_with("HTTP/1.1 403"));
    let page = served.get("/?token=secret");
    assert!(page.starts_with("HTTP/1.1 200"), "{page}");
    assert!(page.contains("Set-Cookie: rapunzel-token=secret; HttpOnly; SameSite=Strict"));
    let with = format!(
        "GET /main.js HTTP/1.1\r\nHost: {}\r\nCookie: rapunzel-token=secret\r\n\r\n",
        served.host
    );
    assert!(served.ask(&with).starts_with("HTTP/1.1 200"));
}

#[test]
fn a_port_in_use_is_told() {
    let (folder, served) = served();
    let address = served.host.parse().expect("an address");
    let options = Options { address, ..Options::local(folder.path().to_owned()) };
    let error = Server::listen(options).expect_err("the port is in use").to_string();
    assert!(error.contains(&served.host) && error.contains("another port"), "{error}");
}

/// Whether a page is sent away soon.
fn is_dropped(client: &mut Client) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        if client.socket.read().is_err() {
            return true;
        }
    }
    false
}

#[test]
fn pages_that_send_nonsense_are_dropped_and_the_others_go_on() {
    let (_folder, served) = served();
    let mut good = served.page();
    good.open("springs/rope");
    for message in [
        Message::text("garbage"),
        Message::text(r#"{"do":"fly"}"#),
        Message::binary(vec![0; 10]),
        Message::text(format!(r#"{{"do":"open","name":"{}"}}"#, "x".repeat(20_000))),
    ] {
        let mut bad = served.page();
        // It may be gone before all of it is sent.
        let _ = bad.socket.send(message.clone());
        assert!(is_dropped(&mut bad), "{message:?}");
    }
    let mut raw = served.page();
    raw.socket.get_mut().write_all(&[0xff; 64]).expect("written");
    assert!(is_dropped(&mut raw));
    good.order(r#"{"do":"run"}"#);
    good.wait("state", |state| state["time"].as_f64() > Some(0.1));
}

#[test]
fn a_page_that_takes_nothing_delays_nobody() {
    let (_folder, served) = served();
    let mut good = served.page();
    good.wait("controls", |note| note["mine"] == true);
    // It never reads.
    let _stuck = served.page();
    good.open("hairs");
    good.order(r#"{"do":"run"}"#);
    let begin = Instant::now();
    good.wait("state", |state| state["time"].as_f64() > Some(0.5));
    assert!(begin.elapsed() < PATIENCE);
}

#[test]
fn a_page_that_hangs_is_dropped() {
    let (_folder, served) = served();
    let mut good = served.page();
    // It neither reads nor answers.
    let stuck = served.page();
    good.wait("controls", |note| note["pages"] == 2);
    good.wait("controls", |note| note["pages"] == 1);
    drop(stuck);
}

#[test]
fn what_runs_goes_on_when_the_last_page_has_gone() {
    let (_folder, served) = served();
    let mut page = served.page();
    page.open("springs/rope");
    page.order(r#"{"do":"run"}"#);
    let state = page.wait("state", |state| state["steps"].as_u64() > Some(0));
    drop(page);
    std::thread::sleep(Duration::from_secs(1));
    // What it stands at when another page comes was reached while there was none.
    let mut other = served.page();
    let first = other.wait("state", |_| true);
    assert_eq!(first["runs"], true);
    let steps = |state: &serde_json::Value| state["steps"].as_u64().expect("steps");
    assert!(steps(&first) > steps(&state) + 20, "{first}");
}

#[test]
fn many_come_and_go() {
    let (_folder, served) = served();
    let mut pages: Vec<_> = (0..100).map(|_| served.page()).collect();
    for k in 0..50 {
        drop(pages.swap_remove((k * 7) % pages.len()));
    }
    let last = pages.last_mut().expect("fifty are left");
    last.wait("controls", |note| note["pages"] == 50);
    drop(pages);
    // Whoever comes alone has the controls.
    let begin = Instant::now();
    loop {
        let mut page = served.page();
        let controls = page.wait("controls", |_| true);
        if controls["pages"] == 1 {
            assert_eq!(controls["mine"], true);
            break;
        }
        assert!(begin.elapsed() < PATIENCE, "{controls}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn one_page_is_at_the_controls() {
    let (_folder, served) = served();
    let mut first = served.page();
    first.wait("controls", |note| note["mine"] == true);
    let mut second = served.page();
    second.wait("controls", |note| note["mine"] == false);
    first.open("springs/rope");
    second.wait("about", |about| about["kind"] == "live");
    second.order(r#"{"do":"run"}"#);
    second.order(r#"{"do":"control"}"#);
    second.wait("controls", |note| note["mine"] == true);
    first.wait("controls", |note| note["mine"] == false);
    // What it asked for before is not done, and what it asks for now is.
    second.order(r#"{"do":"step"}"#);
    let state = second.wait("state", |state| state["steps"].as_u64() > Some(0));
    assert_eq!((state["steps"].as_u64(), state["runs"].as_bool()), (Some(1), Some(false)));
    drop(second);
    first.wait("controls", |note| note["mine"] == true);
}

#[test]
fn the_end_comes_within_a_second() {
    let (_folder, mut served) = served();
    let mut page = served.page();
    page.open("hairs");
    page.order(r#"{"do":"run"}"#);
    page.wait("state", |state| state["runs"] == true);
    let mut slow = TcpStream::connect(&served.host).expect("a connection");
    slow.write_all(b"GET / HT").expect("written");
    let took = served.stop();
    assert!(took < Duration::from_secs(1), "{took:?}");
}
