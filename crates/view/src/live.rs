//! A scene that runs.

use crate::clock::WallPace;
use crate::frame::{Colors, FrameHead, frame};
use crate::hands::{self, Hand};
use crate::knobs::Knob;
use crate::layout::{Parts, layout};
use nalgebra::Isometry3;
use rapunzel_scene::{Plan, Scene};
use rapunzel_sim::{SimError, Snapshot, StepReport, World};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A scene with its world.
pub(crate) struct Live {
    /// The scene as its file has it, with what hands and sliders changed.
    pub(crate) scene: Scene,
    /// The scene as its file has it.
    original: Scene,
    /// Where its files are.
    folder: PathBuf,
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
    /// Whether sliders were moved after the start, which a saved scene does not tell.
    is_bent: bool,
}

impl Live {
    /// Builds the world of a scene whose files are in a folder.
    pub(crate) fn new(scene: Scene, folder: &Path) -> Result<Self, SimError> {
        let world = World::build(&scene.clone().seen_from(folder))?;
        Ok(Self {
            original: scene.clone(),
            folder: folder.to_owned(),
            plan: Plan::new(&scene),
            start: world.snapshot(),
            world,
            scene,
            pace: WallPace::new(),
            report: StepReport::default(),
            step_time: Duration::ZERO,
            failure: None,
            hand: None,
            is_bent: false,
        })
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
        self.hand = None;
        self.scene.grips = self.original.grips.clone();
        if let (Some(now), Some(first)) = (&mut self.scene.mass_spring, &self.original.mass_spring)
        {
            now.holds = first.holds.clone();
            // Holds of hands are in the system too, which is soon built.
            self.world = World::build(&self.scene.clone().seen_from(&self.folder))?;
            self.start = self.world.snapshot();
        } else {
            self.world.restore(&self.start)?;
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

    pub(crate) fn let_go(&mut self) -> Result<(), SimError> {
        match self.hand.take() {
            Some(hand) => hand.let_go(&mut self.scene, &mut self.world),
            None => Ok(()),
        }
    }

    pub(crate) fn fix(&mut self, at: (usize, usize), fixed: bool) -> Result<(), SimError> {
        hands::fix(&mut self.scene, &mut self.world, at, fixed)
    }

    /// Saves the scene with all that was changed under a name that no file has, and gives that and
    /// whether a run of it goes as all went here.
    pub(crate) fn save(&mut self, folder: &Path, stem: &str) -> Result<(PathBuf, bool), SimError> {
        self.let_go()?;
        let mut scene = self.scene.clone();
        let frames = (self.world.time() * self.plan.frame_rate).ceil();
        scene.duration = scene.duration.max(frames / self.plan.frame_rate);
        let text = scene.to_ron()?;
        let io = |path: &Path, source| SimError::Io { action: "write", path: path.into(), source };
        let mut number = 1;
        loop {
            let path = folder.join(format!("{stem}-changed-{number}.ron"));
            match File::create_new(&path) {
                Ok(mut file) => {
                    file.write_all(text.as_bytes()).map_err(|error| io(&path, error))?;
                    return Ok((path, !self.is_bent));
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
                Err(error) => return Err(io(&path, error)),
            }
        }
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
        })
    }

    pub(crate) fn frame(&self, layout: u32, colors: &mut Colors) -> Vec<u8> {
        let (number, time) = (self.world.steps(), self.world.time());
        let poses: Vec<Isometry3<f64>> = self.world.poses().collect();
        let head = FrameHead { layout, number, time };
        frame(head, self.world.stepper().strands(), &poses, colors)
    }
}
