//! The alternating direction method of multipliers, as Douglas-Rachford splitting on the velocities
//! of the sides of all contacts.
//!
//! One half of an iteration solves every contact by itself, the other every body by itself, so both
//! are parallel and the result does not depend on who computes what. A side `i` has a metric `R_i`,
//! a multiple of the identity, so that a contact alone is solved in closed form. With `h` the
//! state,
//!
//! ```text
//! z  = the velocities nearest to h, in the metric, that with some impulses r obey the law
//! v  = the velocities nearest to 2 z - h that the bodies can have
//! h <- h + alpha (v - z)
//! ```
//!
//! Where `v = z` both hold: the bodies move as `r` makes them, and `r` obeys the law. Their
//! difference is the error of either, `R (z - v)` in impulses. Near the answer descent takes over.
//!
//! Between contacts and bodies go changes, from the velocities and impulses that were given, and of
//! `h` from what these make of it: what bodies answer in single precision is small near the end,
//! and so are its roundings. An iteration reads and writes about a kilobyte of each contact, more
//! in all than caches hold where contacts are many: buffers that serve one part at a time belong to
//! the thread (`AdmmWorkspace`).

mod admm_part;
mod admm_state;
mod anderson;
mod contact_group;
mod contact_kernel;
mod contact_lanes;
mod contact_sides;
mod descent;
mod phase;
mod phase_pool;
mod shared_vectors;

use crate::metric;
use crate::solver::check;
use crate::{Body, Contact, ContactError, FreeMasses, Report, Solver, Tolerance};
use admm_part::{AdmmPart, AdmmWorkspace};
use admm_state::AdmmState;
use anderson::{Anderson, AndersonHistory, IterationKind, ResidualProducts};
use contact_sides::ContactSides;
use descent::{DescentPlan, descend};
use nalgebra::Vector3;
use phase::{Phase, eval_residual, residual_of_parts};
use phase_pool::{Leader, PhasePool};
use rayon::prelude::*;
use shared_vectors::SharedVectors;
use std::ops::Range;
use std::sync::LazyLock;

/// The solver for thousands of contacts: cost linear in points and contacts an iteration.
#[derive(Debug, Clone)]
pub struct Admm {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    /// Over-relaxation `alpha`, between 0 and 2.
    pub relaxation: f64,
    /// Metric of a point in units of its own inertia, unless it is pressed together with many
    /// others: larger trusts impulses more, smaller velocities.
    pub weight: f64,
    /// Steps that the acceleration remembers; 0 for no acceleration.
    pub memory: usize,
    /// Histories of the splitting and of the descent, by part, kept from solve to solve.
    histories: Vec<[AndersonHistory; 2]>,
}

/// Iterations between two checks of the tolerance.
const CHECK_INTERVAL: usize = 5;
/// Fewest sides of a part: enough to be worth the taking.
const SIDES_PER_PART: usize = 96;
/// Contacts of a part.
const CONTACTS_PER_PART: usize = 256;
/// Most parts whose histories are kept from solve to solve: as many as find them in the caches.
const KEPT_HISTORIES: usize = 128;
/// Iterations that make a step of the acceleration, of more than [`FEW_SIDES`] sides.
const ITERATIONS_PER_STEP: usize = 3;
/// Number of sides up to which every iteration is a step: of those the memory spans much.
const FEW_SIDES: usize = 64;
/// Impulses with an error of so many times that of the given ones lead nowhere.
const STRAYED: f64 = 100.0;
/// Descent where a solve begins near its end.
const AT_START: DescentPlan =
    DescentPlan { largest_error: 30.0, min_iterations: 5, max_iterations: 30, off_course: 1.5 };
/// Descent where splitting has come near the end.
const AT_END: DescentPlan =
    DescentPlan { largest_error: 3.0, min_iterations: 1, max_iterations: 8, off_course: 1.5 };
/// Descent where most points are in a crowd: what they do together is what splitting is slow to
/// find. Where that is not what is wrong, descent creeps, and must not be long about it.
const IN_CROWD: DescentPlan =
    DescentPlan { largest_error: 30.0, min_iterations: 5, max_iterations: 40, off_course: 3.0 };

impl Admm {
    /// The solver with its usual relaxation, weight and memory.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, relaxation: 1.6, weight: 8.0, memory: 10, histories: Vec::new() }
    }
}

