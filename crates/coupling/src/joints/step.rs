//! Newton's method for fibres and their joints together.

use super::groups::JoinedSolve;
use super::joined_fibers::JoinedFibers;
use super::network::{GroupMotion, JointState, frame};
use crate::{CouplingError, StepReport};
use nalgebra::Vector3;
use rapunzel_linalg::LinalgError;
use rapunzel_rod_dynamic::{JointLoads, Ledger, StepError, expected_error};
use rayon::prelude::*;

/// Most iterations of Newton's method.
const JOINED_ITERATIONS: usize = 30;
/// Most halvings of a step.
const JOINED_HALVINGS: u32 = 10;
/// Error allowed after the last increment, rad.
const TURN_TOLERANCE: f64 = 1e-13;
/// Increments below this, rad, that hardly fall any more are rounding.
const NOISE: f64 = 1e-6;

/// After increments up to this, rad, responses to loads are as good as before.
const SMALL: f64 = 1e-6;

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
        let gaps: Vec<_> = network
            .links
            .iter()
            .map(|link| {
                let [a, b] = link.sides.map(|side| place(side.group, side.lane, side.node));
                a - b
            })
            .collect();
        let turns = self.turns();
        let Self { fibers, network, loads } = self;
        let groups = fibers.groups.par_iter_mut().zip(&network.groups).zip(&*loads);
        let set_out = groups.map(|((group, joints), loads)| {
            group.set_out_joined((time, dt), search, JointLoads { points: &joints.points, loads })
        });
        set_out.collect::<Vec<_>>().into_iter().collect::<Result<(), _>>()?;
        let (mut increments, mut before) = (Vec::new(), f64::INFINITY);
        let mut motions = vec![GroupMotion::default(); fibers.groups.len()];
        let mut anew = true;
        for iteration in 1..=JOINED_ITERATIONS {
            let groups = fibers.groups.par_iter_mut().zip(&network.groups).zip(&mut motions);
            let linearized: Vec<_> = groups
                .map(|((group, joints), motion)| {
                    group.linearize_joined(time, &joints.points, anew, motion)
                })
                .collect();
            linearized.into_iter().collect::<Result<(), _>>()?;
            let actions: Vec<_> = network
                .links
                .iter()
                .zip(&turns)
                .map(|(link, before)| {
                    let frames = link.sides.map(|side| frame(fibers, &side));
                    link.junction.as_ref().map(|junction| junction.act(frames, before, dt))
                })
                .collect();
            let state =
                JointState { gaps: &gaps, actions: &actions, motions: &motions, loads: &*loads };
            let changes = network.solve(&state).map_err(PartFailure::Joints)?;
            let all = loads.iter_mut().flatten().zip(changes.iter().flatten());
            all.for_each(|(load, change)| *load += change);
            let groups = fibers.groups.par_iter_mut().zip(&network.groups).zip(&*loads);
            let advanced: Vec<_> = groups
                .map(|((group, joints), loads)| {
                    group.advance_joined(JointLoads { points: &joints.points, loads })
                })
                .collect();
            let mut turn = 0.0_f64;
            for own in advanced {
                turn = turn.max(own?);
            }
            increments.push(turn);
            let rounding = turn < NOISE && turn > 0.9 * before;
            // With responses of an earlier iteration joints converge linearly.
            if expected_error(turn, before, anew) < TURN_TOLERANCE || rounding {
                return Ok(iteration);
            }
            anew = turn > SMALL;
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
