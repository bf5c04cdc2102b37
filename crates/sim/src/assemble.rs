use crate::curve::knot;
use crate::mass_spring::MassSprings;
use crate::objects::{Sizes, build_object};
use crate::scene::{Arrangement, Bundle, FiberShape, Initial, RodMethod, Scene, scalp};
use crate::stepper::{Scenery, Stepper};
use crate::steppers::{Charged, Free, InContact};
use crate::{Plan, SimError, World};
use nalgebra::{Point3, Vector3};
use rapunzel_charging::{ChargedRods, HeadGeometry};
use rapunzel_coupling::{
    BundleConditions, CollisionObject, FiberConditions, FiberGroup, Fibers, FibersInContact,
    RodBatch, Rods, Surroundings,
};
use rapunzel_fiber::generate::{self, Ellipse, Helix, Lock, Overhand, Sine};
use rapunzel_fiber::{Assembly, Fiber, FiberError, NodeProperties, so3};
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Rod, RodError, RodIntegrator, RodState, SectionLaws, Staggered,
    StaggeredBatch,
};
use std::sync::Arc;

/// One fibre of the scene, ready to be handed to an integrator.
struct FiberStart {
    bundle: usize,
    rod: Rod,
    /// `None` for the natural shape, in which integrators start.
    state: Option<RodState>,
    velocity: Vector3<f64>,
    conditions: Arc<BundleConditions>,
}

impl FiberStart {
    /// The state to start in, if it is not that in which an integrator starts by itself.
    fn moving(&self, natural: impl FnOnce() -> RodState) -> Option<RodState> {
        if self.velocity == Vector3::zeros() {
            return self.state.clone();
        }
        let mut state = self.state.clone().unwrap_or_else(natural);
        state.velocities.fill(self.velocity);
        Some(state)
    }
}

impl World {
    /// The world of a scene at its start.
    ///
    /// # Errors
    /// [`SimError::Scene`] if the scene makes no sense; [`SimError::Fiber`] and [`SimError::Rod`]
    /// where only the combination of its numbers does not, such as a sine too fine for its
    /// segments; [`SimError::Io`], [`SimError::Mesh`] and [`SimError::Object`] for objects.
    pub fn build(scene: &Scene) -> Result<Self, SimError> {
        scene.validate()?;
        let mut starts = Vec::new();
        for (i, bundle) in scene.fibers.iter().enumerate() {
            // Bundles of one scene must not repeat each other's random choices.
            let seed = scene.seed.wrapping_add(i as u64);
            let (node, laws) = matter(scene, bundle, i, 0.0)?;
            let fibers =
                grow(bundle, node, seed).map_err(|source| SimError::Fiber { bundle: i, source })?;
            let radius = node.section.equivalent_radius();
            let conditions = Arc::new(
                BundleConditions::new(scene, bundle, radius)
                    .map_err(|source| SimError::Rod { bundle: i, source })?,
            );
            let course = course(bundle, i)?;
            for fiber in fibers {
                starts.push(FiberStart {
                    bundle: i,
                    state: laid(&fiber, &bundle.initial, course.as_deref(), i)?,
                    velocity: Vector3::from(bundle.velocity),
                    rod: Rod { laws: laws.clone(), ..Rod::damped(fiber, bundle.damping_time) },
                    conditions: Arc::clone(&conditions),
                });
            }
        }
        let assembly = Assembly::new(starts.iter().map(|s| s.rod.fiber.clone()).collect());
        let springs = scene.mass_spring.as_ref().map(MassSprings::new).transpose();
        let springs = springs.map_err(|source| SimError::MassSpring { time: 0.0, source })?;
        let sizes = match &springs {
            Some(springs) => sizes_of_springs(scene, springs),
            None => sizes_of_fibers(scene, &assembly),
        };
        let objects = scene.objects.iter().enumerate();
        let objects = objects.map(|(i, object)| build_object(object, i, &sizes));
        let mut objects = objects.collect::<Result<Vec<_>, _>>()?;
        let stepper = match springs {
            Some(springs) => Box::new(springs) as Box<dyn Stepper>,
            None => stepper(scene, &starts, assembly, &mut objects)?,
        };
        let mut world = Self::new(scene.environment.clone(), objects, stepper);
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
    assembly: Assembly,
    objects: &mut [CollisionObject],
) -> Result<Box<dyn Stepper>, SimError> {
    let scenery = Scenery::of_fibers(scene);
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
    let Some(settings) = &scene.contact else {
        let groups = groups(&assembly, starts, |starts| {
            batch(scene.stepper.method(false), scene.stepper.tolerance, starts)
        })?;
        let fibers = Fibers::new(assembly, groups, keeps_ledger);
        return Ok(Box::new(Free { fibers, scenery, tells_ledger }));
    };
    let groups = groups(&assembly, starts, |starts| {
        // Fibres that touch are integrated by backward Euler: all else has been refused.
        side_by_side(StaggeredBatch::backward_euler(rods(starts))?, starts)
    })?;
    let count = objects.len();
    let environment = &scene.environment;
    let mut around = Surroundings { environment, objects, start: 0.0, end: 0.0 };
    let fibers = Fibers::new(assembly, groups, keeps_ledger);
    let fibers = FibersInContact::new(settings.clone(), fibers, &mut around)?;
    Ok(Box::new(InContact { fibers, scenery, tells_ledger, objects: count }))
}

/// The fibres of an assembly in its groups, each group as `batch` makes it.
fn groups<B: RodBatch + ?Sized>(
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
            root: *start.rod.fiber.root(),
            tip: batch.state(lane).tip(&start.rod.fiber),
        };
        let lanes = starts.iter().enumerate().map(lane).collect();
        Ok(FiberGroup { fibers: fibers.to_vec(), batch, lanes })
    };
    assembly.groups().map(group).collect()
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
fn sizes_of_fibers(scene: &Scene, assembly: &Assembly) -> Sizes {
    let lengths = assembly.fibers().iter().map(|fiber| fiber.length());
    Sizes {
        roundest: scene.roundest(),
        longest: lengths.fold(0.0, f64::max),
        thickest: assembly.radii().iter().copied().fold(0.0, f64::max),
    }
}

