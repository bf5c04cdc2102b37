//! Fibres as the scene puts them.

use super::groom::curves;
use super::placed::{Laid, placed, untwisted};
use super::stage::BuildStage;
use crate::SimError;
use crate::curve::knot;
use crate::scene::{Arrangement, Bundle, Feed, FiberMatter, FiberShape, Initial, Scene, scalp};
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapunzel_coupling::{BundleConditions, FiberConditions};
use rapunzel_fiber::generate::{self, Ellipse, Helix, Lock, Overhand, Sine};
use rapunzel_fiber::{Fiber, FiberError, NodeProperties, so3};
use rapunzel_rod_dynamic::{
    End, Rod, RodError, RodIntegrator, RodState, SectionLaws, Staggered, equilibrium,
};
use std::f64::consts::TAU;
use std::sync::Arc;

/// One fibre of the scene, ready to be handed to an integrator.
#[derive(Clone)]
pub(super) struct FiberStart {
    pub(super) bundle: usize,
    pub(super) rod: Rod,
    /// `None` for the natural shape, in which integrators start.
    pub(super) state: Option<RodState>,
    pub(super) velocity: Vector3<f64>,
    /// Angular velocity, rad/s, and a point on its axis, world.
    pub(super) spin: (Vector3<f64>, Point3<f64>),
    /// Velocities of the nodes beside these, m/s; none, or one for each.
    pub(super) velocities: Vec<Vector3<f64>>,
    pub(super) conditions: Arc<BundleConditions>,
    /// Load on the tip where the bundle leaves it free.
    pub(super) end_load: End,
    /// Pose of the tip at the start, if it is not that of the state.
    pub(super) tip: Option<Isometry3<f64>>,
    /// Poses at which the grippers of the bundle hold their nodes from the start on, if those are
    /// not of the state.
    pub(super) taken: Vec<Option<Isometry3<f64>>>,
}

impl FiberStart {
    /// The state to start in, if it is not that in which an integrator starts by itself.
    pub(super) fn moving(&self, natural: impl FnOnce() -> RodState) -> Option<RodState> {
        let (spin, about) = self.spin;
        let still = self.velocity == Vector3::zeros() && spin == Vector3::zeros();
        if still && self.velocities.is_empty() {
            return self.state.clone();
        }
        let mut state = self.state.clone().unwrap_or_else(natural);
        for (velocity, place) in state.velocities.iter_mut().zip(&state.positions) {
            *velocity = self.velocity + spin.cross(&(place - about));
        }
        for (velocity, own) in state.velocities.iter_mut().zip(&self.velocities) {
            *velocity += own;
        }
        // Sections turn with the whole; what the nodes add turns tangents only.
        let lengths = self.rod.fiber.segment_lengths();
        for (e, frame) in state.frames.iter().enumerate() {
            let swing = match self.velocities.get(e..e + 2) {
                Some(ends) => (frame * Vector3::z()).cross(&((ends[1] - ends[0]) / lengths[e])),
                None => Vector3::zeros(),
            };
            state.angular_velocities[e] = frame.inverse_transform_vector(&(spin + swing));
        }
        Some(state)
    }
}

/// What the fibres of bundle `i` are made of, and the laws of their sections, at time `t`, s.
pub(crate) fn matter(
    scene: &Scene,
    bundle: &Bundle,
    i: usize,
    t: f64,
) -> Result<(FiberMatter, SectionLaws), SimError> {
    scene.matter(bundle, t).map_err(|source| SimError::Keratin { bundle: i, source })
}

