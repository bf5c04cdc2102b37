use crate::error::{finite, non_negative, positive};
use crate::force::{self, add_run};
use crate::spring::Springs;
use crate::supports::Supports;
use crate::{BendResistance, NodeVectors, Spring, SpringError, WindField};
use nalgebra::{Point, SVector};
use std::collections::BTreeMap;

/// Point masses in `D` dimensions, the springs between them, and what acts on them.
///
/// Positions, velocities and forces are in the world frame. The equation of motion is
/// `m a = springs + bends + loads + m g - m gamma (v - u)`, with the drag rate `gamma` and the wind
/// `u`.
#[derive(Debug, Clone)]
pub struct System<const D: usize> {
    pub(crate) time: f64,
    pub(crate) positions: NodeVectors<D>,
    pub(crate) velocities: NodeVectors<D>,
    pub(crate) masses: Vec<f64>,
    pub(crate) inverse_masses: Vec<f64>,
    pub(crate) springs: Springs,
    pub(crate) bends: Vec<BendResistance>,
    pub(crate) supports: Supports<D>,
    pub(crate) gravity: SVector<f64, D>,
    pub(crate) drag: f64,
    pub(crate) wind: WindField<D>,
    pub(crate) loads: BTreeMap<usize, SVector<f64, D>>,
}

impl<const D: usize> System<D> {
    /// Creates nodes at rest at `positions` (m) with `masses` (kg), connected by `springs`, without
    /// other forces.
    ///
    /// # Errors
    /// [`SpringError`] names the first node or spring with numbers that make no sense.
    pub fn new(
        positions: &[Point<f64, D>],
        masses: &[f64],
        springs: &[Spring],
    ) -> Result<Self, SpringError> {
        let nodes = positions.len();
        if masses.len() != nodes || nodes == 0 {
            let expected = format!("one for each of the {nodes} nodes, and at least one node");
            return Err(SpringError::Count { what: "masses", found: masses.len(), expected });
        }
        for (node, &mass) in masses.iter().enumerate() {
            if !(mass > 0.0 && mass.is_finite() && (1.0 / mass).is_finite()) {
                return Err(SpringError::Mass { node, mass });
            }
        }
        springs.iter().enumerate().try_for_each(|(s, spring)| spring.check(s, nodes))?;
        let mut system = Self {
            time: 0.0,
            positions: NodeVectors::zeros(nodes),
            velocities: NodeVectors::zeros(nodes),
            masses: masses.to_vec(),
            inverse_masses: masses.iter().map(|m| 1.0 / m).collect(),
            springs: Springs::new(springs),
            bends: Vec::new(),
            supports: Supports::none(nodes),
            gravity: SVector::zeros(),
            drag: 0.0,
            wind: WindField::default(),
            loads: BTreeMap::new(),
        };
        let coordinates: Vec<_> = positions.iter().map(|p| p.coords).collect();
        system.set_positions(&NodeVectors::of(&coordinates))?;
        Ok(system)
    }

    /// Replaces the bend resistances of the system; an empty list removes them.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`], [`SpringError::Parameter`].
    pub fn with_bends(mut self, bends: Vec<BendResistance>) -> Result<Self, SpringError> {
        bends.iter().enumerate().try_for_each(|(b, bend)| bend.check(b, self.nodes()))?;
        self.bends = bends;
        Ok(self)
    }

