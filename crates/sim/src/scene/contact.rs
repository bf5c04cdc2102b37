use super::check::{Allowed, Check};
use crate::contact::{Partner, Touch};
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
    pub(super) fn check(&self, check: &mut Check) {
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
    /// own axis; with an object the axis is the fibre's.
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
