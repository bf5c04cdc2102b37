use crate::{Conditions, RodError, StepError};
use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, SectionLaw, so3};
use std::ops::AddAssign;
use std::sync::Arc;

/// A fibre with the internal damping of its material.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// The fibre in its natural state.
    pub fiber: Fiber,
    /// Kelvin-Voigt retardation time, s: the moment is `K (kappa - kappa0 + tau d(kappa)/dt)`.
    pub damping_time: f64,
    /// Constitutive laws of the sections in place of `K (kappa - kappa0)`. Only
    /// [`crate::Staggered`] and [`crate::StaggeredBatch`] support laws other than the linear one.
    pub laws: SectionLaws,
}

impl Rod {
    /// An undamped rod.
    #[must_use]
    pub fn new(fiber: Fiber) -> Self {
        Self::damped(fiber, 0.0)
    }

    /// A rod with internal damping of a retardation time, s.
    #[must_use]
    pub fn damped(fiber: Fiber, damping_time: f64) -> Self {
        Self { fiber, damping_time, laws: SectionLaws::Linear }
    }
}

/// Constitutive laws of a rod's sections.
#[derive(Debug, Clone, Default)]
pub enum SectionLaws {
    /// The linear law, with the stiffness of the fibre and the damping time of the rod.
    #[default]
    Linear,
    /// One law for all sections.
    Same(Arc<dyn SectionLaw>),
    /// One law per node, `n + 1` of them.
    Each(Vec<Arc<dyn SectionLaw>>),
}

impl SectionLaws {
    /// The law at a node, if it is not the linear one.
    pub(crate) fn at(&self, node: usize) -> Option<&Arc<dyn SectionLaw>> {
        match self {
            Self::Linear => None,
            Self::Same(law) => Some(law),
            Self::Each(laws) => laws.get(node),
        }
    }
}

/// Two sets of laws are equal if they share the same law objects (pointer equality).
impl PartialEq for SectionLaws {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Linear, Self::Linear) => true,
            (Self::Same(a), Self::Same(b)) => Arc::ptr_eq(a, b),
            (Self::Each(a), Self::Each(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
            }
            _ => false,
        }
    }
}

/// Configuration and velocities of a rod: what every integrator can be started from and read as.
#[derive(Debug, Clone, PartialEq)]
pub struct RodState {
    /// Time, s.
    pub time: f64,
    /// Positions of the `n + 1` nodes, m, world.
    pub positions: Vec<Point3<f64>>,
    /// Velocities of the `n + 1` nodes, m/s, world.
    pub velocities: Vec<Vector3<f64>>,
    /// Material frames `[d1 d2 d3]` at the midpoints of the `n` segments.
    pub frames: Vec<Rotation3<f64>>,
    /// Angular velocities of the `n` segments, rad/s, material frame.
    pub angular_velocities: Vec<Vector3<f64>>,
    /// Force in each of the `n` segments that the part beyond exerts on the part before, N, world.
    pub forces: Vec<Vector3<f64>>,
    /// Darboux vectors at the `n + 1` nodes, 1/m, material frame.
    pub curvatures: Vec<Vector3<f64>>,
}

impl RodState {
    /// Pose of the tip, world frame: the last node, with the frame of the last segment continued
    /// over half of it.
    ///
    /// # Panics
    /// If the state is not one of this fibre.
    #[must_use]
    pub fn tip(&self, fiber: &Fiber) -> Isometry3<f64> {
        let n = fiber.segments();
        let turn = 0.75 * self.curvatures[n] + 0.25 * self.curvatures[n - 1];
        let frame = self.frames[n - 1] * so3::exp(&(0.5 * fiber.segment_lengths()[n - 1] * turn));
        Isometry3::from_parts(
            self.positions[n].into(),
            UnitQuaternion::from_rotation_matrix(&frame),
        )
    }
}

/// Mechanical energy of a rod, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Kinetic energy of translation and rotation, J.
    pub kinetic: f64,
    /// Elastic energy of bending and torsion, J.
    pub elastic: f64,
    /// Potential energy in the given gravity, J, zero at the world's origin.
    pub gravitational: f64,
}

impl Energy {
    /// Sum of kinetic, elastic and gravitational energy, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational
    }
}

/// Momentum of a rod or of many.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Momentum {
    /// Linear momentum, kg m/s, world.
    pub linear: Vector3<f64>,
    /// Angular momentum about the world's origin, kg m^2/s, world: of the nodes and of the spin of
    /// the sections.
    pub angular: Vector3<f64>,
}

impl AddAssign for Momentum {
    fn add_assign(&mut self, other: Self) {
        self.linear += other.linear;
        self.angular += other.angular;
    }
}

/// Cost and final residual of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RodStepReport {
    /// Newton iterations, over all sub-steps.
    pub iterations: usize,
    /// Number of times the step was halved because Newton's method failed.
    pub halvings: usize,
    /// Relative residual of the last solve.
    pub residual: f64,
}

/// An integrator of one rod in time.
///
/// A step that returns an error leaves the rod as it was.
pub trait RodIntegrator: Send {
    /// The rod that is integrated.
    fn rod(&self) -> &Rod;

    /// Current time, s.
    fn time(&self) -> f64;

    /// Current state of the rod. Allocates; costs one pass over the nodes.
    fn state(&self) -> RodState;

    /// Restarts from `state`. Positions are rebuilt from the root position and the frames, so that
    /// segments have exactly their length; forces and curvatures are recomputed.
    ///
    /// # Errors
    /// [`RodError::Length`] for arrays that do not fit the rod, [`RodError::Invalid`] for numbers
    /// that are not finite.
    fn set_state(&mut self, state: &RodState) -> Result<(), RodError>;

    /// Sets additional forces on the nodes, N, world, one per node, constant until set again.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is one per node.
    fn set_node_forces(&mut self, forces: &[Vector3<f64>]) -> Result<(), RodError>;

    /// Energy of the current state in the given gravity (m/s^2), J.
    fn energy(&self, gravity: &Vector3<f64>) -> Energy;

    /// Advances the rod by `dt` seconds. Halves the step where Newton's method fails.
    ///
    /// # Errors
    /// [`StepError`]; the rod is then as before.
    fn step(&mut self, dt: f64, conditions: &dyn Conditions) -> Result<RodStepReport, StepError>;

    /// Appends all numbers that determine the further motion, so that [`RodIntegrator::restore`]
    /// continues bit for bit.
    fn save(&self, numbers: &mut Vec<f64>);

    /// Restores the state from the numbers that [`RodIntegrator::save`] wrote.
    ///
    /// # Errors
    /// [`RodError::Length`] when the count is not that of this rod.
    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError>;
}