impl Solver for Admm {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        check(bodies, contacts, velocities, impulses)?;
        if contacts.is_empty() {
            return Ok(Report { converged: true, ..Report::default() });
        }
        let sides = ContactSides::new(contacts, velocities.len());
        let ([metric, traces], crowded) =
            choose_metric(bodies, &sides, velocities.len(), self.weight);
        let count = sides.len();
        let state = AdmmState {
            contacts,
            sides: &sides,
            velocities,
            metric: &metric,
            traces: &traces,
            free: FreeMasses::new(bodies, contacts),
            crowded,
            metric_weight: self.weight,
            relaxation: self.relaxation,
            h: LazyLock::new(Box::new(move || SharedVectors::zeros(count))),
            impulse_changes: SharedVectors::zeros(contacts.len()),
            velocity_changes: SharedVectors::zeros(velocities.len()),
        };
        let mut histories = std::mem::take(&mut self.histories);
        let parts = parts(bodies, impulses, &state, &mut histories);
        let run_part = |phase: &Phase, part: &mut AdmmPart<'_, '_>, space: &mut AdmmWorkspace| {
            phase.run(part, &state, space);
        };
        let pool = PhasePool::new(parts.into_iter(), run_part);
        let period = if sides.len() > FEW_SIDES { ITERATIONS_PER_STEP } else { 1 };
        let plans = if crowded { [&IN_CROWD, &IN_CROWD] } else { [&AT_START, &AT_END] };
        let report = pool.with_leader(|leader| {
            let start = eval_residual(leader);
            let found = self.iterate(leader, &start, period, plans)?;
            let error = |report: &Report| self.tolerance.error(report);
            if !found.converged && error(&found) > STRAYED * error(&start) {
                // Bodies that answer what is not finite are told.
                let told = if error(&found).is_finite() { start } else { found };
                return Ok(Report { iterations: found.iterations, converged: false, ..told });
            }
            leader.run(Phase::ReturnImpulses);
            Ok(found)
        });
        drop(pool);
        histories.truncate(KEPT_HISTORIES);
        self.histories = histories;
        bodies.par_iter_mut().for_each(|body| body.forget_weights());
        report
    }
}

impl Admm {
    /// Iterates all parts to the end, from what `start` tells of, with steps of the acceleration of
    /// `period` iterations, and descents at the start and near the end.
    fn iterate<'a, 'b, A>(
        &self,
        leader: &Leader<'_, '_, AdmmPart<'a, 'b>, Phase, AdmmWorkspace, A>,
        start: &Report,
        period: usize,
        [at_start, at_end]: [&DescentPlan; 2],
    ) -> Result<Report, ContactError>
    where
        A: Fn(&Phase, &mut AdmmPart<'a, 'b>, &mut AdmmWorkspace) + Sync,
    {
        let tolerance = &self.tolerance;
        let mut iterations = 0;
        let descend = |found: &Report, plan, iterations: &mut usize| {
            let found = descend(leader, tolerance, tolerance.error(found), plan, iterations);
            found.map(|found| Report { iterations: *iterations, converged: true, ..found })
        };
        // Descent alone, where the given impulses are near the answer.
        if let Some(found) = descend(start, at_start, &mut iterations) {
            return Ok(found);
        }
        leader.run(Phase::Initialize);
        let mut body_error = None;
        leader.for_each(|part| body_error = body_error.take().or(part.body_error.take()));
        if let Some(error) = body_error {
            return Err(error);
        }
        let mut anderson = Anderson::new(self.memory, period);
        loop {
            iterations += 1;
            let last = iterations >= tolerance.iterations;
            let checks = last || iterations.is_multiple_of(CHECK_INTERVAL);
            // z: every contact by itself, in the metric.
            leader.run(Phase::Prox { keeps_velocities: checks });
            // v, and h <- h + alpha (v - z): every body by itself.
            let starts_step = anderson.starts_step();
            let kind = anderson.next_iteration();
            leader.run(Phase::Respond { starts_step, kind, keeps_velocities: checks });
            // Anderson's acceleration of h over all sides.
            if let IterationKind::EndOfStep(_) = kind {
                let mut products = ResidualProducts::default();
                leader.for_each(|part| products.add(&part.products));
                leader.run(Phase::Extrapolate(anderson.update(&products)));
            }
            if !checks {
                continue;
            }
            // Where v - z is small the law itself is checked, with the velocities of the impulses.
            leader.run(Phase::EvalSplitting);
            if last || tolerance.reached(&residual_of_parts(leader)) {
                leader.run(Phase::EvalVelocities);
                let found = eval_residual(leader);
                let converged = tolerance.reached(&found);
                if converged || last {
                    return Ok(Report { iterations, converged, ..found });
                }
                if let Some(found) = descend(&found, at_end, &mut iterations) {
                    return Ok(found);
                }
            }
        }
    }
}

