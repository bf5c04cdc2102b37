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
//! difference is the error of either, `R (z - v)` in impulses.

use crate::anderson::Anderson;
use crate::contact::free_solve;
use crate::metric;
use crate::residual::slip_error;
use crate::solver::check;
use crate::{Body, Contact, ContactError, Report, Solver, report};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::ops::Range;

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
    pub const EXACT: Self =
        Self { residual: 1e-12, normal: f64::INFINITY, slip: f64::INFINITY, iterations: 20_000 };

    /// The largest of the errors found, in tolerances: at most one where all are kept.
    #[must_use]
    pub fn error(&self, found: &Report) -> f64 {
        let normal = found.normal_error / self.normal;
        (found.residual / self.residual).max(normal).max(found.slip_error / self.slip)
    }

    fn reached(&self, found: &Report) -> bool {
        self.error(found) <= 1.0
    }
}

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
    sides: Sides,
    anderson: Anderson,
}

/// What the iteration knows of the sides of contacts, sorted by point, and of the points, in the
/// order of the bodies.
#[derive(Debug, Clone, Default)]
struct Sides {
    /// Where the sides at each point start; one more than there are points.
    starts: Vec<usize>,
    /// Contact of each side, and the sign of its impulse there.
    contact: Vec<(usize, f64)>,
    /// Sides of each contact.
    of_contact: Vec<[Option<usize>; 2]>,
    /// Metric of every side, kg.
    metric: Vec<f64>,
    /// State of every side, and what an iteration adds to it.
    h: Vec<Vector3<f64>>,
    step: Vec<Vector3<f64>>,
    /// Impulses that act in the given velocities, by point.
    given: Vec<Vector3<f64>>,
    /// Velocities, impulses to respond to, and responses, by point.
    v: Vec<Vector3<f64>>,
    asked: Vec<Vector3<f64>>,
    answer: Vec<Vector3<f64>>,
}

/// Iterations between two looks at the tolerance.
const LOOK: usize = 5;
/// Contacts that one task takes.
const CHUNK: usize = 256;

