use rapunzel_coupling::{ContactWork, EnergyLedger};
use rapunzel_rod_dynamic::Energy;
use serde::{Deserialize, Serialize};

/// The part of all energy that a run was given which may come from nowhere. A method that is stable
/// creates none, or what vanishes with its step; one that is not multiplies it by thousands.
const UNEXPLAINED: f64 = 0.1;
/// What rounding may leave, as a part of the energy that bends all fibres by a radian, and of that
/// in gravity.
const ENERGY_ROUNDING: f64 = 1e-9;

/// Where the energy of a run came from, as far as that is known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct EnergyBudget {
    /// Kinetic and elastic energy of the start, J.
    start: f64,
    /// Energy in gravity at the start, J.
    height: f64,
    /// Energy that means nothing, J.
    rounding: f64,
    /// The most that each had given at any frame, J: gravity, loads, air, supports, contacts.
    most: [f64; 5],
}

/// Energy that has come from nowhere, and more of it than may.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CreatedEnergy {
    /// Energy that no work explains, J.
    pub(crate) created: f64,
    /// Energy of the start, and all that was given since, J.
    pub(crate) supplied: f64,
}

/// Kinetic and elastic energy, J.
pub(crate) fn stored(energy: &Energy) -> f64 {
    energy.kinetic + energy.elastic
}

impl EnergyBudget {
    /// The budget of a motion with this energy at its start, whose fibres take `bending` to bend by
    /// a radian, J.
    pub(crate) fn new(start: &Energy, bending: f64) -> Self {
        let (rounding, height) =
            (ENERGY_ROUNDING * (bending + start.gravitational.abs()), start.gravitational);
        Self { start: stored(start), height, rounding, most: [0.0; 5] }
    }

    /// Looks at the energy at a frame. Without the work of everything nothing but gravity may give
    /// any.
    ///
    /// # Errors
    /// [`CreatedEnergy`] if more has come from nowhere than may.
    pub(crate) fn watch(
        &mut self,
        energy: &Energy,
        works: Option<(EnergyLedger, ContactWork)>,
    ) -> Result<(), CreatedEnergy> {
        let fallen = self.height - energy.gravitational;
        let given = works.map_or([fallen, 0.0, 0.0, 0.0, 0.0], |(works, contacts)| {
            let ContactWork { kinematic, adhesion, .. } = contacts;
            [works.gravity, works.loads, works.drag, works.supports, kinematic + adhesion]
        });
        for (most, given) in self.most.iter_mut().zip(given) {
            *most = most.max(given);
        }
        let created = stored(energy) - self.start - given.iter().sum::<f64>();
        let supplied = self.start + self.most.iter().sum::<f64>();
        if created <= UNEXPLAINED * supplied + self.rounding {
            return Ok(());
        }
        Err(CreatedEnergy { created, supplied })
    }
}
