use super::Motion;
use super::check::{Allowed, Check};
use crate::contact::{Partner, Touch};
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::{Ball, Cuboid, DistanceField, HalfSpace};
use rapunzel_contact::{ContactError, LimitCurve};
use serde::{Deserialize, Serialize};

/// What fibres do where they touch; left out, they pass through everything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSettings {
    /// Friction among fibres, and with objects that say nothing else.
    pub friction: Friction,
    /// Largest Coulomb residual of a step: how far impulses are from the law, relative to all
    /// impulses.
    #[serde(default = "residual")]
    pub residual: f64,
    /// Largest slip of a contact that sticks, m/s.
    #[serde(default = "slip")]
    pub slip: f64,
    /// Deepest penetration that a step may leave, in diameters.
    #[serde(default = "depth")]
    pub depth: f64,
    /// Most iterations of the solver at once.
    #[serde(default = "iterations")]
    pub iterations: usize,
}

fn residual() -> f64 {
    1e-3
}
fn slip() -> f64 {
    4e-5
}
fn depth() -> f64 {
    0.02
}
fn iterations() -> usize {
    400
}

/// Coefficients of friction of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Friction {
    /// The same in all directions.
    Isotropic(f64),
    /// By what the fibre's scales do: a fibre that moves root first goes with them.
    Cuticle {
        /// With the scales.
        with: f64,
        /// Against them.
        against: f64,
        /// Across the fibre.
        across: f64,
    },
}

/// Something that fibres lie on or bump into.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Its surface, about its own origin.
    pub shape: ObjectShape,
    /// Where its origin is at the start, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// How it is turned at the start: about the world's fixed x, then y, then z axes, degrees.
    #[serde(default)]
    pub turn: [f64; 3],
    /// How it moves.
    #[serde(default)]
    pub motion: Motion,
}

/// The surface of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ObjectShape {
    /// All that lies below a plane.
    Plane {
        /// Upward, any length.
        normal: [f64; 3],
    },
    /// A ball.
    Ball {
        /// Its radius, m.
        radius: f64,
    },
    /// A round bar with round ends, along its z axis, the origin in the middle.
    Capsule {
        /// Distance of the centers of its ends, m.
        length: f64,
        /// Its radius, m.
        radius: f64,
    },
    /// A box along its axes, the origin in the middle.
    Cuboid {
        /// Lengths of its sides, m.
        sides: [f64; 3],
    },
}

impl ContactSettings {
    pub(super) fn check(&self, check: &mut Check) {
        check.within("friction", |c| self.friction.check(c));
        check.number("residual", self.residual, Allowed::Within(1e-14, 0.1), "");
        check.number("slip", self.slip, Allowed::Positive, "m/s");
        check.number("depth", self.depth, Allowed::Within(1e-9, 0.1), "diameters");
        check.count("iterations", self.iterations, 1, 1_000_000);
    }
}

impl Friction {
    fn check(&self, check: &mut Check) {
        let mut one = |field: &str, mu: f64| {
            check.number(field, mu, Allowed::Within(0.0, 100.0), "");
        };
        match *self {
            Self::Isotropic(mu) => one("", mu),
            Self::Cuticle { with, against, across } => {
                one("with", with);
                one("against", against);
                one("across", across);
            }
        }
    }

    /// The limit curve of a touch. Of two fibres that touch, both have this friction, each by its
    /// own axis; an object has none of its own.
    pub(crate) fn of(&self, touch: &Touch) -> Result<LimitCurve, ContactError> {
        match *self {
            Self::Isotropic(mu) => Ok(LimitCurve::Circle { mu }),
            Self::Cuticle { with, against, across } => {
                let curve = LimitCurve::cuticle(with, against, across);
                match touch.partner {
                    Partner::Object(_) => Ok(curve),
                    Partner::Fiber(_) => LimitCurve::between(&curve, &curve, touch.turn()),
                }
            }
        }
    }
}

impl Object {
    pub(super) fn check(&self, check: &mut Check) {
        check.vector("position", &self.position, "m");
        check.vector("turn", &self.turn, "degrees");
        check.within("motion", |c| self.motion.check(c));
        check.within("shape", |c| match &self.shape {
            ObjectShape::Plane { normal } => c.direction("normal", normal),
            ObjectShape::Ball { radius } => c.number("radius", *radius, Allowed::Positive, "m"),
            ObjectShape::Capsule { length, radius } => {
                c.number("length", *length, Allowed::NonNegative, "m");
                c.number("radius", *radius, Allowed::Positive, "m");
            }
            ObjectShape::Cuboid { sides } => {
                for (i, side) in sides.iter().enumerate() {
                    c.number(&format!("sides[{i}]"), *side, Allowed::Positive, "m");
                }
            }
        });
    }
}

impl Object {
    /// The object as the search for contacts takes it.
    pub(crate) fn build(&self) -> crate::contact::Object {
        let field: Box<dyn DistanceField + Send + Sync> = match &self.shape {
            ObjectShape::Plane { normal } => Box::new(HalfSpace {
                point: Point3::origin(),
                normal: Unit::new_normalize(Vector3::from(*normal)),
            }),
            ObjectShape::Ball { radius } => {
                Box::new(Ball { center: Point3::origin(), radius: *radius })
            }
            ObjectShape::Capsule { length, radius } => {
                let end = Point3::new(0.0, 0.0, 0.5 * length);
                Box::new(Capsule { start: -end, end, radius: *radius })
            }
            ObjectShape::Cuboid { sides } => Box::new(Cuboid { half: 0.5 * Vector3::from(*sides) }),
        };
        let [x, y, z] = self.turn.map(f64::to_radians);
        let start = Isometry3::from_parts(
            Translation3::from(self.position),
            UnitQuaternion::from_euler_angles(x, y, z),
        );
        let (motion, origin) = (self.motion.clone(), Point3::from(self.position));
        let pose = move |t: f64| motion.displacement(t, &origin) * start;
        crate::contact::Object { field, pose: Box::new(pose) }
    }
}