impl Admm {
    /// The solver with its usual relaxation, weight and memory.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self {
            tolerance,
            relaxation: 1.6,
            weight: 8.0,
            memory: 10,
            sides: Sides::default(),
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
        self.anderson.reset(self.memory);
        let sides = &mut self.sides;
        sides.prepare(bodies, contacts, velocities, impulses, self.weight)?;
        let responses = sides.responses();
        let weights: Vec<f64> = responses.iter().map(|w| 1.0 / w).collect();
        let roots: Vec<f64> = sides.metric.iter().map(|mass| mass.sqrt()).collect();
        // Impulses on the first points, world.
        let mut world = vec![Vector3::zeros(); contacts.len()];
        let mut iterations = 0;
        loop {
            iterations += 1;
            sides.obey(contacts, &responses, impulses, &mut world);
            sides.respond(bodies, velocities, &world, self.relaxation);
            if self.memory > 0 {
                self.anderson.next(&roots, &sides.step, &mut sides.h);
            } else {
                sides.h.iter_mut().zip(&sides.step).for_each(|(h, step)| *h += step);
            }
            let last = iterations >= self.tolerance.iterations;
            if !iterations.is_multiple_of(LOOK) && !last {
                continue;
            }
            let near = sides.error(contacts, &responses, impulses, self.relaxation);
            if last || self.tolerance.reached(&near) {
                sides.truth(bodies, velocities, &world);
                let velocities: Vec<_> = contacts
                    .par_iter()
                    .zip(&*impulses)
                    .map(|(c, r)| c.relative(&sides.v) + r * c.compliance)
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

impl Sides {
    /// Chooses the metric and starts at the given impulses.
    fn prepare(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
        weight: f64,
    ) -> Result<(), ContactError> {
        let points = velocities.len();
        self.sort(contacts, points);
        for array in [&mut self.given, &mut self.asked, &mut self.answer] {
            array.clear();
            array.resize(points, Vector3::zeros());
        }
        self.v.clear();
        self.v.extend_from_slice(velocities);
        let on_side =
            |&(contact, sign): &(usize, f64)| contacts[contact].frame * impulses[contact] * sign;
        for point in 0..points {
            let sides = &self.contact[self.starts[point]..self.starts[point + 1]];
            self.given[point] = sides.iter().map(on_side).sum();
        }
        let mut masses = vec![0.0; points];
        let parts = split(&mut masses, bodies);
        let ranges = ranges(bodies);
        let starts = &self.starts;
        bodies
            .par_iter_mut()
            .zip(parts)
            .zip(ranges)
            .map(|((body, masses), range)| {
                let sides: Vec<usize> =
                    range.map(|point| starts[point + 1] - starts[point]).collect();
                metric::masses(&mut **body, &sides, weight, masses);
                let both = masses.iter().zip(&sides);
                let weights: Vec<f64> = both.map(|(mass, &sides)| mass * sides as f64).collect();
                body.set_weights(&weights)
            })
            .collect::<Result<(), _>>()?;
        self.metric.clear();
        self.h.clear();
        for point in 0..points {
            for side in &self.contact[self.starts[point]..self.starts[point + 1]] {
                self.metric.push(masses[point]);
                self.h.push(velocities[point] - on_side(side) / masses[point]);
            }
        }
        self.step.clear();
        self.step.resize(self.h.len(), Vector3::zeros());
        Ok(())
    }

    /// Sorts the sides of all contacts by their points.
    fn sort(&mut self, contacts: &[Contact], points: usize) {
        self.starts.clear();
        self.starts.resize(points + 1, 0);
        let sides = |c: &Contact| [Some((c.first, 1.0)), c.second.map(|point| (point, -1.0))];
        for (point, _) in contacts.iter().flat_map(sides).flatten() {
            self.starts[point + 1] += 1;
        }
        for point in 0..points {
            self.starts[point + 1] += self.starts[point];
        }
        let mut next = self.starts.clone();
        self.contact.clear();
        self.contact.resize(self.starts[points], (0, 0.0));
        self.of_contact.clear();
        for (i, contact) in contacts.iter().enumerate() {
            self.of_contact.push(sides(contact).map(|side| {
                side.map(|(point, sign)| {
                    let at = next[point];
                    self.contact[at] = (i, sign);
                    next[point] += 1;
                    at
                })
            }));
        }
    }

    /// Answer of each contact to its own impulse in the metric, 1/kg.
    fn responses(&self) -> Vec<f64> {
        let one = |side: &Option<usize>| side.map_or(0.0, |side| 1.0 / self.metric[side]);
        self.of_contact.iter().map(|[first, second]| one(first) + one(second)).collect()
    }

    /// Solves every contact by itself, where the sides have the velocities `h` without it.
    fn obey(
        &self,
        contacts: &[Contact],
        responses: &[f64],
        impulses: &mut [Vector3<f64>],
        world: &mut [Vector3<f64>],
    ) {
        let velocity = |side: &Option<usize>| side.map_or_else(Vector3::zeros, |side| self.h[side]);
        let solve = |(contact, [first, second]): (&Contact, &[Option<usize>; 2]),
                     response: &f64| {
            let q = contact.frame.tr_mul(&(velocity(first) - velocity(second))) + contact.bias;
            free_solve(contact, &q, *response)
        };
        impulses
            .par_chunks_mut(CHUNK)
            .zip(world.par_chunks_mut(CHUNK))
            .zip(contacts.par_chunks(CHUNK).zip(self.of_contact.par_chunks(CHUNK)))
            .zip(responses.par_chunks(CHUNK))
            .for_each(|(((impulses, world), (contacts, sides)), responses)| {
                for (i, one) in contacts.iter().zip(sides).enumerate() {
                    impulses[i] = solve(one, &responses[i]);
                    world[i] = one.0.frame * impulses[i];
                }
            });
    }

    /// Lets the bodies move as near to `2 z - h` as they can, and finds the step to the next state.
    fn respond(
        &mut self,
        bodies: &mut [&mut dyn Body],
        base: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
        relaxation: f64,
    ) {
        let ranges = ranges(bodies);
        let Self { starts, contact, metric, h, step, given, v, asked, answer, .. } = self;
        let (starts, contact, metric, h) = (&*starts, &*contact, &*metric, &*h);
        let (v, asked, answer) = (split(v, bodies), split(asked, bodies), split(answer, bodies));
        let mut rest = &mut step[..];
        let steps: Vec<_> = ranges
            .iter()
            .map(|range| {
                let count = starts[range.end] - starts[range.start];
                let (head, tail) = std::mem::take(&mut rest).split_at_mut(count);
                rest = tail;
                head
            })
            .collect();
        let impulse = |side: usize| impulses[contact[side].0] * contact[side].1;
        bodies
            .par_iter_mut()
            .zip(ranges)
            .zip(steps.into_par_iter().zip(v))
            .zip(asked.into_par_iter().zip(answer))
            .for_each(|(((body, range), (step, v)), (asked, answer))| {
                for (point, asked) in range.clone().zip(&mut *asked) {
                    *asked = -given[point];
                    for side in starts[point]..starts[point + 1] {
                        *asked += (h[side] - base[point]) * metric[side] + impulse(side) * 2.0;
                    }
                }
                body.weighted_respond(asked, answer);
                let first = starts[range.start];
                for ((point, v), answer) in range.zip(v).zip(answer) {
                    *v = base[point] + *answer;
                    for side in starts[point]..starts[point + 1] {
                        let z = h[side] + impulse(side) / metric[side];
                        step[side - first] = (*v - z) * relaxation;
                    }
                }
            });
    }

    /// The velocities that the impulses really cause.
    fn truth(
        &mut self,
        bodies: &mut [&mut dyn Body],
        base: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
    ) {
        let ranges = ranges(bodies);
        let Self { starts, contact, given, v, asked, .. } = self;
        let (v, asked) = (split(v, bodies), split(asked, bodies));
        let bodies = bodies.par_iter_mut().zip(ranges);
        bodies.zip(asked.into_par_iter().zip(v)).for_each(|((body, range), (asked, v))| {
            for (point, asked) in range.clone().zip(&mut *asked) {
                *asked = -given[point];
                for (contact, sign) in &contact[starts[point]..starts[point + 1]] {
                    *asked += impulses[*contact] * *sign;
                }
            }
            body.respond(asked, v);
            v.iter_mut().zip(&base[range]).for_each(|(v, base)| *v += base);
        });
    }

    /// How far what the contacts want is from what the bodies do.
    fn error(
        &self,
        contacts: &[Contact],
        responses: &[f64],
        impulses: &[Vector3<f64>],
        relaxation: f64,
    ) -> Report {
        let step = |side: Option<usize>| side.map_or_else(Vector3::zeros, |side| self.step[side]);
        let part = |chunk: usize| {
            let (mut wrong, mut all, mut found) = (0.0, 0.0, Report::default());
            for i in chunk * CHUNK..contacts.len().min((chunk + 1) * CHUNK) {
                let (contact, r, [first, second]) =
                    (&contacts[i], &impulses[i], self.of_contact[i]);
                let mut off = contact.frame.tr_mul(&(step(first) - step(second))) / relaxation;
                let velocity = contact.relative(&self.v);
                if r.x <= -contact.adhesion {
                    // Nothing holds it: only what closes the gap is wrong.
                    off = Vector3::new(velocity.x.min(0.0), 0.0, 0.0);
                }
                let velocity = velocity + r * contact.compliance;
                let slip = slip_error(contact, &velocity, r, 1.0 / responses[i]);
                wrong += off.norm_squared() / (responses[i] * responses[i]);
                all += r.norm_squared();
                found.normal_error = found.normal_error.max(off.x.abs());
                found.slip_error = found.slip_error.max(slip);
            }
            (wrong, all, found)
        };
        let parts: Vec<_> = (0..contacts.len().div_ceil(CHUNK)).into_par_iter().map(part).collect();
        let (mut wrong, mut all, mut found) = (0.0, 0.0, Report::default());
        for (of_part, all_of_part, part) in parts {
            wrong += of_part;
            all += all_of_part;
            found.normal_error = found.normal_error.max(part.normal_error);
            found.slip_error = found.slip_error.max(part.slip_error);
        }
        if wrong > 0.0 {
            found.residual = if all > 0.0 { (wrong / all).sqrt() } else { f64::INFINITY };
        }
        found
    }
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

/// Cuts an array over all points into those of each body.
fn split<'a, T>(mut array: &'a mut [T], bodies: &[&mut dyn Body]) -> Vec<&'a mut [T]> {
    let cut = |body: &&mut dyn Body| {
        let (head, tail) = std::mem::take(&mut array).split_at_mut(body.points());
        array = tail;
        head
    };
    bodies.iter().map(cut).collect()
}
