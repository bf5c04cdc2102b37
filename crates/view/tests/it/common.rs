use rapunzel_view::{GalleryScene, Options, Server};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// As long as anything may take on a busy machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(200);

/// A rope of ten nodes.
pub(crate) const ROPE: &str = "(
    format: 1, name: \"A rope\", duration: 1.0, stepper: (dt: 4e-3),
    mass_spring: (
        model: Rope(nodes: 10, spacing: 0.05, direction: (0.0, 0.0, -1.0)),
        mass: 0.01, frequency: 40.0, drag: 0.2, damping_ratio: 0.1, substeps: 4,
    ),
)";
/// Three hairs that hang.
pub(crate) const HAIRS: &str = "(
    format: 1, name: \"Three hairs\", duration: 0.1, stepper: (dt: 1e-3),
    fibers: [(
        length: 0.1, segments: 20, section: Circle(radius: 4e-5), damping_time: 1e-3,
        arrangement: EllipseAtDensity(semi_axes: (0.005, 0.005), density: 4e4),
    )],
    environment: (viscosity: 1.8e-5),
    output: (frame_rate: 100.0),
)";

/// Three hairs that hang beside a ball whose motion is given.
pub(crate) const BALL: &str = "(
    format: 1, name: \"A ball beside hairs\", duration: 0.1, stepper: (dt: 1e-3),
    fibers: [(
        length: 0.1, segments: 20, section: Circle(radius: 4e-5), damping_time: 1e-3,
        arrangement: EllipseAtDensity(semi_axes: (0.005, 0.005), density: 4e4),
    )],
    objects: [(shape: Ball(radius: 0.02), position: (0.035, 0.0, -0.07))],
    contact: (friction: Isotropic(0.3)),
    environment: (viscosity: 1.8e-5),
    output: (frame_rate: 100.0, ledger: true),
)";
/// The same ball, which goes slowly through the hairs by itself.
pub(crate) fn bump() -> String {
    let motion = "-0.07), motion: Translate(velocity: (-0.1, 0.0, 0.0), until: 0.05))";
    BALL.replace("-0.07))", motion).replace("0.035, 0.0", "0.027, 0.0")
}

/// Hairs with charge.
pub(crate) const CHARGED: &str = "(
    format: 1, name: \"Charged hairs\", duration: 5.0, stepper: (dt: 1.0),
    fibers: [(
        length: 0.1, segments: 10, section: Circle(radius: 4e-5),
        arrangement: Ellipse(semi_axes: (0.004, 0.004), count: 6),
        charge: (amount: Fiber(-1e-11)),
    )],
    charging: (dealing: Falling(4), tolerance: 1e-3),
)";

/// A scene of the gallery that names no files.
pub(crate) fn alone(name: &str, text: &str) -> GalleryScene {
    GalleryScene { name: name.into(), text: text.into(), files: Vec::new() }
}

/// A server that is stopped when it is dropped.
pub(crate) struct Served {
    /// Host and port.
    pub(crate) host: String,
    pub(crate) url: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Option<PathBuf>>>,
    /// What was kept of a scene that was left.
    pub(crate) kept: Option<PathBuf>,
}

impl Served {
    pub(crate) fn new(options: Options) -> Self {
        let server = Server::listen(options).expect("a free port");
        let (url, stop) = (server.url(), Arc::new(AtomicBool::new(false)));
        let host = url.trim_start_matches("http://").split('/').next().expect("a host").to_owned();
        let asked = Arc::clone(&stop);
        let run = move || server.run(&|| asked.load(Ordering::Relaxed)).expect("threads");
        Self { host, url, stop, thread: Some(thread::spawn(run)), kept: None }
    }

    /// A gallery of a rope and hairs.
    pub(crate) fn gallery(folder: &Path) -> Self {
        let gallery = vec![alone("springs/rope", ROPE), alone("hairs", HAIRS)];
        Self::new(Options { gallery, ..Options::local(folder.to_owned()) })
    }

    /// Stops the server and tells how long that took.
    pub(crate) fn stop(&mut self) -> Duration {
        let begin = Instant::now();
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            self.kept = thread.join().expect("no panic");
        }
        begin.elapsed()
    }

    /// A scene in a file of a folder.
    pub(crate) fn scene(folder: &Path, text: &str) -> Self {
        let path = folder.join("scene.ron");
        std::fs::write(&path, text).expect("written");
        Self::new(Options { what: Some(path), ..Options::local(folder.to_owned()) })
    }

    /// The answer to a request as it stands, with head and body.
    pub(crate) fn ask(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream.write_all(request.as_bytes()).expect("written");
        let mut answer = Vec::new();
        // A connection that is closed at once may be reset.
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    pub(crate) fn get(&self, path: &str) -> String {
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host))
    }

    /// A page without a browser.
    pub(crate) fn page(&self) -> Client {
        Client::new(&self.host).expect("a socket")
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop();
    }
}

