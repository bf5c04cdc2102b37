//! What is kept of a scene that ran: the scene with all that was changed, and where it stood.

use crate::live::{KEPT, Live};
use rapunzel_scene::Scene;
use rapunzel_sim::{SimError, keep_state, read_text, take_up_state};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

impl Live {
    /// Saves the scene with all that was changed under a name that no file has, and gives that and
    /// whether a run of it goes as all went here. The files that ship with it come beside it.
    pub(crate) fn save(&mut self, folder: &Path, stem: &str) -> Result<(PathBuf, bool), SimError> {
        self.write(folder, &format!("{stem}-changed")).map(|(path, _)| (path, !self.is_bent))
    }

    /// Saves the scene, and beside it where it stands, so that it can be gone on with to the same
    /// bits.
    pub(crate) fn keep(&mut self, folder: &Path, stem: &str) -> Result<PathBuf, SimError> {
        let (path, scene) = self.write(folder, &format!("{stem}-kept"))?;
        let whole = std::path::absolute(&path).unwrap_or_else(|_| path.clone());
        let seen = scene.seen_from(whole.parent().unwrap_or(folder));
        keep_state(&seen, &self.world, self.is_bent, &whole.with_extension(KEPT))?;
        Ok(path)
    }

    /// Goes on from where the scene was left, if that was kept in a file; where it cannot be, why
    /// is kept instead.
    pub(crate) fn take_up(&mut self, path: &Path) {
        if !path.is_file() {
            return;
        }
        let seen = self.scene.clone().seen_from(&self.folder);
        match take_up_state(&seen, &mut self.world, path) {
            Ok(is_bent) => self.is_bent = is_bent,
            Err(error) => self.unkept = Some(error.to_string()),
        }
    }

    /// Writes the scene, as long as it ran at least, under the first name that is free.
    fn write(&mut self, folder: &Path, stem: &str) -> Result<(PathBuf, Scene), SimError> {
        self.let_go()?;
        let mut scene = self.scene.clone();
        let frames = (self.world.time() * self.plan.frame_rate).ceil();
        scene.duration = scene.duration.max(frames / self.plan.frame_rate);
        let text = scene.to_ron()?;
        let io = |path: &Path, source| SimError::Io { action: "write", path: path.into(), source };
        for (name, text) in &self.files {
            let path = folder.join(name);
            match File::create_new(&path) {
                Ok(mut file) => {
                    file.write_all(text.as_bytes()).map_err(|error| io(&path, error))?;
                }
                // A file that is the same serves as well.
                Err(_) if read_text(&path).is_ok_and(|there| there == *text) => {}
                Err(error) => return Err(io(&path, error)),
            }
        }
        let mut number = 1;
        loop {
            let path = folder.join(format!("{stem}-{number}.ron"));
            match File::create_new(&path) {
                Ok(mut file) => {
                    file.write_all(text.as_bytes()).map_err(|error| io(&path, error))?;
                    return Ok((path, scene));
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
                Err(error) => return Err(io(&path, error)),
            }
        }
    }
}
