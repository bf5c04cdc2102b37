//! Fibres in groups that are moved side by side, and in contact.

use super::batch::{rods, side_by_side};
use super::start::FiberStart;
use crate::SimError;
use crate::scene::{ContactSettings, RodMethod, Scene};
use rapunzel_coupling::{
    CollisionObject, ContactJoints, FiberConditions, FiberGroup, Fibers, FibersInContact, RodBatch,
    Surroundings,
};
use rapunzel_fiber::Assembly;
use rapunzel_rod_dynamic::{RodError, StaggeredBatch};
use std::sync::Arc;

/// All fibres, laid out.
pub(super) fn assembly(starts: &[FiberStart]) -> Assembly {
    Assembly::new(starts.iter().map(|start| start.rod.fiber.clone()).collect())
}

/// What is around at the start.
pub(super) fn at_start<'a>(
    scene: &'a Scene,
    objects: &'a mut [CollisionObject],
) -> Surroundings<'a> {
    Surroundings { environment: &scene.environment, objects, start: 0.0, end: 0.0 }
}

/// Fibres that touch each other and the objects around them, with joints.
pub(super) fn in_contact(
    settings: &ContactSettings,
    (method, keeps_ledger): (RodMethod, bool),
    starts: &[FiberStart],
    assembly: Assembly,
    joints: ContactJoints<'_>,
    around: &mut Surroundings<'_>,
) -> Result<FibersInContact, SimError> {
    let groups = groups(&assembly, starts, |starts| {
        let batch = match method {
            RodMethod::Staggered { rho_infinity } => {
                StaggeredBatch::hybrid(rods(starts), rho_infinity)?
            }
            // All else has been refused.
            _ => StaggeredBatch::backward_euler(rods(starts))?,
        };
        side_by_side(batch, starts)
    })?;
    let fibers = Fibers::new(assembly, groups, keeps_ledger);
    Ok(FibersInContact::new(settings.clone(), fibers, around, joints)?)
}

/// The fibres of an assembly in its groups, each group as `batch` makes it.
pub(super) fn groups<B: RodBatch + ?Sized>(
    assembly: &Assembly,
    starts: &[FiberStart],
    batch: impl Fn(&[&FiberStart]) -> Result<Box<B>, RodError>,
) -> Result<Vec<FiberGroup<B>>, SimError> {
    let group = |fibers: &[usize]| {
        let starts: Vec<&FiberStart> = fibers.iter().map(|&fiber| &starts[fiber]).collect();
        let bundle = starts[0].bundle;
        let batch = batch(&starts).map_err(|source| SimError::Rod { bundle, source })?;
        let lane = |(lane, start): (usize, &&FiberStart)| FiberConditions {
            bundle: Arc::clone(&start.conditions),
            segments: start.rod.fiber.segments(),
            root: *start.rod.fiber.root(),
            tip: start.tip.unwrap_or_else(|| batch.state(lane).tip(&start.rod.fiber)),
            end_load: start.end_load,
            taken: start.taken.clone(),
            pulls: None,
        };
        let lanes = starts.iter().enumerate().map(lane).collect();
        Ok(FiberGroup { fibers: fibers.to_vec(), batch, lanes })
    };
    assembly.groups().map(group).collect()
}
