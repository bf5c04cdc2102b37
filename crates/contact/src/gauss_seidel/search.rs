use super::GaussSeidel;
use super::delassus::{Delassus, Place};
use crate::residual::{report, slip_error};
use crate::{Contact, Report, Tolerance, Violation, solve_contact};
use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, NullaryFnOnce};
use std::collections::VecDeque;

/// The part of a tolerance that contacts may leave before they are solved.
const PART: f64 = 0.9;
/// How much of the residual contacts may leave first, in what they would if all left as much.
const MUCH: f64 = 4.0;
/// By what part of that the velocity of a point may change before its contacts are looked at again.
const CHANGE: f64 = 0.05;

/// Looks in a row at which no fewer contacts are wrong than were ever before, after which it gives up.
const LOOKS: usize = 2;

/// A search, with the velocities while the impulses found so far act.
pub(super) struct Search<'a> {
    solver: &'a GaussSeidel,
    delassus: Delassus<'a>,
    contacts: &'a [Contact],
    impulses: &'a mut [Vector3<f64>],
    /// By contact: its points, how it answers itself, and the mass that compares its impulse and its velocity.
    places: Vec<[Option<Place>; 2]>,
    responses: Vec<Matrix3<f64>>,
    weights: Vec<f64>,
    /// By point: the contacts there, from a start to the next.
    starts: Vec<u32>,
    at_points: Vec<u32>,
    /// Sum of the squares of all impulses from the tips of their cones.
    squares: f64,
    /// Contacts to look at, and which these are.
    queue: VecDeque<u32>,
    waits: Vec<bool>,
}

/// How well contacts are solved at a time.
#[derive(Clone, Copy)]
struct Pass {
    /// The part of the residual that a contact may leave, if all left as much; the first pass looks at
    /// velocities alone, as few need more.
    share: f64,
    /// Solves, at most.
    most: usize,
}

impl Pass {
    const FIRST: Self = Self { share: f64::INFINITY, most: usize::MAX };

    /// The part of the tolerances of velocities that a contact may leave.
    fn part(&self) -> f64 {
        PART.min(self.share)
    }

    /// One that asks for more, as the tolerance is missed although no contact leaves more than it may. Few
    /// contacts have most of the residual.
    fn next(&self) -> Self {
        let share = if self.share.is_finite() { 0.5 * self.share } else { MUCH };
        Self { share, ..*self }
    }
}

