//! The alternating direction method of multipliers, as Douglas-Rachford splitting on the velocities
//! of the points.
//!
//! One half of an iteration solves every contact by itself, the other every body by itself, so both
//! are parallel and the result does not depend on who computes what. A point `i` has a metric `R_i`,
//! a multiple of the identity, so that a contact alone is solved in closed form. With `h` the state,
//!
//! ```text
//! z  = the velocities nearest to h, in the metric, that with some impulses r obey the law
//! v  = the velocities nearest to 2 z - h that the bodies can have
//! h <- h + alpha (v - z)
//! ```
//!
//! Where `v = z` both hold: the bodies move as `r` makes them, and `r` obeys the law. Their
//! difference is the error of either, `R (z - v)` in impulses.

use crate::anderson::Anderson;
use crate::contact::free_solve;
use crate::solver::check;
use crate::{Body, Contact, ContactError, Report, Solver, report};
use nalgebra::Vector3;
use rayon::prelude::*;

/// When a solver stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest Coulomb residual, relative to all impulses.
    pub residual: f64,
    /// Largest error of a normal velocity, m/s.
    pub normal: f64,
    /// Largest slip of a contact that sticks, m/s.
    pub slip: f64,
    /// Most iterations.
    pub iterations: usize,
}

impl Tolerance {
    /// For single bodies and tests: to a relative residual of 1e-12.
    pub const EXACT: Self = Self {
        residual: 1e-12,
        normal: f64::INFINITY,
        slip: f64::INFINITY,
        iterations: 20_000,
    };

    fn reached(&self, found: &Report) -> bool {
        found.residual <= self.residual
            && found.normal_error <= self.normal
            && found.slip_error <= self.slip
    }
}

/// The solver for thousands of contacts: cost linear in points and contacts an iteration.
#[derive(Debug, Clone)]
pub struct Admm {
    /// When to stop.
    pub tolerance: Tolerance,
    /// Over-relaxation `alpha`, between 0 and 2.
    pub relaxation: f64,
    /// Metric of a point in units of its own inertia: larger trusts impulses more, smaller
    /// velocities.
    pub weight: f64,
    /// How many steps the acceleration remembers; 0 for none.
    pub memory: usize,
    points: Points,
    anderson: Anderson,
}

/// What the iteration knows of the points, in the order of the bodies.
#[derive(Debug, Clone, Default)]
struct Points {
    /// Contact of each point, or `u32::MAX`, and the sign of its impulse.
    contact: Vec<(u32, f64)>,
    /// Metric, kg.
    metric: Vec<f64>,
    /// Impulses that act in the given velocities, world.
    given: Vec<Vector3<f64>>,
    /// State, velocities, impulses to respond to, and responses, world.
    h: Vec<Vector3<f64>>,
    v: Vec<Vector3<f64>>,
    asked: Vec<Vector3<f64>>,
    answer: Vec<Vector3<f64>>,
    /// What an iteration adds to the state.
    step: Vec<Vector3<f64>>,
}

/// Iterations between two looks at the tolerance.
const LOOK: usize = 5;
/// Contacts that one task takes.
const CHUNK: usize = 1024;
const NONE: u32 = u32::MAX;

impl Admm {
    /// The solver with its usual relaxation and weight.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self {
            tolerance,
            relaxation: 1.6,
            weight: 4.0,
            memory: 12,
            points: Points::default(),
            anderson: Anderson::default(),
        }
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
        let mut iterations = 0;
        self.points.prepare(bodies, contacts, velocities, impulses, self.weight)?;
        self.anderson.reset(self.memory);
        let points = &self.points;
        let responses: Vec<f64> = contacts
            .iter()
            .map(|c| 1.0 / points.metric[c.first] + c.second.map_or(0.0, |b| 1.0 / points.metric[b]))
            .collect();
        let weights: Vec<f64> = responses.iter().map(|w| 1.0 / w).collect();
        // Impulses on the first points, world.
        let mut world: Vec<Vector3<f64>> = vec![Vector3::zeros(); contacts.len()];
        loop {
            let h = &self.points.h;
            impulses
                .par_chunks_mut(CHUNK)
                .zip(world.par_chunks_mut(CHUNK))
                .zip(contacts.par_chunks(CHUNK).zip(responses.par_chunks(CHUNK)))
                .for_each(|((impulses, world), (contacts, responses))| {
                    for (i, contact) in contacts.iter().enumerate() {
                        let q = contact.relative(h);
                        impulses[i] = free_solve(contact, &q, responses[i]);
                        world[i] = contact.frame * impulses[i];
                    }
                });
            let points = &mut self.points;
            points.respond(bodies, velocities, &world, self.relaxation);
            if self.memory > 0 {
                self.anderson.next(&points.metric, &points.step, &mut points.h);
            } else {
                points.h.iter_mut().zip(&points.step).for_each(|(h, step)| *h += step);
            }
            iterations += 1;
            let last = iterations >= self.tolerance.iterations;
            if iterations.is_multiple_of(LOOK) || last {
                let near = points.error(contacts, &responses, impulses, self.relaxation);
                if last || self.tolerance.reached(&near) {
                    points.truth(bodies, velocities, &world);
                    let velocities: Vec<_> = contacts
                        .iter()
                        .zip(&*impulses)
                        .map(|(c, r)| c.relative(&points.v) + r * c.compliance)
                        .collect();
                    let found = report(contacts, &velocities, impulses, &weights);
                    let converged = self.tolerance.reached(&found);
                    if converged || last {
                        return Ok(Report { iterations, converged, ..found });
                    }
                }
            }
        }
    }
}

