use serde::{Deserialize, Serialize};

/// How the fibres of a scene with charge came to rest in a step; of a run, sums and the worst.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ChargeReport {
    /// Evaluations of the electric forces.
    pub evaluations: usize,
    /// How often an iterate was shortened because it raised the energy.
    pub retreats: usize,
    /// Steps that did not come to rest within their evaluations: what they left is no equilibrium.
    pub unsettled: usize,
    /// Difference of the electric forces on the nodes and those that hold the fibres where they
    /// are, over the former (roots of sums of squares).
    pub residual: f64,
    /// Charge of all fibres, C.
    pub charge: f64,
    /// Charge that has gone to the head since the start, C.
    pub drained: f64,
    /// Electric energy, J.
    pub energy: f64,
    /// Mean over the nodes of the electric force on them over their charge, V/m.
    pub mean_field: f64,
    /// The largest ratio of the electric force on a fibre to its weight.
    pub lift: f64,
    /// Different equilibria that the ways of dealing that are compared have come to, with that of
    /// the run; zero as long as none are compared.
    pub equilibria: usize,
    /// The largest distance of a node from where it is in another of them, m.
    pub apart: f64,
}

impl ChargeReport {
    /// Takes note of the next step.
    pub fn add(&mut self, next: &Self) {
        *self = Self {
            evaluations: self.evaluations + next.evaluations,
            retreats: self.retreats + next.retreats,
            unsettled: self.unsettled + next.unsettled,
            residual: self.residual.max(next.residual),
            equilibria: self.equilibria.max(next.equilibria),
            apart: self.apart.max(next.apart),
            ..*next
        };
    }
}
