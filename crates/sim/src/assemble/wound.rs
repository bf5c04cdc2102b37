//! Fibres that start wound around objects: at rest there, if friction and their ends hold them.

use super::stage::BuildStage;
use super::start::FiberStart;
use super::still::{Settling, Still};
use crate::SimError;
use crate::scene::{Initial, Scene};
use rapunzel_coupling::{CollisionObject, FibersInContact};

/// Most steps in which wound fibres come to rest, with either residual.
const STEPS: usize = 250;
/// Largest Coulomb residuals then, relative to all impulses, one tried after the other: what a
/// residual leaves moves a light fibre under tension, and not all contacts can be solved for more
/// exactly.
const RESIDUALS: [f64; 2] = [1e-7, 1e-6];
/// Speed at which they rest, in that at which a contact still sticks.
const SLOW: f64 = 0.1;

/// Wound fibres that have come to rest.
pub(super) struct SettledWinding {
    fibers: FibersInContact,
    /// Their numbers among all fibres.
    numbers: Vec<u32>,
}

impl SettledWinding {
    /// Lets all fibres begin with what contacts of these bear.
    pub(super) fn warm(&self, all: &mut FibersInContact) {
        all.expect_impulses_of(&self.fibers, &self.numbers);
    }
}

/// Lets fibres that are wound around objects come to rest where they are, each by its bending, its
/// ends and the contacts that hold it. Those that do not stay within a diameter of where they were
/// wound start there as they are, and a note tells of them. Returns those that rest, if all do.
///
/// # Errors
/// [`SimError`] of what cannot be in contact.
pub(super) fn settle_wound(
    scene: &Scene,
    starts: &mut [FiberStart],
    objects: &[CollisionObject],
    notes: &mut Vec<String>,
    at: &dyn Fn(BuildStage),
) -> Result<Option<SettledWinding>, SimError> {
    let is_wound =
        |start: &FiberStart| matches!(scene.fibers[start.bundle].initial, Initial::Wrapped { .. });
    let all = (0..).zip(&*starts).filter(|(_, start)| is_wound(start));
    let (numbers, wound): (Vec<u32>, Vec<FiberStart>) =
        all.map(|(i, one)| (i, one.clone())).unzip();
    let Some(settings) = scene.contact.as_ref().filter(|_| !wound.is_empty()) else {
        return Ok(None);
    };
    // What hangs at joints is not known of fibres by themselves.
    if scene.has_joints() {
        return Ok(None);
    }
    // What slips more slowly sticks.
    let longest = wound.iter().map(|start| start.rod.fiber.length()).fold(0.0, f64::max);
    let speed = SLOW * settings.slip / longest;
    let diameter = |start: &FiberStart| {
        let radii = start.rod.fiber.nodes().iter().map(|node| node.section.equivalent_radius());
        2.0 * radii.fold(0.0, f64::max)
    };
    let reach = wound.iter().map(diameter).fold(f64::INFINITY, f64::min);
    let settle = |residual: f64, done: usize| {
        let mut still = Still::new(scene, &wound, objects)?;
        let residual = settings.residual.min(residual);
        let settling = Settling { speed, reach, steps: STEPS, residual };
        let at = |step| {
            let most = RESIDUALS.len() * STEPS;
            at(BuildStage::Settling { done: done + step, most });
        };
        let (mut fibers, mut slow) = still.settle(settings, &settling, None, &at)?;
        if slow.iter().all(|slow| *slow) {
            // Contacts that are found anew where fibres have come to ask for the last of the way.
            (fibers, slow) = still.settle(settings, &settling, Some(&fibers), &at)?;
        }
        Ok::<_, SimError>((still.starts, fibers, slow))
    };
    let (mut settled, mut fibers, mut slow) = settle(RESIDUALS[0], 0)?;
    if !slow.iter().all(|slow| *slow) {
        (settled, fibers, slow) = settle(RESIDUALS[1], STEPS)?;
    }
    let mut all_rest = true;
    let own = starts.iter_mut().filter(|start| is_wound(start));
    for ((start, settled), is_slow) in own.zip(settled).zip(slow) {
        let (Some(was), Some(is)) = (&start.state, &settled.state) else { continue };
        let ways = was.positions.iter().zip(&is.positions).map(|(a, b)| (b - a).norm());
        if is_slow && ways.fold(0.0, f64::max) < reach {
            *start = FiberStart {
                state: settled.state,
                tip: settled.tip,
                taken: settled.taken,
                ..start.clone()
            };
        } else {
            all_rest = false;
            notes.push(format!(
                "fibers[{}] does not rest as it is wound: nothing holds its ends, or friction does \
                 not hold what its bending asks for",
                start.bundle
            ));
        }
    }
    Ok(all_rest.then_some(SettledWinding { fibers, numbers }))
}
