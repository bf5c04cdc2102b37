use crate::RodError;

/// The three weights of the first-order generalised-alpha method, thesis (3.141), (3.142):
/// for `dy/dt = f(y)`, with `y' = dy/dt` carried along,
///
/// ```text
/// (1 - alpha) y'_1 + alpha y'_0 = f((1 - beta) y_1 + beta y_0)
/// y_1 = y_0 + dt (gamma y'_1 + (1 - gamma) y'_0)
/// ```
///
/// Second order in time if and only if `alpha - beta + gamma = 1/2` (3.147).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    alpha: f64,
    beta: f64,
    gamma: f64,
}

impl Coefficients {
    /// The thesis's weights for all but one of its examples: alpha 0.3, beta 0, gamma 0.7.
    ///
    /// **First order.** Because `alpha + gamma = 1` and `beta = 0` the old derivative drops out:
    /// this is the implicit Euler method, which damps slow motion as well as fast.
    pub const THESIS: Self = Self { alpha: 0.3, beta: 0.0, gamma: 0.7 };

    /// The thesis's weights for its helix under an end load: alpha 0.4, beta 0, gamma 1.
    /// **First order**, and more strongly damped than [`Coefficients::THESIS`].
    pub const THESIS_DAMPED: Self = Self { alpha: 0.4, beta: 0.0, gamma: 1.0 };

    /// The second-order member (3.148) with spectral radius `rho_infinity` at infinite frequency:
    /// 1 conserves (midpoint rule), 0 removes the highest frequencies in one step (BDF2).
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless `0 <= rho_infinity <= 1`.
    pub fn second_order(rho_infinity: f64) -> Result<Self, RodError> {
        if !(0.0..=1.0).contains(&rho_infinity) {
            return Err(RodError::Invalid {
                what: "rho_infinity",
                why: "must lie between 0 (strongest damping) and 1 (none)",
            });
        }
        let lambda = -rho_infinity;
        Ok(Self {
            alpha: (3.0 * lambda + 1.0) / (2.0 * lambda - 2.0),
            beta: lambda / (lambda - 1.0),
            gamma: 1.0 / (1.0 - lambda),
        })
    }

    /// Any stable weights.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless `alpha <= 1/2`, `0 <= beta <= 1/2`, `1/2 <= gamma` and
    /// `gamma >= 1/2 - alpha + beta`: (3.146) and the condition for oscillations it lacks.
    pub fn new(alpha: f64, beta: f64, gamma: f64) -> Result<Self, RodError> {
        let stable = alpha.is_finite()
            && gamma.is_finite()
            && alpha <= 0.5
            && (0.0..=0.5).contains(&beta)
            && gamma >= 0.5
            && gamma >= 0.5 - alpha + beta - 1e-14;
        if stable {
            Ok(Self { alpha, beta, gamma })
        } else {
            Err(RodError::Invalid {
                what: "generalised-alpha weights",
                why: "unstable; need alpha <= 1/2, 0 <= beta <= 1/2, \
                      gamma >= max(1/2, 1/2 - alpha + beta)",
            })
        }
    }

    /// The midpoint rule, all weights 1/2. Needs no derivative to start from.
    pub(super) const MIDPOINT: Self = Self { alpha: 0.5, beta: 0.5, gamma: 0.5 };

    /// Weight alpha of the old derivative in the stage derivative.
    #[must_use]
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Weight beta of the old value in the stage value.
    #[must_use]
    pub fn beta(&self) -> f64 {
        self.beta
    }

    /// Weight gamma of the new derivative in the update.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Time of the stage, as a fraction of the step.
    pub(super) fn stage(&self) -> f64 {
        1.0 - self.beta
    }

    /// `c` in `y'_stage = c (y_stage - y_0) + d y'_0`, for a step `dt`.
    pub(super) fn rate(&self, dt: f64) -> f64 {
        (1.0 - self.alpha) / (self.gamma * dt * (1.0 - self.beta))
    }