/// A page without a browser.
pub(crate) struct Client {
    pub(crate) socket: WebSocket<TcpStream>,
    /// The last layout and frame, and all pictures.
    pub(crate) layout: Vec<u8>,
    pub(crate) frame: Vec<u8>,
    pub(crate) pictures: Vec<Vec<u8>>,
}

impl Client {
    pub(crate) fn new(host: &str) -> Option<Self> {
        let stream = TcpStream::connect(host).ok()?;
        stream.set_read_timeout(Some(PATIENCE)).ok()?;
        let mut request = format!("ws://{host}/socket").into_client_request().ok()?;
        request.headers_mut().insert("Origin", format!("http://{host}").parse().ok()?);
        let (socket, _) = tungstenite::client(request, stream).ok()?;
        Some(Self { socket, layout: Vec::new(), frame: Vec::new(), pictures: Vec::new() })
    }

    pub(crate) fn order(&mut self, order: &str) {
        self.socket.send(Message::text(order)).expect("sent");
    }

    /// The next text, having drawn all frames before it.
    pub(crate) fn text(&mut self) -> Option<Value> {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "the server says nothing");
            match self.socket.read().ok()? {
                Message::Text(text) => return serde_json::from_str(&text).ok(),
                Message::Binary(bytes) if bytes.starts_with(b"RPF1") => {
                    self.frame = bytes.to_vec();
                    self.order(r#"{"do":"drawn","frames":1}"#);
                }
                Message::Binary(bytes) if bytes.starts_with(b"RPP1") => {
                    self.pictures.push(bytes.to_vec());
                }
                Message::Binary(bytes) => self.layout = bytes.to_vec(),
                Message::Close(_) => return None,
                _ => {}
            }
        }
    }

    /// The next text of a kind for which something holds.
    pub(crate) fn wait(&mut self, is: &str, that: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        loop {
            let text = self.text().expect("the connection holds");
            if text["is"] == is && that(&text) {
                return text;
            }
            assert!(begin.elapsed() < PATIENCE, "no {is} came that is as expected: {text}");
        }
    }

    /// Waits for a scene that is named so.
    pub(crate) fn open(&mut self, name: &str) -> Value {
        self.order(&format!(r#"{{"do":"open","name":"{name}"}}"#));
        self.wait("about", |about| about["kind"] == "live" && about["title"] == name)
    }

    /// Waits for a frame for which something holds.
    pub(crate) fn wait_frame(&mut self, that: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        while self.frame.is_empty() || !that(self) {
            assert!(begin.elapsed() < PATIENCE, "no frame comes that is as expected");
            // Whatever changes nothing makes the next state and frame come.
            self.order(r#"{"do":"fit_colors"}"#);
            self.text().expect("the connection holds");
        }
    }

    fn count(&self, at: usize) -> usize {
        let bytes = self.frame[at..at + 4].try_into().expect("four bytes");
        u32::from_le_bytes(bytes) as usize
    }

    /// Singles of the last frame.
    fn floats(&self, at: usize, count: usize) -> Vec<f64> {
        let bytes = self.frame[at..at + 4 * count].chunks_exact(4);
        bytes.map(|b| f64::from(f32::from_le_bytes(b.try_into().expect("four bytes")))).collect()
    }

    /// Number of points of the last frame.
    pub(crate) fn points(&self) -> usize {
        self.count(72)
    }

    /// Place of an object in the last frame, m.
    pub(crate) fn object(&self, index: usize) -> [f64; 3] {
        let at = 80 + 8 * self.points() + 28 * index;
        self.floats(at, 3).try_into().expect("three numbers")
    }

    /// Contacts (place and force), boxes (two corners) and points of field lines of the last frame.
    pub(crate) fn extras(&self) -> [Vec<Vec<f64>>; 3] {
        let at = 80 + 8 * self.points() + 28 * self.count(76);
        let [pushes, boxes, lines, points] = [0, 4, 8, 12].map(|k| self.count(at + k));
        let (first, second) = (at + 16, at + 16 + 24 * pushes);
        let third = second + 24 * boxes + 4 * lines;
        assert_eq!(self.frame.len(), third + 12 * points);
        let of = |at: usize, count: usize, each: usize| {
            let floats = self.floats(at, each * count);
            floats.chunks(each).map(<[f64]>::to_vec).collect::<Vec<_>>()
        };
        [of(first, pushes, 6), of(second, boxes, 6), of(third, points, 3)]
    }

    /// Position of a point of the last frame, m, and to what it is right.
    pub(crate) fn position(&self, point: usize) -> ([f64; 3], f64) {
        let number =
            |at: usize| f64::from_le_bytes(self.frame[at..at + 8].try_into().expect("eight bytes"));
        let unit = number(48);
        let axis = |axis: usize| {
            let at = 80 + 8 * point + 2 * axis;
            let of = u16::from_le_bytes([self.frame[at], self.frame[at + 1]]);
            number(24 + 8 * axis) + unit * f64::from(of)
        };
        ([0, 1, 2].map(axis), 0.5 * unit)
    }
}
