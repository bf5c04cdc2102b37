use crate::SimError;
use crate::scene::Hold;
use nalgebra::{Point3, Vector3};
use rapunzel_charging::ChargedRods;
use rapunzel_coupling::{EnergyLedger, FibersInContact, StepReport, Stopwatch, Surroundings};
use rapunzel_export::Strand;
use rapunzel_export::usd::{Prim, PrimShape};
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{Energy, Momentum, NodeQuantity, RodState};
use rapunzel_studio::Coloring;
use rapunzel_studio::sheet::Support;
use std::ops::Range;

/// A place where two things touched in the last step, with a force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// Where, m, world.
    pub place: Point3<f64>,
    /// Mean force on the first of the two, N, world: over the last part of a step of fibres, over
    /// the last step of nodes of springs.
    pub force: Vector3<f64>,
}

/// Something that moves, with its whole state: the seam between a [world](crate::World), which has
/// a clock, an environment and objects, and what is in it.
///
/// The first methods are what every run needs. The others have defaults: columns of tables, what
/// frames show beside strands, and views of a state that is one of fibres.
pub trait Stepper: Send + Sync {
    /// Moves everything by `dt`, s. The result must not depend on the number of threads.
    ///
    /// # Errors
    /// [`SimError`], of which [`SimError::Stepper`] takes any error; some may have been moved then
    /// and others not: [restore](Self::restore) what was saved before going on.
    fn step(&mut self, around: &mut Surroundings, dt: f64) -> Result<StepReport, SimError>;

    /// Energy, J, in a gravity, m/s^2, zero at the world's origin.
    fn energy(&self, gravity: &Vector3<f64>) -> Energy;

    /// Number of nodes of each strand. What has no strands has no frames and no probes.
    fn strand_nodes(&self) -> Vec<usize>;

    /// Strands as frames show them, each made when it is asked for.
    fn strands(&self) -> Box<dyn Iterator<Item = Strand> + '_>;

    /// Appends the points of all strands, m, world, one strand after another.
    fn points(&self, into: &mut Vec<Point3<f64>>) {
        into.extend(self.strands().flat_map(|strand| strand.points));
    }

    /// Appends what colors show at the points of all strands, one strand after another.
    fn values(&self, of: Coloring, into: &mut Vec<f64>) {
        let strands = self.strands().enumerate();
        into.extend(strands.flat_map(|(index, strand)| of.of_strand(index, &strand)));
    }

    /// Number of nodes of everything.
    fn nodes(&self) -> usize {
        self.strand_nodes().iter().sum()
    }

    /// Position (m) and velocity (m/s) of a node, world: of a strand, or, where nodes are counted
    /// as a whole, of everything. `None` is the last node.
    ///
    /// # Panics
    /// If there is no such strand or node, as indexing does.
    fn node(&self, strand: usize, node: Option<usize>) -> (Point3<f64>, Vector3<f64>);

    /// All numbers from which the motion goes on bit for bit, as lists that are made one at a time;
    /// the iterator tells their number exactly.
    fn save(&self) -> Box<dyn Iterator<Item = Vec<f64>> + '_>;

    /// Goes back to numbers that were saved at a time, s.
    ///
    /// # Errors
    /// [`SimError`] if they were saved of something else.
    fn restore(&mut self, saved: &[Vec<f64>], time: f64) -> Result<(), SimError>;

    /// What frames show besides.
    fn scenery(&self) -> Scenery {
        let strands = 0..self.strand_nodes().len();
        let shape = PrimShape::Curves { strands, guide: false };
        let prim = Prim { name: "Lines".to_owned(), shape, color: Scenery::ROPE };
        Scenery { layer: Scenery::FIBERS, prims: vec![prim], supports: Vec::new() }
    }

    /// Names, with units, of the columns that this adds to the table of energies.
    fn energy_columns(&self) -> Vec<String> {
        Vec::new()
    }

