//! Runs of scenes, and what is kept of them.

use rapunzel_repro::Fallible;
use rapunzel_repro::plot::Picture;
use rapunzel_sim::{Plan, Scene, World};
use std::fs;
use std::path::Path;

/// Reads a scene of the folder `scenes`.
pub(crate) fn scene(name: &str) -> Fallible<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let path = folder.join(name).with_extension("ron");
    let scene = Scene::from_ron(&fs::read_to_string(&path)?)?;
    Ok(scene.seen_from(path.parent().unwrap_or(&folder)))
}

/// Runs a scene; `observe` sees its start and what every step leaves.
pub(crate) fn play(scene: &Scene, mut observe: impl FnMut(&World)) -> Fallible<()> {
    let plan = Plan::new(scene);
    let mut world = World::build(scene)?;
    observe(&world);
    while world.steps() < plan.steps {
        let dt = plan.step_after(world.steps());
        world.step(dt)?;
        observe(&world);
    }
    Ok(())
}

/// Pictures of all fibers at given instants.
pub(crate) struct Film {
    times: Vec<f64>,
    pub(crate) pictures: Vec<Picture>,
}

impl Film {
    /// A film that takes pictures at `times`, s, in their order.
    pub(crate) fn at(times: &[f64]) -> Self {
        Self { times: times.to_vec(), pictures: Vec::new() }
    }

    /// Takes a picture when it is time; true if it did.
    pub(crate) fn observe(&mut self, world: &World) -> bool {
        let due = self.times.get(self.pictures.len());
        // Half of the finest step in use, so that rounding does not delay a picture.
        if due.is_none_or(|t| world.time() < t - 5e-6) {
            return false;
        }
        let fibers = (0..world.assembly().fibers().len()).map(|i| world.state(i).positions);
        let caption = format!("t = {:.3} s", world.time());
        self.pictures.push(Picture { caption, fibers: fibers.collect() });
        true
    }
}
