use nalgebra::{Matrix3, Vector3};
use std::fmt::Debug;

/// The constitutive law of a cross section: the moment caused by a history of strains.
///
/// The strain is `kappa - kappa0`, 1/m, the moment is in N m, both in the material frame. The
/// memory of a law is a number of vectors for each section, which the caller stores, zero in the
/// natural state. An implicit scheme evaluates responses at trial strains and commits the strain
/// that it takes.
///
/// A passive law returns no work that was not done on it: the moment at the end of a step times
/// the rise of the strain is at least the rise of the stored energy.
pub trait SectionLaw: Debug + Send + Sync {
    /// Number of vectors in the memory of a section.
    fn memory(&self) -> usize;

    /// Whether the moment is an affine function of the strain at the end of a step: one response
    /// then determines the responses at all strains.
    fn is_affine(&self) -> bool {
        false
    }

    /// Response after `dt > 0` seconds in which the strain went linearly from its value at the last
    /// commit to `strain`.
    ///
    /// # Panics
    /// If `memory` has another length than [`SectionLaw::memory`].
    fn response(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>, dt: f64) -> SectionResponse;

    /// Commits the step of `dt` seconds to `strain`; `dt = 0` is an instantaneous strain.
    ///
    /// # Panics
    /// If `memory` has another length than [`SectionLaw::memory`].
    fn commit(&self, memory: &mut [Vector3<f64>], strain: &Vector3<f64>, dt: f64);

    /// Energy per length that the step to `strain` dissipates, before it is committed, J/m: the
    /// work done in the step, less the rise of the stored energy.
    ///
    /// # Panics
    /// If `memory` has another length than [`SectionLaw::memory`].
    fn dissipated(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>, dt: f64) -> f64;

    /// Energy per length that a section stores at `strain`, J/m, after the step to it.
    ///
    /// # Panics
    /// As [`SectionLaw::response`].
    fn stored_energy(&self, memory: &[Vector3<f64>], strain: &Vector3<f64>) -> f64;

    /// Computes the responses of many sections, whose memories lie one after the other. Gives the
    /// same numbers as [`SectionLaw::response`] for each; a law may share work between sections.
    ///
    /// # Panics
    /// If there is not one memory and one response for each strain.
    fn responses(
        &self,
        memory: &[Vector3<f64>],
        strains: &[Vector3<f64>],
        dt: f64,
        out: &mut [SectionResponse],
    ) {
        let count = self.memory();
        for (i, (strain, out)) in strains.iter().zip(out).enumerate() {
            *out = self.response(&memory[count * i..count * (i + 1)], strain, dt);
        }
    }

    /// Commits the steps of many sections, whose memories lie one after the other.
    ///
    /// # Panics
    /// As [`SectionLaw::responses`].
    fn commits(&self, memory: &mut [Vector3<f64>], strains: &[Vector3<f64>], dt: f64) {
        let count = self.memory();
        for (i, strain) in strains.iter().enumerate() {
            self.commit(&mut memory[count * i..count * (i + 1)], strain, dt);
        }
    }
}

/// Response of a section to a strain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SectionResponse {
    /// Moment, N m, material frame.
    pub moment: Vector3<f64>,
    /// Derivative of the moment by the strain, N m^2, symmetric.
    pub tangent: Matrix3<f64>,
    /// Energy per length, J/m, whose derivative by the strain is the moment, up to a constant that
    /// is the same for all strains of the step.
    pub potential: f64,
}

/// The linearly elastic section: `m = K (kappa - kappa0)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearLaw {
    /// Bending stiffness about d1 and d2 and torsional stiffness, N m^2.
    pub stiffness: Vector3<f64>,
}

impl SectionLaw for LinearLaw {
    fn memory(&self) -> usize {
        0
    }

    fn is_affine(&self) -> bool {
        true
    }

    fn response(&self, _: &[Vector3<f64>], strain: &Vector3<f64>, _: f64) -> SectionResponse {
        SectionResponse {
            moment: self.stiffness.component_mul(strain),
            tangent: Matrix3::from_diagonal(&self.stiffness),
            potential: self.stored_energy(&[], strain),
        }
    }

    fn commit(&self, _: &mut [Vector3<f64>], _: &Vector3<f64>, _: f64) {}

    fn dissipated(&self, _: &[Vector3<f64>], _: &Vector3<f64>, _: f64) -> f64 {
        0.0
    }

    fn stored_energy(&self, _: &[Vector3<f64>], strain: &Vector3<f64>) -> f64 {
        0.5 * self.stiffness.component_mul(strain).dot(strain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moment_is_the_derivative_of_the_energy() {
        let law = LinearLaw { stiffness: Vector3::new(1.0, 2.0, 3.0) };
        let strain = Vector3::new(0.3, -0.2, 0.5);
        let SectionResponse { moment, tangent, potential } = law.response(&[], &strain, 0.1);
        assert_eq!((law.memory(), potential), (0, law.stored_energy(&[], &strain)));
        for i in 0..3 {
            let mut moved = strain;
            moved[i] += 1e-6;
            let slope = (law.stored_energy(&[], &moved) - law.stored_energy(&[], &strain)) / 1e-6;
            // Of a quadratic function, off by half of the second derivative times the step.
            assert!((slope - moment[i]).abs() < 2e-6, "{slope} {}", moment[i]);
            assert_eq!(tangent[(i, i)], law.stiffness[i]);
        }
    }
}
