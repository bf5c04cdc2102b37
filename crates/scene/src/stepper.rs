use super::check::{Allowed, Check};
use rapunzel_rod_dynamic::{BoxOptions, Coefficients, RodError, StaggeredBatch};
use serde::{Deserialize, Serialize};

/// Time integration settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepperSettings {
    /// Largest time step, s. The step taken is the largest not above it of which the frame
    /// interval is a multiple.
    pub dt: f64,
    /// Time integrator; left out, it is `Staggered`.
    #[serde(default)]
    pub method: Option<RodMethod>,
    /// Largest estimated error of the nodes' positions that may build up in a second of simulated
    /// time, m/s: each step is cut into as many steps as that takes, each at three times the cost
    /// of a step. Left out, the step size is `dt`.
    #[serde(default)]
    pub tolerance: Option<f64>,
}

/// Time integrator of a single fibre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum RodMethod {
    /// The staggered chain: second order in time and space, eight fibres at once. Fibres that bear
    /// contacts move by the backward Euler method as long as they do.
    Staggered {
        /// Spectral radius at infinite frequency: the fraction of the highest frequencies that is
        /// left after a step. 0 damps most; above 0.9 long runs may end, above 0.4 those of whips.
        #[serde(default = "rho_infinity")]
        rho_infinity: f64,
    },
    /// The staggered chain with the backward Euler method: first order in time, damps more, and
    /// bodies in contact come to rest.
    BackwardEuler,
    /// The box scheme in space with the generalised-alpha method in time (thesis 3.4).
    Box {
        /// Weights of the time integration.
        #[serde(default)]
        weights: Weights,
        /// Newton's method stops at this residual, relative to the magnitude of the terms.
        #[serde(default = "residual")]
        residual: f64,
    },
}

/// Weights of the generalised-alpha method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Weights {
    /// Second-order weights.
    SecondOrder {
        /// Spectral radius at infinite frequency: 1 conserves, 0 damps most.
        rho_infinity: f64,
    },
    /// The thesis's weights for most of its examples, alpha 0.3, beta 0, gamma 0.7: first order,
    /// damped.
    Thesis,
    /// The thesis's weights for its damped helix, alpha 0.4, beta 0, gamma 1: first order, damped
    /// more.
    ThesisDamped,
    /// Any stable weights.
    Given {
        /// Weight of the old derivative, at most 1/2.
        alpha: f64,
        /// Weight of the old value, 0 to 1/2.
        beta: f64,
        /// Weight of the new derivative in the update, at least 1/2 and 1/2 - alpha + beta.
        gamma: f64,
    },
}

fn rho_infinity() -> f64 {
    StaggeredBatch::DEFAULT_RHO_INF
}

fn residual() -> f64 {
    BoxOptions::default().tolerance
}

impl Default for RodMethod {
    fn default() -> Self {
        Self::Staggered { rho_infinity: rho_infinity() }
    }
}

impl Default for Weights {
    fn default() -> Self {
        Self::SecondOrder { rho_infinity: 0.8 }
    }
}

impl Weights {
    /// The weights as the integrator takes them.
    ///
    /// # Errors
    /// [`RodError::Invalid`] for weights that are not stable.
    pub fn coefficients(&self) -> Result<Coefficients, RodError> {
        match *self {
            Self::SecondOrder { rho_infinity } => Coefficients::second_order(rho_infinity),
            Self::Thesis => Ok(Coefficients::THESIS),
            Self::ThesisDamped => Ok(Coefficients::THESIS_DAMPED),
            Self::Given { alpha, beta, gamma } => Coefficients::new(alpha, beta, gamma),
        }
    }
}

impl StepperSettings {
    /// The integrator.
    #[must_use]
    pub fn method(&self) -> RodMethod {
        self.method.unwrap_or_default()
    }

    /// Whether the method supports contacts.
    pub fn can_touch(&self) -> bool {
        self.keeps_ledgers()
    }

    /// Whether the method supports energy ledgers.
    pub fn keeps_ledgers(&self) -> bool {
        !matches!(self.method, Some(RodMethod::Box { .. })) && self.tolerance.is_none()
    }

    /// Whether the method keeps ledgers, and needs them: a method that hardly damps is unstable in
    /// long steps. The bound is the `rho_infinity` up to which whips have been tested.
    pub fn may_create_energy(&self) -> bool {
        let undamped = |method: &RodMethod| matches!(method, RodMethod::Staggered { rho_infinity } if *rho_infinity > 0.4);
        self.keeps_ledgers() && self.method.as_ref().is_some_and(undamped)
    }

    /// Reports problems of the settings.
    pub(crate) fn check(&self, check: &mut Check) {
        check.number("dt", self.dt, Allowed::Within(1e-9, 60.0), "s");
        if let Some(tolerance) = self.tolerance {
            check.number("tolerance", tolerance, Allowed::Positive, "m/s");
        }
        check.within("method", |c| match &self.method() {
            RodMethod::BackwardEuler => {
                if self.tolerance.is_some() {
                    c.refuse("", "is of first order, but a tolerance needs one of second".into());
                }
            }
            RodMethod::Staggered { rho_infinity } => {
                c.number("rho_infinity", *rho_infinity, Allowed::Within(0.0, 1.0), "");
            }
            RodMethod::Box { weights, residual } => {
                c.number("residual", *residual, Allowed::Within(1e-14, 1e-2), "");
                match weights {
                    Weights::SecondOrder { rho_infinity } => {
                        let unit = Allowed::Within(0.0, 1.0);
                        c.number("weights.rho_infinity", *rho_infinity, unit, "");
                    }
                    other => {
                        if let Err(error) = other.coefficients() {
                            c.refuse("weights", error.to_string());
                        }
                    }
                }
            }
        });
    }
}
