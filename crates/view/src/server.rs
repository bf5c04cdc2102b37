use crate::driver::Driver;
use crate::gate::{Admission, Gate};
use crate::hub::Hub;
use crate::options::Options;
use crate::request::{PATIENCE, Refusal, Request};
use crate::{ViewError, answer, assets, gallery, socket};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};
use std::{io, thread};

/// Connections at once; more are closed at once.
const MOST_CONNECTIONS: usize = 512;
/// Events of pages that wait at most.
const MOST_EVENTS: usize = 256;
/// How often is looked whether the server is to end.
const ASK: Duration = Duration::from_millis(20);
/// How long the threads of the server are waited for in the end.
const FAREWELL: Duration = Duration::from_millis(700);

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    options: Options,
}

impl Server {
    /// Listens at the address of the options.
    ///
    /// # Errors
    /// [`ViewError::Listen`] for an address that is in use or not of this machine,
    /// [`ViewError::Open`] for one that others reach without a token.
    pub fn listen(options: Options) -> Result<Self, ViewError> {
        let address = options.address;
        if !address.ip().is_loopback() && options.token.as_ref().is_none_or(String::is_empty) {
            return Err(ViewError::Open { address });
        }
        let listener = TcpListener::bind(address);
        let listener = listener.map_err(|source| ViewError::Listen { address, source })?;
        let address = listener.local_addr();
        let address =
            address.map_err(|source| ViewError::Listen { address: options.address, source })?;
        Ok(Self { listener, address, options })
    }

    /// The address of the page.
    #[must_use]
    pub fn url(&self) -> String {
        Gate::new(self.address, self.options.token.clone()).url()
    }

    /// Serves until `stop` says so, which is asked often. What is shown is simulated meanwhile.
    ///
    /// Returns within a second of `stop`; a step or the building of a scene that takes longer ends
    /// with the program.
    ///
    /// Gives the file of a scene that was left in the midst, with all that was changed; beside it
    /// is where it stood, and opened again it goes on there.
    ///
    /// # Errors
    /// [`ViewError::Thread`].
    pub fn run(self, stop: &dyn Fn() -> bool) -> Result<Option<PathBuf>, ViewError> {
        let Self { listener, address, options } = self;
        let (events, heard) = mpsc::sync_channel(MOST_EVENTS);
        let hub = Arc::new(Hub::new(events));
        let door = Arc::new(Door {
            gate: Gate::new(address, options.token.clone()),
            pictures: gallery::GalleryPictures::new(options.gallery.clone()),
            hub: Arc::clone(&hub),
            connections: AtomicUsize::new(0),
        });
        let driver = Driver::new(options, Arc::clone(&hub), heard);
        let named = |name: &str| thread::Builder::new().name(name.into());
        let driven = named("simulation").spawn(move || driver.run()).map_err(ViewError::Thread)?;
        let open = Arc::clone(&door);
        let accepting = named("server").spawn(move || open.accept(&listener));
        let accepting = accepting.map_err(ViewError::Thread)?;
        while !stop() {
            thread::sleep(ASK);
        }
        hub.end();
        // Whoever waits for a connection gets a last one.
        let _ = TcpStream::connect_timeout(&address, FAREWELL);
        let begin = Instant::now();
        let busy = || {
            let threads = !driven.is_finished() || !accepting.is_finished();
            threads || door.connections.load(Ordering::Relaxed) > 0
        };
        while busy() && begin.elapsed() < FAREWELL {
            thread::sleep(ASK);
        }
        // Of a step that takes longer, nothing is known that could be kept.
        let kept = if driven.is_finished() { driven.join().ok().flatten() } else { None };
        Ok(kept)
    }
}

/// Where connections come in.
#[derive(Debug)]
struct Door {
    gate: Gate,
    pictures: gallery::GalleryPictures,
    hub: Arc<Hub>,
    connections: AtomicUsize,
}

impl Door {
    fn accept(self: Arc<Self>, listener: &TcpListener) {
        for stream in listener.incoming() {
            if self.hub.has_ended() {
                return;
            }
            let Ok(stream) = stream else {
                // Too many files are open, say: they will be fewer.
                thread::sleep(ASK);
                continue;
            };
            let door = Arc::clone(&self);
            if self.connections.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
                self.connections.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            let serve = move || {
                if let Err(error) = door.serve(stream) {
                    tracing::debug!(%error, "a connection broke");
                }
                door.connections.fetch_sub(1, Ordering::Relaxed);
            };
            if thread::Builder::new().name("connection".into()).spawn(serve).is_err() {
                self.connections.fetch_sub(1, Ordering::Relaxed);
            }
        }
    }

    fn serve(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = Request::read(&mut stream);
        let admitted = request.and_then(|request| Ok((self.gate.admit(&request)?, request)));
        let (entry, request) = match admitted {
            Ok(admitted) => admitted,
            Err(refusal) => return answer::refuse(&mut stream, refusal),
        };
        if request.path == "/socket" {
            let Some(key) = request.socket_key else {
                return answer::refuse(&mut stream, Refusal::NotFound);
            };
            answer::open_socket(&mut stream, &key)?;
            socket::serve(stream, &self.hub);
            return Ok(());
        }
        let with_body = match request.method.as_str() {
            "GET" => true,
            "HEAD" => false,
            _ => return answer::refuse(&mut stream, Refusal::Method),
        };
        let cookie = match &entry {
            Admission::Plain => None,
            Admission::WithCookie(cookie) => Some(cookie.as_str()),
        };
        if let Some(asset) = assets::asset(&request.path) {
            return answer::give(&mut stream, asset, cookie, with_body);
        }
        let picture = request.path.strip_prefix("/picture/");
        match picture.and_then(|name| self.pictures.get(name)) {
            Some(png) => answer::give(&mut stream, ("image/png", &png), cookie, with_body),
            None => answer::refuse(&mut stream, Refusal::NotFound),
        }
    }
}
