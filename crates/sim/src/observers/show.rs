use crate::scene::{Format, Motion, Moves, Object, Scene, Wind};
use crate::{Scenery, World};
use rapunzel_studio::sheet::Support;

/// What frames show.
#[derive(Debug)]
pub(crate) struct Show {
    /// Formats of frames beside the files for ParaView.
    pub(crate) formats: Vec<Format>,
    /// What there is beside points of strands.
    pub(crate) scenery: Scenery,
    pub(crate) objects: Objects,
    /// Which previews show.
    pub(crate) wind: Wind,
}

/// Which files hold the objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Objects {
    /// There are none.
    None,
    /// One for all frames: none moves.
    Once,
    /// One for each frame.
    Always,
}

impl Show {
    /// What frames show of a scene and its world.
    pub(crate) fn of(scene: &Scene, world: &World) -> Self {
        let springs = scene.mass_spring.as_ref();
        let wind = springs.map_or(scene.environment.wind, |springs| springs.wind);
        let scenery = world.stepper().scenery();
        let (formats, objects) = (scene.output.formats.clone(), Objects::of(&scene.objects));
        Self { formats, scenery, objects, wind }
    }

    /// What holds the strands at a time, s.
    pub(crate) fn supports(&self, time: f64) -> Vec<Support> {
        let now = self.scenery.supports.iter().filter(|(_, times)| times.contains(&time));
        now.map(|(support, _)| *support).collect()
    }
}

impl Objects {
    pub(crate) fn of(objects: &[Object]) -> Self {
        let still = |one: &Object| one.moves == Moves::Led && one.motion == Motion::Fixed;
        match objects {
            [] => Self::None,
            _ if objects.iter().all(still) => Self::Once,
            _ => Self::Always,
        }
    }

    /// The number of the file for a frame.
    pub(crate) fn file(self, frame: usize) -> Option<usize> {
        match self {
            Self::None => None,
            Self::Once => Some(0),
            Self::Always => Some(frame),
        }
    }

    /// How many files there are of so many frames.
    pub(crate) fn count(self, frames: u64) -> u64 {
        match self {
            Self::None => 0,
            Self::Once => 1,
            Self::Always => frames,
        }
    }
}
