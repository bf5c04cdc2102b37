use super::check::{Allowed, Check};
use super::contact::check_restitution;
use super::{FrictionLaw, Keyframe, Motion};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// An object that fibres and free objects lie on or collide with. There are no contacts between
/// kinematic objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Surface of the object, about its own origin.
    pub shape: ObjectShape,
    /// Position of its origin at the start, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Rotation at the start: about the world's fixed x, then y, then z axes, degrees.
    #[serde(default)]
    pub turn: [f64; 3],
    /// Friction of fibres on the object; left out, the friction among fibres. `Cuticle` refers to
    /// the fibre's axis. At a contact of a free object with another object, the friction of the
    /// other one applies if given, else that of the free one, else that of the scene, but no
    /// `Cuticle`; of two free objects the one that is earlier in the list counts as the free one.
    #[serde(default)]
    pub friction: Option<FrictionLaw>,
    /// Coefficient of restitution of fibres on the object, from zero to one; left out, that among
    /// fibres. Between two objects the rule for friction applies.
    #[serde(default)]
    pub restitution: Option<f64>,
    /// Prescribed motion of a kinematic object.
    #[serde(default)]
    pub motion: Motion,
    /// Displacements of a kinematic object by hand, on top of its motion, as `Keyframes` of a
    /// motion are; left out, none.
    #[serde(default)]
    pub drag: Vec<Keyframe>,
    /// Whether the object is kinematic or moves freely.
    #[serde(default)]
    pub moves: Moves,
}

/// Kinematic or free motion of an object.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Moves {
    /// Kinematic: it follows its `motion`, whatever is in its path.
    #[default]
    Led,
    /// Free: a rigid body (thesis 8.4.1) of uniform density under gravity and contact forces.
    Free {
        /// Mass or density; the inertia follows from the shape.
        mass: ObjectMass,
        /// Velocity of its center of mass at the start, m/s.
        #[serde(default)]
        velocity: [f64; 3],
        /// Angular velocity at the start, degrees/s, world.
        #[serde(default)]
        spin: [f64; 3],
    },
}

/// Mass of an object, by its density or directly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ObjectMass {
    /// Density, kg/m^3.
    Density(f64),
    /// Mass, kg.
    Mass(f64),
}

/// The surface of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ObjectShape {
    /// The half space below a plane.
    Plane {
        /// Upward normal of the plane, any length.
        normal: [f64; 3],
    },
    /// A ball.
    Ball {
        /// Radius of the ball, m.
        radius: f64,
    },
    /// A capsule: a cylinder with hemispherical ends, along its z axis, with the origin in the
    /// middle.
    Capsule {
        /// Distance of the centers of the two hemispheres, m.
        length: f64,
        /// Radius of the capsule, m.
        radius: f64,
    },
    /// A box along its axes, the origin in the middle.
    Cuboid {
        /// Lengths of the sides of the box, m.
        sides: [f64; 3],
    },
    /// The ground below smooth random hills, up along its z axis, with the origin in the middle at
    /// mean height. Beyond its sides the heights at its rim go on.
    HeightField {
        /// Lengths along x and y, m.
        sides: [f64; 2],
        /// Distance of the points between which the ground is flat, m; at most a quarter of the
        /// wavelength.
        spacing: f64,
        /// Bound of the heights, up and down, m.
        amplitude: f64,
        /// Mean distance from crest to crest, m.
        wavelength: f64,
        /// Seed of the hills.
        #[serde(default)]
        seed: u64,
    },
    /// A closed surface in a file.
    Mesh {
        /// Path of a `.ply`, `.stl` or `.obj` file, relative to the folder of the scene.
        file: PathBuf,
        /// Distance of the points at which its distance field is stored, m: finer details of the
        /// surface are rounded.
        spacing: f64,
        /// Metres for a unit of the file: 0.001 for a file in millimetres.
        #[serde(default = "one")]
        scale: f64,
        /// Whether a surface that is not closed is repaired: holes closed, faces oriented alike and
        /// superfluous parts left out; the repairs are reported.
        #[serde(default)]
        repair: bool,
    },
    /// The head that a hairstyle grows on, in the frame of a groom of the style.
    Head {
        /// Path of the style, relative to the folder of the scene.
        style: PathBuf,
        /// Distance of the points at which its distance field is stored, m: finer details of the
        /// surface are rounded.
        spacing: f64,
    },
}

fn one() -> f64 {
    1.0
}

/// Largest angular speed of a free object at the start, degrees/s.
const FASTEST_SPIN: f64 = 3.6e5;

impl Object {
    /// Where the object is at the start: the map from its frame to the world.
    #[must_use]
    pub fn start(&self) -> Isometry3<f64> {
        let [x, y, z] = self.turn.map(f64::to_radians);
        let turn = UnitQuaternion::from_euler_angles(x, y, z);
        Isometry3::from_parts(Translation3::from(self.position), turn)
    }

