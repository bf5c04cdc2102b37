//! The case: one rod at rest, and what it touches, as data.
//!
//! A case is a RON file like a scene: SI units, angles in degrees, the world frame; unknown fields
//! and numbers out of their range are errors. Its rod is clamped at its root, loaded along its
//! length, and its far end is free, in a joint, in a bearing, or clamped.

pub use crate::asked::{BranchSwitch, CaseStart, CaseSweep, Critical, Parameter, Wish, Wished};
pub use crate::case_contact::TouchingRod;
pub use crate::case_end::{CaseEnd, CaseRoot, SlidingHold};

use crate::taper::{Tapered, check_taper};
use crate::{
    Allowed, Check, FORMAT, LoadFrame, MaterialSpec, Object, Pose, SceneError, SceneProblem,
    TaperPoint, check_section, parse,
};
use rapunzel_fiber::Section;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One rod with its loads and its boundary conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Version of the format, 1.
    pub format: u32,
    /// Title of the case.
    #[serde(default)]
    pub name: String,
    /// Length of the rod, m; with a `wish` the shortest length that is tried.
    pub length: f64,
    /// Stiffness and mass of the rod.
    pub rod: CaseRod,
    /// Table of sections, stiffness and mass along the rod, from the clamp to the far end; left
    /// out, they are the same all along.
    #[serde(default)]
    pub taper: Vec<TaperPoint>,
    /// Darboux vector of the unloaded rod in the material frame (about d1, d2, tangent), 1/m.
    #[serde(default)]
    pub natural_curvature: [f64; 3],
    /// Other rods, stiffly joined end to end to this one: each takes its place from an arc length
    /// on.
    #[serde(default)]
    pub joined: Vec<JoinedRod>,
    /// Acceleration of free fall, m/s^2.
    #[serde(default = "earth")]
    pub gravity: [f64; 3],
    /// Pose of the clamped end of the rod.
    #[serde(default)]
    pub clamp: Pose,
    /// What holds the rod there.
    #[serde(default)]
    pub root: CaseRoot,
    /// Boundary condition at the far end.
    #[serde(default)]
    pub end: CaseEnd,
    /// Point masses along the rod.
    #[serde(default)]
    pub masses: Vec<PointMass>,
    /// Forces along the rod.
    #[serde(default)]
    pub forces: Vec<Force>,
    /// Points of the rod that are held at or pulled to given places.
    #[serde(default)]
    pub places: Vec<PlacedPoint>,
    /// Fixed objects that the rod touches without friction.
    #[serde(default)]
    pub objects: Vec<Object>,
    /// Other rods, which touch this one, each other and the objects without friction.
    #[serde(default)]
    pub rods: Vec<TouchingRod>,
    /// A length to be found, for questions such as "how long must it be".
    #[serde(default)]
    pub wish: Option<Wish>,
    /// Where the search starts; left out, from the natural shape and from bent ones.
    #[serde(default)]
    pub start: Option<CaseStart>,
    /// A parameter that changes, and the equilibria along its way.
    #[serde(default)]
    pub sweep: Option<CaseSweep>,
    /// A load, a turn or a length at which the equilibrium loses its stability.
    #[serde(default)]
    pub critical: Option<Critical>,
    /// If given, all equilibria that are found instead of one stable equilibrium, also with up to
    /// so many whole turns of the end about its tangent; zero adds no turns. Equilibria that only
    /// differ by a turn or a reflection of the whole rod are listed once.
    #[serde(default)]
    pub all_with_turns: Option<u16>,
    /// Number of equal parts between the stations at which the result is given.
    #[serde(default = "hundred")]
    pub parts: usize,
}

fn earth() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn hundred() -> usize {
    100
}

/// Stiffness and mass of a rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CaseRod {
    /// A solid cross section of a material.
    Solid {
        /// Cross section, m.
        section: Section,
        /// Material of the rod.
        #[serde(default)]
        material: MaterialSpec,
    },
    /// Measured properties, as of a hose or a cable.
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

/// A rod that another one goes on as.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JoinedRod {
    /// Arc length from the clamp at which it begins, m; it ends where the next one begins.
    pub from: f64,
    /// Its stiffness and mass.
    pub rod: CaseRod,
    /// Its Darboux vector without loads, in the material frame, 1/m.
    #[serde(default)]
    pub natural_curvature: [f64; 3],
}

/// A point mass that hangs on the rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointMass {
    /// Arc length from the clamp, m.
    pub at: f64,
    /// Mass, kg.
    pub mass: f64,
}

/// A force on a point of the rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Arc length from the clamp, m.
    pub at: f64,
    /// Components of the force in its frame, N.
    pub value: [f64; 3],
    /// Whether the direction of the force stays or follows the rod.
    #[serde(default)]
    pub frame: LoadFrame,
}

