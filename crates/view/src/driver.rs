//! The thread that moves what is shown, and does what pages ask for between steps.

use crate::frame::Colors;
use crate::hub::{Event, Hub};
use crate::live::Live;
use crate::options::Options;
use crate::order::Order;
use crate::stage::Showing;
use crate::watch::Watch;
use crate::{modes, state};
use rapunzel_sim::SimError;
use serde_json::json;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Frames follow each other no faster.
const FRAME: Duration = Duration::from_millis(16);
/// How often pages are told how all stands.
const STATE: Duration = Duration::from_millis(100);
/// How long nothing is waited for at most.
const IDLE: Duration = Duration::from_millis(100);
/// Slowest and fastest speed.
const SPEEDS: (f64, f64) = (1e-4, 100.0);

/// What moves what is shown.
pub(crate) struct Driver {
    options: Options,
    hub: Arc<Hub>,
    events: Receiver<Event>,
    stage: Showing,
    /// Name of the scene of the gallery that is shown.
    name: String,
    watch: Option<Watch>,
    colors: Colors,
    /// Number of the layout.
    layout: u32,
    /// Whether something has changed since the last frame, and since the last state.
    is_new: [bool; 2],
    framed: Instant,
    told: Instant,
    /// Values of sliders that are to be set.
    values: Vec<(String, f64)>,
}

impl Driver {
    pub(crate) fn new(options: Options, hub: Arc<Hub>, events: Receiver<Event>) -> Self {
        let now = Instant::now();
        Self {
            options,
            hub,
            events,
            stage: Showing::Gallery,
            name: String::new(),
            watch: None,
            colors: Colors::default(),
            layout: 0,
            is_new: [true; 2],
            framed: now,
            told: now,
            values: Vec::new(),
        }
    }

    /// Goes on until the server ends.
    pub(crate) fn run(mut self) {
        self.open();
        if self.options.runs {
            self.go();
        }
        while self.heed() {
            self.look();
            self.advance();
            self.publish();
        }
    }

    /// Opens what the options name.
    fn open(&mut self) {
        self.name.clear();
        if let Some(path) = &self.options.what {
            self.hub.show(&json!({ "is": "about", "kind": "building" }).to_string(), None);
            self.watch = path.is_file().then(|| Watch::new(path));
            self.stage = Showing::open(path);
        } else {
            self.stage = Showing::Gallery;
        }
        self.show();
    }

    /// Opens a scene of the gallery.
    fn open_named(&mut self, name: &str) {
        let Some(scene) = self.options.gallery.iter().find(|scene| scene.name == name) else {
            return;
        };
        let Some(scene) = scene.scene() else { return };
        self.hub.show(&json!({ "is": "about", "kind": "building" }).to_string(), None);
        self.watch = None;
        self.stage = Showing::build(scene, &self.options.folder);
        name.clone_into(&mut self.name);
        self.show();
    }

    /// Shows what is on the stage from its beginning.
    fn show(&mut self) {
        self.colors.range = None;
        self.values.clear();
        self.relay();
    }

    /// Tells pages what is shown, and all of it that does not change from frame to frame.
    fn relay(&mut self) {
        self.layout += 1;
        let about = state::about(&self.stage, &self.title(), &self.options.gallery, &self.name);
        self.hub.show(&about, self.stage.layout(self.layout));
        self.is_new = [true; 2];
    }

    fn title(&self) -> String {
        let path = self.options.what.as_ref().and_then(|path| path.file_name());
        match (&self.stage, path) {
            (Showing::Gallery, _) => String::new(),
            (_, Some(name)) if self.name.is_empty() => name.to_string_lossy().into_owned(),
            _ => self.name.clone(),
        }
    }

