use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use serde::{Deserialize, Serialize};

/// What the contacts of a step, or of a run, were and cost.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ContactReport {
    /// Contacts in the list, at most.
    pub listed: usize,
    /// Contacts that bore something, at most.
    pub active: usize,
    /// Iterations of the contact solver.
    pub iterations: usize,
    /// Solves of all contacts: iterations of Newton's method.
    pub solves: usize,
    /// Lists of contacts.
    pub lists: usize,
    /// Parts of steps.
    pub parts: usize,
    /// Parts that were taken although they missed a tolerance, for want of shorter ones.
    pub unresolved: usize,
    /// Where the first of these was worst.
    #[serde(default)]
    pub first_unresolved: Option<Unresolved>,
    /// Largest Coulomb residual, relative to all impulses.
    pub residual: f64,
    /// Largest error of a normal velocity, m/s.
    pub normal_error: f64,
    /// Largest slip that the friction does not allow, m/s.
    pub slip_error: f64,
    /// Largest velocity with which a contact that sticks has moved, m/s: within a step; what it
    /// goes in one it is asked to go back in the next.
    #[serde(default)]
    pub creep: f64,
    /// Deepest penetration that a step left, m, beside what has given way by its compliance.
    pub depth: f64,
}

/// Where contacts missed their tolerances most: the deepest of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unresolved {
    /// Start of the part of a step, s.
    pub time: f64,
    /// The two that touch: a fibre before an object.
    pub sides: [BodyRef; 2],
    /// The segment of the first, from the root, if that is a fibre.
    pub segment: Option<usize>,
    /// How deep they are in each other, m; negative if they are not.
    pub depth: f64,
}

impl ContactReport {
    /// Tells that a part was taken although it missed a tolerance, and where.
    pub(crate) fn miss(&mut self, worst: Option<Unresolved>) {
        self.unresolved = 1;
        self.first_unresolved = worst;
    }

    /// Adds another part or step: what it cost is summed, of the rest the largest stays.
    pub fn add(&mut self, other: &Self) {
        self.listed = self.listed.max(other.listed);
        self.active = self.active.max(other.active);
        self.iterations += other.iterations;
        self.solves += other.solves;
        self.lists += other.lists;
        self.parts += other.parts;
        self.unresolved += other.unresolved;
        self.first_unresolved = self.first_unresolved.or(other.first_unresolved);
        self.residual = self.residual.max(other.residual);
        self.normal_error = self.normal_error.max(other.normal_error);
        self.slip_error = self.slip_error.max(other.slip_error);
        self.creep = self.creep.max(other.creep);
        self.depth = self.depth.max(other.depth);
    }
}

impl Unresolved {
    pub(crate) fn new(time: f64, point: &ContactPoint) -> Self {
        Self { time, sides: point.sides, segment: point.segment(), depth: -point.gap }
    }

    /// Where the deepest of some contact points is.
    pub(crate) fn deepest(time: f64, points: &[ContactPoint]) -> Option<Self> {
        let deepest = points.iter().min_by(|a, b| a.gap.total_cmp(&b.gap))?;
        Some(Self::new(time, deepest))
    }
}
