//! What a user asks of one rod at rest: the case.
//!
//! A case is a RON file like a scene: SI units, angles in degrees, the world frame; unknown fields
//! and numbers that make no sense are errors. Its rod is clamped at its root, loaded along its
//! length, and its far end is free, in a joint, in a bearing, or clamped.

use crate::{
    Allowed, Check, FORMAT, LoadFrame, MaterialSpec, Orientation, Pose, SceneError, SceneProblem,
    check_section, parse,
};
use rapunzel_fiber::{NodeProperties, Section};
use serde::{Deserialize, Serialize};

/// One rod, what loads it and what holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Version of the format, 1.
    pub format: u32,
    /// A title.
    #[serde(default)]
    pub name: String,
    /// Length of the rod, m; with a `wish` the shortest that is tried.
    pub length: f64,
    /// What the rod is made of.
    pub rod: CaseRod,
    /// Darboux vector of the unloaded rod in the material frame (about d1, d2, tangent), 1/m.
    #[serde(default)]
    pub natural_curvature: [f64; 3],
    /// Acceleration of free fall, m/s^2.
    #[serde(default = "earth")]
    pub gravity: [f64; 3],
    /// Where the rod is clamped.
    #[serde(default)]
    pub clamp: Pose,
    /// What holds or loads the far end.
    #[serde(default)]
    pub end: CaseEnd,
    /// Masses on the way.
    #[serde(default)]
    pub masses: Vec<PointMass>,
    /// Forces on the way.
    #[serde(default)]
    pub forces: Vec<Force>,
    /// Places on the way that the rod is held at or pulled to.
    #[serde(default)]
    pub places: Vec<PlacedPoint>,
    /// "How long must it be": a length to be found.
    #[serde(default)]
    pub wish: Option<Wish>,
    /// All equilibria that are found, not only a stable one, also with up to so many whole turns
    /// of the end about its tangent; zero adds no turns. Those that only differ by a turn or a
    /// reflection of the whole are told once.
    #[serde(default)]
    pub all_with_turns: Option<u16>,
    /// Number of equal parts between the stations of the answer.
    #[serde(default = "hundred")]
    pub parts: usize,
}

fn earth() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn hundred() -> usize {
    100
}

/// What a rod is made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CaseRod {
    /// A solid section of a material.
    Solid {
        /// Cross section, m.
        section: Section,
        /// Its material.
        #[serde(default)]
        material: MaterialSpec,
    },
    /// Measured: a hose, a cable.
    Measured {
        /// Bending stiffnesses about d1 and d2, N m^2.
        bending: [f64; 2],
        /// Torsion stiffness, N m^2.
        torsion: f64,
        /// Mass per length, kg/m.
        linear_density: f64,
        /// Radius for the picture, m.
        radius: f64,
    },
}

/// What holds or loads the far end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CaseEnd {
    /// Nothing, but perhaps a dead force and moment, which keep their directions.
    Free {
        /// Force on the end, N.
        #[serde(default)]
        force: [f64; 3],
        /// Moment on the end, N m.
        #[serde(default)]
        moment: [f64; 3],
    },
    /// A ball joint.
    Joint {
        /// Where, m.
        position: [f64; 3],
    },
    /// A bearing along a tangent, in which the rod turns freely about itself.
    Bearing {
        /// Where, m.
        position: [f64; 3],
        /// The tangent, away from the clamp; any length.
        direction: [f64; 3],
    },
    /// A clamp.
    Clamped {
        /// Where, m.
        position: [f64; 3],
        /// The frame there; its tangent is along the rod, away from the first clamp.
        orientation: Orientation,
    },
}

impl Default for CaseEnd {
    fn default() -> Self {
        Self::Free { force: [0.0; 3], moment: [0.0; 3] }
    }
}

impl CaseEnd {
    /// Where the end is held.
    #[must_use]
    pub fn position(&self) -> Option<[f64; 3]> {
        match self {
            Self::Free { .. } => None,
            Self::Joint { position }
            | Self::Bearing { position, .. }
            | Self::Clamped { position, .. } => Some(*position),
        }
    }
}

