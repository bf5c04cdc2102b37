//! What pages ask for, done between steps.

use crate::driver::Driver;
use crate::frame::Colors;
use crate::modes;
use crate::order::Order;
use crate::stage::Showing;
use rapunzel_sim::SimError;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Slowest and fastest speed.
const SPEEDS: (f64, f64) = (1e-4, 100.0);

impl Driver {
    pub(crate) fn obey(&mut self, order: Order) -> Result<(), SimError> {
        match order {
            Order::Drawn { .. } | Order::Control | Order::Picture(_) | Order::EndPicture => {}
            Order::Show(shows) => self.shows = shows,
            Order::Over { over } => {
                if let Showing::Recorded(recorded) = &mut self.stage {
                    recorded.lay(over);
                }
            }
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
                // What comes next is something else, with a look of its own.
                self.colors = Colors::default();
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
            Order::TakeObject { object, at } => live.take_object(object, at),
            Order::Move { to } => {
                live.lead(to);
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
        let (folder, stem) = self.place();
        let Showing::Live(live) = &mut self.stage else { return Ok(()) };
        let (path, exact) = live.save(&folder, &stem)?;
        let note = json!({ "is": "saved", "file": path.display().to_string(), "exact": exact });
        self.hub.note(&note.to_string());
        Ok(())
    }

    /// The folder in which what is shown is saved, and how its name begins.
    pub(crate) fn place(&self) -> (PathBuf, String) {
        let path = self.options.what.as_ref().filter(|_| self.name.is_empty());
        let own = self.name.rsplit('/').next().unwrap_or_default();
        let stem = path.and_then(|path| path.file_stem());
        let stem = stem.map_or(own.to_owned(), |stem| stem.to_string_lossy().into_owned());
        let folder = path.and_then(|path| path.parent()).unwrap_or(&self.options.folder);
        (folder.to_owned(), stem)
    }

    pub(crate) fn go(&mut self) {
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
}