/// Metric of a side, kg, and trace of the point's answer to itself, 1/kg, by point; and whether
/// most points are in a crowd.
fn choose_metric(
    bodies: &mut [&mut dyn Body],
    sides: &ContactSides,
    points: usize,
    weight: f64,
) -> ([Vec<f64>; 2], bool) {
    let mut all = [vec![0.0; points], vec![0.0; points]];
    let ranges = ranges(bodies);
    let mut rest = all.each_mut().map(|all| &mut all[..]);
    let parts: Vec<_> = ranges
        .iter()
        .map(|range| {
            rest.each_mut().map(|rest| {
                let (own, behind) = std::mem::take(rest).split_at_mut(range.len());
                *rest = behind;
                own
            })
        })
        .collect();
    let crowded = bodies
        .par_iter_mut()
        .zip(parts)
        .zip(ranges)
        .map(|((body, own), range)| {
            let counts: Vec<usize> = range.map(|point| sides.at_point(point).len()).collect();
            metric::masses(&mut **body, &counts, weight, own)
        })
        .collect::<Vec<usize>>();
    (all, 2 * crowded.into_iter().sum::<usize>() > points)
}

/// Parts of bodies and contacts, cut by their number alone.
fn parts<'a, 'b>(
    mut bodies: &'a mut [&'b mut dyn Body],
    mut impulses: &'a mut [Vector3<f64>],
    state: &AdmmState,
    histories: &'a mut Vec<[AndersonHistory; 2]>,
) -> Vec<AdmmPart<'a, 'b>> {
    let groups = body_groups(bodies, state.sides);
    let contacts = impulses.len();
    let count = groups.len().max(contacts.div_ceil(CONTACTS_PER_PART));
    histories.resize_with(histories.len().max(count), Default::default);
    // Spread evenly where there are fewer groups than parts.
    let cut = |all: usize, part: usize| all * part / count;
    let (mut own, mut points) = (Vec::with_capacity(count), 0..0);
    for (part, histories) in (0..count).zip(histories) {
        let of_part = &groups[cut(groups.len(), part)..cut(groups.len(), part + 1)];
        let own_bodies = of_part.iter().map(|(bodies, _)| bodies).sum();
        points = points.end..of_part.last().map_or(points.end, |(_, points)| *points);
        let own_contacts = cut(contacts, part)..cut(contacts, part + 1);
        let (of_bodies, rest) = std::mem::take(&mut bodies).split_at_mut(own_bodies);
        bodies = rest;
        let (of_contacts, rest) = std::mem::take(&mut impulses).split_at_mut(own_contacts.len());
        impulses = rest;
        own.push(((of_bodies, points.clone()), (of_contacts, own_contacts), histories.each_mut()));
    }
    let part = |(bodies, contacts, histories)| AdmmPart::new(state, bodies, contacts, histories);
    own.into_par_iter().map(part).collect()
}

/// Groups of bodies that are taken together: the number of bodies, and the end of their points.
fn body_groups(bodies: &[&mut dyn Body], sides: &ContactSides) -> Vec<(usize, usize)> {
    let mut groups = Vec::new();
    let (mut count, mut start) = (0, 0);
    for Range { end, .. } in ranges(bodies) {
        count += 1;
        if sides.at_points(&(start..end)).len() >= SIDES_PER_PART {
            groups.push((count, end));
            (count, start) = (0, end);
        }
    }
    if count > 0 {
        groups.push((count, ranges(bodies).last().map_or(0, |range| range.end)));
    }
    groups
}

/// Points of each body among those of all bodies.
fn ranges(bodies: &[&mut dyn Body]) -> Vec<Range<usize>> {
    let mut start = 0;
    let range = |body: &&mut dyn Body| {
        let range = start..start + body.points();
        start = range.end;
        range
    };
    bodies.iter().map(range).collect()
}
