use super::{MaxwellElement, Relaxation};
use crate::KeratinError;
use crate::error::{not_negative, positive};
use nalgebra::{Matrix3, Vector3};
use rapunzel_fiber::{SectionLaw, SectionResponse};

/// Fraction of a Maxwell element's stress that remains after `x` relaxation times, and its mean
/// over them, which is also the fraction of a strain that grew linearly meanwhile.
fn decay(x: f64) -> (f64, f64) {
    let left = (-x).exp();
    // Below the limit, the next term of the series is below the last digit; above it, three are
    // lost.
    let mean =
        if x < 1e-3 { 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) } else { (1.0 - left) / x };
    (left, mean)
}

/// Energy that a Maxwell element of modulus 1 dissipates in `x` relaxation times, `int q^2 dx`, by
/// `q = q0 exp(-y) + r (1 - exp(-y)) / x` after `y` of them: the factors of `q0^2`, `2 q0 r` and
/// `r^2`.
fn fading(x: f64) -> [f64; 3] {
    let (left, mean) = decay(x);
    let squares = 0.5 * x * mean * (1.0 + left);
    let products = 0.5 * x * mean * mean;
    // Above the limit, four digits are lost in the difference; below it, so many terms are exact.
    let rises = if x < 0.03 {
        let tail = 1.0 / 24.0 - x * (31.0 / 2520.0 - x / 320.0);
        x * (1.0 / 3.0 - x * (0.25 - x * (7.0 / 60.0 - x * tail)))
    } else {
        (1.0 - 2.0 * mean + squares / x) / x
    };
    [squares, products, rises]
}

/// Stress and work of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelaxationStep {
    /// Stress at the end of the step.
    pub stress: f64,
    /// Work done in the step per volume: the integral of stress by strain.
    pub work: f64,
}

/// A generalized Maxwell model in one dimension: its strain and the stresses of its elements.
///
/// Steps in which the strain changes linearly are exact for any step size. The model is passive.
#[derive(Debug, Clone, PartialEq)]
pub struct MaxwellModel {
    equilibrium: f64,
    branches: Vec<MaxwellElement>,
    strain: f64,
    stresses: Vec<f64>,
}

impl MaxwellModel {
    /// An unstrained model of a relaxation function.
    #[must_use]
    pub fn new(law: &Relaxation) -> Self {
        Self::of(law.equilibrium(), law.branches().to_vec())
    }

    /// An unstrained model of these elements, in this order.
    pub(super) fn of(equilibrium: f64, branches: Vec<MaxwellElement>) -> Self {
        let stresses = vec![0.0; branches.len()];
        Self { equilibrium, branches, strain: 0.0, stresses }
    }

    /// Sets other relaxation times; strains and stresses are unchanged.
    pub(super) fn set_times(&mut self, times: impl IntoIterator<Item = f64>) {
        for (branch, time) in self.branches.iter_mut().zip(times) {
            branch.time = time;
        }
    }

    /// Present strain.
    #[must_use]
    pub fn strain(&self) -> f64 {
        self.strain
    }

    /// Present stress.
    #[must_use]
    pub fn stress(&self) -> f64 {
        self.equilibrium * self.strain + self.stresses.iter().sum::<f64>()
    }

    /// Energy per volume that the springs store.
    #[must_use]
    pub fn stored_energy(&self) -> f64 {
        let springs = self.stresses.iter().zip(&self.branches);
        let of_branches: f64 = springs.map(|(q, b)| q * q / b.modulus).sum();
        0.5 * (self.equilibrium * self.strain * self.strain + of_branches)
    }

    /// Moves linearly to `strain`, which is finite, within `dt` seconds (0: at once).
    pub fn strain_to(&mut self, strain: f64, dt: f64) -> RelaxationStep {
        let rise = strain - self.strain;
        let mut work = self.equilibrium * (self.strain + 0.5 * rise) * rise;
        for (q, b) in self.stresses.iter_mut().zip(&self.branches) {
            let x = dt / b.time;
            let (left, mean) = decay(x);
            // q' = G e' - q / tau: the mean of q, times the rise, is the work.
            let lag = if x < 1e-3 { 0.5 - x * (1.0 / 6.0 - x / 24.0) } else { (1.0 - mean) / x };
            work += (*q * mean + b.modulus * rise * lag) * rise;
            *q = *q * left + b.modulus * rise * mean;
        }
        self.strain = strain;
        RelaxationStep { stress: self.stress(), work }
    }

    /// Moves linearly within `dt` seconds to the strain at which the model has the given stress.
    /// The stress during the step is different: for a constant stress, take short steps.
    pub fn stress_to(&mut self, stress: f64, dt: f64) -> RelaxationStep {
        let (mut stiffness, mut rest) = (self.equilibrium, self.equilibrium * self.strain);
        for (q, b) in self.stresses.iter().zip(&self.branches) {
            let (left, mean) = decay(dt / b.time);
            rest += q * left;
            stiffness += b.modulus * mean;
        }
        self.strain_to(self.strain + (stress - rest) / stiffness, dt)
    }
}

/// The law of a viscoelastic section: `K` times a relaxation function in fractions of `K`, and
/// Kelvin-Voigt damping in parallel, `m = K (G * dE + tau dE/dt)`.
///
/// The law is passive. A step costs one exponential per Maxwell element.
#[derive(Debug, Clone, PartialEq)]
pub struct Viscoelastic {
    stiffness: Vector3<f64>,
    equilibrium: f64,
    branches: Vec<MaxwellElement>,
    damping_time: f64,
}

