//! How heavy is what moves where free bodies touch.
//!
//! A light body between a heavy one and the ground moves with the heavy one: where it closes its
//! gap to the ground too fast, what is wrong is an impulse on both, which is far more than the
//! light body's own inertia makes of the velocity.

use crate::{Body, Contact};

/// By point of some bodies, the mass of the heaviest free body that moves with the point's own, as
/// contacts link them.
#[derive(Debug, Clone, Default)]
pub struct FreeMasses(
    /// Masses, kg; zero where a body is not free. Empty if none is.
    Vec<f64>,
);

impl FreeMasses {
    /// The masses of bodies with such contacts. Costs a pass over the contacts, if any body is
    /// [free](Body::free_mass).
    #[must_use]
    pub fn new(bodies: &[&mut dyn Body], contacts: &[Contact]) -> Self {
        let mut heaviest: Vec<f64> =
            bodies.iter().map(|body| body.free_mass().unwrap_or(0.0)).collect();
        if heaviest.iter().all(|mass| *mass == 0.0) {
            return Self::default();
        }
        let counts = bodies.iter().map(|body| body.points()).enumerate();
        let owners: Vec<usize> =
            counts.flat_map(|(body, count)| std::iter::repeat_n(body, count)).collect();
        // The first body of each of which all are in touch.
        let mut firsts: Vec<usize> = (0..bodies.len()).collect();
        for contact in contacts {
            let Some(second) = contact.second else { continue };
            let [a, b] = [contact.first, second].map(|point| root(&mut firsts, owners[point]));
            let both = [a.min(b), a.max(b)];
            if a != b && both.iter().all(|&body| heaviest[body] > 0.0) {
                firsts[both[1]] = both[0];
                heaviest[both[0]] = heaviest[both[0]].max(heaviest[both[1]]);
            }
        }
        Self(owners.into_iter().map(|body| heaviest[root(&mut firsts, body)]).collect())
    }

    /// Mass of the heaviest that a contact moves, kg; zero unless all that it moves is free.
    #[must_use]
    pub fn of(&self, contact: &Contact) -> f64 {
        let at = |point: usize| self.0.get(point).copied().unwrap_or(0.0);
        contact.second.map_or(f64::INFINITY, at).min(at(contact.first))
    }
}

/// The first body that one is in touch with, by links that are shortened on the way.
fn root(firsts: &mut [usize], mut body: usize) -> usize {
    while firsts[body] != body {
        firsts[body] = firsts[firsts[body]];
        body = firsts[body];
    }
    body
}
