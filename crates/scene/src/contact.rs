use super::check::{Allowed, Check};
use rapunzel_keratin::KeratinError;
use rapunzel_keratin::surface::{self, Direction, Spray, Wetness};
use serde::{Deserialize, Serialize};

/// What fibres and objects do where they touch; left out, fibres pass through everything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSettings {
    /// Friction among fibres, and of objects that say nothing else.
    pub friction: FrictionLaw,
    /// Newton's restitution among fibres, and of objects that say nothing else: the share of the
    /// velocity of approach with which a contact opens, from zero to one. Slower approaches than
    /// gravity makes in two steps come to rest.
    #[serde(default)]
    pub restitution: f64,
    /// What holds together what touches; left out, nothing does.
    #[serde(default)]
    pub adhesion: Option<Adhesion>,
    /// How far two that touch give way, m per N of what presses them, and of friction before it
    /// slides; zero is rigid. It is that of a spring, which backward Euler damps: a touch that
    /// bounces does not give way. What is pressed in so does not count as `depth`.
    #[serde(default)]
    pub compliance: f64,
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
    /// How all contacts are solved together.
    #[serde(default)]
    pub solver: ContactMethod,
}

/// How all contacts of a step are solved together. Both leave no more than the same tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ContactMethod {
    /// All at once, body by body and contact by contact in turn: the method of multipliers, on all
    /// threads.
    #[default]
    Splitting,
    /// So for ten iterations, and then one after the other, those alone that are wrong, each
    /// exactly: Gauss-Seidel, on one thread. A third of the iterations where hair falls and lies,
    /// longer ones, so that it takes somewhat more time. Where a fibre has too many contacts to
    /// write out how they answer each other, where rigid bodies move freely, and for the rest of a
    /// step in which it led nowhere, as `Splitting`.
    Polished,
}

fn residual() -> f64 {
    1e-4
}
fn slip() -> f64 {
    4e-5
}
fn depth() -> f64 {
    0.02
}
fn iterations() -> usize {
    2000
}

/// What holds fibres to each other and to objects; of these only bonds hold objects to each other.
/// Friction grows with it: a touch slides where the friction exceeds its coefficient times what
/// presses it and what it could bear in tension together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Adhesion {
    /// A pull along the contact: the same up to a gap, then none. Places where fibres cross have no
    /// length, and no pull.
    Line {
        /// Pull per length of contact, N/m.
        force: f64,
        /// Largest gap at the start of a step, m; the work of separation per length is the pull
        /// times this.
        range: f64,
    },
    /// Liquid that wets fibres completely and draws them together, as the gap lets it; fibres of
    /// different radii as those of the smallest. Objects stay dry.
    Capillary {
        /// Surface tension, N/m; water at 20 C has 0.0728.
        surface_tension: f64,
        /// Cross section of the liquid between two fibres side by side, m^2. More than
        /// `(4 - pi) r^2` counts as that.
        area: f64,
        /// Volume of the liquid where two fibres cross, m^3.
        #[serde(default)]
        volume: f64,
    },
    /// One rigid bond for every two things that touch at the start, where they are nearest, which
    /// once broken is gone. It holds a place, about which they may turn.
    Bonds {
        /// Tensile force under which it breaks, N.
        strength: f64,
        /// Largest gap at the start of the run, m.
        range: f64,
    },
    /// Bonds of hair spray, which break at the middle of what thesis Table 2.12 has for them.
    Spray {
        /// Which spray.
        hold: Spray,
        /// Largest gap at the start of the run, m.
        range: f64,
    },
}

/// Bonds between what touches at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bonds {
    /// Tensile force under which one breaks, N.
    pub strength: f64,
    /// Largest gap at the start of the run, m.
    pub range: f64,
}

/// Coefficients of friction of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum FrictionLaw {
    /// The same in all directions.
    Isotropic(f64),
    /// The same in all directions, more for a contact that sticks than for one that slides: one
    /// sticks if it slipped by no more than the `slip` of the contact settings when the step began.
    Resting {
        /// While it sticks.
        resting: f64,
        /// While it slides, at most as much.
        sliding: f64,
    },
    /// By what the fibre's scales do: a fibre that moves root first goes with them.
    Cuticle {
        /// With the scales.
        with: f64,
        /// Against them.
        against: f64,
        /// Across the fibre.
        across: f64,
    },
    /// As table 2.11 of the thesis has it for hair, untreated, in motion: the same in all
    /// directions.
    Keratin {
        /// What hair slides on.
        on: FrictionSurface,
        /// Whether there is water between.
        #[serde(default = "dry")]
        wetness: Wetness,
    },
}

