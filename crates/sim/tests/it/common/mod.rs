//! A scene that is stepped, as the tests of contacts ask for it.
pub(crate) mod books;
pub(crate) mod topology;

use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Soup;
use rapunzel_sim::{Scene, SimError, StepReport, World};
use std::fmt::Write;

pub(crate) struct Run {
    pub(crate) world: World,
    pub(crate) dt: f64,
}

impl Run {
    pub(crate) fn new(scene: &Scene) -> Self {
        let world = World::build(scene).expect("a world");
        Self { dt: scene.stepper.dt, world }
    }

    pub(crate) fn read(text: &str) -> Self {
        Self::new(&Scene::from_ron(text).unwrap_or_else(|error| panic!("{error} in {text}")))
    }

    /// A step whose contacts are all resolved, and that leaves fibres as long as they are. Of
    /// charged ones, which come to rest as curves, nodes are the ends of arcs.
    pub(crate) fn step(&mut self) -> StepReport {
        self.try_step().expect("a step")
    }

    /// The same where there may be no such step.
    pub(crate) fn try_step(&mut self) -> Result<StepReport, SimError> {
        let report = self.world.step(self.dt)?;
        assert_eq!(report.contact.unresolved, 0, "at {} s: {report:?}", self.world.time());
        if report.contact.parts > 0 {
            self.assert_lengths();
        }
        Ok(report)
    }

    /// Nothing in the data of a fibre allows its segments another length: only the rounding of
    /// places, some digits of their distance from the origin, is left of it.
    fn assert_lengths(&self) {
        for (i, fiber) in self.world.assembly().fibers().iter().enumerate() {
            let nodes = self.positions(i);
            for (ends, length) in nodes.windows(2).zip(fiber.segment_lengths()) {
                let stretch = (ends[1] - ends[0]).norm() / length - 1.0;
                assert!(stretch.abs() < 1e-12, "fibre {i} at {} s: {stretch:e}", self.world.time());
            }
        }
    }

    pub(crate) fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.step();
        }
    }

    pub(crate) fn fibers(&self) -> usize {
        self.world.assembly().fibers().len()
    }

    pub(crate) fn positions(&self, fiber: usize) -> Vec<Point3<f64>> {
        self.world.state(fiber).positions
    }

    pub(crate) fn all_positions(&self) -> topology::Fibers {
        (0..self.fibers()).map(|fiber| self.positions(fiber)).collect()
    }

    /// Momentum of all fibres and free objects, kg m/s.
    pub(crate) fn momentum(&self) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for (i, fiber) in self.world.assembly().fibers().iter().enumerate() {
            let n = fiber.segments();
            for (a, v) in self.world.state(i).velocities.iter().enumerate() {
                sum += fiber.mass() / n as f64 * if a == 0 || a == n { 0.5 } else { 1.0 } * v;
            }
        }
        let bodies = (0..).map_while(|i| self.world.body(i));
        sum + bodies.map(|body| body.mass() * body.velocity).sum::<Vector3<f64>>()
    }
}

/// A mesh as the text of a PLY file.
pub(crate) fn ply(mesh: &Soup) -> String {
    let (points, faces) = (mesh.vertices.len(), mesh.triangles.len());
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {points}\nproperty double x\nproperty double y\n\
         property double z\nelement face {faces}\nproperty list uchar int vertex_indices\n\
         end_header\n"
    );
    for p in &mesh.vertices {
        writeln!(text, "{:?} {:?} {:?}", p.x, p.y, p.z).expect("memory");
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "3 {a} {b} {c}").expect("memory");
    }
    text
}
