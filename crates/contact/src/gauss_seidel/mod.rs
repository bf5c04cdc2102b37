use crate::residual::report;
use crate::{Body, Contact, ContactError, Report, Solver, solve_contact};
use nalgebra::Vector3;

mod delassus;

use delassus::finite;

pub(crate) use delassus::Delassus;

/// Block Gauss-Seidel: one contact after the other is solved exactly while the others' impulses
/// stay, in the order of their first points (root to tip), until all obey the law.
///
/// The reference solver: it knows every answer explicitly and solves every limit curve exactly.
/// Memory and setup grow with the square of the touched points of a body, a sweep costs one column
/// per contact; many contacts per fiber want [`Solver`]s that do without.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussSeidel {
    /// Sweeps after which it stops in any case.
    pub sweeps: usize,
    /// Coulomb residual to reach, see [`Report::residual`].
    pub residual: f64,
    /// Error of normal velocity and slip to reach, m/s.
    pub velocity: f64,
    /// By how much of its change an impulse is replaced, more than zero and less than two; above
    /// one where many contacts support each other.
    pub relaxation: f64,
}

impl Default for GaussSeidel {
    /// At most 1000 sweeps to a residual of 1e-6 and 1 um/s, without relaxation.
    fn default() -> Self {
        Self { sweeps: 1000, residual: 1e-6, velocity: 1e-6, relaxation: 1.0 }
    }
}

impl GaussSeidel {
    fn validate(&self) -> Result<(), ContactError> {
        let checks = [
            ("tolerance of the residual", self.residual, f64::INFINITY),
            ("tolerance of velocities", self.velocity, f64::INFINITY),
            ("relaxation", self.relaxation, 2.0),
        ];
        match checks.into_iter().find(|&(_, value, bound)| !(value > 0.0 && value < bound)) {
            Some((what, value, _)) => Err(ContactError::Invalid {
                what,
                value,
                why: "it must be positive and finite, a relaxation less than two",
            }),
            None => Ok(()),
        }
    }

    /// The velocities in `delassus` are those while `impulses` act, before and after.
    fn sweep(
        &self,
        delassus: &mut Delassus,
        contacts: &[Contact],
        impulses: &mut [Vector3<f64>],
    ) -> Report {
        let mut order: Vec<usize> = (0..contacts.len()).collect();
        order.sort_by_key(|&i| contacts[i].first);
        let responses: Vec<_> = contacts.iter().map(|c| delassus.own_response(c)).collect();
        let weights: Vec<_> = std::iter::zip(contacts, &responses)
            .map(|(contact, response)| {
                let trace = response.trace() + 3.0 * contact.compliance;
                // What cannot move has no weight of its own: any will do.
                if trace > 0.0 { 3.0 / trace } else { 1.0 }
            })
            .collect();
        let mut sweeps = 0;
        loop {
            let velocities: Vec<_> = std::iter::zip(contacts, &*impulses)
                .map(|(c, r)| delassus.relative_velocity(c) + r * c.compliance)
                .collect();
            let mut report = report(contacts, &velocities, impulses, &weights);
            report.iterations = sweeps;
            report.converged = report.residual <= self.residual
                && report.normal_error <= self.velocity
                && report.slip_error <= self.velocity;
            if report.converged || sweeps == self.sweeps {
                return report;
            }
            for &i in &order {
                let contact = &contacts[i];
                let free = delassus.relative_velocity(contact) - responses[i] * impulses[i];
                let exact = solve_contact(contact, &responses[i], &free);
                let relaxed = self.relax(contact, &impulses[i], &exact);
                delassus.apply(contact, &(relaxed - impulses[i]));
                impulses[i] = relaxed;
            }
            sweeps += 1;
        }
    }

    /// Goes further than the exact solution, but not out of the cone.
    fn relax(&self, contact: &Contact, old: &Vector3<f64>, exact: &Vector3<f64>) -> Vector3<f64> {
        if self.relaxation == 1.0 {
            return *exact;
        }
        let relaxed = old + (exact - old) * self.relaxation;
        let normal = (relaxed.x + contact.adhesion).max(0.0);
        let friction = contact.friction.project(&relaxed.yz(), normal);
        Vector3::new(normal - contact.adhesion, friction.x, friction.y)
    }
}

impl Solver for GaussSeidel {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        self.validate()?;
        if impulses.len() != contacts.len() {
            return Err(ContactError::Length {
                what: "impulses of contacts",
                expected: contacts.len(),
                found: impulses.len(),
            });
        }
        finite("component of a starting impulse", impulses)?;
        let mut delassus = Delassus::new(bodies, contacts, velocities)?;
        Ok(self.sweep(&mut delassus, contacts, impulses))
    }
}
