use super::delassus::{Delassus, PatchPoint};
use super::queue::ContactQueue;
use super::settings::GaussSeidel;
use crate::local::LocalProblem;
use crate::residual::{JOINT_CLOSED, report, slips};
use crate::{Contact, Report, Tolerance, Violation};
use nalgebra::Vector3;
use pulp::{Arch, NullaryFnOnce};
use std::borrow::Borrow;

/// Part of a tolerance of velocities that a contact may leave before it is solved.
const PASSED_PART: f64 = 0.9;
/// Share of the residual that a contact may leave first, relative to what it would if all left as
/// much.
const FIRST_SHARE: f64 = 4.0;
/// Change of a point's velocity after which its contacts are looked at again, relative to the
/// errors that they may leave.
const UNSEEN_CHANGE: f64 = 0.05;

/// Checks in a row at which no fewer contacts are wrong than were ever before, after which the
/// search gives up.
const FRUITLESS_CHECKS: usize = 2;

/// A contact with its points, impulse and weight side by side, as they are read together.
#[repr(align(64))]
struct ContactSite {
    contact: Contact,
    /// Places of the two points.
    places: [PatchPoint; 2],
    /// Impulse found so far, N s, in the contact's frame.
    impulse: Vector3<f64>,
    /// Mass that compares errors of the impulse and of the velocity, kg.
    weight: f64,
}

impl Borrow<Contact> for ContactSite {
    fn borrow(&self) -> &Contact {
        &self.contact
    }
}

/// A search, with the velocities while the impulses found so far act.
pub(super) struct ImpulseSearch<'a> {
    solver: &'a GaussSeidel,
    delassus: Delassus<'a>,
    sites: Vec<ContactSite>,
    /// Local problems, by contact.
    locals: Vec<LocalProblem>,
    /// First entry of `contacts_at`, by point, and the number of all.
    starts: Vec<u32>,
    /// Contacts, by the points they are at.
    contacts_at: Vec<u32>,
    /// Sum of the squares of all impulses from the tips of their cones, (N s)^2.
    squares: f64,
    queue: ContactQueue,
    /// Buffer for the points of a patch that have changed.
    changed: Vec<usize>,
}

/// Bounds of the errors that contacts may leave in one pass.
#[derive(Clone, Copy)]
struct PassBounds {
    /// Part of the residual that a contact may leave, if all left as much; the first pass looks at
    /// velocities alone, as few need more.
    share: f64,
    /// Most solved contacts.
    most_solves: usize,
}

impl PassBounds {
    /// First pass, which looks at velocities alone.
    const FIRST: Self = Self { share: f64::INFINITY, most_solves: usize::MAX };

    /// Part of the tolerances of velocities that a contact may leave.
    fn part(&self) -> f64 {
        PASSED_PART.min(self.share)
    }

    /// Next pass, which asks for more, as the tolerance is missed although no contact leaves more
    /// than it may. Few contacts have most of the residual.
    fn next(&self) -> Self {
        let share = if self.share.is_finite() { 0.5 * self.share } else { FIRST_SHARE };
        Self { share, ..*self }
    }
}