impl Viscoelastic {
    /// A section of stiffness `K` (N m^2, as in [`rapunzel_fiber::NodeProperties`]) with the
    /// relaxation function `relaxation` in fractions of `K` and the retardation time
    /// `damping_time`, s (0: none).
    ///
    /// # Errors
    /// Refuses stiffnesses that are not positive and a negative time.
    pub fn new(
        stiffness: Vector3<f64>,
        relaxation: &Relaxation,
        damping_time: f64,
    ) -> Result<Self, KeratinError> {
        for k in stiffness.iter() {
            positive("stiffness (N m^2)", *k)?;
        }
        not_negative("damping time (s)", damping_time)?;
        let (equilibrium, branches) = (relaxation.equilibrium(), relaxation.branches().to_vec());
        Ok(Self { stiffness, equilibrium, branches, damping_time })
    }

    /// A section of these elements alone, with moduli in fractions of `K`, in this order.
    pub(super) fn of(stiffness: Vector3<f64>, branches: Vec<MaxwellElement>) -> Self {
        Self { stiffness, equilibrium: 0.0, branches, damping_time: 0.0 }
    }

    /// A Kelvin-Voigt section: `m = K (E + tau dE/dt)`.
    ///
    /// # Errors
    /// As [`Viscoelastic::new`].
    pub fn kelvin_voigt(stiffness: Vector3<f64>, tau: f64) -> Result<Self, KeratinError> {
        Self::new(stiffness, &Relaxation::new(1.0, Vec::new())?, tau)
    }
}

impl SectionLaw for Viscoelastic {
    /// Two parts: the strain at the last commit, and the stress of each element in fractions of
    /// `K`.
    fn memory(&self) -> usize {
        1 + self.branches.len()
    }

    fn is_affine(&self) -> bool {
        true
    }

    fn response(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>, dt: f64) -> SectionResponse {
        let mut out = [SectionResponse::default()];
        self.responses(memory, std::slice::from_ref(strain), dt, &mut out);
        out[0]
    }

    fn commit(&self, memory: &mut [Vector3<f64>], strain: &Vector3<f64>, dt: f64) {
        self.commits(memory, std::slice::from_ref(strain), dt);
    }

    fn dissipated(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>, dt: f64) -> f64 {
        let square = |v: &Vector3<f64>| self.stiffness.component_mul(v).dot(v);
        let rise = strain - memory[0];
        let viscosity = if dt > 0.0 { self.damping_time / dt } else { 0.0 };
        let mut sum = viscosity * square(&rise);
        for (q, b) in memory[1..].iter().zip(&self.branches) {
            let rise = b.modulus * rise;
            let [squares, products, rises] = fading(dt / b.time);
            let both = 2.0 * products * self.stiffness.component_mul(q).dot(&rise);
            sum += (squares * square(q) + both + rises * square(&rise)) / b.modulus;
        }
        sum
    }

    fn responses(
        &self,
        memory: &[Vector3<f64>],
        strains: &[Vector3<f64>],
        dt: f64,
        out: &mut [SectionResponse],
    ) {
        let memories = || memory.chunks_exact(self.memory()).zip(strains);
        let damping = if self.damping_time > 0.0 { self.damping_time / dt } else { 0.0 };
        let mut tangent = self.equilibrium + damping;
        for ((memory, strain), out) in memories().zip(&mut *out) {
            out.moment = self.equilibrium * strain + damping * (strain - memory[0]);
        }
        for (k, b) in self.branches.iter().enumerate() {
            let (left, mean) = decay(dt / b.time);
            let slope = b.modulus * mean;
            tangent += slope;
            for ((memory, strain), out) in memories().zip(&mut *out) {
                out.moment += left * memory[1 + k] + slope * (strain - memory[0]);
            }
        }
        let slope = tangent * self.stiffness;
        for ((memory, strain), out) in memories().zip(&mut *out) {
            let moment = self.stiffness.component_mul(&out.moment);
            let rise = strain - memory[0];
            // The energy of a rise from the last strain.
            let potential = (moment - 0.5 * slope.component_mul(&rise)).dot(&rise);
            *out = SectionResponse { moment, tangent: Matrix3::from_diagonal(&slope), potential };
        }
    }

    fn commits(&self, memory: &mut [Vector3<f64>], strains: &[Vector3<f64>], dt: f64) {
        let count = self.memory();
        for (k, b) in self.branches.iter().enumerate() {
            let (left, mean) = decay(dt / b.time);
            let slope = b.modulus * mean;
            for (memory, strain) in memory.chunks_exact_mut(count).zip(strains) {
                let q = left * memory[1 + k] + slope * (strain - memory[0]);
                // What fades for ever would end in denormal numbers, which are slow.
                let gone = q.amax() < f64::MIN_POSITIVE;
                memory[1 + k] = if gone { Vector3::zeros() } else { q };
            }
        }
        for (memory, strain) in memory.chunks_exact_mut(count).zip(strains) {
            memory[0] = *strain;
        }
    }

    fn stored_energy(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>) -> f64 {
        let square = |v: &Vector3<f64>| self.stiffness.component_mul(v).dot(v);
        let springs = memory[1..].iter().zip(&self.branches);
        let of_branches: f64 = springs.map(|(q, b)| square(q) / b.modulus).sum();
        0.5 * (self.equilibrium * square(strain) + of_branches)
    }
}
