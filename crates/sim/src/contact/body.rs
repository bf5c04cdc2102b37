//! Fibres as bodies of the contact solver.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rapunzel_contact::{Body, ContactError};
use rapunzel_rod_dynamic::{ImpulseResponse, Point, PointResponses, RodError, StaggeredBatch};

/// Multiplications that a pass over a segment costs, and lanes that a pass serves at once: what a
/// product with matrices that are written out has to beat.
const PASS: usize = 160;
const LANES: usize = 8;

/// The fibres of a group, whose step has been predicted, with the points at which they touch.
pub(super) struct Fibers<'a> {
    batch: &'a mut StaggeredBatch,
    points: &'a [Point],
    /// How the points answer, by fibre, where there are so few that this is cheaper than to go
    /// through the fibres.
    explicit: Option<Vec<Explicit>>,
}

/// The answers of the points of one fibre, written out.
struct Explicit {
    own: PointResponses,
    /// With the masses added.
    weighted: DMatrix<f64>,
    /// Impulses and velocities.
    room: [DVector<f64>; 2],
}

impl<'a> Fibers<'a> {
    pub(super) fn new(
        batch: &'a mut StaggeredBatch,
        points: &'a [Point],
    ) -> Result<Self, ContactError> {
        let mut counts = [0; LANES];
        points.iter().for_each(|point| counts[point.fiber as usize] += 1);
        let squares: usize = counts.iter().map(|count| 9 * count * count).sum();
        let nodes = ImpulseResponse::nodes(batch) / batch.rods().len();
        let explicit = if squares < PASS * LANES * nodes {
            let answers = batch.write_out(points).map_err(|error| refused(&error))?;
            Some(answers.into_iter().map(Explicit::new).collect())
        } else {
            None
        };
        Ok(Self { batch, points, explicit })
    }
}

impl Explicit {
    fn new(own: PointResponses) -> Self {
        let size = own.matrix.nrows();
        let room = [DVector::zeros(size), DVector::zeros(size)];
        Self { own, weighted: DMatrix::zeros(size, size), room }
    }

    /// With `M` the masses, `W - W S (1 + S W S)^-1 S W` where `S^2 = M`. False if `W` is not
    /// positive semidefinite.
    fn weigh(&mut self, masses: &[f64]) -> bool {
        let root = |i: usize| masses[self.own.points[i / 3]].sqrt();
        let mut half = self.own.matrix.clone();
        half.row_iter_mut().enumerate().for_each(|(i, mut row)| row *= root(i));
        let mut inner = half.clone();
        inner.column_iter_mut().enumerate().for_each(|(i, mut column)| column *= root(i));
        (0..inner.nrows()).for_each(|i| inner[(i, i)] += 1.0);
        let Some(factor) = inner.cholesky() else { return false };
        let solved = factor.l_dirty().solve_lower_triangular_mut(&mut half);
        self.weighted.copy_from(&self.own.matrix);
        self.weighted.gemm_tr(-1.0, &half, &half, 1.0);
        solved
    }

    fn answer(
        &mut self,
        weighted: bool,
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) {
        let [from, to] = &mut self.room;
        for (i, &point) in self.own.points.iter().enumerate() {
            from.fixed_rows_mut::<3>(3 * i).copy_from(&impulses[point]);
        }
        let matrix = if weighted { &self.weighted } else { &self.own.matrix };
        to.gemv(1.0, matrix, from, 0.0);
        for (i, &point) in self.own.points.iter().enumerate() {
            velocities[point].copy_from(&to.fixed_rows::<3>(3 * i));
        }
    }
}

fn refused(error: &RodError) -> ContactError {
    ContactError::Body { body: 0, why: error.to_string() }
}

impl Body for Fibers<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn set_weights(&mut self, weights: &[f64]) -> Result<(), ContactError> {
        if let Some(explicit) = &mut self.explicit {
            let positive = explicit.iter_mut().all(|one| one.weigh(weights));
            let why = "its answer to impulses is not positive".into();
            return if positive { Ok(()) } else { Err(ContactError::Body { body: 0, why }) };
        }
        self.batch.set_weights(self.points, weights).map_err(|error| refused(&error))
    }

    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        if let Some(explicit) = &mut self.explicit {
            return explicit.iter_mut().for_each(|one| one.answer(false, impulses, velocities));
        }
        let answered = self.batch.respond_at(self.points, impulses, velocities);
        debug_assert!(answered.is_ok(), "the points are on the fibres");
    }

    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        if let Some(explicit) = &mut self.explicit {
            return explicit.iter_mut().for_each(|one| one.answer(true, impulses, velocities));
        }
        let answered = self.batch.weighted_respond_at(self.points, impulses, velocities);
        debug_assert!(answered.is_ok(), "the points are on the fibres");
    }

    fn own_traces(&mut self, traces: &mut [f64]) {
        if let Some(explicit) = &self.explicit {
            for PointResponses { points, matrix } in explicit.iter().map(|one| &one.own) {
                for (i, &point) in points.iter().enumerate() {
                    traces[point] = matrix.fixed_view::<3, 3>(3 * i, 3 * i).trace();
                }
            }
            return;
        }
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
