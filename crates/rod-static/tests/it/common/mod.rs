//! What the integration tests share: the oracle files.
pub(crate) mod reference;

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use serde::Deserialize;
use std::path::PathBuf;

/// The cases of `name` in the folder `RAPUNZEL_ORACLES`, or of the copy in `tests/data`.
pub(crate) fn cases<Case: for<'a> Deserialize<'a>>(name: &str) -> Vec<Case> {
    #[derive(Deserialize)]
    struct Oracle<Case> {
        cases: Vec<Case>,
    }
    let folder = std::env::var_os("RAPUNZEL_ORACLES").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data"),
        PathBuf::from,
    );
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let oracle: Oracle<Case> =
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(!oracle.cases.is_empty(), "{} has no cases", path.display());
    oracle.cases
}

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
