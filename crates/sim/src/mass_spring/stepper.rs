use super::build::{build, readings};
use super::motion::ErasedSystem;
use crate::scene::{Hold, MassSpring};
use crate::stepper::{ContactForce, Scenery, Stepper};
use crate::{NodePull, SimError};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::TimeInterval;
use rapunzel_coupling::{StepReport, Surroundings};
use rapunzel_export::Strand;
use rapunzel_mass_spring::SpringError;
use rapunzel_rod_dynamic::Energy;

/// A mass-spring system that moves by itself among objects.
pub(crate) struct MassSprings {
    springs: Box<dyn ErasedSystem>,
    scenery: Scenery,
    /// Names and units of the readings.
    columns: Vec<String>,
}

impl MassSprings {
    /// The system of a scene at its start.
    pub(crate) fn new(scene: &MassSpring) -> Result<Self, SpringError> {
        let springs = build(scene)?;
        let (lines, surface) = (springs.strands().len(), springs.surface());
        let is_held = |node| springs.is_held(node);
        let scenery = Scenery::of_springs(scene, lines, surface, springs.places(), is_held);
        Ok(Self { springs, scenery, columns: readings(scene) })
    }
}

impl Stepper for MassSprings {
    /// # Errors
    /// [`SimError::MassSpring`] with the time, and which node or why.
    fn step(&mut self, around: &mut Surroundings, dt: f64) -> Result<StepReport, SimError> {
        let (time, gravity) = (around.start, around.gravity());
        let iterations = self
            .springs
            .step(TimeInterval { start: time, length: dt }, &gravity, around.objects)
            .map_err(|source| SimError::MassSpring { time, source })?;
        Ok(StepReport::of_one(iterations, 0, 0))
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        self.springs.energy(gravity)
    }

    fn strand_nodes(&self) -> Vec<usize> {
        self.springs.strands().iter().map(|strand| strand.points.len()).collect()
    }

    fn strands(&self) -> Box<dyn Iterator<Item = Strand> + '_> {
        Box::new(self.springs.strands().into_iter())
    }

    fn points(&self, into: &mut Vec<Point3<f64>>) {
        self.springs.points(into);
    }

    fn nodes(&self) -> usize {
        self.springs.nodes()
    }

    fn node(&self, _: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>) {
        self.springs.node(node.unwrap_or(self.springs.nodes() - 1))
    }

    fn save(&self) -> Box<dyn Iterator<Item = Vec<f64>> + '_> {
        Box::new(std::iter::once_with(|| self.springs.save()))
    }

    fn restore(&mut self, saved: &[Vec<f64>], time: f64) -> Result<(), SimError> {
        let own = saved.first().is_some_and(|numbers| self.springs.restore(numbers));
        let source = SpringError::Count {
            what: "saved numbers",
            found: saved.first().map_or(0, Vec::len),
            expected: "those of this system".to_owned(),
        };
        own.then_some(()).ok_or(SimError::MassSpring { time, source })
    }

    fn scenery(&self) -> Scenery {
        self.scenery.clone()
    }

    fn energy_columns(&self) -> Vec<String> {
        self.columns.clone()
    }

    fn energy_row(&self) -> Vec<f64> {
        self.springs.readings()
    }

    fn node_of(&self, strand: usize, point: usize) -> usize {
        self.springs.node_of(strand, point)
    }

    fn pull(&mut self, pulls: &[NodePull]) -> Result<(), SimError> {
        let pulled = self.springs.pull(pulls);
        pulled.map_err(|source| SimError::MassSpring { time: 0.0, source })
    }

    fn hold(&mut self, hold: Hold) -> Result<(), SimError> {
        let time = hold.from;
        self.springs.hold(hold).map_err(|source| SimError::MassSpring { time, source })
    }

    fn is_held(&self, node: usize) -> bool {
        self.springs.is_held(node)
    }

    fn touches(&self) -> Vec<ContactForce> {
        self.springs.touches()
    }

    fn warning(&self, dt: f64) -> Option<String> {
        Some(self.springs.warning(dt)?.to_string())
    }
}
