//! Energy ledger of a time step.

use std::ops::AddAssign;

/// Energy ledger of one step of one rod, J: the change of its energy, and all work done on it.
/// `kinetic + elastic` equals the sum of all other entries to rounding, although every entry is
/// computed by itself, from the equations that the step has solved.
///
/// Gravity, loads and wind are those at the end of the step. Where they are steady, all entries
/// but `integrator` have the order of accuracy of the method.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    /// Change of the kinetic energy over the step, J.
    pub kinetic: f64,
    /// Change of the elastic energy over the step, J.
    pub elastic: f64,
    /// Work of gravity, J: the loss of gravitational energy where gravity is steady.
    pub gravity: f64,
    /// Work of forces and moments at the ends, along the rod and on its nodes, J.
    pub loads: f64,
    /// Work of air drag at the mean velocity over the step, J: positive only where wind drives the
    /// rod.
    pub drag: f64,
    /// Work of internal viscosity at the mean strain rate over the step, J. Never positive.
    pub damping: f64,
    /// Work of held and pinned ends, J, zero where they rest: of the mean of the reactions before
    /// and after the step (backward Euler: of the reactions after it), of the impulses that the
    /// supports take up, and the elastic energy of an end joint that is clamped (gained) or
    /// released (lost).
    pub supports: f64,
    /// Work of contacts, J: impulses on the nodes times the nodes' mean velocities over the step.
    pub contacts: f64,
    /// Work of joints with other fibres, J: loads at the end of the step times displacements and
    /// turns over it.
    pub joints: f64,
    /// Work of the time integration, J, for which the values at the end of a step stand for those
    /// over it. Backward Euler only loses where the potential of its step is convex: half the mass
    /// times the squared change of velocity, and the elastic energy of the change of curvature.
    /// Summed over a fixed time it vanishes linearly with the step size, for the second-order
    /// method quadratically; linearly too where drag differs along and across the rod, because that
    /// difference is explicit.
    pub integrator: f64,
    /// Work of the residual that Newton's method left, J: nearly rounding in steps that are solved
    /// at once, more in steps that a contact solver ends as soon as its own tolerance is met.
    pub solver: f64,
}

impl Ledger {
    /// Energy gained by the rod, kinetic and elastic, J.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.kinetic + self.elastic
    }

    /// All work done on the rod, J.
    #[must_use]
    pub fn work(&self) -> f64 {
        let outside = self.gravity + self.loads + self.drag + self.supports + self.contacts;
        outside + self.joints + self.damping + self.integrator + self.solver
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
        self.joints += other.joints;
        self.integrator += other.integrator;
        self.solver += other.solver;
    }
}
