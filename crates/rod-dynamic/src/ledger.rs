//! What a rod's energy becomes.

use std::ops::AddAssign;

/// The ledger of a step of one rod, J: what its energy gained, and all work done on it. The first
/// two lines are the sum of the others, to rounding: every line is computed by itself, from the
/// equations that the step has solved.
///
/// Gravity, loads and wind are those at the end of the step, as these equations have them. Where
/// they are steady all lines but that of the integrator are of the order of the method.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    /// Change of the kinetic energy.
    pub kinetic: f64,
    /// Change of the elastic energy.
    pub elastic: f64,
    /// Work of gravity: what the energy in it loses where gravity is steady.
    pub gravity: f64,
    /// Work of forces and moments at the ends, along the rod and on its nodes.
    pub loads: f64,
    /// Work of the air, at the mean velocity over the step: negative but for what wind gives.
    pub drag: f64,
    /// Work of internal viscosity, at the mean rate over the step. Never positive.
    pub damping: f64,
    /// Work of held and pinned ends, zero where they rest, with the mean of the reactions before
    /// and after the step (backward Euler: with that after it); what an elastic end stores when it
    /// is clamped, and loses when it is let go; and the impulses that it takes up.
    pub supports: f64,
    /// Impulses on the nodes times their mean velocities.
    pub contacts: f64,
    /// Work of the method in time, for which the values at the end of a step stand for those over
    /// it. Backward Euler only loses where the potential of its step is convex: half the mass times
    /// the squared change of velocity, and the elastic energy of the change of curvature. Summed
    /// over a time this vanishes as the step, that of the second-order method as its square; as the
    /// step too where drag differs along and across the rod, whose difference is explicit.
    pub integrator: f64,
    /// Work of what Newton's method left unbalanced: nearly rounding in steps that are solved at
    /// once, more in those that a solver of contacts ends as soon as its own tolerance is met.
    pub solver: f64,
}

impl Ledger {
    /// What the rod gained, J.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.kinetic + self.elastic
    }

    /// All work done on the rod, J.
    #[must_use]
    pub fn work(&self) -> f64 {
        let outside = self.gravity + self.loads + self.drag + self.supports + self.contacts;
        outside + self.damping + self.integrator + self.solver
    }
}

impl AddAssign for Ledger {
    fn add_assign(&mut self, other: Self) {
        self.kinetic += other.kinetic;
        self.elastic += other.elastic;
        self.gravity += other.gravity;
        self.loads += other.loads;
        self.drag += other.drag;
        self.damping += other.damping;
        self.supports += other.supports;
        self.contacts += other.contacts;
        self.integrator += other.integrator;
        self.solver += other.solver;
    }
}
