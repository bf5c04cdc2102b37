use rapunzel_rod_dynamic::Ledger;
use serde::{Deserialize, Serialize};

/// All work done on fibres and free objects, J, but for that of [contacts](crate::ContactWork). With
/// the latter it sums up to what the kinetic and elastic energy have gained.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Works {
    /// Of gravity.
    pub gravity: f64,
    /// Of point forces, and of forces and moments at the ends.
    pub loads: f64,
    /// Of the air: negative but for what wind gives.
    pub drag: f64,
    /// Of internal viscosity, never positive.
    pub damping: f64,
    /// Of ends that are held: roots that move, tips that are pulled.
    pub supports: f64,
    /// Of the method in time, as [`Ledger::integrator`].
    pub integrator: f64,
    /// Of what the search for a step left unbalanced, as [`Ledger::solver`].
    pub solver: f64,
}

impl Works {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        let outside = self.gravity + self.loads + self.drag + self.supports;
        outside + self.damping + self.integrator + self.solver
    }

    /// Adds those of a step of a fibre.
    pub(crate) fn book(&mut self, step: &Ledger) {
        self.gravity += step.gravity;
        self.loads += step.loads;
        self.drag += step.drag;
        self.damping += step.damping;
        self.supports += step.supports;
        self.integrator += step.integrator;
        self.solver += step.solver;
    }
}