/// A mass that hangs on the rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointMass {
    /// Arc length from the clamp, m.
    pub at: f64,
    /// Mass, kg.
    pub mass: f64,
}

/// A force on the way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Arc length from the clamp, m.
    pub at: f64,
    /// Components in the frame, N.
    pub value: [f64; 3],
    /// Whether its direction stays or follows the rod.
    #[serde(default)]
    pub frame: LoadFrame,
}

/// A place that a point of the rod is held at or pulled to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedPoint {
    /// Arc length of the point from the clamp, m.
    pub at: f64,
    /// Where it is to be, m.
    pub position: [f64; 3],
    /// Stiffness of the spring that pulls it there, N/m; without one it is held.
    #[serde(default)]
    pub stiffness: Option<f64>,
}

/// A question for the length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wish {
    /// What the rod is to do.
    pub so_that: Wished,
    /// The longest length that is tried, m.
    pub longest: f64,
}

/// What a rod of the right length does; the shortest length is told that does it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Wished {
    /// It bends nowhere more than this, 1/m.
    Curvature(f64),
    /// It hangs this far below the lower one of its ends, m.
    Sag(f64),
    /// It pulls or pushes the clamp with no more than this, N.
    ClampForce(f64),
    /// It bends and twists the clamp with no more than this, N m.
    ClampMoment(f64),
}

impl Case {
    /// Reads and validates a case.
    ///
    /// # Errors
    /// [`SceneError`] with everything that is wrong, at line, column and path.
    pub fn from_ron(text: &str) -> Result<Self, SceneError> {
        let refuse = |problems| Err(SceneError { source_text: text.to_owned(), problems });
        match parse::<Self>(text) {
            Err(problem) => refuse(vec![problem]),
            Ok(case) => {
                let mut check = Check::default();
                case.check(&mut check);
                let problems = check.finish(Some(text));
                if problems.is_empty() { Ok(case) } else { refuse(problems) }
            }
        }
    }

    /// What is wrong with the case; places are not known.
    #[must_use]
    pub fn problems(&self) -> Vec<SceneProblem> {
        let mut check = Check::default();
        self.check(&mut check);
        check.finish(None)
    }

    /// Stiffnesses (N m^2), mass per length (kg/m) and radius (m).
    pub fn properties(&self) -> ([f64; 3], f64, f64) {
        match self.rod {
            CaseRod::Solid { section, material } => {
                let solid = material.solid().expect("the case has been checked");
                let node = NodeProperties::new(section, &solid);
                let stiffness = [0, 1, 2].map(|i| node.stiffness[i]);
                (stiffness, node.linear_density, section.equivalent_radius())
            }
            CaseRod::Measured { bending: [a, b], torsion, linear_density, radius } => {
                ([a, b, torsion], linear_density, radius)
            }
        }
    }

    /// Whether the rod is approximated by a chain: what only that can do is asked for.
    pub fn needs_chain(&self) -> bool {
        !self.places.is_empty() || self.forces.iter().any(|f| f.frame == LoadFrame::Follower)
    }

    fn check(&self, check: &mut Check) {
        if self.format != FORMAT {
            let message = format!("is {}, but this version reads format {FORMAT}", self.format);
            check.refuse("format", message);
        }
        check.number("length", self.length, Allowed::Within(1e-6, 1e3), "m");
        check.within("rod", |c| self.rod.check(c, self.length));
        check.vector("natural_curvature", &self.natural_curvature, "1/m");
        self.check_curvature(check);
        check.vector("gravity", &self.gravity, "m/s^2");
        check.within("clamp", |c| self.clamp.check(c));
        check.within("end", |c| self.end.check(c));
        check.count("parts", self.parts, 2, 100_000);
        let along = Allowed::Within(0.0, self.length);
        check.each("masses", &self.masses, |c, mass| {
            c.number("at", mass.at, along, "m");
            c.number("mass", mass.mass, Allowed::NonNegative, "kg");
        });
        check.each("forces", &self.forces, |c, force| {
            c.number("at", force.at, along, "m");
            c.vector("value", &force.value, "N");
        });
        check.each("places", &self.places, |c, place| {
            c.number("at", place.at, along, "m");
            c.vector("position", &place.position, "m");
            if let Some(stiffness) = place.stiffness {
                c.number("stiffness", stiffness, Allowed::Positive, "N/m");
            }
            self.check_reach(c, "position", place.position, place.at);
        });
        if let Some(wish) = self.wish {
            check.within("wish", |c| wish.check(c, self.length));
        }
        let longest = self.wish.map_or(self.length, |wish| wish.longest);
        if let Some(position) = self.end.position() {
            self.check_reach(check, "end", position, longest);
        }
        self.check_together(check);
    }

