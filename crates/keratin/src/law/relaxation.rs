use crate::KeratinError;
use crate::error::{not_negative, positive};

/// A Maxwell element: a spring and a dashpot in series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxwellElement {
    /// Modulus of the spring, in the unit of the law.
    pub modulus: f64,
    /// Relaxation time, viscosity over modulus, s.
    pub time: f64,
}

/// The relaxation function `G(t)` of a generalized Maxwell model: a spring beside Maxwell elements,
/// `G(t) = G_inf + sum_i G_i exp(-t / tau_i)`.
///
/// Moduli are in any unit: Pa for stresses, 1 for fractions of a stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct Relaxation {
    equilibrium: f64,
    branches: Vec<MaxwellElement>,
}

impl Relaxation {
    /// A spring of modulus `equilibrium` beside Maxwell elements, in any order; without a spring, a
    /// fluid.
    ///
    /// # Errors
    /// Refuses a negative `equilibrium`, moduli and times that are not positive, and a model
    /// without spring and elements.
    pub fn new(equilibrium: f64, mut branches: Vec<MaxwellElement>) -> Result<Self, KeratinError> {
        not_negative("equilibrium modulus", equilibrium)?;
        for branch in &branches {
            positive("modulus of a Maxwell element", branch.modulus)?;
            positive("relaxation time (s)", branch.time)?;
        }
        let glassy = equilibrium + branches.iter().map(|b| b.modulus).sum::<f64>();
        positive("modulus of the whole", glassy)?;
        branches.sort_by(|a, b| a.time.total_cmp(&b.time));
        // Equal times are one element.
        branches.dedup_by(|next, kept| {
            let same = next.time == kept.time;
            if same {
                kept.modulus += next.modulus;
            }
            same
        });
        Ok(Self { equilibrium, branches })
    }

    /// A relaxation function with a given modulus at `t_ref` seconds and a given loss per decade of
    /// time, constant between two times as Chapman found for wool between 0.1 and 1000 minutes
    /// (thesis, lines 558 to 562): a constant distribution of relaxation times, here four in each
    /// decade.
    ///
    /// # Errors
    /// The errors of [`Relaxation::new`]; also a loss that would make the modulus negative.
    pub fn logarithmic(
        modulus: f64,
        t_ref: f64,
        per_decade: f64,
        times: [f64; 2],
    ) -> Result<Self, KeratinError> {
        const IN_A_DECADE: f64 = 4.0;
        positive("loss per decade", per_decade)?;
        not_negative("time of the modulus (s)", t_ref)?;
        let [first, last] =
            [positive("first time (s)", times[0])?, positive("last time (s)", times[1])?];
        let mut branches = Vec::new();
        let mut time = first;
        while time <= last * (1.0 + 1e-9) {
            branches.push(MaxwellElement { modulus: per_decade / IN_A_DECADE, time });
            time *= 10_f64.powf(1.0 / IN_A_DECADE);
        }
        let transient: f64 = branches.iter().map(|b| b.modulus * (-t_ref / b.time).exp()).sum();
        Self::new(modulus - transient, branches)
    }

    /// Equilibrium modulus `G_inf`, which remains after infinite time.
    #[must_use]
    pub fn equilibrium(&self) -> f64 {
        self.equilibrium
    }

    /// Glassy modulus `G(0)`, of an instantaneous strain.
    #[must_use]
    pub fn glassy(&self) -> f64 {
        self.equilibrium + self.branches.iter().map(|b| b.modulus).sum::<f64>()
    }

    /// The Maxwell elements by rising relaxation time, no two alike.
    #[must_use]
    pub fn branches(&self) -> &[MaxwellElement] {
        &self.branches
    }

    /// Relaxation function `G(t)`; 0 before the strain, `t < 0`.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        self.branches.iter().fold(self.equilibrium, |g, b| g + b.modulus * (-t / b.time).exp())
    }

    /// Derivative `dG/dt` of the relaxation function for `t >= 0`.
    #[must_use]
    pub fn rate(&self, t: f64) -> f64 {
        self.branches.iter().map(|b| -b.modulus / b.time * (-t / b.time).exp()).sum()
    }

    /// Boltzmann's superposition (2.4): the stress at `t` after strain increments at given times,
    /// `(time, increment)`.
    #[must_use]
    pub fn stress(&self, steps: &[(f64, f64)], t: f64) -> f64 {
        steps.iter().map(|(time, strain)| strain * self.at(t - time)).sum()
    }

    /// Storage and loss modulus at an angular frequency, rad/s: `G* = G1 + i G2`. A cycle of
    /// amplitude `e` loses `pi G2 e^2` (2.9).
    #[must_use]
    pub fn dynamic(&self, frequency: f64) -> [f64; 2] {
        self.branches.iter().fold([self.equilibrium, 0.0], |[storage, loss], b| {
            let x = frequency * b.time;
            let part = b.modulus * x / (1.0 + x * x);
            [storage + part * x, loss + part]
        })
    }
}
