use crate::{ContactWork, SimError, World};
use rapunzel_rod_dynamic::Energy;
use serde::{Deserialize, Serialize};

/// The part of all energy that a run was given which may come from nowhere. A method that is stable
/// creates none, or what vanishes with its step; one that is not multiplies it by thousands.
const UNEXPLAINED: f64 = 0.1;
/// What rounding may leave, as a part of the energy that bends all fibres by a radian, and of that in
/// gravity.
const ROUNDING: f64 = 1e-9;

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

fn stored(energy: &Energy) -> f64 {
    energy.kinetic + energy.elastic
}

impl EnergyBudget {
    /// The budget of a world at its start.
    pub(crate) fn new(world: &World) -> Self {
        let start = world.energy();
        let bent = |fiber: &rapunzel_fiber::Fiber| fiber.nodes()[0].stiffness.x / fiber.length();
        let fibers = world.assembly().fibers().iter();
        let scale = fibers.map(bent).sum::<f64>() + start.gravitational.abs();
        let (rounding, height) = (ROUNDING * scale, start.gravitational);
        Self { start: stored(&start), height, rounding, most: [0.0; 5] }
    }

    /// Looks at a world at a frame. Without the work of everything nothing but gravity may give any.
    ///
    /// # Errors
    /// [`SimError::Created`] if more energy has come from nowhere than may.
    pub(crate) fn watch(&mut self, world: &World) -> Result<(), SimError> {
        let energy = world.energy();
        let fallen = self.height - energy.gravitational;
        let given = world.ledger().map_or([fallen, 0.0, 0.0, 0.0, 0.0], |works| {
            let ContactWork { led, adhesion, .. } = world.contact_work();
            [works.gravity, works.loads, works.drag, works.supports, led + adhesion]
        });
        for (most, given) in self.most.iter_mut().zip(given) {
            *most = most.max(given);
        }
        let created = stored(&energy) - self.start - given.iter().sum::<f64>();
        let supplied = self.start + self.most.iter().sum::<f64>();
        if created <= UNEXPLAINED * supplied + self.rounding {
            return Ok(());
        }
        let fibers = 0..world.assembly().fibers().len();
        let gravity = world.gravity();
        let of = |fiber: usize| stored(&world.fiber_energy(fiber, &gravity));
        let fiber = fibers.max_by(|&a, &b| of(a).total_cmp(&of(b)));
        Err(SimError::Created { time: world.time(), created, supplied, fiber })
    }
}
