use super::check::{Allowed, Check};
use rapunzel_keratin::KeratinError;
use rapunzel_keratin::surface::{self, Direction, Spray, Wetness};
use serde::{Deserialize, Serialize};

/// Contact law and solver settings of fibres and objects; left out, there are no contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSettings {
    /// Friction among fibres, and of objects that give none of their own.
    pub friction: FrictionLaw,
    /// Newton's coefficient of restitution among fibres, and of objects that give none of their
    /// own, from zero to one. Slower approaches than gravity makes in two steps come to rest.
    #[serde(default)]
    pub restitution: f64,
    /// Adhesion at contacts; left out, there is none.
    #[serde(default)]
    pub adhesion: Option<Adhesion>,
    /// Compliance of a contact, m per N of normal force, and of friction before it slides; zero is
    /// rigid. It is the compliance of a spring, which backward Euler damps: a contact with
    /// restitution is rigid. Elastic compression does not count as `depth`.
    #[serde(default)]
    pub compliance: f64,
    /// Rolling resistance, m: a contact resists that its sides roll over each other with at most
    /// this times its normal force, N m.
    #[serde(default)]
    pub rolling_resistance: f64,
    /// Largest Coulomb residual of a step: the distance of the impulses from the contact law,
    /// relative to all impulses. Where objects touch and nothing else, an error of a velocity
    /// counts as one of the heaviest of those that bear on each other.
    #[serde(default = "residual")]
    pub residual: f64,
    /// Largest slip velocity of a sticking contact, m/s.
    #[serde(default = "slip")]
    pub slip: f64,
    /// Largest penetration that a step may leave, in diameters.
    #[serde(default = "depth")]
    pub depth: f64,
    /// Largest number of iterations in one solve.
    #[serde(default = "iterations")]
    pub iterations: usize,
    /// Method that solves all contacts of a step together.
    #[serde(default)]
    pub solver: ContactMethod,
}

/// Method that solves all contacts of a step together. Every method meets the same tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ContactMethod {
    /// The method of multipliers, which solves all contacts at once, body by body and contact by
    /// contact in turn, on all threads; Gauss-Seidel, one contact after another, where fibres have
    /// no more than four contacts each, on the average.
    #[default]
    Splitting,
    /// Twenty iterations of `Splitting`, then Gauss-Seidel on the contacts that still violate the
    /// law, over-relaxed, on one thread. A third of the iterations where a bundle falls and lies,
    /// but longer ones, so that it takes about as much time. Like `Splitting` where a fibre has too
    /// many contacts for an explicit response matrix, where rigid bodies move freely, and for the
    /// rest of a step in which it did not converge.
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

/// Adhesion of fibres to each other and to objects; only bonds hold objects to each other. Friction
/// grows with adhesion: a contact slides where the friction exceeds its coefficient times the sum
/// of the normal force and the tension that the contact could bear.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Adhesion {
    /// A constant pull along the contact up to a gap, then none. Crossing fibres have no contact
    /// length, and no pull.
    Line {
        /// Pull per length of contact, N/m.
        force: f64,
        /// Largest gap at the start of a step, m; the work of separation per length is the pull
        /// times this.
        range: f64,
    },
    /// Liquid that wets fibres completely and draws them together, by the law of the gap; fibres of
    /// different radii are treated as of the smallest radius. Objects stay dry.
    Capillary {
        /// Surface tension, N/m; water at 20 C has 0.0728.
        surface_tension: f64,
        /// Cross section of the liquid between two fibres side by side, m^2. More than
        /// `(4 - pi) r^2` counts as that.
        area: f64,
        /// Volume of the liquid at a crossing of two fibres, m^3.
        #[serde(default)]
        volume: f64,
    },
    /// One rigid bond for every pair of bodies in contact at the start, at their nearest points,
    /// which is gone once it is broken. It holds a point, about which the bodies may rotate.
    Bonds {
        /// Tensile force under which a bond breaks, N.
        strength: f64,
        /// Largest gap at the start of the run, m.
        range: f64,
    },
    /// Bonds of hair spray, which break at the middle of the range of thesis Table 2.12.
    Spray {
        /// Class of the hair spray.
        hold: Spray,
        /// Largest gap at the start of the run, m.
        range: f64,
    },
}

/// Rigid bonds between bodies in contact at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bonds {
    /// Tensile force under which one breaks, N.
    pub strength: f64,
    /// Largest gap at the start of the run, m.
    pub range: f64,
}

/// Friction law of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum FrictionLaw {
    /// Isotropic friction with one coefficient.
    Isotropic(f64),
    /// Isotropic friction, with a larger coefficient for a sticking contact than for a
    /// sliding one: a contact sticks if it slipped by no more than the `slip` of the contact
    /// settings when the step began.
    Resting {
        /// Coefficient of a sticking contact.
        resting: f64,
        /// Coefficient of a sliding contact, at most that of a sticking one.
        sliding: f64,
    },
    /// Friction by the direction of the fibre's scales: a fibre that moves root first goes with
    /// them.
    Cuticle {
        /// Coefficient with the scales.
        with: f64,
        /// Coefficient against the scales.
        against: f64,
        /// Coefficient across the fibre.
        across: f64,
    },
    /// Kinetic friction of untreated hair by table 2.11 of the thesis, the same in all directions.
    Keratin {
        /// Surface on which the hair slides.
        on: FrictionSurface,
        /// Whether there is water at the contact.
        #[serde(default = "dry")]
        wetness: Wetness,
    },
}

fn dry() -> Wetness {
    Wetness::Dry
}

/// Surfaces of table 2.11 on which hair slides.
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
    /// Coefficient of sliding friction of untreated hair.
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
        let rolling = self.rolling_resistance;
        check.number("rolling_resistance", rolling, Allowed::NonNegative, "m");
        check.number("residual", self.residual, Allowed::Within(1e-14, 0.1), "");
        check.number("slip", self.slip, Allowed::Positive, "m/s");
        check.number("depth", self.depth, Allowed::Within(1e-9, 0.1), "diameters");
        check.count("iterations", self.iterations, 1, 1_000_000);
    }
}

impl Adhesion {
    /// The bonds, if the adhesion is by bonds.
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

    /// Whether the law depends on the axis of a fibre, which two objects do not have.
    pub fn needs_axis(&self) -> bool {
        matches!(self, Self::Cuticle { .. })
    }
}
