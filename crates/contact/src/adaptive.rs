//! One by one where contacts are few, splitting where they are many.

use crate::one_by_one::OneByOne;
use crate::{Body, Contact, ContactError, Report, Solver, Tolerance};
use nalgebra::{Matrix3, Vector3};

/// Sides of contacts, on the average of what moves, up to which contacts are few.
const FEW: usize = 4;
/// Part of the tolerances that contacts are solved to one by one: each leaves as much as it may.
const PART: f64 = 0.3;
/// Part of its whole answer to impulses by which a stiff contact answers one along its normal. One
/// by one a straight fibre that was pressed end on came to rest beside its axis, and bore a tenth
/// less than Euler's load.
const STIFF: f64 = 1e-3;
/// [`GaussSeidel`](crate::GaussSeidel) where what moves has few contacts each, as hair that falls
/// and hangs. [`Admm`](crate::Admm) where it has many, where bodies have no
/// [dense operator](Body::dense_delassus) or hardly answer along a normal, and where the first does
/// not come to an end.
///
/// Few contacts make many small problems that know nothing of each other. Gauss-Seidel ends each
/// when it is solved; every iteration of splitting is one of all, until the last is solved.
#[derive(Debug, Clone)]
pub struct Adaptive {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    one_by_one: OneByOne,
    /// Whether contacts were few in the last solve.
    few: bool,
}

impl Adaptive {
    /// A solver that stops at these tolerances.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, one_by_one: OneByOne::new(PART, 1.0, true), few: false }
    }

    /// Forgets that solving one by one has led nowhere, since when only splitting is tried: what
    /// comes now is another problem.
    pub fn forget(&mut self) {
        self.one_by_one.stalled = false;
    }

    /// Whether the last solve went one by one to its end: a more exact one costs hardly more.
    #[must_use]
    pub fn is_one_by_one(&self) -> bool {
        self.few && !self.one_by_one.stalled
    }
}

impl Solver for Adaptive {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        let Self { tolerance, one_by_one, few } = self;
        *few = are_few(bodies, contacts);
        if one_by_one.stalled || !*few {
            let splitting = one_by_one.splitting(tolerance, tolerance.iterations);
            return splitting.solve(bodies, contacts, velocities, impulses);
        }
        one_by_one.solve((tolerance, 0), bodies, contacts, velocities, impulses)
    }
}

/// Whether all that moves has a dense operator at hand, and few contacts, none of which is stiff.
fn are_few(bodies: &[&mut dyn Body], contacts: &[Contact]) -> bool {
    let (mut own, mut moving) = (Vec::new(), 0);
    for body in bodies {
        let Some(groups) = body.dense_delassus() else { return false };
        let start = own.len();
        own.resize(start + body.points(), Matrix3::zeros());
        for (points, blocks) in &groups {
            points.iter().enumerate().for_each(|(i, &k)| own[start + k] = blocks.block(i, i));
        }
        moving += groups.len();
    }
    let sides = contacts.iter().map(|contact| 1 + usize::from(contact.second.is_some()));
    let is_stiff = |contact: &Contact| {
        let answer = |point: usize| own.get(point).copied().unwrap_or_default();
        let answer = answer(contact.first) + contact.second.map_or_else(Matrix3::zeros, answer);
        let normal = contact.frame.column(0);
        normal.dot(&(answer * normal)) < STIFF * answer.trace()
    };
    sides.sum::<usize>() <= FEW * moving && !contacts.iter().any(is_stiff)
}
