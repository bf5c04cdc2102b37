//! A scene that runs.

use crate::GalleryScene;
use crate::clock::WallPace;
use crate::drag::ObjectDrag;
use crate::extras::{Extras, Shows, boxes, pushes};
use crate::field_lines::{FieldLine, field_lines};
use crate::frame::{Colors, FrameHead, ShownPoints, frame};
use crate::hands::{self, Hand};
use crate::knobs::Knob;
use crate::layout::{Parts, layout};
use nalgebra::Isometry3;
use rapunzel_export::surface::Placed;
use rapunzel_export::{Frame, Strand};
use rapunzel_scene::{Moves, Plan, Scene};
use rapunzel_sim::{BuildStage, SimError, Snapshot, StepReport, World};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Ending of the name of a file that holds where a scene was left.
pub(crate) const KEPT: &str = "checkpoint";

/// A scene with its world.
pub(crate) struct Live {
    /// The scene as its file has it, with what hands and sliders changed.
    pub(crate) scene: Scene,
    /// The scene as its file has it.
    original: Scene,
    /// Where its files are.
    pub(crate) folder: PathBuf,
    /// Names and texts of files that ship with it, for which the folder is only lent.
    pub(crate) files: Vec<(String, String)>,
    pub(crate) lent: Option<TempDir>,
    pub(crate) world: World,
    pub(crate) plan: Plan,
    start: Snapshot,
    pub(crate) pace: WallPace,
    /// Of the last step.
    pub(crate) report: StepReport,
    pub(crate) step_time: Duration,
    /// What failed, if something did: it stands still until it is restarted.
    pub(crate) failure: Option<String>,
    pub(crate) hand: Option<Hand>,
    pub(crate) drag: Option<ObjectDrag>,
    /// Why it does not go on from where it was left, if it should.
    pub(crate) unkept: Option<String>,
    /// Field lines, and the number of steps after which they are these.
    lines: Option<(u64, Vec<FieldLine>)>,
    /// What the last frame showed.
    shown: ShownPoints,
    /// Whether sliders were moved after the start, which a saved scene does not tell.
    pub(crate) is_bent: bool,
}

impl Live {
    /// Builds the world of a scene whose files are in a folder.
    pub(crate) fn new(
        scene: Scene,
        folder: &Path,
        at: &dyn Fn(BuildStage),
    ) -> Result<Self, SimError> {
        let world = World::build_observed(&scene.clone().seen_from(folder), at)?;
        Ok(Self {
            original: scene.clone(),
            folder: folder.to_owned(),
            files: Vec::new(),
            lent: None,
            plan: Plan::new(&scene),
            start: world.snapshot(),
            world,
            scene,
            pace: WallPace::new(),
            report: StepReport::default(),
            step_time: Duration::ZERO,
            failure: None,
            hand: None,
            drag: None,
            unkept: None,
            lines: None,
            shown: ShownPoints::default(),
            is_bent: false,
        })
    }

    /// Builds a scene of the gallery; one that names no files is seen from `folder`.
    pub(crate) fn of_gallery(
        item: &GalleryScene,
        scene: Scene,
        folder: &Path,
        at: &dyn Fn(BuildStage),
    ) -> Result<Self, SimError> {
        let lent = item.lay_out().map_err(|source| SimError::Io {
            action: "write",
            path: std::env::temp_dir(),
            source,
        })?;
        let mut live = Self::new(scene, lent.as_ref().map_or(folder, TempDir::path), at)?;
        (live.files, live.lent) = (item.files.clone(), lent);
        Ok(live)
    }

    /// Moves all by a step.
    pub(crate) fn step(&mut self) {
        if self.failure.is_some() {
            return;
        }
        let (begin, dt) = (Instant::now(), self.plan.dt);
        let stepped = self.act(dt).and_then(|()| self.world.step(dt));
        match stepped {
            Ok(report) => self.report = report,
            Err(error) => self.fail(&error),
        }
        self.step_time = begin.elapsed();
        if self.failure.is_none() && !self.world.energy().total().is_finite() {
            self.fail(&SimError::NotFinite { time: self.world.time() });
        }
    }

    fn act(&mut self, dt: f64) -> Result<(), SimError> {
        if let Some(drag) = &self.drag {
            drag.act(&mut self.scene, &mut self.world, dt)?;
        }
        match &mut self.hand {
            Some(hand) => hand.act(&mut self.scene, &mut self.world, dt),
            None => Ok(()),
        }
    }

    fn fail(&mut self, error: &SimError) {
        self.failure = Some(error.to_string());
        self.pace.stop();
    }

    /// Back to the start, without what hands did; sliders stay.
    pub(crate) fn restart(&mut self) -> Result<(), SimError> {
        (self.hand, self.drag, self.lines) = (None, None, None);
        self.scene.objects = self.original.objects.clone();
        self.scene.grips = self.original.grips.clone();
        if let (Some(now), Some(first)) = (&mut self.scene.mass_spring, &self.original.mass_spring)
        {
            now.holds = first.holds.clone();
            // Holds of hands are in the system too, which is soon built.
            self.world = World::build(&self.scene.clone().seen_from(&self.folder))?;
            self.start = self.world.snapshot();
        } else {
            self.world.restore(&self.start)?;
            for (index, object) in self.scene.objects.iter().enumerate() {
                if object.moves == Moves::Led {
                    self.world.lead(index, object)?;
                }
            }
            self.world.set_grips(self.scene.grips.clone())?;
        }
        self.pace.reset(Instant::now(), self.world.time());
        (self.failure, self.is_bent) = (None, false);
        Ok(())
    }