/// A point of the rod that is held at or pulled to a place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedPoint {
    /// Arc length of the point from the clamp, m.
    pub at: f64,
    /// Place of the point, m.
    pub position: [f64; 3],
    /// Stiffness of the spring that pulls the point to the place, N/m; left out, the point is held.
    #[serde(default)]
    pub stiffness: Option<f64>,
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

    /// Problems of the case, without their positions in a text.
    #[must_use]
    pub fn problems(&self) -> Vec<SceneProblem> {
        let mut check = Check::default();
        self.check(&mut check);
        check.finish(None)
    }

    /// Whether the rod is approximated by a chain: some loads or supports are possible in a chain
    /// only.
    pub fn needs_chain(&self) -> bool {
        !self.places.is_empty() || self.forces.iter().any(|f| f.frame == LoadFrame::Follower)
    }

    /// The case with the paths of the files it names made relative to `folder`, the folder of the
    /// case.
    #[must_use]
    pub fn seen_from(mut self, folder: &Path) -> Self {
        let starts = self.rods.iter_mut().map(|rod| &mut rod.start);
        for start in [&mut self.start].into_iter().chain(starts).flatten() {
            let (CaseStart::Curve(file) | CaseStart::Answer(file)) = start;
            *file = folder.join(&*file);
        }
        self.objects.iter_mut().for_each(|object| object.shape.seen_from(folder));
        self
    }

    fn check(&self, check: &mut Check) {
        if self.format != FORMAT {
            let message = format!("is {}, but this version reads format {FORMAT}", self.format);
            check.refuse("format", message);
        }
        self.check_rod(check);
        check.vector("gravity", &self.gravity, "m/s^2");
        check.count("parts", self.parts, 2, 100_000);
        let along = Allowed::Within(0.0, self.length);
        check.each("places", &self.places, |c, place| {
            c.number("at", place.at, along, "m");
            c.vector("position", &place.position, "m");
            if let Some(stiffness) = place.stiffness {
                c.number("stiffness", stiffness, Allowed::Positive, "N/m");
            }
            self.check_reach(c, "position", place.position, place.at);
        });
        self.check_joined(check);
        self.check_asked(check);
        self.check_contact(check);
        let longest = self.longest();
        if let Some(position) = self.end.position() {
            self.check_reach(check, "end", position, longest);
        }
        self.check_together(check);
    }

    /// Reports a natural curvature or twist whose radius is smaller than the rod's radius.
    fn check_curvature(&self, check: &mut Check) {
        let own = match self.rod {
            CaseRod::Solid { section, .. } => section,
            CaseRod::Measured { radius, .. } => Section::Circle { radius },
        };
        let at = |point: &TaperPoint| point.section.unwrap_or(own).equivalent_radius();
        let radius = if self.taper.is_empty() {
            own.equivalent_radius()
        } else {
            self.taper.iter().map(at).fold(0.0, f64::max)
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

    /// Reports joined rods that are not in order.
    fn check_joined(&self, check: &mut Check) {
        let mut before = 0.0;
        for (i, part) in self.joined.iter().enumerate() {
            check.within(&format!("joined[{i}]"), |c| {
                part.rod.check(c, self.length);
                c.vector("natural_curvature", &part.natural_curvature, "1/m");
                if !(part.from > before && part.from < self.length) {
                    let message = format!(
                        "is {:?} m, but must be beyond {before:?} m, where the rod before it \
                         begins, and before the end at {:?} m",
                        part.from, self.length
                    );
                    c.refuse("from", message);
                }
            });
            before = part.from;
        }
        if !self.joined.is_empty() && !self.taper.is_empty() {
            check.refuse("taper", "does not go together with joined rods: give one of them".into());
        }
    }

    /// Reports a place farther from the clamp than the rod is long.
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

    /// Reports what is wrong with the rod by itself, with its ends and its dead loads.
    pub(crate) fn check_rod(&self, check: &mut Check) {
        check.number("length", self.length, Allowed::Within(1e-6, 1e3), "m");
        check.within("rod", |c| self.rod.check(c, self.length));
        let measured = matches!(self.rod, CaseRod::Measured { .. });
        check_taper(
            check,
            &self.taper,
            &Tapered { length: self.length, measured, has_section: true },
        );
        check.vector("natural_curvature", &self.natural_curvature, "1/m");
        self.check_curvature(check);
        check.within("clamp", |c| self.clamp.check(c));
        check.within("end", |c| self.end.check(c));
        let along = Allowed::Within(0.0, self.length);
        check.each("masses", &self.masses, |c, mass| {
            c.number("at", mass.at, along, "m");
            c.number("mass", mass.mass, Allowed::NonNegative, "kg");
        });
        check.each("forces", &self.forces, |c, force| {
            c.number("at", force.at, along, "m");
            c.vector("value", &force.value, "N");
        });
    }

    /// Reports fields that exclude each other.
    fn check_together(&self, check: &mut Check) {
        if !self.needs_chain() || self.is_in_contact() {
            return;
        }
        let with = "does not go together with following forces and places on the way";
        if !matches!(self.end, CaseEnd::Free { .. } | CaseEnd::Joint { .. }) {
            check.refuse("end", format!("is held in its direction, which {with}"));
        }
        if matches!(self.end, CaseEnd::Free { moment, .. } if moment != [0.0; 3]) {
            check.refuse("end.moment", with.into());
        }
        if self.all_with_turns.is_some() {
            check.refuse("all_with_turns", with.into());
        }
        if self.root == CaseRoot::Joint {
            check.refuse("root", with.into());
        }
        if !self.joined.is_empty() {
            check.refuse("joined", with.into());
        }
    }
}

impl CaseRod {
    pub(crate) fn check(&self, check: &mut Check, length: f64) {
        match self {
            Self::Solid { section, material } => {
                check.within("section", |c| check_section(c, section, length));
                check.within("material", |c| material.check(c));
                if matches!(material, MaterialSpec::Measured { .. }) {
                    let message = "has no section of its own: give `rod: Measured(...)`";
                    check.refuse("material", message.into());
                }
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