impl<'a> ImpulseSearch<'a> {
    /// A search from `impulses`, N s, in the contacts' frames.
    pub(super) fn new(
        solver: &'a GaussSeidel,
        delassus: Delassus<'a>,
        contacts: &[Contact],
        impulses: &[Vector3<f64>],
    ) -> Self {
        let site = |((contact, local), &impulse): ((&Contact, &LocalProblem), &Vector3<f64>)| {
            let trace = local.response.trace() + 3.0 * contact.compliance;
            // What cannot move has no weight of its own: any will do.
            let weight = if trace > 0.0 { 3.0 / trace } else { 1.0 };
            ContactSite {
                contact: contact.clone(),
                places: delassus.places(contact),
                impulse,
                weight,
            }
        };
        let local = |contact| LocalProblem::new(contact, &delassus.own_response(contact));
        let locals: Vec<_> = contacts.iter().map(local).collect();
        let sites: Vec<_> = contacts.iter().zip(&locals).zip(impulses).map(site).collect();
        let mut starts = vec![0; delassus.len() + 1];
        for place in sites.iter().flat_map(|site| site.places) {
            starts[place.point + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut contacts_at = vec![0; starts.last().map_or(0, |&all| all as usize)];
        let mut next = starts.clone();
        for (i, site) in (0..).zip(&sites) {
            for place in site.places {
                let next = &mut next[place.point];
                contacts_at[*next as usize] = i;
                *next += 1;
            }
        }
        let squares = sites.iter().map(|site| square(&site.contact, &site.impulse)).sum();
        let (queue, changed) = (ContactQueue::new(sites.len()), vec![0; delassus.len()]);
        Self { solver, delassus, sites, locals, starts, contacts_at, squares, queue, changed }
    }

    /// Searches, and writes the impulses found.
    pub(super) fn run(mut self, impulses: &mut [Vector3<f64>]) -> Report {
        let tolerance = self.solver.tolerance;
        let count = self.sites.len();
        let mut order: Vec<u32> = (0..).take(count).collect();
        order.sort_by_key(|&i| self.sites[i as usize].contact.first);
        let most = tolerance.iterations.saturating_mul(count);
        let stride = (self.solver.patience / FRUITLESS_CHECKS).max(1).saturating_mul(count);
        let (mut pass, mut solved, mut before) = (PassBounds::FIRST, 0, None);
        let (mut wrong, mut misses) = (usize::MAX, 0);
        if self.solver.sweeps && count <= most {
            solved += Arch::new().dispatch(FullPass { search: &mut self, order: &order });
        }
        loop {
            for (impulse, site) in impulses.iter_mut().zip(&self.sites) {
                *impulse = site.impulse;
            }
            let one = |i: usize| {
                let site = &self.sites[i];
                (&site.contact, self.velocity(site), site.impulse, site.weight)
            };
            let found = report(count, one);
            let converged = tolerance.reached(&found);
            let stuck = before == Some(solved) && pass.share < 1.0;
            if converged || stuck || misses == FRUITLESS_CHECKS || solved == most {
                let iterations = solved.div_ceil(count.max(1));
                return Report { iterations, converged, ..found };
            }
            before = Some(solved);
            self.queue.clear();
            for &i in &order {
                self.queue.push(i);
            }
            pass.most_solves = stride.min(most - solved);
            let solves = Arch::new().dispatch(RelaxationPass { search: &mut self, pass });
            solved += solves;
            if solves < pass.most_solves {
                (pass, wrong, misses) = (pass.next(), usize::MAX, 0);
            } else {
                let still = self.sites.iter().filter(|site| self.is_wrong(site, &pass)).count();
                misses = if still < wrong { 0 } else { misses + 1 };
                wrong = wrong.min(still);
            }
        }
    }

    /// Relative velocity of a contact, m/s, in its frame, with what its compliance adds.
    #[inline(always)]
    fn velocity(&self, site: &ContactSite) -> Vector3<f64> {
        let compressed = site.impulse * site.contact.compliance;
        self.delassus.relative_at(&site.contact, site.places) + compressed
    }

    /// Whether a contact is farther from the law than a pass lets it be.
    #[inline(always)]
    fn is_wrong(&self, site: &ContactSite, pass: &PassBounds) -> bool {
        let Tolerance { residual, normal, slip, .. } = self.solver.tolerance;
        let ContactSite { contact, impulse, weight, .. } = site;
        let (velocity, load) = (self.velocity(site), impulse.x + contact.adhesion);
        if contact.is_joint() {
            return velocity.norm() > (pass.part() * slip).max(JOINT_CLOSED);
        }
        if load <= 0.0 && velocity.x >= 0.0 {
            return false;
        }
        (velocity.x * weight).min(load).abs() > pass.part() * normal * weight
            || slips(contact, &velocity, impulse, *weight, pass.part() * slip)
            || pass.share.is_finite()
                && Violation::new(contact, &velocity, impulse, *weight).impulse
                    > pass.share * residual * self.mean()
    }

    /// Root of the mean square of the impulses, N s.
    fn mean(&self) -> f64 {
        (self.squares.max(0.0) / self.sites.len() as f64).sqrt()
    }

    /// Change of the velocity of a point, m/s, up to which its contacts are not looked at again.
    fn unseen_change(&self, pass: &PassBounds) -> f64 {
        let Tolerance { residual, normal, slip, .. } = self.solver.tolerance;
        let heaviest = self.sites.iter().map(|site| site.weight).fold(0.0, f64::max);
        let by_impulse = pass.share * residual * self.mean() / heaviest;
        let by_velocity = pass.part() * normal.min(slip);
        UNSEEN_CHANGE
            * if pass.share.is_finite() { by_velocity.min(by_impulse) } else { by_velocity }
    }

    /// Solves a contact by itself. Tells whether that changes anything.
    #[inline(always)]
    fn solve(&mut self, i: usize) -> bool {
        let ContactSite { contact, places, impulse, .. } = &mut self.sites[i];
        let (local, old) = (&mut self.locals[i], *impulse);
        // The velocity without the contact's own impulse, the exact solution, and what it changes.
        let free = self.delassus.relative_at(contact, *places) - local.response * old;
        let exact = local.solve(contact, &free);
        let new = relaxed(contact, self.solver.relaxation, &old, &exact);
        let change = new - old;
        *impulse = new;
        self.squares += square(contact, &new) - square(contact, &old);
        self.delassus.push(*places, &(contact.frame * change));
        change != Vector3::zeros()
    }

    /// Queues contacts of a patch whose points have changed by more than a bound.
    #[inline(always)]
    fn queue(&mut self, patch: usize, bound: f64) {
        let Self { delassus, starts, contacts_at, queue, changed, .. } = self;
        let count = delassus.changed_points(patch, bound, changed);
        for &point in &changed[..count] {
            let [start, end] = [0, 1].map(|next| starts[point + next] as usize);
            contacts_at[start..end].iter().for_each(|&i| queue.push(i));
        }
    }
}

/// Impulse that goes further than the exact solution, but not out of the cone, N s.
#[inline(always)]
fn relaxed(
    contact: &Contact,
    relaxation: f64,
    old: &Vector3<f64>,
    exact: &Vector3<f64>,
) -> Vector3<f64> {
    if relaxation == 1.0 || contact.is_joint() {
        return *exact;
    }
    let relaxed = old + (exact - old) * relaxation;
    let normal = (relaxed.x + contact.adhesion).max(0.0);
    let friction = contact.friction.project(&relaxed.yz(), normal);
    Vector3::new(normal - contact.adhesion, friction.x, friction.y)
}

/// Pass that solves contacts that are wrong until none is, and returns the number of solves.
struct RelaxationPass<'s, 'a> {
    search: &'s mut ImpulseSearch<'a>,
    pass: PassBounds,
}

impl NullaryFnOnce for RelaxationPass<'_, '_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let Self { search, pass } = self;
        let bound = search.unseen_change(&pass);
        let mut solved = 0;
        while let Some(i) = search.queue.pop() {
            search.delassus.look_at(search.sites[i].places);
            if !search.is_wrong(&search.sites[i], &pass) {
                continue;
            }
            if solved == pass.most_solves {
                break;
            }
            if search.solve(i) {
                solved += 1;
                let [first, second] = search.sites[i].places.map(|place| place.patch);
                search.queue(first, bound);
                if second != first {
                    search.queue(second, bound);
                }
            }
        }
        solved
    }
}

/// Solves all contacts once, and returns their number.
struct FullPass<'s, 'a> {
    search: &'s mut ImpulseSearch<'a>,
    order: &'s [u32],
}

impl NullaryFnOnce for FullPass<'_, '_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        for &i in self.order {
            self.search.solve(i as usize);
        }
        self.order.len()
    }
}

/// Square of an impulse from the tip of its cone, (N s)^2.
fn square(contact: &Contact, impulse: &Vector3<f64>) -> f64 {
    (impulse + Vector3::new(contact.adhesion, 0.0, 0.0)).norm_squared()
}
