use super::arrangement::Arrangement;
use super::charging::Charge;
use super::check::{Allowed, Check};
use super::feed::Feed;
use super::fiber_shape::{Closing, FiberShape, Initial};
use super::gripper::{GrippedFibers, Gripper};
use super::groom::{Groom, GroomShape};
use super::load::Profile;
use super::material::{Law, MaterialSpec};
use super::motion::Motion;
use super::section::check_section;
use super::taper::{TaperPoint, Tapered, check_taper, check_taper_law};
use super::tip::{JointKind, Tip};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::generate::root_pose;
use rapunzel_fiber::{FiberError, Section};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Fibres of the same kind on one moving base: one, or many.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bundle {
    /// Length of each fibre, m; to be left out where a groom gives it.
    #[serde(default)]
    pub length: f64,
    /// Number of segments of each fibre; of a groom of the longest, and of others by their length.
    pub segments: usize,
    /// Cross section, m; to be left out where the material or every point of the taper has one of
    /// its own. The section of keratin is given at 65 % humidity, from where it swells.
    #[serde(default)]
    pub section: Option<Section>,
    /// Table of sections, stiffness and mass along the fibres, from root to tip; left out, they are
    /// the same all along. The air drags a tapered fibre as one of the radius of its middle.
    #[serde(default)]
    pub taper: Vec<TaperPoint>,
    /// Material of the fibres.
    #[serde(default)]
    pub material: MaterialSpec,
    /// Retardation time of the internal damping (Kelvin-Voigt), s.
    #[serde(default)]
    pub damping_time: f64,
    /// Natural shape of the fibres, without load.
    #[serde(default)]
    pub shape: FiberShape,
    /// Shape of the fibres at the start.
    #[serde(default)]
    pub initial: Initial,
    /// Uniform velocity of all nodes at the start, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity of the bundle as one body at the start, which adds to the velocity.
    #[serde(default)]
    pub spin: Spin,
    /// Velocities of the nodes of each fibre from the root on, m/s, which add to the others; one
    /// for each node, or none. They must not stretch a segment.
    #[serde(default)]
    pub velocities: Vec<[f64; 3]>,
    /// Pose of the bundle at the start.
    #[serde(default)]
    pub root: Pose,
    /// Number and placement of the fibres.
    #[serde(default)]
    pub arrangement: Arrangement,
    /// Curves that the fibres lie along at the start, in place of length, shape, initial,
    /// arrangement and the orientation of the root.
    #[serde(default)]
    pub groom: Option<Groom>,
    /// Motion of the roots.
    #[serde(default)]
    pub motion: Motion,
    /// Nozzle that the fibres are fed through, paid out or taken up.
    #[serde(default)]
    pub feed: Option<Feed>,
    /// Boundary condition of the roots' frames.
    #[serde(default)]
    pub root_joint: JointKind,
    /// Boundary condition at the tips.
    #[serde(default)]
    pub tip: Tip,
    /// Grippers that take tips, free roots or inner nodes and let them go, for each node in the
    /// order of time.
    #[serde(default)]
    pub grippers: Vec<Gripper>,
    /// Closes each fibre to a ring; root and tip must then be free.
    #[serde(default)]
    pub closed: Option<Closing>,
    /// Point forces along the fibres.
    #[serde(default)]
    pub point_forces: Vec<PointForce>,
    /// Charge of the fibres; needs `charging`.
    #[serde(default)]
    pub charge: Charge,
}

/// Rotation as one body.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Spin {
    /// Angular velocity, degrees/s, world frame.
    pub rate: [f64; 3],
    /// A point on the axis, m, world frame; left out, the position of the root.
    pub about: Option<[f64; 3]>,
}

/// A position and an orientation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pose {
    /// Position, m, world frame.
    pub position: [f64; 3],
    /// Orientation of the material frame.
    pub orientation: Orientation,
}

/// The orientation of the material frame at a root.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Orientation {
    /// Orientation by the tangent: the smallest rotation from the world's z axis to it (straight
    /// down: about x).
    Along {
        /// The tangent, world frame, any length.
        direction: [f64; 3],
        /// Rotation about the tangent before, degrees.
        #[serde(default)]
        roll: f64,
    },
    /// Rotations about the world's fixed x, then y, then z axes.
    Euler {
        /// The three angles, degrees.
        degrees: [f64; 3],
    },
}