    /// Refuses a natural curvature or twist whose radius is smaller than the rod's.
    fn check_curvature(&self, check: &mut Check) {
        let radius = match self.rod {
            CaseRod::Solid { section, .. } => section.equivalent_radius(),
            CaseRod::Measured { radius, .. } => radius,
        };
        let size = self.natural_curvature.iter().fold(0.0, |size: f64, k| size.hypot(*k));
        if radius > 0.0 && size > 1.0 / radius {
            let message = format!(
                "is {size:?} 1/m in size, but a rod of radius {radius:?} m is curved by {:?} 1/m \
                 at most",
                1.0 / radius
            );
            check.refuse("natural_curvature", message);
        }
    }

    /// Refuses a place farther from the clamp than the rod is long.
    fn check_reach(&self, check: &mut Check, field: &str, position: [f64; 3], length: f64) {
        let from = self.clamp.position;
        let distance = (0..3).map(|i| (position[i] - from[i]).powi(2)).sum::<f64>().sqrt();
        if distance > length {
            let message = format!(
                "is {distance:?} m from the clamp, but the rod is {length:?} m long there; move \
                 it nearer or make the rod longer"
            );
            check.refuse(field, message);
        }
    }

    /// Refuses what does not go together.
    fn check_together(&self, check: &mut Check) {
        if !self.needs_chain() {
            return;
        }
        let with = "does not go together with following forces and places on the way";
        if matches!(self.end, CaseEnd::Bearing { .. } | CaseEnd::Clamped { .. }) {
            check.refuse("end", format!("is held in its direction, which {with}"));
        }
        if matches!(self.end, CaseEnd::Free { moment, .. } if moment != [0.0; 3]) {
            check.refuse("end.moment", with.into());
        }
        if self.all_with_turns.is_some() {
            check.refuse("all_with_turns", with.into());
        }
    }
}

impl CaseRod {
    fn check(&self, check: &mut Check, length: f64) {
        match self {
            Self::Solid { section, material } => {
                check.within("section", |c| check_section(c, section, length));
                check.within("material", |c| material.check(c));
                if let Err(error) = material.solid() {
                    check.refuse("material", error.to_string());
                }
            }
            Self::Measured { bending, torsion, linear_density, radius } => {
                check.number("bending[0]", bending[0], Allowed::Positive, "N m^2");
                check.number("bending[1]", bending[1], Allowed::Positive, "N m^2");
                check.number("torsion", *torsion, Allowed::Positive, "N m^2");
                check.number("linear_density", *linear_density, Allowed::NonNegative, "kg/m");
                check.number("radius", *radius, Allowed::Positive, "m");
            }
        }
    }
}

impl CaseEnd {
    fn check(&self, check: &mut Check) {
        match self {
            Self::Free { force, moment } => {
                check.vector("force", force, "N");
                check.vector("moment", moment, "N m");
            }
            Self::Joint { position } => check.vector("position", position, "m"),
            Self::Bearing { position, direction } => {
                check.vector("position", position, "m");
                check.direction("direction", direction);
            }
            Self::Clamped { position, orientation } => {
                Pose { position: *position, orientation: *orientation }.check(check);
            }
        }
    }
}

impl Wish {
    fn check(&self, check: &mut Check, length: f64) {
        check.number("longest", self.longest, Allowed::Within(length, 1e3), "m");
        let (value, unit) = match self.so_that {
            Wished::Curvature(x) => (x, "1/m"),
            Wished::Sag(x) => (x, "m"),
            Wished::ClampForce(x) => (x, "N"),
            Wished::ClampMoment(x) => (x, "N m"),
        };
        check.number("so_that", value, Allowed::Positive, unit);
    }
}
