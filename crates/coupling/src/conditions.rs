use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapunzel_keratin::law::ThreeElement;
use rapunzel_keratin::{Hair, KeratinError};
use rapunzel_rod_dynamic::{Air, Conditions, Drag, End, Instant, RodError, SectionLaws};
use rapunzel_scene::{Bundle, Environment, Scene, Tip, ramped};
use std::sync::Arc;

/// A root of a groom that is nearer to an object than this, m, is one in its skin: meshes of heads
/// and their fields are rounded by as much.
pub(crate) const ROOT: f64 = 1e-3;

/// What acts on all fibres of a bundle.
#[derive(Debug)]
pub struct BundleConditions {
    bundle: Bundle,
    environment: Environment,
    drag: Option<Drag>,
    /// The hair whose law follows the climate, where that changes.
    hair: Option<Hair>,
}

impl BundleConditions {
    /// The conditions of a bundle of a scene, whose fibres have this `length` and equivalent
    /// `radius`, m.
    ///
    /// # Errors
    /// [`RodError`] for fibres that are not slender enough for their drag.
    pub fn new(scene: &Scene, bundle: &Bundle, length: f64, radius: f64) -> Result<Self, RodError> {
        let viscosity = scene.environment.viscosity;
        let drag =
            (viscosity > 0.0).then(|| Drag::slender_body(viscosity, length, radius)).transpose()?;
        let (environment, hair) = (scene.environment.clone(), scene.changing_hair(bundle));
        Ok(Self { bundle: bundle.clone(), environment, drag, hair })
    }

    /// The gap to an object, m, below which roots grow out of it, if that is known of the bundle.
    pub(crate) fn grows_within(&self) -> Option<f64> {
        self.bundle.groom.is_some().then_some(ROOT)
    }

    /// The law of the sections at time `t`, s, if it changes.
    pub(crate) fn laws(&self, t: f64) -> Option<Result<SectionLaws, KeratinError>> {
        let hair = self.hair.as_ref()?;
        let climate = self.environment.climate.at(t);
        let law = climate.and_then(|climate| ThreeElement::section(hair, &climate));
        Some(law.map(|law| SectionLaws::Same(Arc::new(law))))
    }
}

/// What acts on one fibre.
#[derive(Debug, Clone)]
pub struct FiberConditions {
    /// The conditions of its bundle.
    pub bundle: Arc<BundleConditions>,
    /// Number of segments.
    pub segments: usize,
    /// Pose of the root at the start.
    pub root: Isometry3<f64>,
    /// Pose of the tip, the last node, at the start.
    pub tip: Isometry3<f64>,
    /// Load on the tip where the bundle leaves it free.
    pub end_load: End,
    /// Poses at which the grippers of the bundle have taken their nodes, each while it holds.
    pub taken: Vec<Option<Isometry3<f64>>>,
    /// Forces of hands on nodes, N, world; `None` as long as there never was a hand.
    pub pulls: Option<Vec<(usize, Vector3<f64>)>>,
}

/// The conditions during one step.
///
/// What kind of end a tip is may change between steps only, so it is decided for a step as a
/// whole, by the middle of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepConditions<'a> {
    fiber: &'a FiberConditions,
    middle: f64,
}

