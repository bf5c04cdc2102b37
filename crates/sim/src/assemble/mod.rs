//! From a scene to its world.

mod batch;
mod groom;
mod groups;
mod joined;
mod natural;
mod placed;
mod stage;
mod start;
mod still;
mod wound;

use crate::mass_spring::MassSprings;
use crate::objects::{Sizes, build_object};
use crate::scene::{Probe, ProbeNode, Scene};
use crate::stepper::{Scenery, Stepper};
use crate::steppers::{Charged, Free, InContact, Joined};
use crate::{Plan, SimError, World};
use batch::batch;
pub(crate) use groom::strand_count;
use groups::{assembly, at_start, groups, in_contact};
use joined::{ball_joints, joined, joints};
use natural::give_natural_shapes;
use rapunzel_charging::{ChargedRods, HeadGeometry};
use rapunzel_coupling::{CollisionObject, ContactJoints, Fibers};
pub use stage::BuildStage;
pub(crate) use start::matter;
use start::{FiberStart, starts};
use std::sync::Arc;
use wound::{SettledWinding, settle_wound};

impl World {
    /// The world of a scene at its start.
    ///
    /// # Errors
    /// Those of [`build_observed`](Self::build_observed).
    pub fn build(scene: &Scene) -> Result<Self, SimError> {
        Self::build_observed(scene, &|_| ())
    }

    /// The world of a scene at its start; `at` is told what takes long before it begins.
    ///
    /// # Errors
    /// [`SimError::Scene`] if the scene makes no sense; [`SimError::Fiber`] and [`SimError::Rod`]
    /// where only the combination of its numbers does not, such as a sine too fine for its
    /// segments; [`SimError::Io`], [`SimError::Mesh`] and [`SimError::Object`] for objects.
    pub fn build_observed(scene: &Scene, at: &dyn Fn(BuildStage)) -> Result<Self, SimError> {
        scene.validate()?;
        let bundles = scene.fibers.iter().enumerate();
        let mut notes = Vec::new();
        let starts = bundles.map(|(i, bundle)| starts(scene, bundle, i, &mut notes, at));
        let starts: Vec<_> = starts.collect::<Result<_, _>>()?;
        let mut starts: Vec<_> = starts.into_iter().flatten().collect();
        let springs = scene.mass_spring.as_ref().map(MassSprings::new).transpose();
        let springs = springs.map_err(|source| SimError::MassSpring { time: 0.0, source })?;
        let sizes = match &springs {
            Some(springs) => sizes_of_springs(scene, springs),
            None => sizes_of_fibers(scene, &starts),
        };
        let objects = scene.objects.iter().enumerate();
        let objects = objects.map(|(i, object)| build_object(object, i, &sizes));
        let mut objects = objects.collect::<Result<Vec<_>, _>>()?;
        let stepper = match springs {
            Some(springs) => Box::new(springs) as Box<dyn Stepper>,
            None => {
                give_natural_shapes(scene, &mut starts, &mut objects, &mut notes, at)?;
                let wound = settle_wound(scene, &mut starts, &objects, &mut notes, at)?;
                stepper(scene, &starts, wound.as_ref(), &mut objects)?
            }
        };
        check_probes(scene, &*stepper)?;
        let mut world = Self::new(scene.environment.clone(), objects, stepper);
        world.set_notes(notes);
        world.set_grips(scene.grips.clone())?;
        if let Some(warning) = world.warning(Plan::new(scene).dt) {
            tracing::warn!("{warning}");
        }
        if world.ledger().is_some() || scene.is_closed() {
            world.keep_budget();
        }
        Ok(world)
    }
}

