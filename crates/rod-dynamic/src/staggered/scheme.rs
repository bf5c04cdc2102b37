//! The generalised-alpha method of Chung and Hulbert for coordinates with a constant mass.
//!
//! Positions of nodes and directors of segments are such coordinates: the rod is a system of
//! constant mass under holonomic constraints (a differential-algebraic one of index 3), and the
//! method converges with second order for it (Arnold and Bruls 2007). Measured on the whip of a
//! free hair it stays stable up to `rho_inf` of 0.4, where the same method on rotation increments
//! gains energy; see the crate's tests.
//!
//! With `u` the displacement over the step, the end of the step has the velocity `cv u + vc` and
//! the acceleration `c1 (u - du)`. Backward Euler is the same without a use for accelerations: its
//! velocity is the mean one over the step, which contact laws refer to. Each lane has a method of
//! its own.

use pulp::Simd;
use rapunzel_lanes::{LANES, Lane, V3};

/// Coefficients of a method for steps of one second; `a` is the method's own variable beside the
/// true acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scheme {
    /// Acceleration by displacement.
    c1: f64,
    /// Velocity by displacement.
    cv: f64,
    /// Displacement by `a`.
    drift: f64,
    /// Predicted displacement by the true acceleration, and by `a`, beside the drift.
    ahead: [f64; 2],
    /// Velocity by `a`.
    gain: f64,
    /// The next `a` by the true accelerations after and before the step, and by `a`.
    next: [f64; 3],
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

/// Coefficients of the methods for one step size per lane: velocity `cv u + vc` and acceleration
/// `c1 (u - du)` at the end of the step.
#[derive(Clone, Copy)]
pub(super) struct Stage<S: Simd> {
    pub(super) c1: Lane<S>,
    pub(super) cv: Lane<S>,
    pub(super) dt: Lane<S>,
    pub(super) problem: StepProblem,
    /// 1 where products of velocities are taken at the end of a step, 0 where the first is that at
    /// its start.
    pub(super) late: Lane<S>,
    /// Whether the method of any lane depends on the accelerations at the start of a step.
    pub(super) remembers: bool,
    drift: Lane<S>,
    ahead: [Lane<S>; 2],
    gain: Lane<S>,
    next: [Lane<S>; 3],
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
    /// The generalised-alpha method with a spectral radius at infinite frequency.
    pub(super) fn generalised_alpha(rho_inf: f64) -> Self {
        let alpha_m = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0);
        let alpha_f = rho_inf / (rho_inf + 1.0);
        let base = 1.0 - alpha_m + alpha_f;
        let (beta, gamma) = (0.25 * base * base, base - 0.5);
        let (memory, scale) = (beta / (1.0 - alpha_m), 1.0 / (1.0 - alpha_m));
        Self {
            c1: (1.0 - alpha_m) / (beta * (1.0 - alpha_f)),
            cv: gamma / beta,
            drift: 0.5 - beta,
            ahead: [memory * alpha_f, -memory * alpha_m],
            gain: 1.0 - gamma,
            next: [(1.0 - alpha_f) * scale, alpha_f * scale, -alpha_m * scale],
        }
    }

    /// Backward Euler. Both accelerations that it leaves are the true one, as for a method of
    /// second order that goes on from there.
    pub(super) fn backward_euler() -> Self {
        let (ahead, next) = ([0.0; 2], [1.0, 0.0, 0.0]);
        Self { c1: 1.0, cv: 1.0, drift: 0.0, ahead, gain: 0.0, next }
    }

    /// Whether steps depend on the accelerations at their start.
    pub(super) fn remembers(&self) -> bool {
        *self != Self::backward_euler()
    }

    /// Coefficients for the methods of all lanes.
    #[inline(always)]
    pub(super) fn stage<S: Simd>(
        schemes: &[Self; LANES],
        dt: Lane<S>,
        problem: StepProblem,
    ) -> Stage<S> {
        let rate = dt.recip();
        let of = |number: fn(&Self) -> f64| {
            let mut all = [0.0; LANES];
            for (number_of, scheme) in all.iter_mut().zip(schemes) {
                *number_of = number(scheme);
            }
            Lane::load(dt.simd(), &all, 0)
        };
        let dt2 = dt * dt;
        let (mut c1, mut cv) = (rate * rate * of(|s| s.c1), rate * of(|s| s.cv));
        if problem == StepProblem::Start {
            // Its acceleration is that at its start: `u = dt v + dt^2 a / 2`.
            let two = dt.lift(2.0);
            (c1, cv) = (rate * rate * two, rate * two);
        }
        Stage {
            c1,
            cv,
            dt,
            problem,
            late: of(|s| f64::from(s.remembers())),
            remembers: schemes.iter().any(Self::remembers),
            drift: dt2 * of(|s| s.drift),
            ahead: [dt2 * of(|s| s.ahead[0]), dt2 * of(|s| s.ahead[1])],
            gain: dt * of(|s| s.gain),
            next: [of(|s| s.next[0]), of(|s| s.next[1]), of(|s| s.next[2])],
        }
    }
}

impl<S: Simd> Stage<S> {
    /// Predicted displacement `du` and velocity offset `vc` of a step that starts with the rates
    /// `h`.
    #[inline(always)]
    pub(super) fn predict(&self, h: Rates<S>) -> (V3<S>, V3<S>) {
        let base = h.a.mul_add(self.drift, h.v.scale(self.dt));
        let du = h.acceleration.mul_add(self.ahead[0], h.a.mul_add(self.ahead[1], base));
        let vc = base.mul_add(-self.cv, h.a.mul_add(self.gain, h.v));
        (du, vc)
    }

    /// Rates at the end of a step that starts with the rates `h` and ends with velocity `v` and the
    /// true acceleration `acceleration`.
    #[inline(always)]
    pub(super) fn finish(&self, h: Rates<S>, v: V3<S>, acceleration: V3<S>) -> Rates<S> {
        let old = h.acceleration.mul_add(self.next[1], h.a.scale(self.next[2]));
        Rates { v, a: acceleration.mul_add(self.next[0], old), acceleration }
    }
}