/// The fibres of bundle number `index`, ready to be handed to an integrator; what a user should
/// know of them is added to the `notes`, and `at` is told of what takes long.
///
/// # Errors
/// [`SimError`] of what cannot be made of the bundle's numbers and files.
pub(super) fn starts(
    scene: &Scene,
    bundle: &Bundle,
    index: usize,
    notes: &mut Vec<String>,
    at: &dyn Fn(BuildStage),
) -> Result<Vec<FiberStart>, SimError> {
    // Bundles of one scene must not repeat each other's random choices.
    let seed = scene.seed.wrapping_add(index as u64);
    let (matter, laws) = matter(scene, bundle, index, 0.0)?;
    let invalid = |source| SimError::Fiber { bundle: index, source };
    let laid_fibers: Vec<Laid> = match &bundle.groom {
        Some(groom) => {
            let curves = curves(groom, bundle, matter.thickest(), index, notes, at)?;
            let lay = |curve: &Vec<Point3<f64>>| {
                along(curve, |lengths| matter.along(lengths)).map(|(fiber, state)| Laid {
                    fiber,
                    state: Some(state),
                    tip: None,
                })
            };
            curves.iter().map(lay).collect::<Result<_, _>>().map_err(invalid)?
        }
        None => {
            let course = course(bundle, index)?;
            let fibers = natural(bundle, &matter, seed).map_err(invalid)?.into_iter();
            let lay = |fiber: Fiber| {
                let radius = matter.middle_radius();
                if let Some(laid) = placed(scene, bundle, &fiber, radius, index)? {
                    return Ok(laid);
                }
                let state = laid(&fiber, &bundle.initial, course.as_deref(), index)?;
                Ok(Laid { fiber, state, tip: None })
            };
            fibers.map(lay).collect::<Result<_, SimError>>()?
        }
    };
    let longest = laid_fibers.iter().map(|laid| laid.fiber.length()).fold(0.0, f64::max);
    let conditions = BundleConditions::new(scene, bundle, longest, matter.middle_radius());
    let conditions = conditions.map_err(|source| SimError::Rod { bundle: index, source })?;
    let conditions = Arc::new(conditions);
    let turns = bundle.closed.map_or(0.0, |closing| closing.turns);
    let fed = bundle.feed.as_ref().map_or(0.0, Feed::starting_speed);
    let start = |Laid { fiber, mut state, tip }| {
        let rod = Rod { laws: laws.clone(), ..Rod::damped(fiber, bundle.damping_time) };
        if turns != 0.0 {
            let mut own = match state {
                Some(state) => state,
                None => Staggered::new(rod.clone())?.state(),
            };
            twist(&mut own, turns);
            state = Some(own);
        }
        Ok(FiberStart {
            bundle: index,
            state,
            tip,
            velocity: Vector3::from(bundle.velocity) + fed * (rod.fiber.root() * Vector3::z()),
            spin: (
                Vector3::from(bundle.spin.rate.map(f64::to_radians)),
                Point3::from(bundle.spin.about.unwrap_or(bundle.root.position)),
            ),
            velocities: bundle.velocities.iter().map(|v| Vector3::from(*v)).collect(),
            rod,
            conditions: Arc::clone(&conditions),
            end_load: End::FREE,
            taken: Vec::new(),
        })
    };
    let starts: Result<Vec<_>, RodError> = laid_fibers.into_iter().map(start).collect();
    let mut starts = starts.map_err(|source| SimError::Rod { bundle: index, source })?;
    for start in &mut starts {
        settle(start, bundle)?;
        check_velocities(start, index)?;
    }
    Ok(starts)
}

/// Refuses velocities of nodes that stretch a segment.
fn check_velocities(start: &FiberStart, bundle: usize) -> Result<(), SimError> {
    // Those of one body stretch nothing.
    if start.velocities.is_empty() {
        return Ok(());
    }
    let natural = Staggered::new(start.rod.clone());
    let natural = natural.map_err(|source| SimError::Rod { bundle, source })?.state();
    let Some(state) = start.moving(|| natural) else { return Ok(()) };
    let fastest = state.velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
    for (e, frame) in state.frames.iter().enumerate() {
        let apart = state.velocities[e + 1] - state.velocities[e];
        if (frame * Vector3::z()).dot(&apart).abs() > 1e-6 * fastest {
            let why = "stretch a segment: take away what their differences have along the tangents";
            let source = RodError::Invalid { what: "velocities", why };
            return Err(SimError::Rod { bundle, source });
        }
    }
    Ok(())
}