    /// The pose of a kinematic object by time, s, with what hands did to it.
    pub fn led_pose(&self) -> impl Fn(f64) -> Isometry3<f64> + Send + Sync + 'static {
        let (motion, origin, start) = (self.motion.clone(), self.position.into(), self.start());
        let drag = Motion::Keyframes { points: self.drag.clone() };
        move |t| {
            let pose = motion.displacement(t, &origin) * start;
            let by = drag.displacement(t, &Point3::from(pose.translation.vector));
            // Before a hand comes, all is as without it to the last bit.
            if by == Isometry3::identity() { pose } else { by * pose }
        }
    }

    pub(super) fn check(&self, check: &mut Check) {
        check.vector("position", &self.position, "m");
        check.vector("turn", &self.turn, "degrees");
        check.within("motion", |c| self.motion.check(c));
        if !self.drag.is_empty() {
            check.within("drag", |c| {
                Motion::Keyframes { points: self.drag.clone() }.check(c);
            });
        }
        check.within("shape", |c| self.shape.check(c));
        if let Some(friction) = &self.friction {
            check.within("friction", |c| friction.check(c));
        }
        if let Some(restitution) = self.restitution {
            check_restitution(restitution, check);
        }
        let Moves::Free { mass, velocity, spin } = self.moves else { return };
        check.within("moves", |c| {
            let (ObjectMass::Density(mass) | ObjectMass::Mass(mass)) = mass;
            c.number("mass", mass, Allowed::Positive, "kg, or kg/m^3");
            for (i, &x) in velocity.iter().enumerate() {
                c.number(&format!("velocity[{i}]"), x, Allowed::Within(-100.0, 100.0), "m/s");
            }
            for (i, &x) in spin.iter().enumerate() {
                let allowed = Allowed::Within(-FASTEST_SPIN, FASTEST_SPIN);
                c.number(&format!("spin[{i}]"), x, allowed, "degrees/s");
            }
        });
        let led = [("motion", self.motion != Motion::Fixed), ("drag", !self.drag.is_empty())];
        for (field, _) in led.into_iter().filter(|(_, is_led)| *is_led) {
            check.refuse(field, "is given, but the object moves freely: leave one out".into());
        }
        if self.shape.is_endless() {
            check.refuse("moves", "is Free, but the shape has no end: it cannot fall".into());
        }
    }
}

/// Reports friction by the axis of a fibre between two objects that may be in contact.
pub(super) fn check_pairs(objects: &[Object], scene: &FrictionLaw, check: &mut Check) {
    let lacks = |object: &Object| object.friction.as_ref().unwrap_or(scene).needs_axis();
    if !scene.needs_axis() {
        return;
    }
    let lacking: Vec<_> = (0..).zip(objects).filter(|(_, object)| lacks(object)).collect();
    let is_free = |object: &Object| object.moves != Moves::Led;
    for (place, (i, one)) in lacking.iter().enumerate() {
        let meets = |(_, other): &&(usize, &Object)| is_free(one) || is_free(other);
        if let Some((j, _)) = lacking[place + 1..].iter().find(meets) {
            let message = format!(
                "may touch objects[{j}], and the scene's friction is by the axis of a fibre, which \
                 objects do not have: give one of them another `friction`"
            );
            check.refuse(&format!("objects[{i}]"), message);
        }
    }
}

impl ObjectShape {
    fn check(&self, check: &mut Check) {
        let mut positive = |field: &str, length: f64| {
            check.number(field, length, Allowed::Positive, "m");
        };
        match self {
            Self::Plane { normal } => check.direction("normal", normal),
            Self::Ball { radius } => positive("radius", *radius),
            Self::Capsule { length, radius } => {
                positive("radius", *radius);
                check.number("length", *length, Allowed::NonNegative, "m");
            }
            Self::Cuboid { sides } => {
                sides.iter().enumerate().for_each(|(i, x)| positive(&format!("sides[{i}]"), *x));
            }
            Self::HeightField { sides, spacing, amplitude, wavelength, .. } => {
                sides.iter().enumerate().for_each(|(i, x)| positive(&format!("sides[{i}]"), *x));
                positive("spacing", *spacing);
                positive("wavelength", *wavelength);
                check.number("amplitude", *amplitude, Allowed::Finite, "m");
                if *spacing > 0.25 * wavelength {
                    let message = format!(
                        "is {spacing:?}, but must be at most a quarter of the \
                                           wavelength (m)"
                    );
                    check.refuse("spacing", message);
                }
            }
            Self::Mesh { spacing, scale, .. } => {
                positive("spacing", *spacing);
                check.number("scale", *scale, Allowed::Positive, "m");
            }
            Self::Head { spacing, .. } => positive("spacing", *spacing),
        }
    }

    /// Whether the shape extends beyond the part of it that is shown.
    #[must_use]
    pub fn is_endless(&self) -> bool {
        matches!(self, Self::Plane { .. } | Self::HeightField { .. })
    }

    /// Radius of a round shape, m.
    pub fn radius(&self) -> Option<f64> {
        match self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => Some(*radius),
            _ => None,
        }
    }

    /// Path of the file that holds the shape, if there is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Mesh { file, .. } | Self::Head { style: file, .. } => Some(file),
            _ => None,
        }
    }

    /// Makes a path relative to the folder of the scene.
    pub(super) fn seen_from(&mut self, folder: &Path) {
        if let Self::Mesh { file, .. } | Self::Head { style: file, .. } = self {
            *file = folder.join(&*file);
        }
    }
}
