//! Fibres as bodies of the contact solver.

use nalgebra::{Matrix3, Vector3};
use rapunzel_contact::{Body, ContactError};
use rapunzel_rod_dynamic::{ImpulseResponse, Point, StaggeredBatch};

/// The fibres of a group, whose step has been predicted, with the points at which they touch.
pub(super) struct Fibers<'a> {
    batch: &'a mut StaggeredBatch,
    points: &'a [Point],
}

impl<'a> Fibers<'a> {
    pub(super) fn new(batch: &'a mut StaggeredBatch, points: &'a [Point]) -> Self {
        Self { batch, points }
    }
}

impl Body for Fibers<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn set_weights(&mut self, weights: &[f64]) -> Result<(), ContactError> {
        let set = self.batch.set_weights(self.points, weights);
        set.map_err(|error| ContactError::Body { body: 0, why: error.to_string() })
    }

    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        let answered = self.batch.respond_at(self.points, impulses, velocities);
        debug_assert!(answered.is_ok(), "the points are on the fibres");
    }

    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        let answered = self.batch.weighted_respond_at(self.points, impulses, velocities);
        debug_assert!(answered.is_ok(), "the points are on the fibres");
    }

    fn own_traces(&mut self, traces: &mut [f64]) {
        let nodes = self.batch.nodes() / self.batch.rods().len();
        let mut blocks = vec![Matrix3::zeros(); self.batch.nodes()];
        let answered = self.batch.diagonal_blocks(&mut blocks);
        debug_assert!(answered.is_ok(), "there is a block for each node");
        for (trace, point) in traces.iter_mut().zip(self.points) {
            let first = point.fiber as usize * nodes + point.segment as usize;
            let [before, behind] = [first, first + 1].map(|i| blocks[i].trace());
            *trace = before + point.fraction * (behind - before);
        }
    }
}