/// What the fibres of bundle `i` are made of, and the laws of their sections, at time `t`, s.
pub(crate) fn matter(
    scene: &Scene,
    bundle: &Bundle,
    i: usize,
    t: f64,
) -> Result<(NodeProperties, SectionLaws), SimError> {
    scene.matter(bundle, t).map_err(|source| SimError::Keratin { bundle: i, source })
}

/// Lengths of the segments of each fibre of a bundle, m.
fn lengths(bundle: &Bundle) -> Vec<f64> {
    vec![bundle.length / bundle.segments as f64; bundle.segments]
}

/// The fibres of a bundle in their natural state.
fn grow(bundle: &Bundle, node: NodeProperties, seed: u64) -> Result<Vec<Fiber>, FiberError> {
    let pose = bundle.root.isometry()?;
    let straight = Fiber::new(pose, lengths(bundle), vec![node; bundle.segments + 1])?;
    let mut fiber = match bundle.shape {
        FiberShape::Straight => straight,
        FiberShape::Helix { radius, pitch, handedness } => {
            Helix { radius, pitch, handedness }.bend(straight)?
        }
        FiberShape::Sine { amplitude, wavelength } => {
            Sine { amplitude, wavelength }.bend(straight)?
        }
        FiberShape::Curved { curvature } => {
            straight.with_natural_curvature(|_| Vector3::from(curvature))?
        }
    };
    // The generators turn the root so that the shape runs along the pose; other starts do so
    // themselves.
    match bundle.initial {
        Initial::Natural => {}
        Initial::Helix { radius, pitch, handedness } => {
            let wound = Helix { radius, pitch, handedness }.bend(fiber.clone().with_root(pose))?;
            fiber = fiber.with_root(*wound.root());
        }
        Initial::Straight | Initial::Overhand { .. } | Initial::Knot { .. } => {
            fiber = fiber.with_root(pose);
        }
    }
    match bundle.arrangement {
        Arrangement::Single => Ok(vec![fiber]),
        Arrangement::Ellipse { semi_axes: [a, b], count } => {
            generate::bundle(&fiber, &Ellipse { pose, a, b }, count, seed)
        }
        Arrangement::EllipseAtDensity { semi_axes: [a, b], density } => {
            let patch = Ellipse { pose, a, b };
            generate::bundle(&fiber, &patch, patch.count(density)?, seed)
        }
        Arrangement::Scalp { semi_axes, count, polar, azimuth } => {
            // The shape has turned the root.
            let turn = pose.rotation.inverse() * fiber.root().rotation;
            let roots = scalp(semi_axes, count, polar, azimuth)?;
            Ok(roots.iter().map(|root| fiber.clone().with_root(pose * root * turn)).collect())
        }
        Arrangement::Lock { count, radius, curvature_variation, clumping } => {
            Lock { count, radius, curvature_variation, clumping }.grow(&fiber, seed)
        }
    }
}

/// The nodes that the fibres of a bundle start with, m, in their roots' frames; `None` for those
/// whose own shape counts.
fn course(bundle: &Bundle, index: usize) -> Result<Option<Vec<Point3<f64>>>, SimError> {
    let lengths = lengths(bundle);
    let nodes = match &bundle.initial {
        Initial::Natural | Initial::Helix { .. } => return Ok(None),
        Initial::Straight => {
            let mut along = 0.0;
            let next = lengths.iter().map(|length| {
                along += length;
                Point3::new(0.0, 0.0, along)
            });
            Ok(std::iter::once(Point3::origin()).chain(next).collect())
        }
        Initial::Overhand { radius, spacing } => {
            Overhand { radius: *radius, spacing: *spacing }.nodes(&lengths)
        }
        Initial::Knot { curve, scale, spacing } => {
            knot(curve, *scale, *spacing, index)?.nodes(&lengths)
        }
    };
    nodes.map(Some).map_err(|source| SimError::Fiber { bundle: index, source })
}

