//! Supports that hold, guide and tie nodes of a system.

use crate::error::finite;
use crate::supports::Guide;
use crate::{SpringError, System};
use nalgebra::SVector;
use std::collections::BTreeSet;

impl<const D: usize> System<D> {
    /// Whether the velocity of a node is prescribed along every axis.
    #[must_use]
    pub fn is_held(&self, node: usize) -> bool {
        (0..D).all(|axis| self.supports.driven(node, axis))
    }

    /// Fixes `node` where it is.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`].
    pub fn pin(&mut self, node: usize) -> Result<(), SpringError> {
        self.hold(node, SVector::zeros())
    }

    /// Moves `node` at a prescribed velocity (world), m/s, whatever forces act on it, as a mouse
    /// does. Nodes that are tied to it follow.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`], [`SpringError::Parameter`] if the velocity is not finite.
    pub fn hold(&mut self, node: usize, velocity: SVector<f64, D>) -> Result<(), SpringError> {
        (0..D).try_for_each(|axis| self.hold_axis(node, axis, velocity[axis]))
    }

    /// Moves `node` at a prescribed velocity along one axis, m/s; along the others it stays free.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`], [`SpringError::Parameter`] if the velocity is not finite.
    ///
    /// # Panics
    /// If there is no such axis, as indexing does.
    pub fn hold_axis(
        &mut self,
        node: usize,
        axis: usize,
        velocity: f64,
    ) -> Result<(), SpringError> {
        self.known("support", node)?;
        finite("the velocity of a held node (m/s)", &SVector::<f64, 1>::new(velocity))?;
        self.supports.drive(node, axis..axis + 1);
        for partner in self.supports.partners(node, axis) {
            self.velocities.0[axis][partner] = velocity;
        }
        Ok(())
    }

    /// Releases `node`, which keeps its velocity and its ties.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`].
    pub fn release(&mut self, node: usize) -> Result<(), SpringError> {
        self.known("support", node)?;
        self.supports.release(node);
        Ok(())
    }

    /// Ties nodes so that they move along `axis` only together: a clamp that slides. They keep
    /// their offsets and take their mean velocity, weighted by mass.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`].
    ///
    /// # Panics
    /// If there is no such axis, as indexing does.
    pub fn tie(&mut self, nodes: &[usize], axis: usize) -> Result<(), SpringError> {
        nodes.iter().try_for_each(|&node| self.known("tie", node))?;
        let Some(&first) = nodes.first() else { return Ok(()) };
        self.supports.tie(axis, nodes.iter().copied().collect::<BTreeSet<_>>());
        let all = self.supports.partners(first, axis);
        let column = &mut self.velocities.0[axis];
        let driven = all.iter().find(|&&node| self.supports.driven(node, axis));
        let velocity = driven.map_or_else(
            || {
                let mass: f64 = all.iter().map(|&node| self.masses[node]).sum();
                all.iter().map(|&node| self.masses[node] * column[node]).sum::<f64>() / mass
            },
            |&node| column[node],
        );
        all.iter().for_each(|&node| column[node] = velocity);
        Ok(())
    }

    /// Fixes `node` relative to another node: both move as one body without rotation.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`].
    pub fn pin_to(&mut self, node: usize, other: usize) -> Result<(), SpringError> {
        (0..D).try_for_each(|axis| self.tie(&[node, other], axis))
    }

    /// Change of the velocity of `node` per unit of impulse, axis by axis, 1/kg: zero where the
    /// node is driven, the inverse mass of the whole tie where it is tied.
    pub(crate) fn yielding(&self, node: usize) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| match self.supports.guide(node, axis) {
            Guide::Free => self.inverse_masses[node],
            Guide::Driven => 0.0,
            Guide::Tied(tie) => {
                1.0 / self.supports.ties[tie].nodes.iter().map(|&n| self.masses[n]).sum::<f64>()
            }
        })
    }

    /// Change of the velocity of node `i` relative to node `j` per unit of opposite impulses on
    /// both, axis by axis, 1/kg.
    pub(crate) fn yielding_apart(&self, i: usize, j: usize) -> SVector<f64, D> {
        let both = self.yielding(i) + self.yielding(j);
        SVector::from_fn(|axis, _| {
            let guides = [i, j].map(|node| self.supports.guide(node, axis));
            let together = matches!(guides, [Guide::Tied(a), Guide::Tied(b)] if a == b);
            if together { 0.0 } else { both[axis] }
        })
    }

    /// Changes velocities by an impulse on `node` (world), N s.
    pub(crate) fn impel(&mut self, node: usize, impulse: &SVector<f64, D>) {
        let change = impulse.component_mul(&self.yielding(node));
        self.supports.add(&mut self.velocities, node, &change);
    }

    /// Changes positions as [`impel`](Self::impel) changes velocities, for a `moment` in kg m.
    pub(crate) fn shift(&mut self, node: usize, moment: &SVector<f64, D>) {
        let change = moment.component_mul(&self.yielding(node));
        self.supports.add(&mut self.positions, node, &change);
    }
}
