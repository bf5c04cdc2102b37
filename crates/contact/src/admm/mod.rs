//! The alternating direction method of multipliers, as Douglas-Rachford splitting on the velocities
//! of the sides of all contacts.
//!
//! One half of an iteration solves every contact by itself, the other every body by itself, so both
//! are parallel and the result does not depend on who computes what. A side `i` has a metric `R_i`,
//! a multiple of the identity, so that a contact alone is solved in closed form. With `h` the state,
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
//! Between contacts and bodies go changes, from the velocities and impulses that were given, and of `h` from
//! what these make of it: what bodies answer in single precision is small near the end, and so are its roundings.
//! An iteration reads and writes about a kilobyte of each contact, more in all than caches hold where contacts
//! are many: what serves one part at a time has no room of its own.

mod alone;
mod anderson;
mod crew;
mod descent;
mod part;
mod shared;
mod sides;
mod wide;

use crate::metric;
use crate::solver::check;
use crate::{Body, Contact, ContactError, Report, Solver, Tolerance};
use anderson::{Anderson, Products, Turn};
use crew::{Crew, Lead};
use descent::{DescentPlan, descend};
use nalgebra::Vector3;
use part::{Common, Order, Part, Room, judge, together};
use rayon::prelude::*;
use shared::Shared;
use sides::Sides;
use std::ops::Range;
use std::sync::LazyLock;

/// The solver for thousands of contacts: cost linear in points and contacts an iteration.
#[derive(Debug, Clone)]
pub struct Admm {
    /// When to stop.
    pub tolerance: Tolerance,
    /// Over-relaxation `alpha`, between 0 and 2.
    pub relaxation: f64,
    /// Metric of a point in units of its own inertia, unless it is pressed together with many others:
    /// larger trusts impulses more, smaller velocities.
    pub weight: f64,
    /// How many steps the acceleration remembers; 0 for none.
    pub memory: usize,
    /// Room for what parts remember of iterations and of descents.
    steps: Vec<[anderson::Part; 2]>,
}

/// Iterations between two looks at the tolerance.
const LOOK: usize = 5;
/// Sides, and contacts, that a part has: enough to be worth the taking.
const SIDES: usize = 96;
const CONTACTS: usize = 256;
/// Parts whose room for what they remember is kept from solve to solve: as many as find it in the caches.
const ROOMS: usize = 128;
/// Iterations that make a step of the acceleration, of more than a few sides: of those its memory
/// spans much.
const PERIOD: usize = 3;
const FEW: usize = 64;
/// Where a solve begins near its end, and where splitting has come near it.
const AT_START: DescentPlan = DescentPlan { near: 30.0, least: 5, most: 30, off_course: 1.5 };
const AT_END: DescentPlan = DescentPlan { near: 3.0, least: 1, most: 8, off_course: 1.5 };
/// Where most points are in a crowd: what they do together is what splitting is slow to find. Where that is
/// not what is wrong, descent creeps, and must not be long about it.
const IN_CROWD: DescentPlan = DescentPlan { near: 30.0, least: 5, most: 40, off_course: 3.0 };

impl Admm {
    /// The solver with its usual relaxation, weight and memory.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, relaxation: 1.6, weight: 8.0, memory: 10, steps: Vec::new() }
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
        let sides = Sides::new(contacts, velocities.len());
        let ([masses, traces], crowded) = metric_of(bodies, &sides, velocities.len(), self.weight);
        let count = sides.len();
        let common = Common {
            contacts,
            sides: &sides,
            velocities,
            masses: &masses,
            traces: &traces,
            crowded,
            weight: self.weight,
            relaxation: self.relaxation,
            h: LazyLock::new(Box::new(move || Shared::zeros(count))),
            impulses: Shared::zeros(contacts.len()),
            v: Shared::zeros(velocities.len()),
        };
        let mut steps = std::mem::take(&mut self.steps);
        let parts = parts(bodies, impulses, &common, &mut steps);
        let act = |order: &Order, part: &mut Part<'_, '_>, room: &mut Room| {
            part.act(order, &common, room);
        };
        let crew = Crew::new(parts.into_iter(), act);
        let period = if sides.len() > FEW { PERIOD } else { 1 };
        let attempts = if crowded { [&IN_CROWD, &IN_CROWD] } else { [&AT_START, &AT_END] };
        let report = crew.led(|lead| {
            let report = self.lead(lead, period, attempts);
            lead.order(Order::End);
            report
        });
        drop(crew);
        steps.truncate(ROOMS);
        self.steps = steps;
        bodies.par_iter_mut().for_each(|body| body.forget_weights());
        report
    }
}

