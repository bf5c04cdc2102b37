use crate::common::PATIENCE;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs};
use tungstenite::{Message, WebSocket};

/// Names of browsers that speak the protocol of Chromium's developer tools.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// A headless Chromium with one page, which draws without a graphics card.
pub(crate) struct Browser {
    child: Child,
    socket: WebSocket<TcpStream>,
    session: String,
    next: u64,
    /// Errors and exceptions that the page has had.
    pub(crate) errors: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts one with a page of this size; none, said loudly, where there is none on the machine.
    pub(crate) fn start(width: u32, height: u32) -> Option<Self> {
        Self::start_with(width, height, &["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
    }

    /// The same, with other options about how it draws.
    pub(crate) fn start_with(width: u32, height: u32, draws: &[&str]) -> Option<Self> {
        let Some(program) = find() else {
            let names = NAMES.join(", ");
            let message = format!("SKIPPED: there is no browser: install one of {names}\n");
            use std::io::Write;
            // Not by `eprint`, which the frame of tests keeps to itself.
            let _ = std::io::stderr().write_all(message.as_bytes());
            return None;
        };
        let profile = tempfile::tempdir().expect("a folder");
        let mut child = Command::new(program)
            .args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage"])
            .args(draws)
            .arg("--lang=en")
            .args(["--no-first-run", "--mute-audio", "--remote-debugging-port=0"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("--window-size={width},{height}"))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the browser starts");
        let told = BufReader::new(child.stderr.take().expect("it is piped"));
        let mut lines = told.lines().map_while(Result::ok);
        let address =
            lines.find_map(|line| line.strip_prefix("DevTools listening on ").map(str::to_owned));
        // What else it says is read away, lest it waits for a reader.
        std::thread::spawn(move || lines.for_each(drop));
        let address = address.expect("the browser says where it listens");
        let host = address.trim_start_matches("ws://").split('/').next().expect("a host");
        let stream = TcpStream::connect(host).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let (socket, _) = tungstenite::client(address.as_str(), stream).expect("a socket");
        let (session, errors) = (String::new(), Vec::new());
        let mut browser = Self { child, socket, session, next: 0, errors, _profile: profile };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let wish = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", wish);
        browser.session = session["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.resize(width, height);
        Some(browser)
    }

    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        let size = json!({
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 700,
        });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Calls a method and waits for its answer.
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.next += 1;
        let id = self.next;
        let mut call = json!({ "id": id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            call["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(call.to_string())).expect("sent");
        loop {
            let Message::Text(text) = self.socket.read().expect("the browser answers") else {
                continue;
            };
            let answer: Value = serde_json::from_str(&text).expect("JSON");
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.heed(&answer);
        }
    }

    /// All that readers of screens are told.
    pub(crate) fn accessible(&mut self) -> Value {
        self.call("Accessibility.enable", json!({}));
        self.call("Accessibility.getFullAXTree", json!({}))["nodes"].clone()
    }

    /// What a person prefers, as media queries name it.
    pub(crate) fn prefer(&mut self, wishes: &[(&str, &str)]) {
        let features: Vec<_> =
            wishes.iter().map(|(name, value)| json!({ "name": name, "value": value })).collect();
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Keeps what the page complains of.
    fn heed(&mut self, event: &Value) {
        let what = &event["params"];
        match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => self.errors.push(what.to_string()),
            Some("Log.entryAdded") if what["entry"]["level"] == "error" => {
                self.errors.push(what.to_string());
            }
            Some("Runtime.consoleAPICalled") if what["type"] == "error" => {
                self.errors.push(what.to_string());
            }
            _ => {}
        }
    }

    pub(crate) fn open(&mut self, url: &str) {
        self.call("Page.navigate", json!({ "url": url }));
        self.wait("document.readyState === 'complete' && window.rapunzel !== undefined");
    }

    /// The value of an expression, or of what it promises.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let wish = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", wish);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub(crate) fn wait(&mut self, expression: &str) {
        let begin = Instant::now();
        while self.value(&format!("Boolean({expression})")) != true {
            if begin.elapsed() > PATIENCE {
                let state = self.value("JSON.stringify(window.rapunzel?.state)");
                panic!("{expression} is not to be; {:?}; {state}", self.errors);
            }
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    pub(crate) fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let buttons = i32::from(kind != "mouseReleased");
        let event = json!({
            "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", event);
    }

    pub(crate) fn touch(&mut self, kind: &str, points: &[(f64, f64)]) {
        let points: Vec<_> = points.iter().map(|(x, y)| json!({ "x": x, "y": y })).collect();
        self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
    }

    pub(crate) fn key(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "text": key });
            if key == "Tab" {
                event =
                    json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": 9 });
            }
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// A picture of the page in the folder that the environment names, if it names one.
    pub(crate) fn picture(&mut self, name: &str) {
        let Some(folder) = env::var_os("RAPUNZEL_PICTURES").map(PathBuf::from) else { return };
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let text = answer["data"].as_str().expect("a picture");
        let png = data_encoding::BASE64.decode(text.as_bytes()).expect("base64");
        fs::create_dir_all(&folder).expect("a folder");
        fs::write(folder.join(format!("{name}.png")), png).expect("written");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The browser that the environment names, or one in the path.
fn find() -> Option<PathBuf> {
    if let Some(named) = env::var_os("RAPUNZEL_BROWSER") {
        return Some(named.into());
    }
    let folders = env::var_os("PATH")?;
    let candidates = env::split_paths(&folders)
        .flat_map(|folder| NAMES.map(|name| Path::new(&folder).join(name)));
    candidates.into_iter().find(|path| path.is_file())
}
