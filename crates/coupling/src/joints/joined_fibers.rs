use super::matrix::{JointMatrix, MatrixTerms};
use super::network::Network;
use super::node_joint::NodeJoint;
use crate::{CouplingError, Fibers, StepReport, Surroundings};
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{Energy, RodError, StaggeredBatch};

/// Fibres that are joined and touch nothing.
pub struct JoinedFibers {
    pub(super) fibers: Fibers<StaggeredBatch>,
    pub(super) network: Network,
    /// Loads of the joints at the end of the last step, by group, N and N m: where the next step
    /// starts from.
    pub(super) loads: Vec<Vec<Vector3<f64>>>,
    /// The matrix of the joints that the last step was solved with, for the next one.
    pub(super) matrix: Option<JointMatrix>,
}

impl JoinedFibers {
    /// Fibres with these joints between them.
    ///
    /// # Errors
    /// [`CouplingError::JointOpen`] for joints that start open, [`CouplingError::JointTwice`] for
    /// those between nodes that others have joined already.
    ///
    /// # Panics
    /// If there is no such fibre or node, as indexing does.
    pub fn new(
        fibers: Fibers<StaggeredBatch>,
        joints: &[NodeJoint],
    ) -> Result<Self, CouplingError> {
        let network = Network::new(joints, &fibers)?;
        let loads = network.groups.iter().map(|group| vec![Vector3::zeros(); group.points.len()]);
        Ok(Self { loads: loads.collect(), fibers, network, matrix: None })
    }

    /// The fibres.
    #[must_use]
    pub fn fibers(&self) -> &Fibers<StaggeredBatch> {
        &self.fibers
    }

    /// The fibres, to be changed between steps.
    pub fn fibers_mut(&mut self) -> &mut Fibers<StaggeredBatch> {
        &mut self.fibers
    }

    /// Moves all fibres by `dt`, s, in parts where Newton's method needs them. The result does not
    /// depend on the number of threads.
    ///
    /// # Errors
    /// [`CouplingError`]; the fibres may have been moved by a part of the step then:
    /// [restore](Self::restore) what was saved before going on.
    pub fn step(&mut self, around: &Surroundings, dt: f64) -> Result<StepReport, CouplingError> {
        // A step has many parallel loops: a thread outside the pool would sleep at each.
        rayon::scope(|_| self.step_in_parts(around.start, dt))
    }

    /// Energy of all fibres and of what bends between them, J, in a gravity, m/s^2.
    #[must_use]
    pub fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let mut sum = self.fibers.energy(gravity);
        sum.elastic += self.stored().iter().sum::<f64>();
        sum
    }

    /// Force (N) on the first and moment (N m) on the last segment before the first node of a joint
    /// at the end of the last step, world frame; on the second side acts the opposite.
    ///
    /// # Panics
    /// If there is no such joint, as indexing does.
    #[must_use]
    pub fn load(&self, joint: usize) -> [Vector3<f64>; 2] {
        let side = &self.network.links[joint].sides[0];
        let loads = &self.loads[side.group];
        [loads[side.force], side.moment.map_or_else(Vector3::zeros, |at| loads[at])]
    }

    /// All numbers that change: lists that are made one at a time.
    pub fn save(&self) -> impl Iterator<Item = Vec<f64>> {
        let loads = self.loads.iter().flatten().flatten().copied();
        let matrix = MatrixTerms::numbers(&self.network, self.matrix.as_ref());
        self.fibers.save().chain(std::iter::once(loads.chain(matrix).collect()))
    }

    /// Goes back to saved numbers.
    ///
    /// # Errors
    /// [`CouplingError::Restore`] if they are those of other fibres.
    pub fn restore(&mut self, saved: &[Vec<f64>]) -> Result<(), CouplingError> {
        let loads = self.loads.iter().flatten().flatten().count();
        let numbers = loads + MatrixTerms::numbers(&self.network, None).len();
        let Some((joints, fibers)) = saved.split_last().filter(|(own, _)| own.len() == numbers)
        else {
            let found = saved.last().map_or(0, Vec::len);
            let what = "loads of joints";
            return Err(RodError::Length { what, expected: numbers, found }.into());
        };
        let (loads, terms) = joints.split_at(loads);
        // It had an inverse when it was saved.
        let terms = MatrixTerms::of_numbers(&self.network, terms);
        let matrix = terms.and_then(|terms| JointMatrix::new(&self.network, terms).ok());
        self.fibers.restore(fibers)?;
        self.matrix = matrix;
        let own = self.loads.iter_mut().flatten().flatten();
        own.zip(loads).for_each(|(own, saved)| *own = *saved);
        Ok(())
    }
}