    /// Does what pages ask for, waiting as long as nothing else is to be done; false in the end.
    fn heed(&mut self) -> bool {
        let mut wait = self.wait();
        loop {
            match self.events.recv_timeout(wait) {
                Ok(Event::End) | Err(RecvTimeoutError::Disconnected) => return false,
                Ok(Event::Pages) => self.is_new[1] = true,
                Ok(Event::Order(order)) => {
                    self.is_new = [true; 2];
                    if let Err(error) = self.obey(order) {
                        self.complain(&error);
                    }
                }
                Err(RecvTimeoutError::Timeout) => break,
            }
            wait = Duration::ZERO;
        }
        let values = std::mem::take(&mut self.values);
        if !values.is_empty()
            && let Showing::Live(live) = &mut self.stage
            && let Err(error) = live.set(&values)
        {
            self.complain(&error);
        }
        !self.hub.has_ended()
    }

    /// How long nothing is to be done.
    fn wait(&mut self) -> Duration {
        let now = Instant::now();
        let wait = match &mut self.stage {
            Showing::Live(live) => live.pace.wait(now, live.world.time()),
            Showing::Recorded(recorded) => {
                let time = recorded.now.frame.time;
                recorded.pace.wait(now, time)
            }
            Showing::Gallery | Showing::Broken(_) => None,
        };
        let frame = if self.is_new[0] { FRAME } else { IDLE };
        wait.unwrap_or(frame).min(frame)
    }

    fn complain(&self, error: &SimError) {
        let note = json!({ "is": "complaint", "message": error.to_string() });
        self.hub.note(&note.to_string());
    }

    fn obey(&mut self, order: Order) -> Result<(), SimError> {
        match order {
            Order::Drawn | Order::Control => {}
            Order::Run => self.go(),
            Order::Pause => self.halt(),
            Order::Step => {
                self.halt();
                match &mut self.stage {
                    Showing::Live(live) => live.step(),
                    Showing::Recorded(recorded) => {
                        recorded.advance()?;
                    }
                    Showing::Gallery | Showing::Broken(_) => {}
                }
            }
            Order::Restart => {
                self.colors.range = None;
                match &mut self.stage {
                    Showing::Live(live) => live.restart()?,
                    Showing::Recorded(recorded) => recorded.seek(0)?,
                    Showing::Gallery | Showing::Broken(_) => {}
                }
                self.relay();
            }
            Order::Speed { value } => {
                let (value, now) = (value.clamp(SPEEDS.0, SPEEDS.1), Instant::now());
                match &mut self.stage {
                    Showing::Live(live) => live.pace.set_speed(value, now, live.world.time()),
                    Showing::Recorded(recorded) => {
                        recorded.pace.set_speed(value, now, recorded.now.frame.time);
                    }
                    Showing::Gallery | Showing::Broken(_) => {}
                }
            }
            Order::Color { by } => {
                self.colors.by = by.and_then(|name| name.parse().ok());
                self.colors.range = None;
            }
            Order::FitColors => self.colors.range = None,
            Order::Open { name } => self.open_named(&name),
            Order::Gallery => {
                (self.stage, self.watch) = (Showing::Gallery, None);
                self.name.clear();
                self.show();
            }
            Order::Mode => {
                let next = modes::next(&self.options.gallery, &self.name);
                if let Some(name) = next.map(|scene| scene.name.clone()) {
                    let runs = matches!(&self.stage, Showing::Live(live) if live.pace.runs());
                    self.open_named(&name);
                    if runs {
                        self.go();
                    }
                }
            }
            Order::Seek { frame } => {
                if let Showing::Recorded(recorded) = &mut self.stage {
                    recorded.seek(frame)?;
                    recorded.pace.reset(Instant::now(), recorded.now.frame.time);
                }
            }
            Order::Set { knob, value } => {
                // Of many values of one slider the last counts.
                self.values.retain(|(name, _)| *name != knob);
                self.values.push((knob, value));
            }
            order => self.lay_hands(order)?,
        }
        Ok(())
    }

