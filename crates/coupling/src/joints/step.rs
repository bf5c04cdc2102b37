//! Newton's method for fibres and their joints together.

use super::groups::JoinedSolve;
use super::joined_fibers::JoinedFibers;
use super::junction::JunctionAction;
use super::matrix::{JointMatrix, MatrixTerms};
use super::network::{JointResiduals, JointState, Network, frame};
use crate::{CouplingError, Fibers, StepReport};
use nalgebra::Vector3;
use rapunzel_linalg::LinalgError;
use rapunzel_rod_dynamic::{JointLoads, Ledger, StaggeredBatch, StepError, expected_error};
use rayon::prelude::*;

/// Most iterations of Newton's method.
const JOINED_ITERATIONS: usize = 30;
/// Most halvings of a step.
const JOINED_HALVINGS: u32 = 10;
/// Error allowed after the last increment, rad.
const TURN_TOLERANCE: f64 = 1e-13;
/// Increments below this, rad, that hardly fall any more are rounding, if joints are as closed.
const NOISE: f64 = 1e-6;
/// Joints are closed to this, in lengths of a segment and rad, where they need not be to less, and
/// to so many roundings of places.
const CLOSED: f64 = 1e-14;
const ROUNDINGS: f64 = 8.0;
/// Where a joint is no more open than this, in what is rounding, it is let be if it does not close.
const NEARLY: f64 = 16.0;
/// Joints are closed to at least this in each iteration.
const ROUGH: f64 = 1e-3;
/// Where a pass leaves more of the error of joints than this, their matrix is taken anew; where it
/// does with a new one too, what is left is rounding.
const SLOW: f64 = 0.1;

/// Why a part of a step could not be taken.
enum PartFailure {
    Rods(StepError),
    Joints(LinalgError),
}

impl From<StepError> for PartFailure {
    fn from(error: StepError) -> Self {
        Self::Rods(error)
    }
}

impl JoinedFibers {
    /// Takes the step from `start` by `dt`, s, in halves where it must.
    pub(super) fn step_in_parts(
        &mut self,
        start: f64,
        dt: f64,
    ) -> Result<StepReport, CouplingError> {
        let fibers = self.fibers.assembly().fibers().len();
        let mut report = StepReport { fibers, ..StepReport::default() };
        // In shortest parts, so that the last ends exactly.
        let whole = 1_u32 << JOINED_HALVINGS;
        let (mut done, mut part) = (0, whole);
        while done < whole {
            let length = dt * f64::from(part) / f64::from(whole);
            let time = start + dt * f64::from(done) / f64::from(whole);
            let before = self.loads.clone();
            match self.take_part(time, length) {
                Ok(iterations) => {
                    report.iterations += fibers * iterations;
                    report.worst_iterations = report.worst_iterations.max(iterations);
                    done += part;
                    while part < whole && done.is_multiple_of(2 * part) {
                        part *= 2;
                    }
                }
                Err(failure) => {
                    self.fibers.groups.par_iter_mut().for_each(|group| group.batch.abandon());
                    self.loads = before;
                    if part == 1 {
                        return Err(match failure {
                            PartFailure::Rods(source) => CouplingError::Step { time, source },
                            PartFailure::Joints(source) => CouplingError::Joints { time, source },
                        });
                    }
                    part /= 2;
                    report.halvings += 1;
                }
            }
        }
        Ok(report)
    }

    /// Takes a part of a step. Returns the number of Newton iterations.
    fn take_part(&mut self, time: f64, dt: f64) -> Result<usize, PartFailure> {
        if self.fibers.groups.iter().any(|group| group.batch.is_fresh()) {
            self.solve(time, dt, JoinedSolve::Start)?;
            self.accept(time, dt, JoinedSolve::Start)?;
        }
        let turns = self.turns();
        let stored = self.stored();
        let iterations = self.solve(time, dt, JoinedSolve::End)?;
        self.accept(time, dt, JoinedSolve::End)?;
        // What bends between fibres gains of the work of joints on them what it does not lose.
        let mut works = Ledger::default();
        let after = self.turns();
        let each = self.network.links.iter().zip(turns.iter().zip(&after));
        for (link, (before, after)) in each {
            if let Some(junction) = &link.junction {
                works.damping += junction.damped([before, after], dt);
            }
        }
        let gain = self.stored().iter().sum::<f64>() - stored.iter().sum::<f64>();
        works.integrator = gain - works.damping;
        self.fibers.record(&works);
        Ok(iterations)
    }