/// The state in which a fibre is laid from its root's frame on, at rest, along its course if it has
/// one; `None` for its natural one.
fn laid(
    fiber: &Fiber,
    initial: &Initial,
    course: Option<&[Point3<f64>]>,
    bundle: usize,
) -> Result<Option<RodState>, SimError> {
    if let Initial::Helix { radius, pitch, handedness } = *initial {
        let wound = Helix { radius, pitch, handedness }.bend(fiber.clone());
        let wound = wound.map_err(|source| SimError::Fiber { bundle, source })?;
        let natural = Staggered::new(Rod::new(wound.with_root(*fiber.root())));
        return match natural {
            Ok(rod) => Ok(Some(rod.state())),
            Err(source) => Err(SimError::Rod { bundle, source }),
        };
    }
    Ok(course.map(|nodes| untwisted(fiber, nodes)))
}

/// A state at rest along `nodes`, m, in the root's frame, which is carried along without a twist.
fn untwisted(fiber: &Fiber, nodes: &[Point3<f64>]) -> RodState {
    let root = fiber.root();
    let positions = nodes.iter().map(|node| root * node).collect();
    let mut frame = root.rotation.to_rotation_matrix();
    let frames: Vec<_> = nodes
        .windows(2)
        .map(|ends| {
            let tangent = root.rotation * (ends[1] - ends[0]);
            // There is none only for a fibre that turns back on itself.
            let turn = so3::between(&(frame * Vector3::z()), &tangent);
            frame = turn.unwrap_or_default() * frame;
            frame
        })
        .collect();
    let segments = fiber.segments();
    let mut curvatures = vec![Vector3::zeros(); segments + 1];
    for (i, pair) in frames.windows(2).enumerate() {
        let between = 0.5 * (fiber.segment_lengths()[i] + fiber.segment_lengths()[i + 1]);
        curvatures[i + 1] = so3::log(&(pair[0].inverse() * pair[1])) / between;
    }
    RodState {
        time: 0.0,
        positions,
        velocities: vec![Vector3::zeros(); segments + 1],
        frames,
        angular_velocities: vec![Vector3::zeros(); segments],
        forces: vec![Vector3::zeros(); segments],
        curvatures,
    }
}

/// The rods of some fibres.
fn rods(starts: &[&FiberStart]) -> Vec<Rod> {
    starts.iter().map(|start| start.rod.clone()).collect()
}

/// The integrator of a group of fibres of equal segment count, which touch nothing.
fn batch(
    method: RodMethod,
    tolerance: Option<f64>,
    starts: &[&FiberStart],
) -> Result<Box<dyn RodBatch>, RodError> {
    match method {
        RodMethod::Staggered { rho_infinity } if tolerance.is_none() => {
            Ok(side_by_side(StaggeredBatch::new(rods(starts), rho_infinity)?, starts)?)
        }
        // With a tolerance the scene has been refused: its error is estimated for second order.
        RodMethod::BackwardEuler => {
            Ok(side_by_side(StaggeredBatch::backward_euler(rods(starts))?, starts)?)
        }
        RodMethod::Staggered { rho_infinity } => {
            let new = |rod| Staggered::with_rho_inf(rod, rho_infinity);
            Ok(Box::new(Rods { rods: started(starts, new)?, tolerance }))
        }
        RodMethod::Box { weights, residual } => {
            let coefficients = weights.coefficients()?;
            let options = BoxOptions { coefficients, tolerance: residual, ..BoxOptions::default() };
            let new = |rod| BoxIntegrator::new(rod, options);
            Ok(Box::new(Rods { rods: started(starts, new)?, tolerance }))
        }
    }
}

/// Fibres in SIMD lanes, each at its start.
fn side_by_side(
    mut batch: StaggeredBatch,
    starts: &[&FiberStart],
) -> Result<Box<StaggeredBatch>, RodError> {
    for (lane, start) in starts.iter().enumerate() {
        if let Some(state) = start.moving(|| batch.state(lane)) {
            batch.set_state(lane, &state)?;
        }
    }
    Ok(Box::new(batch))
}

/// Integrators of single rods, each at its start.
fn started<I: RodIntegrator>(
    starts: &[&FiberStart],
    new: impl Fn(Rod) -> Result<I, RodError>,
) -> Result<Vec<I>, RodError> {
    let one = |start: &&FiberStart| {
        let mut integrator = new(start.rod.clone())?;
        if let Some(state) = start.moving(|| integrator.state()) {
            integrator.set_state(&state)?;
        }
        Ok(integrator)
    };
    starts.iter().map(one).collect()
}