    /// `d` in `y'_stage = c (y_stage - y_0) + d y'_0`.
    pub(super) fn memory(&self) -> f64 {
        let d = (self.alpha + self.gamma - 1.0) / self.gamma;
        // The midpoint rule and the thesis's weights have none; rounding must not invent one.
        if d.abs() < 1e-15 { 0.0 } else { d }
    }

    /// The new derivative from the slope `(y_1 - y_0) / dt` and the old derivative, (3.154).
    pub(super) fn derivative(&self, slope: f64, old: f64) -> f64 {
        (slope - (1.0 - self.gamma) * old) / self.gamma
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Spectral radius of one step of `dy/dt = -w y` as the integrator computes it, from the
    /// stage form, against which (3.144) is the independent statement.
    fn spectral_radius(k: &Coefficients, omega_dt: f64) -> f64 {
        let step = |y: f64, slope: f64| {
            let (c, d) = (k.rate(1.0), k.memory());
            let stage = (c * y - d * slope) / (c + omega_dt);
            let new = (stage - k.beta * y) / (1.0 - k.beta);
            (new, k.derivative(new - y, slope))
        };
        let ((a, b), (p, q)) = (step(1.0, 0.0), step(0.0, 1.0));
        let (trace, det) = (a + q, a * q - p * b);
        let discriminant = 0.25 * trace * trace - det;
        if discriminant < 0.0 { det.sqrt() } else { (0.5 * trace).abs() + discriminant.sqrt() }
    }

    #[test]
    fn damping_at_infinity_is_the_one_asked_for() {
        for rho in [0.0, 0.3, 0.5, 0.8, 1.0] {
            let k = Coefficients::second_order(rho).expect("rho in range");
            assert_relative_eq!(k.alpha - k.beta + k.gamma, 0.5, epsilon = 1e-15);
            // A double eigenvalue splits by the root of 1 / omega dt.
            assert_relative_eq!(spectral_radius(&k, 1e15), rho, epsilon = 1e-6);
        }
        // (gamma - 1) / gamma: of the derivative, which this method carries but does not use.
        let thesis = spectral_radius(&Coefficients::THESIS, 1e15);
        assert_relative_eq!(thesis, 3.0 / 7.0, epsilon = 1e-6);
        let damped = spectral_radius(&Coefficients::THESIS_DAMPED, 1e15);
        assert_relative_eq!(damped, 0.0, epsilon = 1e-6);
    }

    #[test]
    fn stage_form_is_the_amplification_matrix_of_the_thesis() {
        // Trace and determinant of (3.144).
        for k in [
            Coefficients::second_order(0.8).expect("in range"),
            Coefficients::second_order(0.0).expect("in range"),
            Coefficients::THESIS_DAMPED,
        ] {
            for w in [1e-3, 0.1, 1.0, 30.0] {
                let Coefficients { alpha: a, beta: b, gamma: g } = k;
                let d = (1.0 - a) + g * (1.0 - b) * w;
                let m =
                    [[(1.0 - a) - g * b * w, 1.0 - g - a], [-w, -a - (1.0 - g) * (1.0 - b) * w]];
                let (trace, det) =
                    ((m[0][0] + m[1][1]) / d, (m[0][0] * m[1][1] - m[0][1] * m[1][0]) / (d * d));
                let q = 0.25 * trace * trace - det;
                let radius = if q < 0.0 { det.sqrt() } else { (0.5 * trace).abs() + q.sqrt() };
                assert_relative_eq!(spectral_radius(&k, w), radius, max_relative = 1e-12);
            }
        }
    }

    #[test]
    fn thesis_weights_are_implicit_euler() {
        assert_eq!(Coefficients::THESIS.memory(), 0.0);
        assert_relative_eq!(Coefficients::THESIS.rate(0.1), 10.0, max_relative = 1e-15);
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(Coefficients::second_order(1.1).is_err(), "growing");
        assert!(Coefficients::second_order(f64::NAN).is_err(), "NaN");
        assert!(Coefficients::new(0.3, 0.0, 0.1).is_err(), "unstable");
        assert!(Coefficients::new(0.3, 0.0, 0.7).is_ok(), "the thesis's own");
    }
}
