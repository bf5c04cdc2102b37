//! The thread that moves what is shown, and does what pages ask for between steps.

use crate::darkroom::{Darkroom, Sitting};
use crate::extras::Shows;
use crate::frame::Colors;
use crate::hub::{Event, Hub, PageId};
use crate::live::Live;
use crate::options::Options;
use crate::order::Order;
use crate::stage::Showing;
use crate::state;
use crate::watch::Watch;
use crate::wish::PictureWish;
use rapunzel_sim::style::GrowthStage;
use rapunzel_sim::{BuildStage, ShownStage, SimError};
use rapunzel_studio::{ColorRange, StageOptions};
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Frames follow each other no faster.
const FRAME: Duration = Duration::from_millis(16);
/// Nor faster than takes this part of the time, but not slower than this for that: with the rest of
/// a step, which they wait for, still 15 a second.
const SHARE: u32 = 30;
const SLOWEST_FRAME: Duration = Duration::from_millis(50);
/// While a hand moves they may take this part of the time, and follow each other as fast.
const SHARE_OF_HAND: u32 = 4;
/// How often pages are told how all stands.
const STATE: Duration = Duration::from_millis(100);
/// How long nothing is waited for at most.
const IDLE: Duration = Duration::from_millis(100);

/// What moves what is shown.
pub(crate) struct Driver {
    pub(crate) options: Options,
    pub(crate) hub: Arc<Hub>,
    events: Receiver<Event>,
    pub(crate) stage: Showing,
    /// Name of the scene of the gallery that is shown.
    pub(crate) name: String,
    pub(crate) watch: Option<Watch>,
    pub(crate) colors: Colors,
    pub(crate) shows: Shows,
    /// What draws pictures, once one was wished for.
    darkroom: Option<Darkroom>,
    /// Number of the layout.
    layout: u32,
    /// Whether something has changed since the last frame, and since the last state.
    is_new: [bool; 2],
    framed: Instant,
    /// What the last frame took.
    frame_cost: Duration,
    /// Whether a hand has moved since the last step, and whether a step has felt that since the
    /// last frame, which is to be seen soon.
    hand_moved: bool,
    hand_felt: bool,
    told: Instant,
    /// Values of sliders that are to be set.
    pub(crate) values: Vec<(String, f64)>,
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
            shows: Shows::default(),
            darkroom: None,
            layout: 0,
            is_new: [true; 2],
            framed: now,
            frame_cost: Duration::ZERO,
            hand_moved: false,
            hand_felt: false,
            told: now,
            values: Vec::new(),
        }
    }

    /// Goes on until the server ends.
    ///
    /// Gives the file of the scene that was left in the midst, if one was: beside it is where it
    /// stood.
    pub(crate) fn run(mut self) -> Option<PathBuf> {
        self.open();
        if self.options.runs {
            self.go();
        }
        while self.heed() {
            self.look();
            self.advance();
            self.publish();
        }
        let (folder, stem) = self.place();
        match &mut self.stage {
            Showing::Live(live) if live.world.steps() > 0 && live.failure.is_none() => {
                let kept = live.keep(&folder, &stem);
                kept.map_err(|error| tracing::error!(%error, "where it stood is not kept")).ok()
            }
            _ => None,
        }
    }

    /// Opens what the options name.
    fn open(&mut self) {
        self.name.clear();
        if let Some(path) = &self.options.what {
            let tell = teller(Arc::clone(&self.hub));
            self.watch = path.is_file().then(|| Watch::new(path));
            self.stage = Showing::open(path, self.options.beside.as_deref(), &tell);
        } else {
            self.stage = Showing::Gallery;
        }
        self.show();
    }

    /// Opens a scene of the gallery.
    pub(crate) fn open_named(&mut self, name: &str) {
        let Some(item) = self.options.gallery.iter().find(|item| item.name == name) else {
            return;
        };
        let Some(scene) = item.scene() else { return };
        let tell = teller(Arc::clone(&self.hub));
        self.watch = None;
        let tell = |stage| tell(ShownStage::Building(stage));
        self.stage = Showing::build(item, scene, &self.options.folder, &tell);
        name.clone_into(&mut self.name);
        self.show();
    }

    /// Shows what is on the stage from its beginning.
    pub(crate) fn show(&mut self) {
        self.colors.range = None;
        self.values.clear();
        self.relay();
    }

    /// Tells pages what is shown, and all of it that does not change from frame to frame.
    pub(crate) fn relay(&mut self) {
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
                Ok(Event::Picture(page, wish)) => self.draw(page, wish),
                Ok(Event::Order(order)) => {
                    if matches!(order, Order::Move { .. }) {
                        self.hand_moved = true;
                    } else {
                        self.is_new = [true; 2];
                    }
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
        let frame = if self.is_new[0] && self.hub.wants_frame() {
            self.between_frames().saturating_sub(now - self.framed)
        } else {
            IDLE
        };
        wait.unwrap_or(frame).min(frame)
    }

    /// Time between frames: what is simulated is to go on nearly as fast as without them.
    fn between_frames(&self) -> Duration {
        if self.hand_felt {
            return (SHARE_OF_HAND * self.frame_cost).min(FRAME);
        }
        // What a hand pulls follows it for some steps: a page shows the last of two frames.
        let fastest = if self.stage.is_held() { FRAME / 2 } else { FRAME };
        (SHARE * self.frame_cost).clamp(fastest, SLOWEST_FRAME)
    }

    /// Draws a picture of what is shown now for a page, or no more.
    fn draw(&mut self, page: PageId, wish: Option<PictureWish>) {
        let Some(wish) = wish else {
            self.darkroom.iter().for_each(|darkroom| darkroom.end(page));
            return;
        };
        if self.darkroom.is_none() {
            self.darkroom = Darkroom::start(Arc::clone(&self.hub));
        }
        let picture = self.stage.picture();
        if let (Some(darkroom), Some((frame, objects, ratio))) = (&self.darkroom, picture) {
            let coloring = self.colors.by.map(|by| {
                let range = self.colors.range;
                (by, range.unwrap_or_else(|| ColorRange::of(by.values(&frame))))
            });
            let radius = frame.strands.first().and_then(|strand| strand.radii.first());
            let thickness = wish.thickness(radius.copied().unwrap_or(1.0));
            let ground = !wish.plain;
            let options =
                StageOptions { ratio, coloring, thickness, ground, ..StageOptions::default() };
            darkroom.draw(Sitting { page, wish, frame, objects, options });
        }
    }

    pub(crate) fn complain(&self, error: &SimError) {
        let note = json!({ "is": "complaint", "message": error.to_string() });
        self.hub.note(&note.to_string());
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
            self.hand_felt |= std::mem::take(&mut self.hand_moved);
            if begin.elapsed() >= FRAME || self.hand_felt {
                return;
            }
        }
    }

    /// Sends what is new to the pages that wait for it.
    fn publish(&mut self) {
        let now = Instant::now();
        let is_due = now - self.framed >= self.between_frames();
        if self.is_new[0] && is_due && self.hub.wants_frame() {
            if let Some(frame) = self.stage.frame(self.layout, &mut self.colors, self.shows) {
                self.hub.publish_frame(frame);
            }
            (self.is_new[0], self.hand_felt) = (false, false);
            (self.framed, self.frame_cost) = (now, now.elapsed());
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

/// Tells pages that something is built, and from part to part what.
fn teller(hub: Arc<Hub>) -> impl Fn(ShownStage) {
    let tell = move |mut about: serde_json::Value| {
        about["is"] = "about".into();
        about["kind"] = "building".into();
        hub.show(&about.to_string(), None);
    };
    tell(json!({}));
    let grows = |stage: GrowthStage| match stage {
        GrowthStage::Surfaces => "surfaces",
        GrowthStage::Pores => "pores",
        GrowthStage::PreGuides => "pre_guides",
        GrowthStage::Guides => "guides",
        GrowthStage::Hairs => "hairs",
    };
    move |stage| {
        tell(match stage {
            ShownStage::Growing(stage)
            | ShownStage::Building(BuildStage::Growing { stage, .. }) => {
                json!({ "part": grows(stage) })
            }
            ShownStage::Building(BuildStage::MovingApart) => json!({ "part": "moving_apart" }),
            ShownStage::Building(BuildStage::Settling { done, most }) => {
                json!({ "part": "settling", "done": done, "most": most })
            }
        });
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
