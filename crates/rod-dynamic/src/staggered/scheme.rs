//! The generalised-alpha method of Chung and Hulbert for coordinates with a constant mass.
//!
//! Positions of nodes and directors of segments are such coordinates: the rod is a system of
//! constant mass under holonomic constraints (a differential-algebraic one of index 3), and the
//! method converges with second order for it (Arnold and Bruls 2007). Measured on the whip of a
//! free hair it stays stable up to `rho_inf` of 0.4, where the same method on rotation increments
//! gains energy; see the crate's tests.
//!
//! With `u` the displacement over the step, the end of the step has the velocity `cv u + vc` and
//! the acceleration `c1 (u - du)`. Backward Euler is the same without memory of accelerations: its
//! velocity is the mean one over the step, which contact laws refer to.

use pulp::Simd;
use rapunzel_lanes::{Lane, V3};

/// Coefficients of the method for one spectral radius at infinite frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scheme {
    alpha_m: f64,
    alpha_f: f64,
    beta: f64,
    gamma: f64,
    /// 1 if accelerations are kept from step to step, else 0.
    memory: f64,
}

/// Kind of problem that is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepProblem {
    /// The acceleration at the start of a motion.
    Start,
    /// A time step, with Newton's method started from the predicted motion.
    Step,
    /// Equilibrium: inertia only keeps Newton's matrix from being singular.
    Rest,
}

/// Coefficients of the method for one step size per lane: velocity `cv u + vc` and acceleration `c1
/// (u - du)` at the end of the step.
#[derive(Clone, Copy)]
pub(super) struct Stage<S: Simd> {
    pub(super) c1: Lane<S>,
    pub(super) cv: Lane<S>,
    pub(super) dt: Lane<S>,
    pub(super) problem: StepProblem,
}

/// Velocity, the method's own acceleration-like variable, and the true acceleration of a
/// coordinate.
#[derive(Clone, Copy)]
pub(super) struct Rates<S: Simd> {
    pub(super) v: V3<S>,
    pub(super) a: V3<S>,
    pub(super) acceleration: V3<S>,
}

impl Scheme {
    pub(super) fn new(rho_inf: f64) -> Self {
        let alpha_m = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0);
        let alpha_f = rho_inf / (rho_inf + 1.0);
        let base = 1.0 - alpha_m + alpha_f;
        Self { alpha_m, alpha_f, beta: 0.25 * base * base, gamma: base - 0.5, memory: 1.0 }
    }

    pub(super) fn backward_euler() -> Self {
        Self { alpha_m: 0.0, alpha_f: 0.0, beta: 1.0, gamma: 1.0, memory: 0.0 }
    }

    pub(super) fn has_memory(self) -> bool {
        self.memory > 0.0
    }

    #[inline(always)]
    pub(super) fn stage<S: Simd>(self, dt: Lane<S>, problem: StepProblem) -> Stage<S> {
        let rate = dt.recip();
        if problem == StepProblem::Start {
            // Its acceleration is that at its start: `u = dt v + dt^2 a / 2`.
            let two = dt.lift(2.0);
            return Stage { c1: rate * rate * two, cv: rate * two, dt, problem };
        }
        let c1 = (1.0 - self.alpha_m) / (self.beta * (1.0 - self.alpha_f));
        Stage {
            c1: rate * rate * dt.lift(c1),
            cv: rate * dt.lift(self.gamma / self.beta),
            dt,
            problem,
        }
    }

    /// Predicted displacement `du` and velocity offset `vc` of a step that starts with the rates
    /// `h`.
    #[inline(always)]
    pub(super) fn predict<S: Simd>(self, s: &Stage<S>, h: Rates<S>) -> (V3<S>, V3<S>) {
        let dt2 = s.dt * s.dt;
        let base = h.a.mul_add(dt2 * dt2.lift(0.5 - self.beta), h.v.scale(s.dt));
        let memory = self.beta / (1.0 - self.alpha_m);
        let du = h.acceleration.mul_add(
            dt2 * dt2.lift(memory * self.alpha_f),
            h.a.mul_add(dt2 * dt2.lift(-memory * self.alpha_m), base),
        );
        let vc = base.mul_add(-s.cv, h.a.mul_add(s.dt * dt2.lift(1.0 - self.gamma), h.v));
        (du, vc)
    }

    /// Rates at the end of a step that starts with the rates `h` and ends with velocity `v` and the
    /// true acceleration `acceleration`.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(
        self,
        s: &Stage<S>,
        h: Rates<S>,
        v: V3<S>,
        acceleration: V3<S>,
    ) -> Rates<S> {
        let scale = 1.0 / (1.0 - self.alpha_m);
        let dt = s.dt;
        let old = h
            .acceleration
            .mul_add(dt.lift(self.alpha_f * scale), h.a.scale(dt.lift(-self.alpha_m * scale)));
        let a = acceleration.mul_add(dt.lift((1.0 - self.alpha_f) * scale), old);
        let kept = |x: V3<S>| x.scale(dt.lift(self.memory));
        Rates { v, a: kept(a), acceleration: kept(acceleration) }
    }
}