impl Points {
    /// Chooses the metric and starts at the given impulses.
    fn prepare(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
        weight: f64,
    ) -> Result<(), ContactError> {
        let count = velocities.len();
        let zero = Vector3::zeros();
        let Self { given, h, asked, answer, step, .. } = self;
        for array in [given, h, asked, answer, step] {
            array.clear();
            array.resize(count, zero);
        }
        self.v.clear();
        self.v.extend_from_slice(velocities);
        self.contact.clear();
        self.contact.resize(count, (NONE, 0.0));
        for ((contact, impulse), i) in contacts.iter().zip(impulses).zip(0..) {
            let impulse = contact.frame * impulse;
            self.contact[contact.first] = (i, 1.0);
            self.given[contact.first] = impulse;
            if let Some(second) = contact.second {
                self.contact[second] = (i, -1.0);
                self.given[second] = -impulse;
            }
        }
        self.metric.clear();
        self.metric.resize(count, 0.0);
        let parts = split(&mut self.metric, bodies);
        let contact = split(&mut self.contact, bodies);
        bodies
            .par_iter_mut()
            .zip(parts)
            .zip(contact)
            .map(|((body, metric), contact)| {
                body.own_traces(metric);
                for (metric, (contact, _)) in metric.iter_mut().zip(contact) {
                    // A point that nothing moves has no inertia to compare with.
                    let inertia = if *metric > 0.0 { 3.0 / *metric } else { 1.0 };
                    *metric = if *contact == NONE { 0.0 } else { weight * inertia };
                }
                body.set_weights(metric)
            })
            .collect::<Result<(), _>>()?;
        for i in 0..count {
            if self.metric[i] > 0.0 {
                self.h[i] = velocities[i] - self.given[i] / self.metric[i];
            }
        }
        Ok(())
    }

    /// How far what the contacts want is from what the bodies do.
    fn error(
        &self,
        contacts: &[Contact],
        responses: &[f64],
        impulses: &[Vector3<f64>],
        relaxation: f64,
    ) -> Report {
        let (mut wrong, mut all) = (0.0, 0.0);
        let mut found = Report::default();
        for ((contact, response), r) in contacts.iter().zip(responses).zip(impulses) {
            let mut off = self.step[contact.first];
            if let Some(second) = contact.second {
                off -= self.step[second];
            }
            let mut off = contact.frame.tr_mul(&off) / relaxation;
            if r.x <= -contact.adhesion {
                // Nothing holds it: only what closes the gap is wrong.
                off.y = 0.0;
                off.z = 0.0;
                off.x = contact.relative(&self.v).x.min(0.0);
            }
            wrong += off.norm_squared() / (response * response);
            all += r.norm_squared();
            found.normal_error = found.normal_error.max(off.x.abs());
            found.slip_error = found.slip_error.max(off.yz().norm());
        }
        if wrong > 0.0 {
            found.residual = if all > 0.0 { (wrong / all).sqrt() } else { f64::INFINITY };
        }
        found
    }

    /// The velocities that the impulses really cause.
    fn truth(
        &mut self,
        bodies: &mut [&mut dyn Body],
        base: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
    ) {
        for (i, (contact, sign)) in self.contact.iter().enumerate() {
            let acts = if *contact == NONE {
                Vector3::zeros()
            } else {
                impulses[*contact as usize] * *sign
            };
            self.asked[i] = acts - self.given[i];
        }
        let asked = split(&mut self.asked, bodies);
        let v = split(&mut self.v, bodies);
        bodies
            .par_iter_mut()
            .zip(asked.into_par_iter().zip(v))
            .for_each(|(body, (asked, v))| body.respond(asked, v));
        for (v, base) in self.v.iter_mut().zip(base) {
            *v += base;
        }
    }

    /// Lets the bodies move as near to `2 z - h` as they can, and finds the step to the next state.
    fn respond(
        &mut self,
        bodies: &mut [&mut dyn Body],
        base: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
        relaxation: f64,
    ) {
        let Self { contact, metric, given, h, v, asked, answer, step } = self;
        let (step, v) = (split(step, bodies), split(v, bodies));
        let (asked, answer) = (split(asked, bodies), split(answer, bodies));
        let mut start = 0;
        let ranges: Vec<_> = bodies
            .iter()
            .map(|body| {
                let range = start..start + body.points();
                start = range.end;
                range
            })
            .collect();
        bodies
            .par_iter_mut()
            .zip(ranges)
            .zip(step.into_par_iter().zip(v))
            .zip(asked.into_par_iter().zip(answer))
            .for_each(|(((body, range), (step, v)), (asked, answer))| {
                let h = &h[range.clone()];
                let (contact, metric) = (&contact[range.clone()], &metric[range.clone()]);
                let (given, base) = (&given[range.clone()], &base[range]);
                let impulse = |i: usize| {
                    let (contact, sign) = contact[i];
                    if contact == NONE { Vector3::zeros() } else { impulses[contact as usize] * sign }
                };
                for i in 0..h.len() {
                    asked[i] = (h[i] - base[i]) * metric[i] + impulse(i) * 2.0 - given[i];
                }
                body.weighted_respond(asked, answer);
                for i in 0..h.len() {
                    v[i] = base[i] + answer[i];
                    if metric[i] > 0.0 {
                        let z = h[i] + impulse(i) / metric[i];
                        step[i] = (v[i] - z) * relaxation;
                    }
                }
            });
    }
}

/// Cuts an array of points into those of each body.
fn split<'a, T>(mut array: &'a mut [T], bodies: &[&mut dyn Body]) -> Vec<&'a mut [T]> {
    let cut = |body: &&mut dyn Body| {
        let (head, tail) = std::mem::take(&mut array).split_at_mut(body.points());
        array = tail;
        head
    };
    bodies.iter().map(cut).collect()
}
