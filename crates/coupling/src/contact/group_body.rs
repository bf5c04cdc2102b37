//! Fibres as bodies of the contact solver.

use super::delassus::{DelassusProduct, FiberDelassus, InertiaKind};
use nalgebra::{Matrix3, Vector3};
use pulp::Arch;
use rapunzel_contact::{Body, ContactError, DelassusBlocks};
use rapunzel_rod_dynamic::{ImpulseResponse, Point, PointAction, RodError, StaggeredBatch};

/// Multiplications that a pass over a segment costs, and lanes that a pass serves at once: what a
/// product with matrices that are written out has to beat.
const PASS: usize = 160;
const LANES: usize = 8;

/// Numbers of a segment that are kept for passes with added masses. In their room a matrix in
/// single precision has its place with masses and without: where many contacts must share what
/// memory there is, it takes no more.
const KEPT: usize = 31;

/// The fibres of a group, whose step has been predicted, with the points at which they touch.
pub(super) struct GroupBody<'a> {
    batch: &'a mut StaggeredBatch,
    points: &'a [Point],
    /// How the points answer, by fibre, where there are so few that this is cheaper than to go
    /// through the fibres.
    written: &'a mut Option<DelassusCache>,
    /// Whether contacts are so few that answers with added masses are kept for the same masses.
    few: bool,
}

/// Answers that are written out.
pub(super) struct DelassusCache {
    answers: Vec<FiberDelassus>,
    /// Whether in more than single precision.
    exact: bool,
    /// The masses that have been added.
    masses: Vec<f64>,
}

impl<'a> GroupBody<'a> {
    /// What has been `written` out of the same points before is used again, as long as it is
    /// `exact` enough; with masses added only where contacts are `few`. Where they are not, only
    /// what takes no more room than passes through the fibres is written out.
    pub(super) fn new(
        batch: &'a mut StaggeredBatch,
        points: &'a [Point],
        exact: bool,
        few: bool,
        written: &'a mut Option<DelassusCache>,
    ) -> Result<Self, ContactError> {
        if written.as_ref().is_none_or(|written| exact && !written.exact) {
            *written = None;
            let mut counts = [0; LANES];
            points.iter().for_each(|point| counts[point.fiber as usize] += 1);
            let squares: usize = counts.iter().map(|count| 9 * count * count).sum();
            let nodes = ImpulseResponse::nodes(batch) / batch.rods().len();
            let most = if few { PASS } else { KEPT };
            if squares < most * LANES * nodes {
                // Of no points nothing is asked, which would take as long as of a few.
                let none = points.is_empty();
                let answers = if none { Ok(Vec::new()) } else { batch.write_out(points) };
                let answers = answers.map_err(|error| refused(&error))?;
                let answers = answers
                    .into_iter()
                    .map(|own| FiberDelassus::new(own, exact))
                    .collect::<Result<_, _>>()?;
                *written = Some(DelassusCache { answers, exact, masses: Vec::new() });
            }
        }
        Ok(Self { batch, points, written, few })
    }
}

impl DelassusCache {
    /// Adds masses at the points; false if that cannot be.
    fn weigh(&mut self, masses: &[f64]) -> bool {
        if self.masses == masses {
            return true;
        }
        masses.clone_into(&mut self.masses);
        self.answers.iter_mut().all(|one| one.weigh(masses, self.exact))
    }
}

fn refused(error: &RodError) -> ContactError {
    ContactError::Body { body: 0, why: error.to_string() }
}

