#![doc = include_str!("../README.md")]

mod arrangement;
mod asked;
mod asked_check;
pub mod case;
mod case_contact;
mod case_end;
mod charging;
mod check;
mod compatible;
mod contact;
mod environment;
mod error;
mod feed;
mod feed_check;
mod fiber_shape;
mod fibers;
mod freedom;
mod grip;
mod gripper;
mod groom;
mod joint;
mod joint_node;
mod load;
mod locate;
mod mass_spring;
mod material;
mod matter;
mod motion;
mod object;
mod output;
mod parse;
mod plan;
mod read;
mod section;
mod speed;
mod stepper;
mod style;
mod taper;
mod tip;

pub use arrangement::{Arrangement, scalp};
pub use charging::{
    Amount, Charge, Charging, ConductorHold, Dealing, FieldGridSpec, Flow, Head, Resistance,
};
pub use check::{SceneProblem, TextPlace};
pub use contact::{Adhesion, ContactMethod, ContactSettings, FrictionLaw, FrictionSurface};
pub use environment::{Environment, Wind};
pub use error::SceneError;
pub use feed::{FedLength, Feed};
pub use fiber_shape::{ClosedCurve, Closing, FiberShape, Initial};
pub use fibers::{Bundle, Orientation, PointForce, Pose, Spin};
pub use freedom::{Freedom, SupportAxes};
pub use grip::{Grip, GripPlace};
pub use gripper::Gripper;
pub use groom::{Groom, GroomShape, GroomSource, GroomUpAxis, RootBall};
pub use joint::{FiberJoint, JointHold, JointPlace, ObjectJoint};
pub use joint_node::JointNode;
pub use load::{LoadFrame, Profile, TimedLoad};
pub use mass_spring::{
    Hold, Integrator, MassSpring, Model, NodeContacts, NodeLoad, NodePlaces, SpringBodyShape,
};
pub use material::{ClimateHistory, Keratin, Law, MaterialSpec, fading_power};
pub use matter::FiberMatter;
pub use motion::{Keyframe, Motion, Pace, ramped};
pub use object::{Moves, Object, ObjectMass, ObjectShape};
pub use output::{ContactPartner, Format, Output, Probe, ProbeNode, ProbeQuantity};
pub use plan::Plan;
pub use stepper::{RodMethod, StepperSettings, Weights};
pub use style::style_from_ron;
pub use taper::TaperPoint;
pub use tip::{JointKind, Tip};

use check::{Allowed, Check};
use parse::parse;
use rapunzel_keratin::Hair;
use section::check_section;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The version of the scene format that this crate reads.
pub const FORMAT: u32 = 1;

/// Largest number of frames of a run, each a file or more; more is a typing error.
const MOST_FRAMES: f64 = 1e6;

/// Everything that determines a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of the format, 1.
    pub format: u32,
    /// Title of the scene.
    #[serde(default)]
    pub name: String,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
    /// Simulated time, s.
    pub duration: f64,
    /// Bundles of fibres.
    #[serde(default)]
    pub fibers: Vec<Bundle>,
    /// Objects that fibres lie on and collide with; needs `contact`, or the contacts of
    /// `mass_spring`.
    #[serde(default)]
    pub objects: Vec<Object>,
    /// Contact settings of the fibres; left out, fibres pass through each other.
    #[serde(default)]
    pub contact: Option<ContactSettings>,
    /// Charging of the fibres, which are then at rest instead of moving.
    #[serde(default)]
    pub charging: Option<Charging>,
    /// A mass-spring system in place of fibres.
    #[serde(default)]
    pub mass_spring: Option<MassSpring>,
    /// Joints between fibres.
    #[serde(default)]
    pub joints: Vec<FiberJoint>,
    /// Ball joints between fibres and objects, with `contact`.
    #[serde(default)]
    pub object_joints: Vec<ObjectJoint>,
    /// Hands that pull at nodes.
    #[serde(default)]
    pub grips: Vec<Grip>,
    /// Gravity, air and climate, which act on all fibres.
    #[serde(default)]
    pub environment: Environment,
    /// Time integration.
    pub stepper: StepperSettings,
    /// Output files.
    #[serde(default)]
    pub output: Output,
}

impl Scene {
    /// The scene with the paths of files made relative to `folder`, the folder of the scene.
    #[must_use]
    pub fn seen_from(mut self, folder: &Path) -> Self {
        self.objects.iter_mut().for_each(|object| object.shape.seen_from(folder));
        self.fibers.iter_mut().for_each(|bundle| bundle.seen_from(folder));
        self
    }