impl FiberConditions {
    pub(crate) fn during(&self, middle: f64) -> StepConditions<'_> {
        StepConditions { fiber: self, middle }
    }

    /// What acts on the fibre at time `t`, s, but for forces on nodes.
    #[must_use]
    pub fn at(&self, t: f64) -> Instant {
        self.during(t).at(t)
    }

    /// Length of the fibre that is inside a nozzle at time `t` (s), m.
    pub(crate) fn inside(&self, t: f64) -> f64 {
        self.bundle.bundle.feed.as_ref().map_or(0.0, |feed| feed.inside(t))
    }

    /// Whether the fibre is fed through a nozzle.
    pub(crate) fn is_fed(&self) -> bool {
        self.bundle.bundle.feed.is_some()
    }

    /// Poses at which the grippers of the bundle hold their nodes, `None` of those that do not.
    pub(crate) fn grips(&self) -> impl Iterator<Item = Option<Isometry3<f64>>> {
        let count = self.bundle.bundle.grippers.len();
        (0..count).map(|i| self.taken.get(i).copied().flatten())
    }

    /// Lets grippers take their nodes for the step whose middle is at a time, s, if they have not
    /// yet, and let them go; `pose` tells that of a node by its number.
    pub(crate) fn grip(&mut self, middle: f64, pose: impl Fn(usize) -> Isometry3<f64>) {
        let grippers = &self.bundle.bundle.grippers;
        self.taken.resize(grippers.len(), None);
        for (gripper, taken) in grippers.iter().zip(&mut self.taken) {
            let node = gripper.node.number(self.segments);
            *taken = gripper.holds(middle).then(|| taken.unwrap_or_else(|| pose(node)));
        }
    }

    /// The end that a gripper makes of a tip or root, by its node, at time `t`, s, if one holds it.
    fn gripped(&self, node: usize, t: f64) -> Option<End> {
        let all = self.bundle.bundle.grippers.iter().zip(&self.taken);
        let mut own = all.filter(|(gripper, _)| gripper.node.number(self.segments) == node);
        own.find_map(|(gripper, taken)| Some(gripper.end(t, taken.as_ref()?)))
    }

    /// The inner nodes of grippers, and the places where these hold them at time `t`, s; `None` of
    /// those that do not.
    pub(crate) fn gripped_nodes(
        &self,
        t: f64,
    ) -> impl Iterator<Item = (usize, Option<Point3<f64>>)> {
        let all = self.bundle.bundle.grippers.iter().zip(&self.taken);
        all.filter_map(move |(gripper, taken)| {
            let place = taken.as_ref().map(|taken| gripper.place(t, taken));
            Some((gripper.inner_node(self.segments)?, place))
        })
    }

    /// The forces on all nodes at time `t` (s), N, world; `None` if there are none.
    pub(crate) fn node_forces(&self, t: f64) -> Option<Vec<Vector3<f64>>> {
        let forces = self.bundle.bundle.node_forces(self.segments, t);
        let Some(pulls) = &self.pulls else { return forces };
        let mut forces = forces.unwrap_or_else(|| vec![Vector3::zeros(); self.segments + 1]);
        pulls.iter().for_each(|(node, force)| forces[*node] += force);
        Some(forces)
    }

    /// The tip's start pose, moved along by `way` and turned by `angle` about its tangent.
    fn moved_tip(&self, way: Vector3<f64>, angle: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        Translation3::from(way) * self.tip * turn
    }
}

impl Conditions for StepConditions<'_> {
    fn at(&self, t: f64) -> Instant {
        let BundleConditions { bundle, environment, drag, .. } = &*self.fiber.bundle;
        let Bundle { motion, root_joint, tip, feed, .. } = bundle;
        let start = Point3::from(bundle.root.position);
        let fed = feed.as_ref().map_or(0.0, |feed| feed.fed(t));
        let root = self.fiber.root * Translation3::new(0.0, 0.0, fed);
        let moved_tip = |way, angle| self.fiber.moved_tip(way, angle);
        let tip = match tip {
            Tip::Free => self.fiber.end_load,
            Tip::Loaded { force, moment } => {
                End::Loaded { force: force.at(t), moment: moment.at(t) }
            }
            Tip::Pulled { until, .. } if self.middle >= *until => End::FREE,
            Tip::Pulled { velocity, .. } => End::Held(moved_tip(Vector3::from(*velocity) * t, 0.0)),
            Tip::Held => End::Held(moved_tip(Vector3::zeros(), 0.0)),
            Tip::Driven { velocity, ramp, until, joint, twist } => {
                let way = ramped(t.min(*until), *ramp);
                let angle = twist.to_radians() * way / ramped(*until, *ramp);
                joint.end(t, moved_tip(Vector3::from(*velocity) * way, angle))
            }
            Tip::Led { motion, joint } => {
                let start = self.fiber.tip;
                let place = Point3::from(start.translation.vector);
                joint.end(t, motion.displacement(t, &place) * start)
            }
        };
        Instant {
            gravity: environment.gravity_at(t),
            distributed: Vector3::zeros(),
            root: self
                .fiber
                .gripped(0, t)
                .unwrap_or_else(|| root_joint.end(t, motion.displacement(t, &start) * root)),
            tip: self.fiber.gripped(self.fiber.segments, t).unwrap_or(tip),
            air: drag.map(|drag| Air { wind: environment.wind.at(t), drag }),
            inside: self.fiber.inside(t),
        }
    }
}