impl Body for GroupBody<'_> {
    fn points(&self) -> usize {
        self.points.len()
    }

    fn set_weights(&mut self, weights: &[f64]) -> Result<(), ContactError> {
        if let Some(written) = self.written {
            if written.weigh(weights) {
                return Ok(());
            }
            // Far from where it goes a step may be no minimum, and its answer not positive.
            *self.written = None;
        }
        self.batch.set_weights(self.points, weights).map_err(|error| refused(&error))
    }

    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        if let Some(DelassusCache { answers: explicit, .. }) = self.written {
            let inertia = InertiaKind::Own;
            return Arch::new().dispatch(DelassusProduct {
                explicit,
                inertia,
                impulses,
                velocities,
            });
        }
        let answered = self.batch.respond_at(self.points, impulses, velocities);
        debug_assert!(answered.is_ok(), "the points are on the fibres");
    }

    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        if let Some(DelassusCache { answers: explicit, .. }) = self.written {
            let inertia = InertiaKind::Weighted;
            return Arch::new().dispatch(DelassusProduct {
                explicit,
                inertia,
                impulses,
                velocities,
            });
        }
        let answered = self.batch.weighted_respond_at(self.points, impulses, velocities);
        debug_assert!(answered.is_ok(), "the points are on the fibres");
    }

    fn forget_weights(&mut self) {
        if let Some(written) = self.written.as_mut().filter(|_| !self.few) {
            written.masses.clear();
            written.answers.iter_mut().for_each(FiberDelassus::forget_weights);
        }
    }

    fn own_traces(&mut self, traces: &mut [f64]) {
        if let Some(DelassusCache { answers: explicit, .. }) = self.written {
            explicit.iter().for_each(|one| one.traces(traces));
            return;
        }
        let nodes = self.batch.nodes() / self.batch.rods().len();
        let mut blocks = vec![Matrix3::zeros(); self.batch.nodes()];
        let mut turns = vec![Matrix3::zeros(); self.batch.nodes() - self.batch.rods().len()];
        let answered = self.batch.diagonal_blocks(&mut blocks, &mut turns);
        debug_assert!(answered.is_ok(), "there is a block for each node and segment");
        for (trace, point) in traces.iter_mut().zip(self.points) {
            let Point { fiber, segment, action } = *point;
            let segment = segment as usize;
            let first = fiber as usize * nodes + segment;
            let turn = &turns[fiber as usize * (nodes - 1) + segment];
            *trace = match action {
                PointAction::Force { fraction, arm } => {
                    let [before, behind] = [first, first + 1].map(|i| blocks[i].trace());
                    // Of the rotation `T` the trace of `hat(a)^T T hat(a)`.
                    let beside = arm.norm_squared() * turn.trace() - arm.dot(&(turn * arm));
                    before + fraction * (behind - before) + beside
                }
                PointAction::Couple { lever } => (lever.tr_mul(turn) * lever).trace(),
            };
        }
    }

    fn dense_delassus(&self) -> Option<Vec<(&[usize], &DelassusBlocks)>> {
        let DelassusCache { answers, .. } = self.written.as_ref()?;
        Some(answers.iter().map(FiberDelassus::own).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;
    use rapunzel_fiber::{Fiber, Material, Section};
    use rapunzel_rod_dynamic::{Conditions, Impulses, Instant, Rod, RodStepReport, Steady};

    const SEGMENTS: usize = 25;

    /// So many fibres in a step that has been linearised.
    fn batch(count: usize) -> StaggeredBatch {
        let section = Section::Circle { radius: 3.5e-5 };
        let fiber = Fiber::uniform(0.05, SEGMENTS, section, &Material::HAIR).expect("a fiber");
        let rods = vec![Rod::new(fiber); count];
        let mut batch = StaggeredBatch::new(rods, 0.3).expect("a batch");
        let hold = Steady(Instant::clamped(Isometry3::identity(), Vector3::new(0.0, 2.0, -9.81)));
        let conditions: Vec<&dyn Conditions> = vec![&hold; count];
        let mut reports = vec![RodStepReport::default(); count];
        batch.set_out(1e-3, &conditions, Impulses::NONE, &mut reports).expect("sound");
        batch.linearize().expect("sound");
        batch
    }

    /// A matrix may be quicker than passes and yet take more room.
    #[test]
    fn where_contacts_are_many_large_matrices_are_not_written_out() {
        let mut batch = batch(1);
        for (count, written_out) in [(25, [true, true]), (30, [true, false]), (65, [false, false])]
        {
            let point = |i: u32| Point::on_axis(0, i % 25, 0.5);
            let points: Vec<_> = (0..count).map(point).collect();
            let is_written = |few: bool| {
                let mut written = None;
                GroupBody::new(&mut batch, &points, false, few, &mut written)
                    .expect("points on it");
                written.is_some()
            };
            assert_eq!([true, false].map(is_written), written_out, "{count} points");
        }
    }

    /// Whether the answers are written out or not, or were before, is only a matter of time.
    #[test]
    fn answers_that_are_written_out_are_those_of_the_fibers() {
        let count = 3;
        let mut batch = batch(count);

        let points = [(2, 24, 1.0), (0, 5, 0.5), (2, 7, 0.3), (0, 5, 0.6), (0, 0, 0.0)].map(
            |(fiber, segment, fraction)| {
                // The first is on the axis.
                let arm =
                    if segment == 24 { Vector3::zeros() } else { Vector3::new(0.0, 3e-5, 1e-5) };
                Point::beside_axis(fiber, segment, fraction, arm)
            },
        );
        let mass = batch.rods()[0].fiber.mass();
        let masses = [0.3, 0.1, 0.0, 2.0, 1.0].map(|share| share * mass);
        let asked = [1.0, -2.0, 0.5, 0.7, 3.0].map(|x| Vector3::new(x, 1.0, -x) * mass);
        let mut answers = Vec::new();
        let mut written = None;
        let mut again = None;
        for (written_out, exact, few) in
            [(true, false, true), (true, false, false), (true, true, true), (false, true, true)]
        {
            let fibers = GroupBody::new(&mut batch, &points, exact, few, &mut written);
            let mut fibers = fibers.expect("points on the fibers");
            assert!(fibers.written.is_some());
            if !written_out {
                *fibers.written = None;
            }
            fibers.set_weights(&masses).expect("positive");
            // Weights that are not kept are found again.
            fibers.forget_weights();
            let kept = fibers.written.as_ref().is_some_and(|written| !written.masses.is_empty());
            assert_eq!(kept, written_out && few);
            fibers.set_weights(&masses).expect("positive");
            let (mut free, mut weighted) = ([Vector3::zeros(); 5], [Vector3::zeros(); 5]);
            fibers.respond(&asked, &mut free);
            fibers.weighted_respond(&asked, &mut weighted);
            let mut traces = [0.0; 5];
            fibers.own_traces(&mut traces);
            if few {
                answers.push((free, weighted, traces));
            } else {
                again = Some((free, weighted, traces));
            }
        }
        assert_eq!(again.as_ref(), answers.first());
        let (single, one, other) = (&answers[0], &answers[1], &answers[2]);
        for i in 0..5 {
            assert!((one.0[i] - other.0[i]).norm() < 1e-10 * other.0[i].norm().max(1.0), "{i}");
            assert!((one.1[i] - other.1[i]).norm() < 1e-10 * other.0[i].norm().max(1.0), "{i}");
        }
        for (one, single) in [(&one.0, &single.0), (&one.1, &single.1)] {
            for i in 0..5 {
                let error = (one[i] - single[i]).norm();
                assert!(error < 1e-6 * other.0[i].norm().max(1.0), "{i}: {error}");
            }
            assert!(single != one, "that is of single precision");
        }
        assert!((one.1[0] - one.0[0]).norm() > 1e-2 * one.0[0].norm(), "masses matter");
        // At nodes, on the axis, the traces are exact too.
        assert!((one.2[0] - other.2[0]).abs() < 1e-10 * other.2[0]);
    }
}