    /// The hair of a bundle whose law follows the climate, if the climate changes; else `None`.
    #[must_use]
    pub fn changing_hair(&self, bundle: &Bundle) -> Option<Hair> {
        let keratin = bundle.material.keratin()?;
        let follows = keratin.law == Law::ThreeElement && self.environment.climate.changes();
        keratin.hair(bundle.section).ok().filter(|_| follows)
    }

    /// Radius of the largest round object (m), or zero, if the scene has contacts between objects.
    #[must_use]
    pub fn roundest(&self) -> Option<f64> {
        let one_is_free = self.objects.iter().any(|object| object.moves != Moves::Led);
        let can_meet = one_is_free && self.objects.len() > 1;
        let radii = self.objects.iter().filter_map(|object| object.shape.radius());
        can_meet.then(|| radii.fold(0.0, f64::max))
    }

    /// Paths of the files that the scene names.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let meshes = self.objects.iter().filter_map(|object| object.shape.file());
        meshes.chain(self.fibers.iter().filter_map(Bundle::file))
    }

    /// Paths of the styles among these files, which name files of their own.
    pub fn styles(&self) -> impl Iterator<Item = &Path> {
        let heads = self.objects.iter().filter_map(|object| match &object.shape {
            ObjectShape::Head { style, .. } => Some(style.as_path()),
            _ => None,
        });
        let grooms = self.fibers.iter().filter_map(|bundle| match &bundle.groom.as_ref()?.from {
            GroomSource::Style { file, .. } => Some(file.as_path()),
            GroomSource::Strands { .. } => None,
        });
        heads.chain(grooms)
    }

    /// Whether no energy enters from outside: everything moves by itself, in steady gravity. No
    /// motion of such a scene may gain energy.
    pub fn is_closed(&self) -> bool {
        let still = |bundle: &Bundle| {
            bundle.motion == Motion::Fixed
                && bundle.feed.is_none()
                && matches!(bundle.tip, Tip::Free | Tip::Held)
                && bundle.point_forces.is_empty()
                && bundle.grippers.is_empty()
                && !bundle.has_end_loads()
                && match &bundle.root_joint {
                    JointKind::Clamped | JointKind::Free => true,
                    JointKind::Ball { moment } => *moment == TimedLoad::default(),
                    JointKind::Loaded { .. } | JointKind::Supported { .. } => false,
                }
        };
        let unmoved = |o: &Object| o.moves != Moves::Led || o.motion == Motion::Fixed;
        let air = &self.environment;
        self.fibers.iter().all(still)
            && self.objects.iter().all(unmoved)
            && self.contact.as_ref().is_none_or(|contact| contact.adhesion.is_none())
            && air.gravity_ramp == 0.0
            && air.wind == Wind::default()
            && !air.climate.changes()
            && self.charging.is_none()
            && self.mass_spring.is_none()
            && self.grips.is_empty()
    }

    /// Number of segments of fibre `fiber`, counted over all bundles; `None` if there is no such
    /// fibre. Of fibres behind a groom, whose number is not known before it is read, the groom's.
    fn segments_of(&self, fiber: usize) -> Option<usize> {
        if let Some(springs) = &self.mass_spring {
            return (fiber == 0).then(|| springs.nodes().saturating_sub(1));
        }
        self.bundle_of(fiber).map(|bundle| bundle.segments)
    }

    /// The bundle of fibre `fiber`, counted over all bundles; behind a groom, whose number of
    /// fibres is not known before it is read, the groom's.
    fn bundle_of(&self, mut fiber: usize) -> Option<&Bundle> {
        for bundle in &self.fibers {
            match bundle.count() {
                Some(count) if fiber >= count => fiber -= count,
                _ => return Some(bundle),
            }
        }
        None
    }

    /// Reports fields of fibres, which have no meaning beside a mass-spring system.
    fn check_only_springs(&self, check: &mut Check) {
        let refuse = |check: &mut Check, field: &str| {
            check.refuse(field, "is for fibres, but the scene has a mass_spring system".into());
        };
        if !self.fibers.is_empty() {
            refuse(check, "fibers");
        }
        if self.environment.viscosity != 0.0 {
            refuse(check, "environment.viscosity");
        }
        if self.stepper.method.is_some() {
            refuse(check, "stepper.method");
        }
        if self.stepper.tolerance.is_some() {
            refuse(check, "stepper.tolerance");
        }
        if self.contact.is_some() {
            refuse(check, "contact");
        }
        check.each("objects", &self.objects, |c, object| {
            if object.moves != Moves::Led {
                c.refuse("moves", "is Free, but nodes of a mass_spring system move nothing".into());
            }
            if object.friction.is_some() {
                c.refuse("friction", "is for fibres; give that of the nodes in `contacts`".into());
            }
        });
    }

    /// Reports what is incompatible with the material of a bundle.
    fn check_keratin(&self, bundle: &Bundle, check: &mut Check) {
        let Some(keratin) = bundle.material.keratin() else { return };
        let climate = self.environment.climate.at(0.0);
        let known =
            climate.and_then(|climate| keratin.rod(&keratin.hair(bundle.section)?, &climate));
        if let Err(error) = known {
            check.refuse("material", error.to_string());
        }
        let remembers = self.charging.is_none();
        if remembers && keratin.law != Law::ThreeElement && self.environment.climate.changes() {
            let message = "follows no climate that changes; take ThreeElement, or one humidity";
            check.refuse("material.law", message.into());
        }
        if keratin.law != Law::Elastic && !self.stepper.keeps_ledgers() {
            let message = "is for the methods Staggered and BackwardEuler without a tolerance";
            check.refuse("material.law", message.into());
        }
    }

    /// Reports all problems of the scene: numbers out of range, directions without length, roots
    /// that jump, probes of fibres that do not exist.
    fn check(&self, check: &mut Check) {
        if self.format != FORMAT {
            let message = format!("is {}, but this version reads format {FORMAT}", self.format);
            check.refuse("format", message);
        }
        check.number("duration", self.duration, Allowed::Within(1e-9, 1e6), "s");
        if let Some(springs) = &self.mass_spring {
            check.within("mass_spring", |c| springs.check(c));
            self.check_only_springs(check);
        } else if self.fibers.is_empty() {
            check.refuse("fibers", "is empty, but a scene needs at least one".into());
        }
        check.each("fibers", &self.fibers, |c, bundle| {
            bundle.check(c);
            self.check_keratin(bundle, c);
            self.check_supports(bundle, c);
            self.check_wrapped(bundle, c);
            self.check_feed(bundle, c);
            self.check_inner_grippers(bundle, c);
        });
        check.each("objects", &self.objects, |c, object| object.check(c));
        self.check_joints(check);
        check.each("grips", &self.grips, |c, grip| grip.check(c, self.segments_of(grip.fiber)));
        if let Some(contact) = &self.contact {
            check.within("contact", |c| contact.check(c));
            object::check_pairs(&self.objects, &contact.friction, check);
            if !self.stepper.can_touch() {
                let message = "must be Staggered, BackwardEuler or left out, and without a tolerance \
                               where fibers touch";
                check.refuse("stepper.method", message.into());
            }
        } else if !self.objects.is_empty()
            && self.charging.is_none()
            && self.mass_spring.as_ref().is_none_or(|springs| springs.contacts.is_none())
        {
            let message = "are given, but nothing touches them; say what happens with `contact`, \
                           or `contacts` of a mass_spring system";
            check.refuse("objects", message.into());
        }
        if self.output.ledger && (self.mass_spring.is_some() || !self.stepper.keeps_ledgers()) {
            let message = "is kept of fibres alone, by the methods Staggered and BackwardEuler without \
                           a tolerance: leave it out";
            check.refuse("output.ledger", message.into());
        }
        match &self.charging {
            Some(charging) => self.check_charging(charging, check),
            None => check.each("fibers", &self.fibers, |c, bundle| {
                if bundle.charge != Charge::default() {
                    let message = "is given, but the scene does not say how it is put there; add \
                                   `charging`";
                    c.refuse("charge", message.into());
                }
            }),
        }
        let rate =
            if self.charging.is_some() { 1.0 / self.stepper.dt } else { self.output.frame_rate };
        let frames = self.duration * rate;
        if frames > MOST_FRAMES {
            let message =
                format!("makes {frames:.0} frames, but must make at most {MOST_FRAMES:.0}");
            check.refuse("duration", message);
        }
        check.within("environment", |c| self.environment.check(c));
        check.within("stepper", |c| self.stepper.check(c));
        self.check_formats(check);
        self.check_probes(check);
        check.within("output", |c| self.output.check(c, |fiber| self.segments_of(fiber)));
    }
}
