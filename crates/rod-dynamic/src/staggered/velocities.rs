//! Positions and velocities in a step that is taken in several calls.

use super::batch::StaggeredBatch;
use super::coupled::check;
use super::velocity_lanes::StepVelocity;
use crate::RodError;
use nalgebra::{Point3, Vector3};

impl StaggeredBatch {
    /// Writes the positions of all nodes at the start of the step under way, or of the next, m,
    /// world: into one slice for each fibre.
    ///
    /// # Errors
    /// [`RodError::Length`] for slices that are not as many as fibres, or not as long as nodes.
    pub fn start_positions(&self, positions: &mut [&mut [Point3<f64>]]) -> Result<(), RodError> {
        let nodes = self.rods()[0].fiber.segments() + 1;
        self.check_slices("positions", nodes, positions)?;
        self.engine.start_positions(positions);
        Ok(())
    }

    /// Writes the positions of all nodes where the step under way has been solved to, m, world:
    /// into one slice for each fibre.
    ///
    /// # Errors
    /// [`RodError::Invalid`] if no step is under way, [`RodError::Length`] for slices that are not
    /// as many as fibres, or not as long as nodes.
    pub fn end_positions(&self, positions: &mut [&mut [Point3<f64>]]) -> Result<(), RodError> {
        self.check_step()?;
        let nodes = self.rods()[0].fiber.segments() + 1;
        self.check_slices("positions", nodes, positions)?;
        self.engine.end_positions(positions);
        Ok(())
    }

    /// Writes velocities of all nodes, or of `some` of each fibre, m/s, world: into one slice for
    /// each fibre, which stays as it was where others are.
    ///
    /// # Errors
    /// [`RodError::Invalid`] if no step is under way, [`RodError::Length`] for slices that are not
    /// as many as fibres, or not as long as nodes, and for nodes that are not there.
    pub fn velocities(
        &self,
        which: StepVelocity,
        some: Option<&[usize]>,
        velocities: &mut [&mut [Vector3<f64>]],
    ) -> Result<(), RodError> {
        self.check_step()?;
        let nodes = self.rods()[0].fiber.segments() + 1;
        self.check_slices("velocities", nodes, velocities)?;
        check_some("nodes", nodes, some)?;
        self.engine.velocities(self.known(which), self.predicted, some, velocities);
        Ok(())
    }

    /// Writes angular velocities of all segments, or of `some` of each fibre, rad/s, world: into
    /// one slice for each fibre, which stays as it was where others are.
    ///
    /// # Errors
    /// [`RodError::Invalid`] if no step is under way, [`RodError::Length`] for slices that are not
    /// as many as fibres, or not as long as segments, and for segments that are not there.
    pub fn spins(
        &self,
        which: StepVelocity,
        some: Option<&[usize]>,
        spins: &mut [&mut [Vector3<f64>]],
    ) -> Result<(), RodError> {
        self.check_step()?;
        let segments = self.rods()[0].fiber.segments();
        self.check_slices("spins", segments, spins)?;
        check_some("segments", segments, some)?;
        self.engine.spins(self.known(which), self.predicted, some, spins);
        Ok(())
    }

    /// The velocities that are meant: all increments of a linearisation that is not kept have been
    /// taken.
    fn known(&self, which: StepVelocity) -> StepVelocity {
        if which == StepVelocity::Linear && !self.is_linearized {
            StepVelocity::Mean
        } else {
            which
        }
    }

    fn check_slices<T>(
        &self,
        what: &'static str,
        expected: usize,
        slices: &[&mut [T]],
    ) -> Result<(), RodError> {
        check(what, self.rods().len(), slices.len())?;
        slices.iter().try_for_each(|own| check(what, expected, own.len()))
    }
}

fn check_some(what: &'static str, count: usize, some: Option<&[usize]>) -> Result<(), RodError> {
    let past = some.into_iter().flatten().find(|&&i| i >= count);
    past.map_or(Ok(()), |&found| Err(RodError::Length { what, expected: count, found: found + 1 }))
}