    /// Solves a step from `time` by `dt`, s, without accepting it.
    fn solve(&mut self, time: f64, dt: f64, search: JoinedSolve) -> Result<usize, PartFailure> {
        let Self { fibers, network, .. } = &*self;
        let place = |group: usize, lane, node| fibers.groups[group].batch.node(lane, node).0;
        let (mut gaps, mut least) = (Vec::with_capacity(network.links.len()), CLOSED);
        for link in &network.links {
            let [a, b] = link.sides.map(|side| place(side.group, side.lane, side.node));
            gaps.push(a - b);
            least = least.max(ROUNDINGS * f64::EPSILON * a.coords.norm() / link.length);
        }
        let turns = self.turns();
        let Self { fibers, network, loads, matrix } = self;
        let groups = fibers.groups.par_iter_mut().zip(&network.groups).zip(&*loads);
        let set_out = groups.map(|((group, joints), loads)| {
            group.set_out_joined((time, dt), search, JointLoads { points: &joints.points, loads })
        });
        set_out.collect::<Vec<_>>().into_iter().collect::<Result<(), _>>()?;
        // A matrix is good for the same step only.
        let mut known =
            matrix.take().filter(|own| search == JoinedSolve::End && own.terms().dt == dt);
        let mut ways: Vec<_> = loads.clone();
        let (mut increments, mut before) = (Vec::new(), f64::INFINITY);
        for iteration in 1..=JOINED_ITERATIONS {
            let groups = fibers.groups.par_iter_mut().zip(&network.groups).zip(&mut ways);
            let linearized = groups
                .map(|((group, joints), ways)| group.linearize_joined(time, &joints.points, ways));
            let own = largest(linearized.collect())?;
            let actions: Vec<_> = network
                .links
                .iter()
                .zip(&turns)
                .map(|(link, before)| {
                    let frames = link.sides.map(|side| frame(fibers, &side));
                    link.junction.as_ref().map(|junction| junction.act(frames, before, dt))
                })
                .collect();
            // Joints need not be closer than the fibres will be.
            let goal = (own * own).max(least).min(ROUGH);
            let (mut last, mut new) = (f64::INFINITY, false);
            let left = loop {
                let state = JointState { gaps: &gaps, actions: &actions, ways: &ways, loads };
                let JointResiduals { of_clusters, worst } = network.residuals(&state);
                if worst <= goal {
                    break worst;
                }
                let slow = worst > SLOW * last;
                if slow && (new || worst <= NEARLY * least) {
                    break worst;
                }
                let solved_with = match known.take().filter(|_| !slow) {
                    Some(matrix) => matrix,
                    None => {
                        new = true;
                        matrix_now(fibers, network, &actions, (time, dt))?
                    }
                };
                let unknowns = solved_with.solve(&of_clusters).map_err(PartFailure::Joints)?;
                known = Some(solved_with);
                let changes = network.loads(&unknowns);
                let all = loads.iter_mut().flatten().zip(changes.iter().flatten());
                all.for_each(|(load, change)| *load += change);
                let groups = fibers.groups.par_iter_mut().zip(&network.groups);
                let changed =
                    groups.zip(&changes).zip(&mut ways).map(|(((group, joints), loads), ways)| {
                        let changes = JointLoads { points: &joints.points, loads };
                        group.change_joined(time, changes, ways)
                    });
                changed.collect::<Vec<_>>().into_iter().collect::<Result<(), _>>()?;
                last = worst;
            };
            let taken = fibers.groups.par_iter_mut().map(|group| group.take_joined());
            let turn = largest(taken.collect())?;
            increments.push(turn);
            let rounding = turn < NOISE && turn > 0.9 * before && left < NOISE;
            let closed = left <= TURN_TOLERANCE.max(NEARLY * least);
            if closed && expected_error(turn, before, true) < TURN_TOLERANCE || rounding {
                if search == JoinedSolve::End {
                    *matrix = known;
                }
                return Ok(iteration);
            }
            before = turn;
        }
        // No fibre is to blame alone: the first stands for all.
        Err(StepError::NotConverged { fiber: 0, time, dt, residuals: increments }.into())
    }

    fn accept(&mut self, time: f64, dt: f64, search: JoinedSolve) -> Result<(), StepError> {
        let groups = self.fibers.groups.par_iter_mut();
        let accepted: Vec<_> =
            groups.map(|group| group.accept_joined((time, dt), search)).collect();
        accepted.into_iter().collect()
    }

    /// Rotation vectors of all junctions, rad; zero of ball joints.
    fn turns(&self) -> Vec<Vector3<f64>> {
        let turn = |link: &super::network::Link| {
            let frames = link.sides.map(|side| frame(&self.fibers, &side));
            link.junction.as_ref().map_or_else(Vector3::zeros, |own| own.turn(frames))
        };
        self.network.links.iter().map(turn).collect()
    }

    /// Elastic energies of all junctions, J.
    pub(super) fn stored(&self) -> Vec<f64> {
        let junctions = self.network.links.iter().map(|link| link.junction.as_ref());
        let each = junctions.zip(self.turns());
        each.map(|(junction, turn)| junction.map_or(0.0, |own| own.stored(&turn))).collect()
    }
}

/// The largest of what groups tell.
fn largest(told: Vec<Result<f64, StepError>>) -> Result<f64, StepError> {
    told.into_iter().try_fold(0.0, |most: f64, one| Ok(most.max(one?)))
}

/// The matrix of the joints at the last linearisation of a step from `time` by `dt`, s.
fn matrix_now(
    fibers: &mut Fibers<StaggeredBatch>,
    network: &Network,
    actions: &[Option<JunctionAction>],
    (time, dt): (f64, f64),
) -> Result<JointMatrix, PartFailure> {
    let groups = fibers.groups.par_iter_mut().zip(&network.groups);
    let told = groups.map(|(group, joints)| group.responses(time, &joints.points));
    let told: Vec<Result<_, StepError>> = told.collect();
    let responses = told.into_iter().collect::<Result<_, _>>()?;
    let hessians = actions.iter().map(|action| action.as_ref().map(|own| own.hessian)).collect();
    let matrix = JointMatrix::new(network, MatrixTerms { dt, responses, hessians });
    matrix.map_err(PartFailure::Joints)
}
