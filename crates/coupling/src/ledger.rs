use rapunzel_rod_dynamic::Ledger;
use serde::{Deserialize, Serialize};

/// All work done on fibres and free objects, J, but for [the work of contacts](crate::ContactWork).
/// Both together are what the kinetic and elastic energy have gained.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EnergyLedger {
    /// Work of gravity, J.
    pub gravity: f64,
    /// Work of point forces, and of forces and moments at the ends, J.
    pub loads: f64,
    /// Work of the air, J: negative but for what wind gives.
    pub drag: f64,
    /// Work of internal viscosity, J; never positive.
    pub damping: f64,
    /// Work of ends that are held, J: roots that move, tips that are pulled.
    pub supports: f64,
    /// Work of the method in time, J: see [`Ledger::integrator`]; with what joints do to fibres and
    /// does not become energy between these.
    pub integrator: f64,
    /// Work of what the search for a step left unbalanced, J: see [`Ledger::solver`].
    pub solver: f64,
}

impl EnergyLedger {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        let outside = self.gravity + self.loads + self.drag + self.supports;
        outside + self.damping + self.integrator + self.solver
    }

    /// Adds the works in a step of a fibre or a free object.
    pub(crate) fn record(&mut self, step: &Ledger) {
        self.gravity += step.gravity;
        self.loads += step.loads;
        self.drag += step.drag;
        self.damping += step.damping;
        self.supports += step.supports;
        self.integrator += step.integrator + step.joints;
        self.solver += step.solver;
    }

    /// All works, J, in the order of the fields.
    pub(crate) fn numbers(&self) -> [f64; 7] {
        let Self { gravity, loads, drag, damping, supports, integrator, solver } = *self;
        [gravity, loads, drag, damping, supports, integrator, solver]
    }

    /// The ledger with these works, J, in the order of the fields; `None` for another number of
    /// them.
    pub(crate) fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let &[gravity, loads, drag, damping, supports, integrator, solver] = numbers else {
            return None;
        };
        Some(Self { gravity, loads, drag, damping, supports, integrator, solver })
    }
}
