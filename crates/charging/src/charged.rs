//! Charge comes onto the fibres, and they come to rest (thesis, Algorithm 2).

use crate::ChargingError;
use crate::electric::Electric;
use crate::fibers::RestingFibers;
use crate::flow::flow;
use crate::head::{HeadGeometry, HeadModel};
use crate::report::ChargeReport;
use crate::settle::{Settled, settle};
use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::Fields;
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{Energy, RodState};
use rapunzel_scene::{Charging, Dealing, Scene};

/// Two ends are the same equilibrium if no node is farther apart than this times the tolerance and
/// the length of the longest fibre.
const SAME: f64 = 10.0;

/// Fibres that get a portion of charge in each step, and come to rest with it.
#[derive(Debug, Clone)]
pub struct ChargedRods {
    scene: Scene,
    charging: Charging,
    fibers: RestingFibers,
    electric: Electric,
    /// Charges of all segments when all is dealt, C.
    given: Vec<f64>,
    /// Share of the charge that each step deals.
    shares: Vec<f64>,
    /// Steps taken.
    steps: u64,
    /// The start, where ways of dealing are compared.
    start: Option<Box<Self>>,
}

impl ChargedRods {
    /// The fibres of a scene with charge, at rest under their weight; nothing is dealt yet. `head`
    /// is the object of the scene that is the head, if it has one.
    ///
    /// # Errors
    /// [`ChargingError::Rest`] for fibres without an equilibrium, [`ChargingError::Head`] and
    /// [`ChargingError::Electrostatics`] for a head.
    pub fn new(
        scene: &Scene,
        charging: &Charging,
        assembly: Assembly,
        head: Option<HeadGeometry>,
    ) -> Result<Self, ChargingError> {
        let head = HeadModel::new(&charging.head, &scene.objects, head)?;
        let electric = Electric::new(charging, &assembly, head);
        let given = scene.fibers.iter().flat_map(|bundle| {
            let fibers = bundle.arrangement.fibers();
            let (length, segments) = (bundle.length, bundle.segments);
            let own = move |k| bundle.charge.of_segments(k, fibers, length, segments);
            (0..fibers).flat_map(own)
        });
        let given = given.collect();
        let mut fibers = RestingFibers::new(assembly)?;
        fibers.load_at(scene, 0.0)?;
        fibers.relax()?;
        let mut charged = Self {
            scene: scene.clone(),
            charging: charging.clone(),
            fibers,
            electric,
            given,
            shares: charging.dealing.shares(),
            steps: 0,
            start: None,
        };
        if !charging.compared.is_empty() {
            charged.start = Some(Box::new(charged.clone()));
        }
        Ok(charged)
    }

