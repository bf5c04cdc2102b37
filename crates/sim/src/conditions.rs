use crate::scene::{Environment, Joint, Motion, Profile, Tip, ramped};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapunzel_keratin::law::ThreeElement;
use rapunzel_keratin::{Hair, KeratinError};
use rapunzel_rod_dynamic::{Air, Conditions, Drag, End, Instant, SectionLaws};
use std::sync::Arc;

/// What acts on all fibres of a bundle.
#[derive(Debug)]
pub(crate) struct BundleConditions {
    pub(crate) environment: Environment,
    pub(crate) drag: Option<Drag>,
    pub(crate) motion: Motion,
    pub(crate) root_joint: Joint,
    pub(crate) tip: Tip,
    /// Where the bundle starts.
    pub(crate) start: Point3<f64>,
    /// Number of nodes of a fibre.
    pub(crate) nodes: usize,
    /// Forces on nodes: node, force in N (world), factor over time.
    pub(crate) node_forces: Vec<(usize, Vector3<f64>, Profile)>,
    /// The hair whose law follows the climate, where that changes.
    pub(crate) hair: Option<Hair>,
}

impl BundleConditions {
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
pub(crate) struct FiberConditions {
    pub(crate) bundle: Arc<BundleConditions>,
    /// Pose of the root at the start.
    pub(crate) root: Isometry3<f64>,
    /// Pose of the tip at the start: the last node.
    pub(crate) tip: Isometry3<f64>,
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

    /// The forces on all nodes at time `t`, if the scene has any.
    pub(crate) fn node_forces(&self, t: f64) -> Option<Vec<Vector3<f64>>> {
        if self.bundle.node_forces.is_empty() {
            return None;
        }
        let mut forces = vec![Vector3::zeros(); self.bundle.nodes];
        for (node, force, profile) in &self.bundle.node_forces {
            forces[*node] += force * profile.at(t);
        }
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
        let BundleConditions { environment, drag, motion, root_joint, tip, start, .. } =
            &*self.fiber.bundle;
        let moved_tip = |way, angle| self.fiber.moved_tip(way, angle);
        let tip = match tip {
            Tip::Free => End::FREE,
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
        };
        Instant {
            gravity: environment.gravity_at(t),
            distributed: Vector3::zeros(),
            root: root_joint.end(t, motion.displacement(t, start) * self.fiber.root),
            tip,
            air: drag.map(|drag| Air { wind: environment.wind.at(t), drag }),
        }
    }
}
