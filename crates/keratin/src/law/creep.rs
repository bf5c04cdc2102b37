use super::{MaxwellElement, Relaxation};

/// The creep compliance `J(t)` that belongs to a [`Relaxation`]:
/// `J(t) = J_g + t / eta + sum_j J_j (1 - exp(-t / lambda_j))`, with flow only where the model is a
/// fluid.
///
/// It is exact: in Laplace space `s^2 J(s) G(s) = 1`, so that the retardation times are the zeros
/// of `s G(s)`, one between any two relaxation times. Both functions fulfill (2.6) read as a
/// Stieltjes integral that sees the jump of G at 0, `J(t) G(0) + int_0^t J(t - tau) G'(tau) dtau =
/// 1`; without the jump, as printed, the integral is no constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Creep {
    glassy: f64,
    fluidity: f64,
    /// Compliance and retardation time of each Kelvin element.
    elements: Vec<[f64; 2]>,
}

impl From<&Relaxation> for Creep {
    /// The exact creep compliance of a relaxation function. Cost: some hundred evaluations per
    /// Maxwell element.
    fn from(relaxation: &Relaxation) -> Self {
        let branches = relaxation.branches();
        let equilibrium = relaxation.equilibrium();
        // s G(s) at s = -x, over the rates x; poles at 1 / tau.
        let carson = |x: f64| {
            let part = |b: &MaxwellElement| b.modulus * x / (x - 1.0 / b.time);
            branches.iter().fold(equilibrium, |g, b| g + part(b))
        };
        let slope = |x: f64| {
            let part = |b: &MaxwellElement| b.modulus / b.time / (x - 1.0 / b.time).powi(2);
            branches.iter().map(part).sum::<f64>()
        };
        let mut elements = Vec::new();
        for (i, branch) in branches.iter().enumerate() {
            // Between this pole and the next slower one, or zero, where a solid has its last one.
            let slower = branches.get(i + 1).map_or(0.0, |b| 1.0 / b.time);
            if slower == 0.0 && equilibrium == 0.0 {
                continue;
            }
            let (mut low, mut high) = (slower, 1.0 / branch.time);
            loop {
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    break;
                }
                // From plus infinity after the slower pole (from G_inf at zero) to minus infinity.
                if carson(middle) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let rate = 0.5 * (low + high);
            elements.push([1.0 / (rate * slope(rate)), 1.0 / rate]);
        }
        let viscosity: f64 = branches.iter().map(|b| b.modulus * b.time).sum();
        let fluidity = if equilibrium == 0.0 { 1.0 / viscosity } else { 0.0 };
        Self { glassy: 1.0 / relaxation.glassy(), fluidity, elements }
    }
}

impl Creep {
    /// Creep compliance `J(t)`; 0 before the stress, `t < 0`.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        let start = self.glassy + t * self.fluidity;
        self.elements
            .iter()
            .fold(start, |j, [compliance, time]| j - compliance * (-t / time).exp_m1())
    }

    /// Boltzmann's superposition (2.1): the strain at `t` after stress increments at given times,
    /// `(time, increment)`.
    #[must_use]
    pub fn strain(&self, steps: &[(f64, f64)], t: f64) -> f64 {
        steps.iter().map(|(time, stress)| stress * self.at(t - time)).sum()
    }

    /// Real part and, less its sign, imaginary part of the complex compliance at an angular
    /// frequency, rad/s: `J* = J1 - i J2 = 1 / G*`.
    #[must_use]
    pub fn dynamic(&self, frequency: f64) -> [f64; 2] {
        let flow = [self.glassy, self.fluidity / frequency];
        self.elements.iter().fold(flow, |[storage, loss], [compliance, time]| {
            let x = frequency * time;
            let part = compliance / (1.0 + x * x);
            [storage + part, loss + part * x]
        })
    }
}
