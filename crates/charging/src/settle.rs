//! How all fibres come to rest together.

use crate::ChargingError;
use crate::anderson::{AndersonAcceleration, dot};
use crate::electric::{Electric, Forces};
use crate::fibers::RestingFibers;
use nalgebra::Vector3;

/// Changes that the iteration remembers.
const SETTLE_DEPTH: usize = 12;
/// By how much a step is shortened that raises the energy.
const SHORTER: f64 = 0.25;
/// The shortest part of a step.
const SHORTEST: f64 = 1e-3;

/// What the search for the equilibrium came to.
pub(super) struct Settled {
    pub(super) evaluations: usize,
    pub(super) retreats: usize,
    /// Relative residual of the forces.
    pub(super) residual: f64,
    /// Whether that is within the tolerance.
    pub(super) at_rest: bool,
    /// In the end.
    pub(super) electric: Forces,
}

/// Fibres at rest under given electric forces, and the electric forces where they lie.
struct TrialEquilibrium {
    /// Forces on the nodes that they lie at rest with, N, coordinate by coordinate.
    held: Vec<f64>,
    /// By how much the electric forces differ from those.
    residual: Vec<f64>,
    electric: Forces,
    /// Mechanical and electric energy, J.
    energy: f64,
}

/// Lets all fibres come to rest under gravity, their loads and the electric forces of their
/// charges.
///
/// The unknowns are the electric forces on the nodes. Under any given ones each fibre has its own
/// equilibrium, by Newton's method; sought are those that the charges make where that puts them.
/// That iteration, accelerated, goes down: its steps are shortened until they do not raise the
/// energy of all by more than the tolerance of it, so that it does not end where the energy is
/// stationary but not least, unless it begins there. The fibres are left in the equilibrium under
/// the forces found.
pub(super) fn settle(
    fibers: &mut RestingFibers,
    electric: &Electric,
) -> Result<Settled, ChargingError> {
    let (tolerance, most) = (electric.charging.tolerance, electric.charging.evaluations);
    let start = flat(&evaluate(fibers, electric, 1.0)?.forces);
    let mut now = trial(fibers, electric, start, 1.0)?;
    let mut anderson = AndersonAcceleration::new(SETTLE_DEPTH);
    let (mut evaluations, mut retreats) = (2, 0);
    loop {
        let size = dot(&now.residual, &now.residual).sqrt();
        let forces = flat(&now.electric.forces);
        let residual = if size > 0.0 { size / dot(&forces, &forces).sqrt() } else { 0.0 };
        let at_rest = residual <= tolerance;
        let settled = |electric, evaluations, retreats| Settled {
            evaluations,
            retreats,
            residual,
            at_rest,
            electric,
        };
        if at_rest || evaluations >= most {
            return Ok(settled(now.electric, evaluations, retreats));
        }
        let mut step = anderson.step(&now.held, &now.residual);
        // The energy is known as well as the forces are.
        let slack = tolerance * now.electric.energy.abs();
        let mut part = 1.0;
        let before = fibers.shapes();
        now = loop {
            let held: Vec<f64> = now.held.iter().zip(&step).map(|(f, s)| f + part * s).collect();
            evaluations += 1;
            let next = trial(fibers, electric, held, residual);
            let ready = match &next {
                Ok(next) => next.energy <= now.energy + slack,
                Err(_) => false,
            };
            // So short a step is within what the forces are known by.
            if ready || part < SHORTEST {
                break next?;
            }
            fibers.lie(&before);
            if evaluations >= most {
                fibers.hold(&now.held);
                return Ok(settled(now.electric, evaluations, retreats));
            }
            retreats += 1;
            if part == 1.0 {
                // The way of the plain iteration goes down at first.
                anderson.forget();
                step.clone_from(&now.residual);
            }
            part *= SHORTER;
        };
    }
}

/// Lays the fibres at rest under `held` forces, from where they lie; `residual` is the last
/// relative one.
fn trial(
    fibers: &mut RestingFibers,
    electric: &Electric,
    held: Vec<f64>,
    residual: f64,
) -> Result<TrialEquilibrium, ChargingError> {
    fibers.hold(&held);
    fibers.relax()?;
    let electric = evaluate(fibers, electric, residual)?;
    let gravity = &fibers.gravity;
    let mechanical: f64 = fibers.rods.iter().map(|rod| rod.mechanical_energy(gravity)).sum();
    let residual = flat(&electric.forces).iter().zip(&held).map(|(f, h)| f - h).collect();
    let energy = mechanical + electric.energy;
    Ok(TrialEquilibrium { held, residual, energy, electric })
}

/// The electric forces where the fibres are. Those on the roots, which are held, are left out.
fn evaluate(
    fibers: &RestingFibers,
    electric: &Electric,
    residual: f64,
) -> Result<Forces, ChargingError> {
    let mut forces = electric.forces(fibers, &fibers.positions(), &fibers.charges(), residual)?;
    let layout = fibers.assembly.layout();
    for fiber in 0..layout.fibers() {
        forces.forces[layout.node_range(fiber).start] = Vector3::zeros();
    }
    Ok(forces)
}

fn flat(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}
