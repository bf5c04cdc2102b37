//! What all parts of the solver see.

use super::contact_sides::ContactSides;
use super::shared_vectors::SharedVectors;
use crate::{Contact, ErrorMasses, FreeMasses};
use nalgebra::Vector3;
use std::sync::LazyLock;

/// The problem, the metric and the state of the iteration, read by all parts.
pub(super) struct AdmmState<'a> {
    pub(super) contacts: &'a [Contact],
    pub(super) sides: &'a ContactSides,
    /// Velocities of the points while the given impulses act, m/s, world.
    pub(super) velocities: &'a [Vector3<f64>],
    /// Metric of every side at a point, by point, kg.
    pub(super) metric: &'a [f64],
    /// Traces of the points' answers to impulses on themselves, by point, 1/kg.
    pub(super) traces: &'a [f64],
    /// How heavy is what moves where free bodies touch.
    pub(super) free: FreeMasses,
    /// Whether most points are in a crowd.
    pub(super) crowded: bool,
    /// Weight by which the metric was chosen, in inertias of a point.
    pub(super) metric_weight: f64,
    /// Over-relaxation `alpha`, between 0 and 2.
    pub(super) relaxation: f64,
    /// State `h` of the splitting, by side, as a change from the given velocities, m/s, world.
    /// Where descent comes to the end it is never made.
    pub(super) h: LazyLock<SharedVectors, Box<dyn FnOnce() -> SharedVectors + Send>>,
    /// Changes of the impulses on the contacts' first points, by contact, N s, world.
    pub(super) impulse_changes: SharedVectors,
    /// Changes of the velocities, by point, where they are evaluated, m/s, world.
    pub(super) velocity_changes: SharedVectors,
}

impl AdmmState<'_> {
    /// Change of the impulse of a side on its point, N s, world.
    #[inline]
    pub(super) fn side_impulse(&self, side: usize) -> Vector3<f64> {
        let (contact, sign) = self.sides.contact(side);
        self.impulse_changes.get(contact).map(|x| f64::from_bits(x.to_bits() ^ sign))
    }

    /// Masses with which a report compares errors of impulses and of velocities. In a crowd, and
    /// where nothing but free bodies moves, that is the contact's own, as for
    /// [`crate::Violation`]: in the metric, which is up to eight times as heavy, small errors of
    /// velocities would be large ones of impulses, and a tolerance out of reach. Elsewhere it is
    /// that of the metric, and contacts are right to some digits more, by which the energies of
    /// rods close. Free bodies make errors of impulses those of the heaviest.
    pub(super) fn error_masses(&self, contact: &Contact) -> ErrorMasses {
        let free = self.free.of(contact);
        if free == 0.0 && !self.crowded {
            return (1.0 / self.metric_response(contact)).into();
        }
        let of = |point: usize| self.traces[point];
        let trace = of(contact.first) + contact.second.map_or(0.0, of);
        // What nothing moves has no inertia to compare with.
        let own = if trace > 0.0 { 3.0 / trace } else { 1.0 };
        ErrorMasses { own, moved: own.max(free) }
    }

    /// Velocity of a contact's first point relative to its second while the given impulses act,
    /// m/s, world.
    pub(super) fn relative_velocity(&self, contact: &Contact) -> Vector3<f64> {
        let second = contact.second.map_or(Vector3::zeros(), |point| self.velocities[point]);
        self.velocities[contact.first] - second
    }

    /// Answer of a contact's relative velocity to its own impulse in the metric, 1/kg.
    pub(super) fn metric_response(&self, contact: &Contact) -> f64 {
        let &Contact { first, second, .. } = contact;
        1.0 / self.metric[first] + second.map_or(0.0, |point| 1.0 / self.metric[point])
    }
}
