//! The ledger of a run: all works sum up to what the kinetic and elastic energy gain.

use super::Run;
use rapunzel_sim::{StepReport, World};

/// Energy gained since the start of a step, its works, and how far they are apart.
pub(crate) struct Books {
    pub(crate) run: Run,
    start: f64,
    /// Largest gap in a step, in parts of its works, and sum of all that those were.
    pub(crate) worst: f64,
    moved: f64,
}

fn works(world: &World) -> [f64; 14] {
    let works = world.ledger().expect("the scene asks for it");
    let contacts = world.contact_work();
    [
        works.gravity,
        works.loads,
        works.drag,
        works.damping,
        works.supports,
        works.integrator,
        works.solver,
        contacts.friction,
        contacts.closing,
        contacts.repair,
        contacts.restitution,
        contacts.adhesion,
        contacts.compliance,
        contacts.kinematic,
    ]
}

fn held(world: &World) -> f64 {
    let energy = world.energy();
    energy.kinetic + energy.elastic
}

impl Books {
    pub(crate) fn new(run: Run) -> Self {
        let start = held(&run.world);
        Self { run, start, worst: 0.0, moved: 0.0 }
    }

    pub(crate) fn step(&mut self) -> StepReport {
        let (before, energy) = (works(&self.run.world), held(&self.run.world));
        let report = self.run.step();
        let after = works(&self.run.world);
        let changes: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let gap = held(&self.run.world) - energy - changes.iter().sum::<f64>();
        let moved: f64 = changes.iter().map(|x| x.abs()).sum();
        self.moved += moved;
        self.worst = self.worst.max(gap.abs() / moved);
        report
    }

    /// The gap over the whole run, in parts of all that was moved.
    pub(crate) fn whole(&self) -> f64 {
        let sum: f64 = works(&self.run.world).iter().sum();
        (held(&self.run.world) - self.start - sum).abs() / self.moved
    }
}
