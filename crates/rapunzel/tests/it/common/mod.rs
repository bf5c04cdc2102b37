//! A small scene, and the program as a process.
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Three short hairs that swing: half a second in 510 steps and 16 frames.
pub(crate) const SCENE: &str = "(
    format: 1, name: \"test\", seed: 3, duration: 0.5,
    fibers: [(
        length: 0.05, segments: 8, section: Circle(radius: 4e-5), damping_time: 1e-3,
        shape: Helix(radius: 0.005, pitch: 0.02),
        arrangement: Lock(count: 2, radius: 0.003, curvature_variation: 0.1),
        motion: Swing(angle: 30, radius: 0.05, period: 0.2),
    )],
    stepper: (dt: 0.001),
    output: (formats: [Usd, Hair, Pov], probes: [(quantity: Velocity)]),
)";

pub(crate) fn rapunzel() -> Command {
    Command::new(env!("CARGO_BIN_EXE_rapunzel"))
}

/// A command that runs `scene` into `out`.
pub(crate) fn run_in(scene: &Path, out: &Path) -> Command {
    let mut command = rapunzel();
    command.arg("run").arg(scene).arg("--out").arg(out);
    command
}

pub(crate) fn scene_file(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("scene.ron");
    fs::write(&path, text).expect("writable");
    path
}

/// Waits until a file is there.
pub(crate) fn wait_for(path: &Path) {
    for _ in 0..3000 {
        if path.exists() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{} did not appear", path.display());
}
