//! A stepper of the user's own: a pendulum, which runs with frames, probes, tables and checkpoints
//! as everything else does.

use nalgebra::{Point3, Rotation3, Vector3};
use rapunzel_export::Strand;
use rapunzel_rod_dynamic::Energy;
use rapunzel_sim::{
    Cancel, Control, Existing, Outcome, RunFolder, Scene, SimError, StepReport, Stepper, Summary,
    Surroundings, World, run,
};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

const LENGTH: f64 = 0.5;
const MASS: f64 = 0.2;

/// A mass on a weightless rod that swings in the plane of x and z, stepped by Verlet's method.
struct Pendulum {
    /// From straight down, rad.
    angle: f64,
    /// rad/s.
    rate: f64,
    /// Steps taken.
    steps: f64,
}

impl Pendulum {
    fn at(&self, along: f64) -> Point3<f64> {
        Point3::new(self.angle.sin(), 0.0, -self.angle.cos()) * (along * LENGTH)
    }
}

impl Stepper for Pendulum {
    fn step(&mut self, around: &mut Surroundings, dt: f64) -> Result<StepReport, SimError> {
        let gravity = around.gravity();
        let pull = |angle: f64| {
            let down = Vector3::new(angle.cos(), 0.0, angle.sin());
            gravity.dot(&down) / LENGTH
        };
        let half = self.rate + 0.5 * dt * pull(self.angle);
        self.angle += dt * half;
        self.rate = half + 0.5 * dt * pull(self.angle);
        self.steps += 1.0;
        Ok(StepReport::of_one(0, 0, 0))
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        Energy {
            kinetic: 0.5 * MASS * (LENGTH * self.rate).powi(2),
            elastic: 0.0,
            gravitational: -MASS * gravity.dot(&self.at(1.0).coords),
        }
    }

    fn strand_nodes(&self) -> Vec<usize> {
        vec![2]
    }

    fn strands(&self) -> Box<dyn Iterator<Item = Strand> + '_> {
        let velocity = self.node(0, None).1;
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), PI - self.angle);
        Box::new(std::iter::once(Strand {
            points: vec![Point3::origin(), self.at(1.0)],
            radii: vec![0.01; 2],
            velocities: vec![Vector3::zeros(), velocity],
            frames: vec![turn],
            curvatures: vec![Vector3::zeros(); 2],
            forces: vec![Vector3::zeros()],
            contact_forces: vec![Vector3::zeros(); 2],
            charges: vec![0.0; 2],
        }))
    }

    fn node(&self, _: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        let along = if node == Some(0) { 0.0 } else { 1.0 };
        let across = Vector3::new(self.angle.cos(), 0.0, self.angle.sin());
        (self.at(along), across * (along * LENGTH * self.rate))
    }

    fn save(&self) -> Box<dyn Iterator<Item = Vec<f64>> + '_> {
        Box::new(std::iter::once(vec![self.angle, self.rate, self.steps]))
    }

    fn restore(&mut self, saved: &[Vec<f64>], _: f64) -> Result<(), SimError> {
        let &[angle, rate, steps] = &saved.concat()[..] else {
            return Err(SimError::Stepper("three numbers are a pendulum".into()));
        };
        *self = Self { angle, rate, steps };
        Ok(())
    }

    fn energy_columns(&self) -> Vec<String> {
        vec!["angle (rad)".to_owned()]
    }

    fn energy_row(&self) -> Vec<f64> {
        vec![self.angle]
    }

    fn tables(&self) -> Vec<(&'static str, Vec<String>)> {
        vec![("swings.csv", vec!["rate (rad/s)".to_owned(), "steps".to_owned()])]
    }

    fn row(&self, _: usize) -> Vec<f64> {
        vec![self.rate, self.steps]
    }
}

/// The scene says how long, in which steps and what is written; its fibre is not built.
const SCENE: &str = "(
    format: 1, name: \"A pendulum\", duration: 2.0, stepper: (dt: 1e-3),
    fibers: [(length: 0.5, segments: 2, section: Circle(radius: 1e-3))],
    output: (
        frame_rate: 10, formats: [Usd, Hair],
        probes: [(fiber: 0, node: Tip, quantity: Velocity)],
    ),
)";

