//! Several rods at rest that touch each other and what stands around them.

use crate::StaticError;
use crate::chain::Chain;
use crate::gap::Gap;
use crate::loaded_rod::places;
use crate::riccati::RootSupport;
use crate::shape::Shape;
use crate::state::State;
use crate::target::Target;
use nalgebra::{Point3, Vector3};

/// A rod of an assembly.
#[derive(Debug, Clone)]
pub struct AssemblyRod {
    /// The rod with its dead loads, its clamp, and the places at which nodes are held; the clamp is
    /// where the search starts from if the root is not clamped.
    pub chain: Chain,
    /// What holds its root.
    pub root: RootSupport,
    /// The shape from which the search starts; its last frame is kept if the tip's frame is held.
    pub start: Shape,
}

/// Rods, each a [`Chain`], that touch each other and other things without friction.
///
/// At rest their energy is a minimum among the shapes in which no [`Gap`] is negative. Each contact
/// then pushes with a force that is not negative, and with none where there is a gap. With
/// friction there would be many shapes at rest, and this one among them.
#[derive(Debug, Clone)]
pub struct RodAssembly {
    pub(crate) rods: Vec<AssemblyRod>,
}

/// An equilibrium of a [`RodAssembly`].
#[derive(Debug, Clone)]
pub struct AssemblyRest {
    /// The shapes of the rods.
    pub shapes: Vec<Shape>,
    /// Positions of the stations that gaps depend on, m, world frame, by rod.
    pub stations: Vec<Vec<Point3<f64>>>,
    /// States of the nodes of the rods, as [`Chain::states`] has them. Forces of contacts act in
    /// the middles of segments, and on the last node.
    pub states: Vec<Vec<State>>,
    /// Energy of the bent and twisted rods, J, by rod.
    pub elastic: Vec<f64>,
    /// Energy of the dead loads, J, by rod, as [`Chain::work`] counts it.
    pub load: Vec<f64>,
    /// The forces of the held places, N, world frame, by rod and in the order of its targets.
    pub pulls: Vec<Vec<Vector3<f64>>>,
    /// Gaps that push, with their forces, N.
    pub contacts: Vec<(Gap, f64)>,
    /// The gap that is most negative, m, or zero.
    pub penetration: f64,
    /// The largest product of a contact's force and its gap, N m.
    pub slackness: f64,
    /// The largest moment on a node, N m, that nothing balances.
    pub unbalanced: f64,
    /// Number of Newton steps that were taken.
    pub iterations: usize,
}

impl RodAssembly {
    /// An assembly of these rods.
    ///
    /// # Errors
    /// No rods; a start of another number of nodes; following loads, which have no energy; targets
    /// that pull instead of hold.
    pub fn new(rods: Vec<AssemblyRod>) -> Result<Self, StaticError> {
        if rods.is_empty() {
            return Err(StaticError::NoPieces);
        }
        for rod in &rods {
            rod.chain.check(&rod.start)?;
            let springs = rod.chain.targets.iter().any(|target| !target.is_held());
            if rod.chain.is_followed() || springs {
                return Err(StaticError::NoMinimum);
            }
        }
        Ok(Self { rods })
    }
}

impl AssemblyRod {
    /// Positions at the start of the stations that gaps depend on, m, world frame: the root, the
    /// middles of the segments, and the tip.
    #[must_use]
    pub fn stations(&self) -> Vec<Point3<f64>> {
        places(&self.chain, &self.start.frames, &self.start.positions[0]).stations()
    }

    /// Unit of stiffness of a contact, N/m: that of a segment against a force across it.
    pub(crate) fn contact_unit(&self) -> f64 {
        let unit =
            self.chain.segments.iter().map(|segment| {
                segment.stiffness.x.min(segment.stiffness.y) / segment.length.powi(3)
            });
        unit.fold(f64::INFINITY, f64::min)
    }

    /// Length of the rod, m.
    pub(crate) fn length(&self) -> f64 {
        self.chain.segments.iter().map(|segment| segment.length).sum()
    }

    /// Units of stiffness of the whole rod against rotations (N m) and displacements (N/m).
    pub(crate) fn units(&self) -> [f64; 2] {
        let length = self.length();
        let stiffness = self.chain.stiffness();
        [stiffness * length * length, stiffness]
    }

    pub(crate) fn holds(&self) -> &[Target] {
        &self.chain.targets
    }
}