/// A naturally straight fibre along a curve (world), m, and its state there, at rest; `nodes` gives
/// the properties of its nodes by the lengths of its segments, m.
pub(super) fn along(
    curve: &[Point3<f64>],
    nodes: impl FnOnce(&[f64]) -> Vec<NodeProperties>,
) -> Result<(Fiber, RodState), FiberError> {
    let root = generate::root_pose(curve[0], &(curve[1] - curve[0]))?;
    let lengths: Vec<_> = curve.windows(2).map(|ends| (ends[1] - ends[0]).norm()).collect();
    let properties = nodes(&lengths);
    let fiber = Fiber::new(root, lengths, properties)?;
    let nodes: Vec<_> = curve.iter().map(|point| root.inverse_transform_point(point)).collect();
    let state = untwisted(&fiber, &nodes);
    Ok((fiber, state))
}

/// Lengths of the segments of each fibre of a bundle, m.
fn lengths(bundle: &Bundle) -> Vec<f64> {
    vec![bundle.length / bundle.segments as f64; bundle.segments]
}

/// The fibres of a bundle in their natural state.
fn natural(bundle: &Bundle, matter: &FiberMatter, seed: u64) -> Result<Vec<Fiber>, FiberError> {
    let pose = bundle.root.isometry()?;
    let lengths = lengths(bundle);
    let nodes = matter.along(&lengths);
    let straight = Fiber::new(pose, lengths, nodes)?;
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
        Initial::Straight
        | Initial::Taut
        | Initial::Curve { .. }
        | Initial::Solved { .. }
        | Initial::Wrapped { .. }
        | Initial::Overhand { .. }
        | Initial::Knot { .. } => {
            fiber = fiber.with_root(pose);
        }
    }
    let fibers = arranged(bundle, fiber, pose, seed)?;
    let inside = bundle.feed.as_ref().map_or(0.0, |feed| feed.inside);
    let behind = |fiber: Fiber| {
        let root = fiber.root() * Translation3::new(0.0, 0.0, -inside);
        fiber.with_root(root)
    };
    if inside > 0.0 { Ok(fibers.into_iter().map(behind).collect()) } else { Ok(fibers) }
}

/// The fibres of a bundle, which are all like one but for where the arrangement puts them.
fn arranged(
    bundle: &Bundle,
    fiber: Fiber,
    pose: Isometry3<f64>,
    seed: u64,
) -> Result<Vec<Fiber>, FiberError> {
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
        Initial::Natural
        | Initial::Helix { .. }
        | Initial::Curve { .. }
        | Initial::Solved { .. }
        | Initial::Wrapped { .. } => return Ok(None),
        Initial::Straight | Initial::Taut => {
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

/// Lets a fibre settle to the equilibrium near its start, if its start is to be one.
///
/// # Errors
/// [`SimError::Equilibrium`] where none is found.
fn settle(start: &mut FiberStart, bundle: &Bundle) -> Result<(), SimError> {
    if !matches!(bundle.initial, Initial::Taut | Initial::Solved { .. }) {
        return Ok(());
    }
    let Some(state) = &start.state else { return Ok(()) };
    let conditions = FiberConditions {
        bundle: start.conditions.clone(),
        segments: start.rod.fiber.segments(),
        root: *start.rod.fiber.root(),
        tip: start.tip.unwrap_or_else(|| state.tip(&start.rod.fiber)),
        end_load: start.end_load,
        taken: Vec::new(),
        pulls: None,
    };
    let (mut rest, _) = equilibrium(&start.rod, &conditions.at(0.0), state)?;
    rest.time = 0.0;
    start.tip = Some(conditions.tip);
    start.state = Some(rest);
    Ok(())
}

/// Twists a fibre that starts in a state evenly about its tangents by so many turns over its
/// length.
fn twist(state: &mut RodState, turns: f64) {
    let segments = state.frames.len();
    let step = TAU * turns / segments as f64;
    for (e, frame) in state.frames.iter_mut().enumerate() {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), step * e as f64);
        *frame = Rotation3::from(UnitQuaternion::from_rotation_matrix(frame) * turn);
    }
    let length = |e: usize| (state.positions[e + 1] - state.positions[e]).norm();
    for a in 1..segments {
        let [before, after] = [&state.frames[a - 1], &state.frames[a]];
        let between = 0.5 * (length(a - 1) + length(a));
        state.curvatures[a] = so3::log(&(before.inverse() * after)) / between;
    }
}