    /// The fibres in their natural state.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        &self.fibers.assembly
    }

    /// State of a fibre. Allocates.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn state(&self, fiber: usize) -> RodState {
        self.fibers.rods[fiber].state()
    }

    /// Energy of a fibre but for the electric one, J, in a gravity, m/s^2.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn energy_of(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy {
        self.fibers.rods[fiber].energy(gravity)
    }

    /// Charge at each node of all fibres, C: half of that of the segments beside it.
    #[must_use]
    pub fn charges(&self) -> Vec<f64> {
        let of = |rod: &Vec<f64>| {
            let before = [0.0].iter().chain(rod);
            before.zip(rod.iter().chain(&[0.0])).map(|(a, b)| 0.5 * (a + b)).collect::<Vec<_>>()
        };
        self.fibers.rods.iter().flat_map(|rod| of(&rod.charges)).collect()
    }

    /// How the fibres came to rest in the last step.
    #[must_use]
    pub fn report(&self) -> ChargeReport {
        self.electric.report
    }

    /// Potentials (V) and fields (V/m, world) of all charges at `targets` (world, m), fibres being
    /// points on their axes and conductors without a field inside. Cost: a call of the multipole
    /// method.
    ///
    /// # Errors
    /// [`ChargingError::Electrostatics`] for targets that are nowhere, [`ChargingError::InHead`]
    /// for fibres there.
    pub fn fields(&self, targets: &[Point3<f64>]) -> Result<Fields, ChargingError> {
        self.electric.fields(&self.fibers, targets)
    }

    /// Deals a portion of charge, lets it flow for `dt` seconds, and brings the fibres to rest at
    /// the time `end`, s.
    ///
    /// # Errors
    /// [`ChargingError`]; [restore](Self::restore) what was saved before going on.
    pub fn step(&mut self, end: f64, dt: f64) -> Result<ChargeReport, ChargingError> {
        let (before, share) = (self.dealt(self.steps), self.dealt(self.steps + 1));
        self.steps += 1;
        self.fibers.load_at(&self.scene, end)?;
        let charges = self.fibers.rods.iter_mut().flat_map(|rod| rod.charges.iter_mut());
        for (charge, given) in charges.zip(&self.given) {
            *charge += (share - before) * given;
        }
        self.electric.share = share;
        let flowed = match self.charging.flow {
            None => true,
            Some(law) => {
                let climate = self.scene.environment.climate.at(end);
                let resistance = climate
                    .and_then(|climate| law.resistance_in(&climate))
                    .map_err(|source| ChargingError::Keratin { bundle: 0, source })?;
                flow(&mut self.fibers, &self.electric, &law, resistance, dt)?
            }
        };
        let settled = settle(&mut self.fibers, &self.electric)?;
        let dealt = share * self.given.iter().sum::<f64>();
        let mut charge = report(&self.fibers, &settled, dealt);
        charge.unsettled |= usize::from(!flowed);
        if self.steps == self.shares.len() as u64 {
            self.compare(&mut charge)?;
        }
        self.electric.report = charge;
        Ok(charge)
    }

    /// The share that this many steps have dealt.
    fn dealt(&self, steps: u64) -> f64 {
        let portions = usize::try_from(steps).unwrap_or(usize::MAX).min(self.shares.len());
        self.shares[..portions].iter().sum()
    }

    /// Deals the whole charge in the other ways too, and tells how many equilibria all have come
    /// to.
    fn compare(&self, report: &mut ChargeReport) -> Result<(), ChargingError> {
        let Some(start) = &self.start else { return Ok(()) };
        let mut ends = vec![self.fibers.positions()];
        for &dealing in &self.charging.compared {
            let mut other = start.dealing(dealing);
            let dt = self.scene.stepper.dt;
            for portion in 0..dealing.portions() {
                let charge = other.step((portion + 1) as f64 * dt, dt)?;
                report.evaluations += charge.evaluations;
                report.unsettled += charge.unsettled;
            }
            ends.push(other.fibers.positions());
        }
        let lengths = self.assembly().fibers().iter().map(|fiber| fiber.length());
        let same = SAME * self.charging.tolerance * lengths.fold(0.0, f64::max);
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

    /// The same fibres with charge that is dealt in another way.
    fn dealing(&self, dealing: Dealing) -> Self {
        Self { shares: dealing.shares(), ..self.clone() }
    }

    /// All numbers that change: those of the whole, and a list for each fibre, made one at a time.
    pub fn save(&self) -> impl ExactSizeIterator<Item = Vec<f64>> {
        let dealt = (self.steps as f64, self.electric.share);
        (0..self.fibers.rods.len() + 1).map(move |list| match list.checked_sub(1) {
            None => vec![dealt.0, dealt.1],
            Some(fiber) => {
                let mut numbers = Vec::new();
                self.fibers.rods[fiber].save(&mut numbers);
                numbers
            }
        })
    }

    /// Goes back to numbers that were saved at a time, s.
    ///
    /// # Errors
    /// [`ChargingError::Saved`] if they are those of other fibres; errors of a climate.
    pub fn restore(&mut self, saved: &[Vec<f64>], time: f64) -> Result<(), ChargingError> {
        let wrong = |list| ChargingError::Saved { list };
        let (whole, rods) = saved.split_first().ok_or(wrong(0))?;
        let &[steps, share] = &whole[..] else { return Err(wrong(0)) };
        if rods.len() != self.fibers.rods.len() {
            return Err(wrong(rods.len()));
        }
        for (list, (rod, numbers)) in self.fibers.rods.iter_mut().zip(rods).enumerate() {
            let fits = numbers.len() == rod.saved();
            let restored = if fits { rod.restore(numbers).ok() } else { None };
            restored.ok_or(wrong(list + 1))?;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a saved count"
        )]
        let steps = steps as u64;
        (self.steps, self.electric.share) = (steps, share);
        self.fibers.load_at(&self.scene, time)
    }
}

/// The largest distance of two nodes.
fn apart(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// What is told of a step.
fn report(fibers: &RestingFibers, settled: &Settled, dealt: f64) -> ChargeReport {
    let layout = fibers.assembly.layout();
    let charges = fibers.charges();
    let charge = charges.iter().sum();
    let gravity = fibers.gravity.norm();
    let (mut fields, mut lift) = (Vec::new(), 0.0_f64);
    for (fiber, rod) in fibers.rods.iter().enumerate() {
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
