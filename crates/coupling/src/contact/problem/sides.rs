//! The sides of contacts.

use rapunzel_contact::Body;
use rayon::prelude::*;

/// A side of a contact: the number of the contact, and 0 or 1.
pub(super) type ContactSide = (usize, usize);

/// How all points of some bodies answer themselves, 1/kg.
pub(super) fn traces(bodies: &mut [&mut dyn Body]) -> Vec<f64> {
    let of_body = |body: &mut &mut dyn Body| {
        let mut traces = vec![0.0; body.points()];
        body.own_traces(&mut traces);
        traces
    };
    bodies.par_iter_mut().map(of_body).collect::<Vec<_>>().concat()
}

/// Something of every side, in lists as they are given.
pub(super) fn each<T: Send>(
    sides: &[Vec<ContactSide>],
    of_side: impl Fn(usize, usize) -> T + Sync,
) -> Vec<Vec<T>> {
    let list = |sides: &Vec<ContactSide>| sides.iter().map(|&(i, side)| of_side(i, side)).collect();
    sides.par_iter().map(list).collect()
}