impl Admm {
    /// Leads all parts to the end, by steps of the acceleration that are so many iterations, and descents at the
    /// start and near the end.
    fn lead<'a, 'b, A>(
        &self,
        lead: &Lead<'_, '_, Part<'a, 'b>, Order, Room, A>,
        period: usize,
        [at_start, at_end]: [&DescentPlan; 2],
    ) -> Result<Report, ContactError>
    where
        A: Fn(&Order, &mut Part<'a, 'b>, &mut Room) + Sync,
    {
        let tolerance = &self.tolerance;
        let mut iterations = 0;
        let descend = |found: &Report, attempt, iterations: &mut usize| {
            let found = descend(lead, tolerance, tolerance.error(found), attempt, iterations);
            found.map(|found| Report { iterations: *iterations, converged: true, ..found })
        };
        if let Some(found) = descend(&judge(lead), at_start, &mut iterations) {
            return Ok(found);
        }
        lead.order(Order::SetOut);
        let mut refused = None;
        lead.each(|part| refused = refused.take().or(part.refused.take()));
        if let Some(error) = refused {
            return Err(error);
        }
        let mut anderson = Anderson::new(self.memory, period);
        loop {
            iterations += 1;
            let last = iterations >= tolerance.iterations;
            let looked_at = last || iterations.is_multiple_of(LOOK);
            lead.order(Order::Obey { looked_at });
            let (sets_out, turn) = (anderson.sets_out(), anderson.turn());
            lead.order(Order::Respond { sets_out, turn, looked_at });
            if let Turn::Look(_) = turn {
                let mut products = Products::default();
                lead.each(|part| products.add(&part.products));
                lead.order(Order::Onward(anderson.onward(&products)));
            }
            if !looked_at {
                continue;
            }
            lead.order(Order::Compare);
            if last || tolerance.reached(&together(lead)) {
                lead.order(Order::Tell);
                let found = judge(lead);
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

/// Chooses the metric, kg, and finds the traces of own answers, 1/kg, by point. Tells whether most points are
/// in a crowd.
fn metric_of(
    bodies: &mut [&mut dyn Body],
    sides: &Sides,
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
            let counts: Vec<usize> = range.map(|point| sides.at(point).len()).collect();
            metric::masses(&mut **body, &counts, weight, own)
        })
        .collect::<Vec<usize>>();
    (all, 2 * crowded.into_iter().sum::<usize>() > points)
}

/// Cuts bodies and contacts into parts, by their number alone.
fn parts<'a, 'b>(
    mut bodies: &'a mut [&'b mut dyn Body],
    mut impulses: &'a mut [Vector3<f64>],
    common: &Common,
    steps: &'a mut Vec<[anderson::Part; 2]>,
) -> Vec<Part<'a, 'b>> {
    let groups = groups(bodies, common.sides);
    let contacts = impulses.len();
    let count = groups.len().max(contacts.div_ceil(CONTACTS));
    steps.resize_with(steps.len().max(count), Default::default);
    // Spread evenly where there are fewer groups than parts.
    let cut = |all: usize, part: usize| all * part / count;
    let (mut own, mut points) = (Vec::with_capacity(count), 0..0);
    for (part, steps) in (0..count).zip(steps) {
        let of_part = &groups[cut(groups.len(), part)..cut(groups.len(), part + 1)];
        let own_bodies = of_part.iter().map(|(bodies, _)| bodies).sum();
        points = points.end..of_part.last().map_or(points.end, |(_, points)| *points);
        let own_contacts = cut(contacts, part)..cut(contacts, part + 1);
        let (of_bodies, rest) = std::mem::take(&mut bodies).split_at_mut(own_bodies);
        bodies = rest;
        let (of_contacts, rest) = std::mem::take(&mut impulses).split_at_mut(own_contacts.len());
        impulses = rest;
        own.push(((of_bodies, points.clone()), (of_contacts, own_contacts), steps.each_mut()));
    }
    let part = |(bodies, contacts, steps)| Part::new(common, bodies, contacts, steps);
    own.into_par_iter().map(part).collect()
}

/// How many bodies are taken together, and where their points end.
fn groups(bodies: &[&mut dyn Body], sides: &Sides) -> Vec<(usize, usize)> {
    let mut groups = Vec::new();
    let (mut count, mut start) = (0, 0);
    for Range { end, .. } in ranges(bodies) {
        count += 1;
        if sides.of(&(start..end)).len() >= SIDES {
            groups.push((count, end));
            (count, start) = (0, end);
        }
    }
    if count > 0 {
        groups.push((count, ranges(bodies).last().map_or(0, |range| range.end)));
    }
    groups
}

/// The points of each body.
fn ranges(bodies: &[&mut dyn Body]) -> Vec<Range<usize>> {
    let mut start = 0;
    let range = |body: &&mut dyn Body| {
        let range = start..start + body.points();
        start = range.end;
        range
    };
    bodies.iter().map(range).collect()
}