    /// Numbers of these columns.
    fn energy_row(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Tables of its own: the name of the file, and names of the columns with their units.
    fn tables(&self) -> Vec<(&'static str, Vec<String>)> {
        Vec::new()
    }

    /// Numbers of a row of the table number `table`.
    fn row(&self, _table: usize) -> Vec<f64> {
        Vec::new()
    }

    /// What speaks against steps of `dt`, s.
    fn warning(&self, _dt: f64) -> Option<String> {
        None
    }

    /// Sets what tells how long phases of steps take.
    fn set_stopwatch(&mut self, _stopwatch: Option<Stopwatch>) {}

    /// The state of fibres, if it is one.
    fn fibers(&self) -> Option<&dyn FiberStates> {
        None
    }

    /// Puts a fibre into a state.
    ///
    /// # Errors
    /// [`SimError::State`] for a state of another fibre, [`SimError::NoFibers`] where nothing can
    /// be put so.
    fn set_state(&mut self, _fiber: usize, _state: &RodState) -> Result<(), SimError> {
        Err(SimError::NoFibers)
    }

    /// The node that a point of a strand is, where nodes are counted as a whole; else the point.
    fn node_of(&self, _strand: usize, point: usize) -> usize {
        point
    }

    /// Lets hands pull at nodes from the next step on, in place of those before.
    ///
    /// # Errors
    /// [`SimError::NoHands`] where nothing can be pulled.
    fn pull(&mut self, _pulls: &[NodePull]) -> Result<(), SimError> {
        Err(SimError::NoHands("pulled"))
    }

    /// Moves, fixes or releases a node as a hold of a mass-spring scene does.
    ///
    /// # Errors
    /// [`SimError::NoHands`] where nothing can be held, [`SimError::MassSpring`] for a node that is
    /// not there.
    fn hold(&mut self, _hold: Hold) -> Result<(), SimError> {
        Err(SimError::NoHands("held"))
    }

    /// Whether something holds a node now.
    fn is_held(&self, _node: usize) -> bool {
        false
    }

    /// Where something touched in the last step that is no fibre in contact.
    fn touches(&self) -> Vec<ContactForce> {
        Vec::new()
    }

    /// The fibres with their contacts, if there are any.
    fn in_contact(&self) -> Option<&FibersInContact> {
        None
    }

    /// The fibres with their charge, if there are any.
    fn charged(&self) -> Option<&ChargedRods> {
        None
    }
}

/// Fibres that can be looked at.
pub trait FiberStates {
    /// The fibres in their natural state.
    fn assembly(&self) -> &Assembly;

    /// State of a fibre. Allocates; costs one pass over its nodes.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    fn state(&self, fiber: usize) -> RodState;

    /// Appends the positions of all nodes of a fibre, m, world.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    fn node_positions(&self, fiber: usize, into: &mut Vec<Point3<f64>>) {
        into.extend(self.state(fiber).positions);
    }

    /// Appends the values of a quantity at all nodes of a fibre.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    fn node_values(&self, fiber: usize, of: NodeQuantity, into: &mut Vec<f64>) {
        of.of_state(&self.state(fiber), into);
    }

    /// Energy of a fibre, J, in a gravity, m/s^2.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    fn energy_of(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy;

    /// Momentum of all fibres about the world's origin, if it is told.
    fn momentum(&self) -> Option<Momentum> {
        None
    }

    /// Force (N) and moment (N m) of what holds the tip or the root of a fibre on it at the time
    /// `t` (s), world frame, zero at a free end; `None` where that is not told.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    fn reaction(&self, _fiber: usize, _at_tip: bool, _t: f64) -> Option<[Vector3<f64>; 2]> {
        None
    }

    /// Works done on the fibres since the start, if a ledger is kept.
    fn ledger(&self) -> Option<EnergyLedger> {
        None
    }
}

/// What frames show beside points of strands.
#[derive(Debug, Clone)]
pub struct Scenery {
    /// The USD layer of the strands, a name of a file, and the prim that holds them.
    pub layer: (&'static str, &'static str),
    /// What the strands are in it.
    pub prims: Vec<Prim>,
    /// What holds strands, and when, s.
    pub supports: Vec<(Support, Range<f64>)>,
}

/// A force of a hand on a node during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodePull {
    /// The fibre, counted over all; 0 for what counts its nodes as a whole.
    pub strand: usize,
    /// The node.
    pub node: usize,
    /// Force, N, world.
    pub force: Vector3<f64>,
}
