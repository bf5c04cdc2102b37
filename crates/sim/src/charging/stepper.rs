//! Charge comes onto the fibres, and they come to rest (thesis, Algorithm 2).

use super::flow;
use super::report::ChargeReport;
use super::settle::{Settled, charges, positions, rod_mut, rods, settle};
use crate::assemble::{load_at, resistance};
use crate::{Scene, SimError, StepReport, Stepper, World};
use nalgebra::{Point3, Vector3};

/// Two ends are the same equilibrium if no node is farther apart than this times the tolerance and the
/// length of the longest fibre.
const SAME: f64 = 10.0;

/// Deals a portion of charge in each step, lets it flow, and brings the fibres to rest.
#[derive(Debug)]
pub(crate) struct Charged {
    scene: Scene,
    /// Charges of all segments when all is dealt, C.
    given: Vec<f64>,
    shares: Vec<f64>,
}

impl Charged {
    /// For a world of a scene with charge.
    pub(crate) fn new(scene: &Scene, dealing: crate::scene::Dealing) -> Self {
        let given = scene.fibers.iter().flat_map(|bundle| {
            let fibers = bundle.arrangement.fibers();
            let (length, segments) = (bundle.length, bundle.segments);
            let own = move |k| bundle.charge.of_segments(k, fibers, length, segments);
            (0..fibers).flat_map(own)
        });
        Self { given: given.collect(), scene: scene.clone(), shares: dealing.shares() }
    }

    /// The share that this many steps have dealt.
    fn dealt(&self, steps: u64) -> f64 {
        let portions = usize::try_from(steps).unwrap_or(usize::MAX).min(self.shares.len());
        self.shares[..portions].iter().sum()
    }

    /// Deals the whole charge in the other ways too, and tells how many equilibria all have come to.
    fn compare(&self, world: &World, report: &mut ChargeReport) -> Result<(), SimError> {
        let others = self.scene.charging.iter().flat_map(|charging| &charging.compared);
        let mut ends = vec![positions(world)];
        for &dealing in others {
            let mut scene = self.scene.clone();
            scene.duration = scene.stepper.dt * dealing.portions() as f64;
            if let Some(charging) = &mut scene.charging {
                (charging.dealing, charging.compared) = (dealing, Vec::new());
            }
            let (mut other, mut stepper) = (World::build(&scene)?, Self::new(&scene, dealing));
            for _ in 0..dealing.portions() {
                let charge = stepper.step(&mut other, scene.stepper.dt)?.charge;
                report.evaluations += charge.evaluations;
                report.unsettled += charge.unsettled;
            }
            ends.push(positions(&other));
        }
        if ends.len() == 1 {
            return Ok(());
        }
        let tolerance = self.scene.charging.as_ref().map_or(0.0, |charging| charging.tolerance);
        let lengths = world.assembly().fibers().iter().map(|fiber| fiber.length());
        let same = SAME * tolerance * lengths.fold(0.0, f64::max);
        let mut different: Vec<&[Point3<f64>]> = Vec::new();
        for end in &ends {
            let known = |other: &&[Point3<f64>]| apart(end, other) <= same;
            if !different.iter().any(known) {
                different.push(end);
            }
        }
        report.equilibria = different.len();
        report.apart = ends.iter().map(|end| apart(end, &ends[0])).fold(0.0, f64::max);
        Ok(())
    }
}

impl Stepper for Charged {
    fn step(&mut self, world: &mut World, dt: f64) -> Result<StepReport, SimError> {
        let steps = world.steps();
        let (before, share) = (self.dealt(steps), self.dealt(steps + 1));
        world.advance_clock(dt);
        load_at(&self.scene, world, world.time())?;
        let layout = world.assembly().layout().clone();
        for fiber in 0..layout.fibers() {
            let given = &self.given[layout.segment_range(fiber)];
            if let Some(rod) = rod_mut(world, fiber) {
                for (charge, given) in rod.charges.iter_mut().zip(given) {
                    *charge += (share - before) * given;
                }
            }
        }
        if let Some(electric) = &mut world.electric {
            electric.share = share;
        }
        let flowed = match self.scene.charging.as_ref().and_then(|charging| charging.flow) {
            None => true,
            Some(flow) => {
                let resistance = resistance(&self.scene, &flow, world.time())?;
                flow::flow(world, &flow, resistance, dt)?
            }
        };
        let settled = settle(world)?;
        let dealt = share * self.given.iter().sum::<f64>();
        let mut charge = report(world, &settled, dealt);
        charge.unsettled |= usize::from(!flowed);
        if steps + 1 == self.shares.len() as u64 {
            self.compare(world, &mut charge)?;
        }
        if let Some(electric) = &mut world.electric {
            electric.report = charge;
        }
        Ok(StepReport { fibers: layout.fibers(), charge, ..StepReport::default() })
    }
}

/// The largest distance of two nodes.
fn apart(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// What is told of a step.
fn report(world: &World, settled: &Settled, dealt: f64) -> ChargeReport {
    let layout = world.assembly().layout();
    let charges = charges(world);
    let charge = charges.iter().sum();
    let gravity = world.gravity().norm();
    let (mut fields, mut lift) = (Vec::new(), 0.0_f64);
    for (fiber, rod) in rods(world) {
        let nodes = layout.node_range(fiber);
        let forces = &settled.electric.forces[nodes.start + 1..nodes.end];
        for (node, force) in forces.iter().enumerate() {
            let charge = 0.5 * (rod.charges[node] + rod.charges.get(node + 1).unwrap_or(&0.0));
            fields.push(if charge == 0.0 { 0.0 } else { force.norm() / charge.abs() });
        }
        let weight = rod.mass() * gravity;
        let force = forces.iter().sum::<Vector3<f64>>().norm();
        lift = lift.max(if weight > 0.0 { force / weight } else { 0.0 });
    }
    ChargeReport {
        evaluations: settled.evaluations,
        retreats: settled.retreats,
        unsettled: usize::from(!settled.at_rest),
        residual: settled.residual,
        charge,
        drained: dealt - charge,
        energy: settled.electric.energy,
        mean_field: fields.iter().sum::<f64>() / fields.len().max(1) as f64,
        lift,
        ..ChargeReport::default()
    }
}