impl Default for Orientation {
    fn default() -> Self {
        Self::Along { direction: [0.0, 0.0, -1.0], roll: 0.0 }
    }
}

/// A point force on every fibre of a bundle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointForce {
    /// Arc length of the point as a fraction of the length, 0 at the root and 1 at the tip. The
    /// force acts on the nearest node.
    pub at: f64,
    /// The force, N, world frame.
    pub value: [f64; 3],
    /// Factor of the force over time.
    #[serde(default)]
    pub profile: Profile,
}

impl Bundle {
    /// Sum of the point forces on all nodes of one fibre of so many `segments` at time `t` (s), N,
    /// world; `None` if the bundle has no point forces.
    #[must_use]
    pub fn node_forces(&self, segments: usize, t: f64) -> Option<Vec<Vector3<f64>>> {
        if self.point_forces.is_empty() {
            return None;
        }
        let mut forces = vec![Vector3::zeros(); segments + 1];
        for force in &self.point_forces {
            #[expect(clippy::cast_possible_truncation, reason = "between 0 and the segments")]
            let node = (force.at * segments as f64).round() as usize;
            forces[node] += Vector3::from(force.value) * force.profile.at(t);
        }
        Some(forces)
    }
}

impl Pose {
    /// The pose as a map from the material frame to the world.
    ///
    /// # Errors
    /// [`FiberError::NoDirection`] for a tangent without length.
    pub fn isometry(&self) -> Result<Isometry3<f64>, FiberError> {
        let position = Point3::from(self.position);
        match &self.orientation {
            Orientation::Along { direction, roll } => {
                let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll.to_radians());
                Ok(root_pose(position, &Vector3::from(*direction))? * turn)
            }
            Orientation::Euler { degrees } => {
                let [x, y, z] = degrees.map(f64::to_radians);
                let rotation = UnitQuaternion::from_euler_angles(x, y, z);
                Ok(Isometry3::from_parts(position.into(), rotation))
            }
        }
    }

    pub(crate) fn check(&self, check: &mut Check) {
        check.vector("position", &self.position, "m");
        check.within("orientation", |c| match &self.orientation {
            Orientation::Along { direction, roll } => {
                c.direction("direction", direction);
                c.number("roll", *roll, Allowed::Finite, "degrees");
            }
            Orientation::Euler { degrees } => c.vector("degrees", degrees, "degrees"),
        });
    }
}

impl Bundle {
    /// Number of fibres; `None` of a groom, which is not known before it is read.
    #[must_use]
    pub fn count(&self) -> Option<usize> {
        self.groom.is_none().then(|| self.arrangement.fibers())
    }

