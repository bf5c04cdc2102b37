//! Where a scene was left that is not run into a folder.

use crate::checkpoint::{Checkpoint, scene_hash};
use crate::{Scene, SimError, Statistics, World};
use std::path::Path;

/// Writes the state of the world of a scene into a file, atomically: from it the scene goes on bit
/// for bit. `is_bent` is kept with it: whether the world has come there otherwise than the scene
/// says.
///
/// # Errors
/// [`SimError::Io`] for the file and for those that the scene names, which count too.
pub fn keep_state(
    scene: &Scene,
    world: &World,
    is_bent: bool,
    path: &Path,
) -> Result<(), SimError> {
    let marks = [u64::from(is_bent)];
    Checkpoint::write(world, scene_hash(scene)?, Statistics::default(), &marks, path)
}

/// Puts the world of a scene into the state in a file of [`keep_state`], and tells whether it has
/// come there otherwise than the scene says.
///
/// # Errors
/// [`SimError::DifferentScene`] for a state of another scene, [`SimError::Checkpoint`] for a
/// damaged file and for one of another version.
pub fn take_up_state(scene: &Scene, world: &mut World, path: &Path) -> Result<bool, SimError> {
    let kept = Checkpoint::read(path)?;
    if kept.scene != scene_hash(scene)? {
        return Err(SimError::DifferentScene(path.to_owned()));
    }
    world.restore(&kept.snapshot)?;
    Ok(kept.marks.first().is_some_and(|bent| *bent != 0))
}