fn dry() -> Wetness {
    Wetness::Dry
}

/// What hair slides on in table 2.11.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FrictionSurface {
    /// Hair.
    Hair,
    /// Hard rubber, from tip to root.
    HardRubber,
    /// Nylon.
    Nylon,
    /// Aluminium.
    Aluminium,
    /// Polyethylene.
    Polyethylene,
    /// Glass, only measured wet.
    Glass,
}

impl FrictionSurface {
    /// The coefficient of sliding friction, untreated.
    ///
    /// # Errors
    /// [`KeratinError::NotMeasured`] for dry glass.
    pub fn friction(self, wetness: Wetness) -> Result<f64, KeratinError> {
        let (pair, direction) = match self {
            Self::Hair => ("hair/hair", Direction::WithScales),
            Self::HardRubber => ("hair/hard rubber", Direction::AgainstScales),
            Self::Nylon => ("hair/nylon", Direction::WithScales),
            Self::Aluminium => ("hair/aluminium", Direction::WithScales),
            Self::Polyethylene => ("hair/polyethylene", Direction::WithScales),
            Self::Glass => ("hair/glass", Direction::WithScales),
        };
        Ok(surface::friction(pair, "", direction, wetness)?.slip.value)
    }
}

impl ContactSettings {
    pub(super) fn check(&self, check: &mut Check) {
        check.within("friction", |c| self.friction.check(c));
        check_restitution(self.restitution, check);
        if let Some(adhesion) = self.adhesion {
            check.within("adhesion", |c| adhesion.check(c));
        }
        check.number("compliance", self.compliance, Allowed::NonNegative, "m/N");
        check.number("residual", self.residual, Allowed::Within(1e-14, 0.1), "");
        check.number("slip", self.slip, Allowed::Positive, "m/s");
        check.number("depth", self.depth, Allowed::Within(1e-9, 0.1), "diameters");
        check.count("iterations", self.iterations, 1, 1_000_000);
    }
}

impl Adhesion {
    /// The bonds, if it is these that hold.
    pub fn bonds(self) -> Option<Bonds> {
        match self {
            Self::Bonds { strength, range } => Some(Bonds { strength, range }),
            Self::Spray { hold, range } => {
                let [least, most] = surface::bond_strength(hold).map(|force| force.value);
                Some(Bonds { strength: 0.5 * (least + most), range })
            }
            Self::Line { .. } | Self::Capillary { .. } => None,
        }
    }

    fn check(self, check: &mut Check) {
        let (positive, range) = (Allowed::Positive, "range");
        match self {
            Self::Line { force, range: gap } => {
                check.number("force", force, positive, "N/m");
                check.number(range, gap, positive, "m");
            }
            Self::Capillary { surface_tension, area, volume } => {
                check.number("surface_tension", surface_tension, positive, "N/m");
                check.number("area", area, positive, "m^2");
                check.number("volume", volume, Allowed::NonNegative, "m^3");
            }
            Self::Bonds { strength, range: gap } => {
                check.number("strength", strength, positive, "N");
                check.number(range, gap, positive, "m");
            }
            Self::Spray { range: gap, .. } => check.number(range, gap, positive, "m"),
        }
    }
}

pub(super) fn check_restitution(restitution: f64, check: &mut Check) {
    check.number("restitution", restitution, Allowed::Within(0.0, 1.0), "");
}

impl FrictionLaw {
    pub(super) fn check(&self, check: &mut Check) {
        let mut one = |field: &str, mu: f64| {
            check.number(field, mu, Allowed::Within(0.0, 100.0), "");
        };
        match *self {
            Self::Isotropic(mu) => one("", mu),
            Self::Resting { resting, sliding } => {
                one("resting", resting);
                one("sliding", sliding);
                if sliding > resting {
                    let message = format!("is {sliding:?}, but must be at most `resting`");
                    check.refuse("sliding", message);
                }
            }
            Self::Cuticle { with, against, across } => {
                one("with", with);
                one("against", against);
                one("across", across);
            }
            Self::Keratin { on, wetness } => {
                if let Err(error) = on.friction(wetness) {
                    check.refuse("", error.to_string());
                }
            }
        }
    }

    /// Whether it is by the axis of a fibre, which two objects do not have.
    pub fn needs_axis(&self) -> bool {
        matches!(self, Self::Cuticle { .. })
    }
}