    /// Path of the file that gives the fibres their shape, if there is one.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        self.groom.as_ref().map(|groom| groom.from.file()).or_else(|| self.initial.file())
    }

    /// Makes paths relative to the folder of the scene.
    pub(super) fn seen_from(&mut self, folder: &Path) {
        self.initial.seen_from(folder);
        self.groom.iter_mut().for_each(|groom| groom.seen_from(folder));
    }

    /// Whether loads that are not written in the scene stay on tips.
    pub(super) fn has_end_loads(&self) -> bool {
        let natural = self.groom.as_ref().map(|groom| groom.natural);
        matches!(natural, Some(GroomShape::EndLoads { .. }))
    }

    /// Constitutive law of the sections.
    pub fn law(&self) -> Law {
        self.material.keratin().map_or(Law::Elastic, |keratin| keratin.law)
    }

    /// Reports problems of the bundle.
    pub(crate) fn check(&self, check: &mut Check) {
        if let Some(groom) = &self.groom {
            check.within("groom", |c| groom.check(c));
            self.check_groom(check);
        } else {
            check.number("length", self.length, Allowed::Within(1e-6, 1e3), "m");
        }
        check.count("segments", self.segments, 2, 100_000);
        match (&self.section, self.material) {
            (Some(section), _) => {
                check.within("section", |c| check_section(c, section, self.length));
            }
            (None, MaterialSpec::Keratin { .. }) => {}
            (None, _) if !self.taper.is_empty() => {}
            (None, _) => check.refuse("section", "is missing, but the material has none".into()),
        }
        let tapered = Tapered {
            length: self.length,
            measured: matches!(self.material, MaterialSpec::Measured { .. }),
            has_section: self.section.is_some() || self.material.keratin().is_some(),
        };
        check_taper(check, &self.taper, &tapered);
        if !self.taper.is_empty() {
            check_taper_law(check, &self.material);
        }
        check.within("material", |c| self.material.check(c));
        if self.law() != Law::Elastic && self.damping_time != 0.0 {
            let message = "is given, but the law of the material has its own; leave it out";
            check.refuse("damping_time", message.into());
        }
        check.number("damping_time", self.damping_time, Allowed::NonNegative, "s");
        check.within("shape", |c| self.shape.check(c));
        check.within("initial", |c| self.initial.check(c));
        check.within("root", |c| self.root.check(c));
        check.within("arrangement", |c| self.arrangement.check(c));
        check.within("motion", |c| self.motion.check(c));
        check.vector("velocity", &self.velocity, "m/s");
        self.check_start(check);
        check.within("root_joint", |c| self.root_joint.check(c));
        if self.root_joint.is_free() && self.motion != Motion::Fixed {
            let message = "moves the root, but root_joint lets it move freely; leave one out";
            check.refuse("motion", message.into());
        }
        check.within("tip", |c| self.tip.check(c));
        let gripped = GrippedFibers {
            segments: self.segments,
            root_is_free: self.root_joint.is_free(),
            are_groomed: self.groom.is_some(),
        };
        Gripper::check(&self.grippers, gripped, check);
        check.each("point_forces", &self.point_forces, |c, force| {
            c.number("at", force.at, Allowed::Within(0.0, 1.0), "");
            c.vector("value", &force.value, "N");
            c.within("profile", |c| force.profile.check(c));
        });
        check.within("charge", |c| self.charge.check(c, self.arrangement.fibers(), self.segments));
    }

    /// Reports problems of the motion at the start, and of starts that give the root too.
    fn check_start(&self, check: &mut Check) {
        check.vector("spin.rate", &self.spin.rate, "degrees/s");
        if let Some(about) = &self.spin.about {
            check.vector("spin.about", about, "m");
        }
        check.each("velocities", &self.velocities, |c, v| c.vector("", v, "m/s"));
        let (found, nodes) = (self.velocities.len(), self.segments + 1);
        if self.groom.is_some() && found > 0 {
            let message = "is for fibres of equally many segments, not for a groom: leave it out";
            check.refuse("velocities", message.into());
        } else if found > 0 && found != nodes {
            let message = format!("has {found} entries, but each fibre has {nodes} nodes");
            check.refuse("velocities", message);
        }
        if !self.initial.places_root() {
            return;
        }
        let mut refuse = |given: bool, field: &str| {
            if given {
                let message = "is given by the initial shape: leave it out";
                check.refuse(field, message.into());
            }
        };
        refuse(self.arrangement != Arrangement::default(), "arrangement");
        refuse(self.root.orientation != Orientation::default(), "root.orientation");
        let moved = !matches!(self.initial, Initial::Curve { .. });
        refuse(moved && self.root.position != [0.0; 3], "root.position");
    }

    /// Reports what a groom is in place of, and ends that leave its shape undetermined.
    fn check_groom(&self, check: &mut Check) {
        let mut refuse = |given: bool, field: &str, message: &str| {
            if given {
                check.refuse(field, message.into());
            }
        };
        refuse(self.closed.is_some(), "closed", "is not for the hairs of a groom: leave it out");
        let given = "is given by the groom: leave it out";
        refuse(self.length != 0.0, "length", given);
        refuse(self.shape != FiberShape::default(), "shape", given);
        refuse(self.initial != Initial::default(), "initial", given);
        refuse(self.arrangement != Arrangement::default(), "arrangement", given);
        let turned = "is for fibres of one shape; give `turn` of the groom";
        let orientation = Orientation::default();
        refuse(self.root.orientation != orientation, "root.orientation", turned);
        if matches!(&self.groom, Some(groom) if groom.natural == GroomShape::Drawn) {
            return;
        }
        let held = "must be Clamped, or the natural shape does not follow from the curve; or take \
                    the groom's `natural: Drawn`";
        refuse(self.root_joint != JointKind::Clamped, "root_joint", held);
        let free = "must be Free or Loaded, or the natural shape does not follow from the curve; or \
                    take the groom's `natural: Drawn`";
        let loaded = matches!(self.tip, Tip::Loaded { .. }) && !self.has_end_loads();
        refuse(self.tip != Tip::Free && !loaded, "tip", free);
    }
}