fn pendulum(scene: &Scene, angle: f64) -> World {
    let pendulum = Pendulum { angle, rate: 0.0, steps: 0.0 };
    World::new(scene.environment.clone(), Vec::new(), Box::new(pendulum))
}

/// Runs the scene in a folder up to some steps, or to its end.
fn swing(path: &Path, existing: Existing, most: u64) -> Result<Summary, SimError> {
    let scene = Scene::from_ron(SCENE).expect("a scene");
    let mut folder = RunFolder::open(path, existing)?;
    let cancel = Cancel::new();
    let control = Control {
        sync_is_due: &mut || false,
        cancel: &cancel,
        progress: &mut |now| {
            if now.steps >= most {
                cancel.ask();
            }
        },
        stopwatch: None,
    };
    run(&scene, pendulum(&scene, 0.3), &mut folder, control)
}

/// All files but the log and the lock, with their contents.
fn files(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for folder in [path.to_owned(), path.join("frames")] {
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if entry.path().is_file() && !name.starts_with('.') {
                files.push((name, fs::read(entry.path()).expect("a file")));
            }
        }
    }
    files.sort();
    files
}

#[test]
fn a_stepper_of_ones_own_runs_and_resumes_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let summary = swing(&whole, Existing::Refuse, u64::MAX).expect("a run");
    assert_eq!((summary.outcome, summary.frames, summary.nodes), (Outcome::Complete, 21, 2));
    let cancelled = swing(&parts, Existing::Refuse, 777).expect("a run").outcome;
    assert_eq!(cancelled, Outcome::Cancelled);
    let resumed = swing(&parts, Existing::Resume, u64::MAX).expect("a run").outcome;
    assert_eq!(resumed, Outcome::Complete);
    let (whole, parts) = (files(&whole), files(&parts));
    for name in ["energies.csv", "swings.csv", "probes.csv", "scene.usda", "preview.png"] {
        assert!(whole.iter().any(|(own, _)| own == name), "{name} is missing");
    }
    assert_eq!(whole.len(), parts.len());
    for (one, other) in whole.iter().zip(&parts) {
        assert!(one == other, "{} and {} differ", one.0, other.0);
    }
    let text = |name: &str| {
        let file = whole.iter().find(|(own, _)| own == name).expect("a table");
        String::from_utf8(file.1.clone()).expect("text")
    };
    assert!(
        text("energies.csv").starts_with(
            "time (s),kinetic (J),elastic (J),gravitational (J),total (J),angle (rad)\n"
        )
    );
    assert_eq!(text("swings.csv").lines().last().map(|row| row.ends_with(",2000.0")), Some(true));
}

/// The period of small swings is that of the harmonic oscillator, and a sixteenth of the squared
/// amplitude longer; Verlet's method shortens it by a part of `(dt omega)^2 / 24`.
#[test]
fn the_period_is_the_exact_one() {
    let scene = Scene::from_ron(SCENE).expect("a scene");
    let mut world = pendulum(&scene, 0.1);
    let (dt, mut crossings) = (1e-3, Vec::new());
    for _ in 0..5000 {
        let before = world.node(0, None).0.x;
        world.step(dt).expect("finite");
        let after = world.node(0, None).0.x;
        if before > 0.0 && after <= 0.0 {
            crossings.push(world.time() - dt * after / (after - before));
        }
    }
    let [first, .., last] = crossings[..] else { panic!("{crossings:?}") };
    let period = (last - first) / (crossings.len() - 1) as f64;
    let omega = (9.81 / LENGTH).sqrt();
    let exact = 2.0 * PI / omega * (1.0 + 0.01 / 16.0 + 11.0 * 1e-4 / 3072.0);
    assert!((period / exact - 1.0).abs() < (dt * omega).powi(2) / 10.0, "{period} for {exact}");
}