    /// What hands do to a scene.
    fn lay_hands(&mut self, order: Order) -> Result<(), SimError> {
        let Showing::Live(live) = &mut self.stage else { return Ok(()) };
        match order {
            Order::Take { strand, point, to } => live.take((strand, point), to),
            Order::Move { to } => {
                if let Some(hand) = &mut live.hand {
                    hand.lead(to);
                }
                Ok(())
            }
            Order::Drop => live.let_go(),
            Order::Fix { strand, point, fixed } => {
                live.fix((strand, point), fixed)?;
                self.relay();
                Ok(())
            }
            Order::Save => self.save(),
            _ => Ok(()),
        }
    }

    fn save(&mut self) -> Result<(), SimError> {
        let Showing::Live(live) = &mut self.stage else { return Ok(()) };
        let path = self.options.what.as_ref().filter(|_| self.name.is_empty());
        let (folder, stem) =
            (path.and_then(|path| path.parent()), path.and_then(|p| p.file_stem()));
        let own = self.name.rsplit('/').next().unwrap_or_default();
        let stem = stem.map_or(own.to_owned(), |stem| stem.to_string_lossy().into_owned());
        let folder = folder.unwrap_or(&self.options.folder);
        let (path, exact) = live.save(folder, &stem)?;
        let note = json!({ "is": "saved", "file": path.display().to_string(), "exact": exact });
        self.hub.note(&note.to_string());
        Ok(())
    }

    fn go(&mut self) {
        let now = Instant::now();
        match &mut self.stage {
            Showing::Live(live) if live.failure.is_none() => {
                live.pace.start(now, live.world.time());
            }
            Showing::Recorded(recorded) => recorded.pace.start(now, recorded.now.frame.time),
            _ => {}
        }
    }

    fn halt(&mut self) {
        match &mut self.stage {
            Showing::Live(live) => live.pace.stop(),
            Showing::Recorded(recorded) => recorded.pace.stop(),
            Showing::Gallery | Showing::Broken(_) => {}
        }
    }

    /// Looks whether files have changed.
    fn look(&mut self) {
        let now = Instant::now();
        if let Showing::Recorded(recorded) = &mut self.stage
            && recorded.look(now)
        {
            self.is_new[1] = true;
        }
        if self.watch.as_mut().is_some_and(|watch| watch.has_changed(now)) {
            self.open();
        }
    }

    /// Moves what is shown, as far as it is time to: by steps until a frame is due.
    fn advance(&mut self) {
        let begin = Instant::now();
        loop {
            let moved = match &mut self.stage {
                Showing::Live(live) => step(live),
                Showing::Recorded(recorded) => {
                    let wait = recorded.pace.wait(Instant::now(), recorded.now.frame.time);
                    wait == Some(Duration::ZERO)
                        && recorded.advance().unwrap_or_else(|error| {
                            tracing::warn!(%error, "a frame cannot be read");
                            false
                        })
                }
                Showing::Gallery | Showing::Broken(_) => false,
            };
            if !moved {
                return;
            }
            self.is_new = [true; 2];
            if begin.elapsed() >= FRAME {
                return;
            }
        }
    }

    /// Sends what is new to the pages that wait for it.
    fn publish(&mut self) {
        let now = Instant::now();
        if self.is_new[0] && now - self.framed >= FRAME && self.hub.wants_frame() {
            if let Some(frame) = self.stage.frame(self.layout, &mut self.colors) {
                self.hub.publish_frame(frame);
            }
            self.is_new[0] = false;
            self.framed = now;
        }
        if self.is_new[1] && now - self.told >= STATE {
            let pages = self.hub.count();
            let state = state::state(&mut self.stage, &self.colors, pages, now);
            self.hub.publish_state(&state);
            self.is_new[1] = false;
            self.told = now;
        }
    }
}

/// Takes a step if it is time to.
fn step(live: &mut Live) -> bool {
    let due = live.pace.wait(Instant::now(), live.world.time()) == Some(Duration::ZERO);
    if due {
        live.step();
    }
    due
}
