use crate::charging::{Charged, Electric, Resting, relax, set_matter};
use crate::conditions::{BundleConditions, FiberConditions};
use crate::contact::{Surroundings, Touching, build_object};
use crate::curve::knot;
use crate::group::{Batch, Group, Rods};
use crate::scene::{Arrangement, Bundle, Flow, Initial, Method, Scene, Shape, scalp};
use crate::{FreeFibers, MassSprings, Plan, SimError, Stepper, World, mass_spring};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::generate::{self, Ellipse, Helix, Lock, Overhand, Sine};
use rapunzel_fiber::{Assembly, Fiber, FiberError, NodeProperties, so3};
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Drag, Rod, RodError, RodIntegrator, RodState, SectionLaws,
    Staggered, StaggeredBatch,
};
use std::sync::Arc;

/// One fibre of the scene, ready to be handed to an integrator.
struct Start {
    bundle: usize,
    rod: Rod,
    /// `None` for the natural shape, in which integrators start.
    state: Option<RodState>,
    velocity: Vector3<f64>,
    conditions: Arc<BundleConditions>,
}

impl Start {
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
                conditions(scene, bundle, radius)
                    .map_err(|source| SimError::Rod { bundle: i, source })?,
            );
            let course = course(bundle, i)?;
            for fiber in fibers {
                starts.push(Start {
                    bundle: i,
                    state: laid(&fiber, &bundle.initial, course.as_deref(), i)?,
                    velocity: Vector3::from(bundle.velocity),
                    rod: Rod { laws: laws.clone(), ..Rod::damped(fiber, bundle.damping_time) },
                    conditions: Arc::clone(&conditions),
                });
            }
        }
        let assembly = Assembly::new(starts.iter().map(|s| s.rod.fiber.clone()).collect());
        let groups = assembly
            .groups()
            .map(|fibers| {
                let starts: Vec<&Start> = fibers.iter().map(|&f| &starts[f]).collect();
                let bundle = starts[0].bundle;
                let method = scene.stepper.method(scene.contact.is_some());
                let batch = match scene.charging {
                    Some(_) => {
                        let rods = starts.iter().map(|start| &start.rod.fiber);
                        Box::new(Resting::new(rods, fibers)?) as Box<dyn Batch>
                    }
                    None => batch(method, scene.stepper.tolerance, &starts)
                        .map_err(|source| SimError::Rod { bundle, source })?,
                };
                let lane = |(lane, start): (usize, &&Start)| FiberConditions {
                    bundle: Arc::clone(&start.conditions),
                    root: *start.rod.fiber.root(),
                    tip: batch.state(lane).tip(&start.rod.fiber),
                };
                let lanes = starts.iter().enumerate().map(lane).collect();
                Ok(Group { fibers: fibers.to_vec(), batch, lanes })
            })
            .collect::<Result<_, SimError>>()?;
        let mut world = Self::new(scene.environment.clone(), assembly, groups);
        if scene.output.ledger || scene.stepper.may_create_energy() {
            world.keep_works();
        }
        if let Some(springs) = &scene.mass_spring {
            let refused = |source| SimError::MassSpring { time: 0.0, source };
            let springs = mass_spring::build(springs).map_err(refused)?;
            world.springs = Some(springs);
            if let Some(warning) = world.warning(Plan::new(scene).dt) {
                tracing::warn!("{warning}");
            }
        }
        let around = surroundings(scene, &world);
        let objects = scene.objects.iter().enumerate();
        world.objects = objects
            .map(|(i, object)| build_object(object, i, &around))
            .collect::<Result<_, _>>()?;
        if let Some(charging) = &scene.charging {
            world.electric = Some(Electric::new(charging, &scene.objects, &world)?);
            load_at(scene, &mut world, 0.0)?;
            let gravity = world.gravity();
            relax(&mut world, &gravity)?;
        }
        if world.works().is_some() || scene.is_closed() {
            world.keep_budget();
        }
        Ok(world)
    }
}

/// The sizes of what is around objects.
fn surroundings(scene: &Scene, world: &World) -> Surroundings {
    if let Some(springs) = &world.springs {
        let from_first = |node| (springs.node(node).0 - springs.node(0).0).norm();
        let contacts = scene.mass_spring.as_ref().and_then(|system| system.contacts.as_ref());
        return Surroundings {
            roundest: None,
            longest: (0..springs.nodes()).map(from_first).fold(0.0, f64::max),
            thickest: contacts.map_or(0.0, |contacts| contacts.radius),
        };
    }
    let lengths = world.assembly().fibers().iter().map(|fiber| fiber.length());
    Surroundings {
        roundest: scene.roundest(),
        longest: lengths.fold(0.0, f64::max),
        thickest: world.assembly().radii().iter().copied().fold(0.0, f64::max),
    }
}

/// What moves the world of a scene.
///
/// # Errors
/// [`SimError::Collision`] if its fibres cannot be searched for contacts.
pub fn stepper_for(scene: &Scene, world: &World) -> Result<Box<dyn Stepper>, SimError> {
    if scene.mass_spring.is_some() {
        return Ok(Box::new(MassSprings));
    }
    if let Some(charging) = &scene.charging {
        return Ok(Box::new(Charged::new(scene, charging.dealing)));
    }
    Ok(match &scene.contact {
        None => Box::new(FreeFibers),
        Some(settings) => Box::new(Touching::new(settings.clone(), world)?),
    })
}