impl<'a> Search<'a> {
    pub(super) fn new(
        solver: &'a GaussSeidel,
        delassus: Delassus<'a>,
        contacts: &'a [Contact],
        impulses: &'a mut [Vector3<f64>],
    ) -> Self {
        let responses: Vec<_> = contacts.iter().map(|c| delassus.own_response(c)).collect();
        let places: Vec<_> = contacts.iter().map(|contact| delassus.places(contact)).collect();
        let weight = |(contact, response): (&Contact, &Matrix3<f64>)| {
            let trace = response.trace() + 3.0 * contact.compliance;
            // What cannot move has no weight of its own: any will do.
            if trace > 0.0 { 3.0 / trace } else { 1.0 }
        };
        let weights = contacts.iter().zip(&responses).map(weight).collect();
        let mut starts = vec![0; delassus.len() + 1];
        for place in places.iter().flatten().flatten() {
            starts[place.point + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut at_points = vec![0; starts.last().map_or(0, |&all| all as usize)];
        let mut next = starts.clone();
        for (i, places) in (0..).zip(&places) {
            for place in places.iter().flatten() {
                let next = &mut next[place.point];
                at_points[*next as usize] = i;
                *next += 1;
            }
        }
        let squares = contacts.iter().zip(&*impulses).map(|(c, r)| square(c, r)).sum();
        let (queue, waits) = (VecDeque::new(), vec![false; contacts.len()]);
        Self {
            solver,
            delassus,
            contacts,
            impulses,
            places,
            responses,
            weights,
            starts,
            at_points,
            squares,
            queue,
            waits,
        }
    }

    pub(super) fn run(mut self) -> Report {
        let tolerance = self.solver.tolerance;
        let count = self.contacts.len();
        let mut order: Vec<u32> = (0..).take(count).collect();
        order.sort_by_key(|&i| self.contacts[i as usize].first);
        let most = tolerance.iterations.saturating_mul(count);
        let stride = (self.solver.patience / LOOKS).max(1).saturating_mul(count);
        let (mut pass, mut solved, mut before) = (Pass::FIRST, 0, None);
        let (mut wrong, mut misses) = (usize::MAX, 0);
        loop {
            let velocities: Vec<_> = (0..count).map(|i| self.velocity(i)).collect();
            let found = report(self.contacts, &velocities, self.impulses, &self.weights);
            let converged = tolerance.reached(&found);
            let stuck = before == Some(solved) && pass.share < 1.0;
            if converged || stuck || misses == LOOKS || solved == most {
                let iterations = solved.div_ceil(count.max(1));
                return Report { iterations, converged, ..found };
            }
            before = Some(solved);
            self.queue.clear();
            self.queue.extend(&order);
            self.waits.fill(true);
            pass.most = stride.min(most - solved);
            let solves = Arch::new().dispatch(Relax { search: &mut self, pass });
            solved += solves;
            if solves < pass.most {
                (pass, wrong, misses) = (pass.next(), usize::MAX, 0);
            } else {
                let still = (0..count).filter(|&i| self.is_wrong(i, &pass)).count();
                misses = if still < wrong { 0 } else { misses + 1 };
                wrong = wrong.min(still);
            }
        }
    }

    /// The relative velocity of a contact, with what its impulse compresses.
    #[inline(always)]
    fn velocity(&self, i: usize) -> Vector3<f64> {
        let contact = &self.contacts[i];
        let compressed = self.impulses[i] * contact.compliance;
        self.delassus.relative(contact, self.places[i]) + compressed
    }

    /// Whether a contact is farther from the law than a pass lets it be.
    #[inline(always)]
    fn is_wrong(&self, i: usize, pass: &Pass) -> bool {
        let Tolerance { residual, normal, slip, .. } = self.solver.tolerance;
        let (contact, impulse, weight) = (&self.contacts[i], &self.impulses[i], self.weights[i]);
        let (velocity, load) = (self.velocity(i), impulse.x + contact.adhesion);
        if load <= 0.0 && velocity.x >= 0.0 {
            return false;
        }
        velocity.x.min(load / weight).abs() > pass.part() * normal
            || slip_error(contact, &velocity, impulse, weight) > pass.part() * slip
            || pass.share.is_finite()
                && Violation::new(contact, &velocity, impulse, weight).impulse
                    > pass.share * residual * self.mean()
    }

    /// The root of the mean square of the impulses.
    fn mean(&self) -> f64 {
        (self.squares.max(0.0) / self.contacts.len() as f64).sqrt()
    }

    /// By how much the velocity of a point may change before its contacts are looked at again.
    fn bound(&self, pass: &Pass) -> f64 {
        let Tolerance { residual, normal, slip, .. } = self.solver.tolerance;
        let heaviest = self.weights.iter().copied().fold(0.0, f64::max);
        let by_impulse = pass.share * residual * self.mean() / heaviest;
        let by_velocity = pass.part() * normal.min(slip);
        CHANGE * if pass.share.is_finite() { by_velocity.min(by_impulse) } else { by_velocity }
    }

    /// Solves a contact by itself. Tells whether that changes anything.
    #[inline(always)]
    fn solve(&mut self, i: usize) -> bool {
        let (contact, response, old) = (&self.contacts[i], &self.responses[i], self.impulses[i]);
        let free = self.delassus.relative(contact, self.places[i]) - response * old;
        let exact = solve_contact(contact, response, &free);
        let new = relaxed(contact, self.solver.relaxation, &old, &exact);
        let change = new - old;
        self.impulses[i] = new;
        self.squares += square(contact, &new) - square(contact, &old);
        self.delassus.push(self.places[i], &(contact.frame * change));
        change != Vector3::zeros()
    }

    /// Queues contacts of a patch whose points have changed by more than a bound.
    #[inline(always)]
    fn queue(&mut self, patch: usize, bound: f64) {
        let Self { delassus, starts, at_points, waits, queue, .. } = self;
        delassus.changed(patch, bound, |point| {
            for &i in &at_points[starts[point] as usize..starts[point + 1] as usize] {
                if !waits[i as usize] {
                    waits[i as usize] = true;
                    queue.push_back(i);
                }
            }
        });
    }
}

/// Goes further than the exact solution, but not out of the cone.
#[inline(always)]
fn relaxed(
    contact: &Contact,
    relaxation: f64,
    old: &Vector3<f64>,
    exact: &Vector3<f64>,
) -> Vector3<f64> {
    if relaxation == 1.0 {
        return *exact;
    }
    let relaxed = old + (exact - old) * relaxation;
    let normal = (relaxed.x + contact.adhesion).max(0.0);
    let friction = contact.friction.project(&relaxed.yz(), normal);
    Vector3::new(normal - contact.adhesion, friction.x, friction.y)
}

/// Solves contacts that are wrong until none is. Tells how many solves that took.
struct Relax<'s, 'a> {
    search: &'s mut Search<'a>,
    pass: Pass,
}

impl NullaryFnOnce for Relax<'_, '_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let Self { search, pass } = self;
        let bound = search.bound(&pass);
        let mut solved = 0;
        while let Some(i) = search.queue.pop_front() {
            let i = i as usize;
            search.waits[i] = false;
            search.delassus.look_at(search.places[i]);
            if !search.is_wrong(i, &pass) {
                continue;
            }
            if solved == pass.most {
                break;
            }
            if search.solve(i) {
                solved += 1;
                let [first, second] = search.places[i].map(|place| place.map(|p| p.patch));
                if let Some(patch) = first {
                    search.queue(patch, bound);
                }
                if let Some(patch) = second.filter(|_| second != first) {
                    search.queue(patch, bound);
                }
            }
        }
        solved
    }
}

/// The square of an impulse from the tip of its cone.
fn square(contact: &Contact, impulse: &Vector3<f64>) -> f64 {
    (impulse + Vector3::new(contact.adhesion, 0.0, 0.0)).norm_squared()
}