    /// Gives sliders other values; where the scene then cannot be built, all stays as it is.
    pub(crate) fn set(&mut self, values: &[(String, f64)]) -> Result<(), SimError> {
        let mut changed = self.scene.clone();
        for (name, value) in values {
            if let Some(knob) = Knob::of(&changed, name) {
                knob.set(&mut changed, *value);
            }
        }
        let mut world = World::build(&changed.clone().seen_from(&self.folder))?;
        let now = self.world.snapshot();
        let is_start = self.world.steps() == 0;
        if is_start {
            self.start = world.snapshot();
        } else {
            world.restore(&now)?;
        }
        self.is_bent |= !is_start;
        (self.scene, self.world) = (changed, world);
        Ok(())
    }

    /// A hand takes hold of a point of a strand.
    pub(crate) fn take(&mut self, at: (usize, usize), to: [f64; 3]) -> Result<(), SimError> {
        self.let_go()?;
        self.hand = Hand::take(&mut self.scene, &self.world, at, to, self.plan.dt);
        Ok(())
    }

    /// A hand takes hold of an object at a place.
    pub(crate) fn take_object(&mut self, object: usize, at: [f64; 3]) -> Result<(), SimError> {
        self.let_go()?;
        let can = self.scene.charging.is_none();
        self.drag = can.then(|| ObjectDrag::take(&self.scene, object, at)).flatten();
        Ok(())
    }

    /// Moves the hand.
    pub(crate) fn lead(&mut self, to: [f64; 3]) {
        self.hand.iter_mut().for_each(|hand| hand.lead(to));
        self.drag.iter_mut().for_each(|drag| drag.lead(to));
    }

    pub(crate) fn let_go(&mut self) -> Result<(), SimError> {
        self.drag = None;
        match self.hand.take() {
            Some(hand) => hand.let_go(&mut self.scene, &mut self.world),
            None => Ok(()),
        }
    }

    pub(crate) fn fix(&mut self, at: (usize, usize), fixed: bool) -> Result<(), SimError> {
        hands::fix(&mut self.scene, &mut self.world, at, fixed)
    }

    /// Whether hands or sliders have changed the scene.
    pub(crate) fn is_changed(&self) -> bool {
        self.scene != self.original
    }

    pub(crate) fn layout(&self, number: u32) -> Vec<u8> {
        let stepper = self.world.stepper();
        let strands: Vec<_> = stepper.strands().collect();
        let scenery = stepper.scenery();
        let time = self.world.time();
        let supports: Vec<_> = scenery
            .supports
            .iter()
            .filter(|(_, times)| times.contains(&time))
            .map(|(support, _)| *support)
            .collect();
        let objects: Vec<_> = self.world.surfaces().collect();
        layout(&Parts {
            number,
            strands: &strands,
            prims: &scenery.prims,
            supports: &supports,
            objects: &objects,
            springs: self.scene.mass_spring.is_some(),
            first_of_two: None,
        })
    }

    pub(crate) fn frame(&mut self, layout: u32, colors: &mut Colors, shows: Shows) -> Vec<u8> {
        let (number, time) = (self.world.steps(), self.world.time());
        let poses: Vec<Isometry3<f64>> = self.world.poses().collect();
        let head = FrameHead { layout, number, time };
        self.shown.read(self.world.stepper(), colors.by);
        let mut extras = Extras::default();
        // Of what is on demand only these need more than points.
        let whole = shows.volumes.is_some() || shows.field;
        let strands: Vec<_> =
            if whole { self.world.stepper().strands().collect() } else { Vec::new() };
        if shows.contacts {
            extras.pushes = pushes(self.world.touches());
        }
        if let Some(level) = shows.volumes {
            extras.boxes = boxes(&strands, level);
        }
        if shows.field {
            extras.lines = self.lines(number, &strands);
        }
        let mut bytes = frame(head, &self.shown, &poses, colors);
        extras.write(&mut bytes);
        bytes
    }

    /// Field lines, new ones if there was a step since the last.
    fn lines(&mut self, number: u64, strands: &[Strand]) -> Vec<FieldLine> {
        if self.lines.as_ref().is_none_or(|(of, _)| *of != number) {
            let lines = field_lines(&self.world, strands).unwrap_or_else(|error| {
                tracing::warn!(%error, "there are no field lines");
                Vec::new()
            });
            self.lines = Some((number, lines));
        }
        self.lines.as_ref().map(|(_, lines)| lines.clone()).unwrap_or_default()
    }

    /// Strands and objects as a picture shows them; sections as round.
    pub(crate) fn picture(&self) -> (Frame, Vec<Placed>, Option<f64>) {
        let strands = self.world.stepper().strands().collect();
        let frame = Frame { index: 0, time: self.world.time(), strands };
        (frame, self.world.surfaces().collect(), None)
    }
}
