//! A hand that drags objects whose motion is given, and what of it is written into the scene.

use nalgebra::Vector3;
use rapunzel_scene::{Keyframe, Motion, Moves, Object, Scene};
use rapunzel_sim::{SimError, World};

/// An object follows a hand within so long, s, and no faster than this, m/s: what it meets is to
/// have the time to give way.
const FOLLOW: f64 = 1.0 / 60.0;
const FASTEST_OBJECT: f64 = 1.0;
/// An object stands still in this part of a step at its start and at its end, so that a run of the
/// saved scene, whose clock may round otherwise, sees it at the same place to the last bit.
const REST: f64 = 0.25;

/// Objects that a hand drags.
#[derive(Debug)]
pub(crate) struct ObjectDrag {
    /// The object under the hand, and those that go with it.
    objects: Vec<usize>,
    /// From the place of the hand to the displacement of the objects, m.
    offset: Vector3<f64>,
    /// Displacement that is asked for, m.
    to: Vector3<f64>,
}

impl ObjectDrag {
    /// Takes hold of an object at a place, and of those that have its motion, such as the teeth of
    /// a comb; none if it moves freely or is not there.
    pub(crate) fn take(scene: &Scene, object: usize, at: [f64; 3]) -> Option<Self> {
        let own = scene.objects.get(object).filter(|own| own.moves == Moves::Led)?;
        let with = |other: &Object| {
            own.motion != Motion::Fixed && other.motion == own.motion && other.drag == own.drag
        };
        let objects = scene.objects.iter().enumerate();
        let objects = objects.filter(|(index, other)| *index == object || with(other));
        let to = dragged(own).1;
        Some(Self {
            objects: objects.map(|(index, _)| index).collect(),
            offset: to - Vector3::from(at),
            to,
        })
    }

    /// The object that was taken hold of, or the first of those that go with it.
    pub(crate) fn object(&self) -> usize {
        self.objects.first().copied().unwrap_or_default()
    }

    /// Moves the hand.
    pub(crate) fn lead(&mut self, to: [f64; 3]) {
        self.to = self.offset + Vector3::from(to);
    }

    /// Writes what the hand does from now on into the scene and the world, before a step of `dt`.
    pub(crate) fn act(
        &self,
        scene: &mut Scene,
        world: &mut World,
        dt: f64,
    ) -> Result<(), SimError> {
        let time = world.time();
        for &index in &self.objects {
            let Some(object) = scene.objects.get_mut(index) else { continue };
            let (last, from) = dragged(object);
            let steps = (FOLLOW / dt).ceil().max(1.0);
            let way = (self.to - from).cap_magnitude(FASTEST_OBJECT * (steps - 2.0 * REST) * dt);
            if time < last || way.norm() < 1e-9 {
                continue;
            }
            let key = |time: f64, place: Vector3<f64>| Keyframe {
                time,
                translation: place.into(),
                rotation: [0.0; 3],
            };
            if object.drag.is_empty() {
                object.drag.push(key(0.0, Vector3::zeros()));
            }
            object.drag.push(key(time + REST * dt, from));
            object.drag.push(key(time + (steps - REST) * dt, from + way));
            world.lead(index, object)?;
        }
        Ok(())
    }
}

/// Time and place of the last displacement of an object, s and m.
fn dragged(object: &Object) -> (f64, Vector3<f64>) {
    let last = object.drag.last();
    last.map_or((0.0, Vector3::zeros()), |key| (key.time, key.translation.into()))
}
