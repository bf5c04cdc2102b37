//! What the integration tests share: references, rotations, random numbers.
pub(crate) mod reference;

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// The rotation with the given rows.
pub(crate) fn rotation(rows: &[[f64; 3]; 3]) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| rows[i][j]))
}

/// Numbers that look random and are the same on every machine.
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// In `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// A direction, all of them alike.
    pub(crate) fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0);
            if (0.01..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }
}