/// What moves the fibres of a scene.
fn stepper(
    scene: &Scene,
    starts: &[FiberStart],
    wound: Option<&SettledWinding>,
    objects: &mut [CollisionObject],
) -> Result<Box<dyn Stepper>, SimError> {
    let assembly = assembly(starts);
    let segments: Vec<_> = (0..scene.fibers.len()).map(|i| segments(starts, i)).collect();
    let scenery = Scenery::of_fibers(scene, &segments);
    if let Some(charging) = &scene.charging {
        let head = charging.head.object().map(|i| HeadGeometry {
            field: Arc::clone(objects[i].field()),
            pose: objects[i].pose(0.0),
            surface: objects[i].surface().clone(),
        });
        let fibers = ChargedRods::new(scene, charging, assembly, head)?;
        return Ok(Box::new(Charged { fibers, scenery }));
    }
    let keeps_ledger = scene.output.ledger || scene.stepper.may_create_energy();
    let tells_ledger = scene.output.ledger;
    if scene.has_joints() && scene.contact.is_none() {
        let fibers = joined(scene, starts, assembly, keeps_ledger)?;
        return Ok(Box::new(Joined { fibers, scenery, tells_ledger }));
    }
    let Some(settings) = &scene.contact else {
        let groups = groups(&assembly, starts, |starts| {
            batch(scene.stepper.method(), scene.stepper.tolerance, starts)
        })?;
        let fibers = Fibers::new(assembly, groups, keeps_ledger);
        return Ok(Box::new(Free { fibers, scenery, tells_ledger }));
    };
    let count = objects.len();
    let mut around = at_start(scene, objects);
    let method = scene.stepper.method();
    let (between, on_objects) = (joints(scene, starts), ball_joints(scene, starts));
    let joints = ContactJoints { fibers: &between, objects: &on_objects };
    let mut fibers =
        in_contact(settings, (method, keeps_ledger), starts, assembly, joints, &mut around)?;
    if let Some(wound) = wound {
        wound.warm(&mut fibers);
    }
    Ok(Box::new(InContact { fibers, scenery, tells_ledger, objects: count }))
}

/// Numbers of segments of the fibres of a bundle.
fn segments(starts: &[FiberStart], bundle: usize) -> Vec<usize> {
    let of = starts.iter().filter(|start| start.bundle == bundle);
    of.map(|start| start.rod.fiber.segments()).collect()
}

/// The sizes of what meets objects: a mass-spring system.
fn sizes_of_springs(scene: &Scene, springs: &MassSprings) -> Sizes {
    let from_first = |node| (springs.node(0, Some(node)).0 - springs.node(0, Some(0)).0).norm();
    let contacts = scene.mass_spring.as_ref().and_then(|system| system.contacts.as_ref());
    Sizes {
        roundest: None,
        longest: (0..springs.nodes()).map(from_first).fold(0.0, f64::max),
        thickest: contacts.map_or(0.0, |contacts| contacts.radius),
    }
}

/// The sizes of what meets objects: fibres, and other objects.
fn sizes_of_fibers(scene: &Scene, starts: &[FiberStart]) -> Sizes {
    let fibers = || starts.iter().map(|start| &start.rod.fiber);
    let nodes = fibers().flat_map(|fiber| fiber.nodes());
    Sizes {
        roundest: scene.roundest(),
        longest: fibers().map(|fiber| fiber.length()).fold(0.0, f64::max),
        thickest: nodes.map(|node| node.section.equivalent_radius()).fold(0.0, f64::max),
    }
}

/// Looks whether the nodes that are probed are there: what a groom has is known only when it is
/// read.
fn check_probes(scene: &Scene, stepper: &dyn Stepper) -> Result<(), SimError> {
    if scene.fibers.iter().all(|bundle| bundle.groom.is_none()) {
        return Ok(());
    }
    let nodes = stepper.strand_nodes();
    for (probe, &Probe { fiber, node, .. }) in scene.output.probes.iter().enumerate() {
        let of = nodes.get(fiber).copied().unwrap_or(0);
        let least = if let ProbeNode::At { index } = node { index + 1 } else { 1 };
        if of < least {
            return Err(SimError::Probe { probe, fiber, fibers: nodes.len(), nodes: of });
        }
    }
    Ok(())
}