/// Puts the loads of the scene at time `t` (s) on fibres at rest, and makes them of their matter in the
/// climate then, if that changes.
pub(crate) fn load_at(scene: &Scene, world: &mut World, t: f64) -> Result<(), SimError> {
    for group in &mut world.groups {
        group.put_forces(t).map_err(|source| SimError::Step { time: t, source })?;
    }
    if !scene.environment.climate.changes() {
        return Ok(());
    }
    let mut fiber = 0;
    for (i, bundle) in scene.fibers.iter().enumerate() {
        let (node, _) = matter(scene, bundle, i, t)?;
        for _ in 0..bundle.arrangement.fibers() {
            set_matter(world, fiber, &node)?;
            fiber += 1;
        }
    }
    Ok(())
}

/// Resistance of fibres a length at time `t` (s), ohm/m.
pub(crate) fn resistance(scene: &Scene, flow: &Flow, t: f64) -> Result<f64, SimError> {
    let climate = scene.environment.climate.at(t);
    climate
        .and_then(|climate| flow.resistance_in(&climate))
        .map_err(|source| SimError::Keratin { bundle: 0, source })
}

fn conditions(scene: &Scene, bundle: &Bundle, radius: f64) -> Result<BundleConditions, RodError> {
    let viscosity = scene.environment.viscosity;
    let drag = (viscosity > 0.0)
        .then(|| Drag::slender_body(viscosity, bundle.length, radius))
        .transpose()?;
    let node = |at: f64| {
        #[expect(clippy::cast_possible_truncation, reason = "between 0 and the segments")]
        let node = (at * bundle.segments as f64).round() as usize;
        node
    };
    let node_forces = bundle
        .point_forces
        .iter()
        .map(|f| (node(f.at), Vector3::from(f.value), f.profile.clone()))
        .collect();
    Ok(BundleConditions {
        environment: scene.environment.clone(),
        drag,
        motion: bundle.motion.clone(),
        root_joint: bundle.root_joint.clone(),
        tip: bundle.tip.clone(),
        start: Point3::from(bundle.root.position),
        nodes: bundle.segments + 1,
        node_forces,
        hair: scene.changing_hair(bundle),
    })
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
        Shape::Straight => straight,
        Shape::Helix { radius, pitch, handedness } => {
            Helix { radius, pitch, handedness }.bend(straight)?
        }
        Shape::Sine { amplitude, wavelength } => Sine { amplitude, wavelength }.bend(straight)?,
        Shape::Curved { curvature } => {
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

/// The nodes that the fibres of a bundle start with, m, in their roots' frames; `None` for those whose
/// own shape counts.
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

/// The state in which a fibre is laid from its root's frame on, at rest, along its course if it has one;
/// `None` for its natural one.
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

/// The integrator of a group of fibres of equal segment count.
fn batch(
    method: Method,
    tolerance: Option<f64>,
    starts: &[&Start],
) -> Result<Box<dyn Batch>, RodError> {
    let rods = || starts.iter().map(|start| start.rod.clone()).collect();
    match method {
        Method::Staggered { rho_infinity } if tolerance.is_none() => {
            side_by_side(StaggeredBatch::new(rods(), rho_infinity)?, starts)
        }
        // With a tolerance the scene has been refused: its error is estimated for second order.
        Method::BackwardEuler => side_by_side(StaggeredBatch::backward_euler(rods())?, starts),
        Method::Staggered { rho_infinity } => {
            let new = |rod| Staggered::with_rho_inf(rod, rho_infinity);
            Ok(Box::new(Rods { rods: started(starts, new)?, tolerance }))
        }
        Method::Box { weights, residual } => {
            let coefficients = weights.coefficients()?;
            let options = BoxOptions { coefficients, tolerance: residual, ..BoxOptions::default() };
            let new = |rod| BoxIntegrator::new(rod, options);
            Ok(Box::new(Rods { rods: started(starts, new)?, tolerance }))
        }
    }
}

/// Fibres in SIMD lanes, each at its start.
fn side_by_side(mut batch: StaggeredBatch, starts: &[&Start]) -> Result<Box<dyn Batch>, RodError> {
    for (lane, start) in starts.iter().enumerate() {
        if let Some(state) = start.moving(|| batch.state(lane)) {
            batch.set_state(lane, &state)?;
        }
    }
    Ok(Box::new(batch))
}

/// Integrators of single rods, each at its start.
fn started<I: RodIntegrator>(
    starts: &[&Start],
    new: impl Fn(Rod) -> Result<I, RodError>,
) -> Result<Vec<I>, RodError> {
    let one = |start: &&Start| {
        let mut integrator = new(start.rod.clone())?;
        if let Some(state) = start.moving(|| integrator.state()) {
            integrator.set_state(&state)?;
        }
        Ok(integrator)
    };
    starts.iter().map(one).collect()
}