    /// Number of nodes, at least one.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.masses.len()
    }

    /// Number of springs.
    #[must_use]
    pub fn springs(&self) -> usize {
        self.springs.len()
    }

    /// Spring `s` with its present parameters.
    ///
    /// # Panics
    /// If there is no such spring, as indexing does.
    #[must_use]
    pub fn spring(&self, s: usize) -> Spring {
        self.springs.get(s)
    }

    /// Masses of the nodes, kg.
    #[must_use]
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Current time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Sets the time, on which the wind depends, s.
    pub fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// Position of `node` (world), m.
    ///
    /// # Panics
    /// If there is no such node, as indexing does.
    #[must_use]
    pub fn position(&self, node: usize) -> Point<f64, D> {
        self.positions.get(node).into()
    }

    /// Velocity of `node` (world), m/s.
    ///
    /// # Panics
    /// If there is no such node, as indexing does.
    #[must_use]
    pub fn velocity(&self, node: usize) -> SVector<f64, D> {
        self.velocities.get(node)
    }

    /// Positions of all nodes (world), m.
    #[must_use]
    pub fn positions(&self) -> &NodeVectors<D> {
        &self.positions
    }

    /// Velocities of all nodes (world), m/s.
    #[must_use]
    pub fn velocities(&self) -> &NodeVectors<D> {
        &self.velocities
    }

    /// Sets the positions of all nodes (world), m.
    ///
    /// # Errors
    /// [`SpringError::Count`], [`SpringError::NotFinite`].
    pub fn set_positions(&mut self, positions: &NodeVectors<D>) -> Result<(), SpringError> {
        self.check("position", positions)?;
        self.positions = positions.clone();
        Ok(())
    }

    /// Sets the velocities of all nodes (world), m/s; velocities of supports are kept.
    ///
    /// # Errors
    /// [`SpringError::Count`], [`SpringError::NotFinite`].
    pub fn set_velocities(&mut self, velocities: &NodeVectors<D>) -> Result<(), SpringError> {
        self.check("velocity", velocities)?;
        let mut change = velocities.clone();
        change.add_scaled(-1.0, &self.velocities);
        self.supports.project(&mut change);
        self.velocities.add_scaled(1.0, &change);
        Ok(())
    }

    /// Restores saved positions (world), m, and velocities (world), m/s, also those of supports.
    ///
    /// # Errors
    /// [`SpringError::Count`], [`SpringError::NotFinite`].
    pub fn set_state(
        &mut self,
        positions: &NodeVectors<D>,
        velocities: &NodeVectors<D>,
    ) -> Result<(), SpringError> {
        self.check("velocity", velocities)?;
        self.set_positions(positions)?;
        self.velocities = velocities.clone();
        Ok(())
    }

    fn check(&self, what: &'static str, columns: &NodeVectors<D>) -> Result<(), SpringError> {
        if columns.len() != self.nodes() {
            let expected = format!("one for each of the {} nodes", self.nodes());
            return Err(SpringError::Count { what, found: columns.len(), expected });
        }
        match columns.first_not_finite() {
            Some(node) => Err(SpringError::NotFinite { what, node }),
            None => Ok(()),
        }
    }

    /// Sets the acceleration of free fall (world), m/s^2.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] if it is not finite.
    pub fn set_gravity(&mut self, gravity: SVector<f64, D>) -> Result<(), SpringError> {
        finite("gravity (m/s^2)", &gravity)?;
        self.gravity = gravity;
        Ok(())
    }

    /// Sets the drag rate gamma, 1/s: Stokes's drag for a unit of mass; a free oscillation decays
    /// as `exp(-gamma t / 2)`.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] if it is negative or not finite.
    pub fn set_drag(&mut self, rate: f64) -> Result<(), SpringError> {
        non_negative("the drag rate (1/s)", rate)?;
        self.drag = rate;
        Ok(())
    }

    /// Sets the wind, which acts through the drag.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] if a number is not finite or the period not positive.
    pub fn set_wind(&mut self, wind: WindField<D>) -> Result<(), SpringError> {
        finite("the wind (m/s)", &wind.steady)?;
        finite("the pulse of the wind (m/s)", &wind.pulse)?;
        positive("the period of the wind (s)", wind.period)?;
        self.wind = wind;
        Ok(())
    }

    /// Sets the force of the load on `node` (world), N; zero takes it away.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`], [`SpringError::Parameter`].
    pub fn set_load(&mut self, node: usize, force: SVector<f64, D>) -> Result<(), SpringError> {
        self.known("load", node)?;
        finite("a load (N)", &force)?;
        self.loads.insert(node, force);
        self.loads.retain(|_, force| force.norm_squared() > 0.0);
        Ok(())
    }

    /// Sets the rest length of spring `s`, m.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] if it is not positive and finite.
    ///
    /// # Panics
    /// If there is no such spring, as indexing does.
    pub fn set_rest_length(&mut self, s: usize, length: f64) -> Result<(), SpringError> {
        self.set_rest_lengths([(s, length)])
    }

    /// Sets the rest lengths of several springs, m, each given by its index.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] for the first one that is not positive and finite.
    ///
    /// # Panics
    /// If there is no such spring, as indexing does.
    pub fn set_rest_lengths(
        &mut self,
        lengths: impl IntoIterator<Item = (usize, f64)>,
    ) -> Result<(), SpringError> {
        for (s, length) in lengths {
            positive("a rest length (m)", length)?;
            self.springs.rest_length[s] = length;
        }
        self.springs.refresh();
        Ok(())
    }

    /// Sets the yield strain of all springs.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] if it is not positive.
    pub fn set_yield_strain(&mut self, strain: f64) -> Result<(), SpringError> {
        if strain.is_nan() || strain <= 0.0 {
            let (what, allowed) = ("the yield strain", "positive; infinite for never");
            return Err(SpringError::Parameter { what, value: strain, allowed });
        }
        self.springs.yield_strain.fill(strain);
        Ok(())
    }

    /// Velocity of the air at the current time (world), m/s, as the wind rose of the texts shows
    /// it.
    #[must_use]
    pub fn wind(&self) -> SVector<f64, D> {
        self.wind.at(self.time)
    }

    pub(crate) fn known(&self, what: &'static str, node: usize) -> Result<(), SpringError> {
        let nodes = self.nodes();
        if node < nodes {
            Ok(())
        } else {
            Err(SpringError::MissingNode { what, index: node, node, nodes })
        }
    }

    /// Forces of springs and bends at given positions (m) and velocities (m/s), N (world).
    ///
    /// # Panics
    /// If there is not one of each for every node.
    #[must_use]
    pub fn internal_forces(&self, x: &NodeVectors<D>, v: &NodeVectors<D>) -> NodeVectors<D> {
        let mut forces = NodeVectors::zeros(self.nodes());
        for run in &self.springs.runs {
            add_run(&self.springs, run, x, v, &mut forces);
        }
        self.bends.iter().for_each(|bend| bend.add_forces(x, &mut forces));
        forces
    }

    /// Force of spring `s` on its first node in the present state (world), N.
    ///
    /// # Panics
    /// If there is no such spring, as indexing does.
    #[must_use]
    pub fn spring_force(&self, s: usize) -> SVector<f64, D> {
        let [i, j] = self.springs.nodes[s];
        let apart = self.positions.get(j) - self.positions.get(i);
        let parting = self.velocities.get(j) - self.velocities.get(i);
        force::force(&self.springs, s, &apart, &parting)
    }

    /// Mean rest length of the springs, m: the length scale of the system.
    pub(crate) fn size(&self) -> f64 {
        self.springs.rest_length.iter().sum::<f64>() / self.springs().max(1) as f64
    }
}
