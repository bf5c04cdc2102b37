//! The potential and the field of point charges, and ways to sum them.

use crate::direct_sum::{Cloud, direct_sums, places};
use crate::error::{check_charges, check_positions};
use crate::{COULOMB_CONSTANT, ElectrostaticsError};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Potentials and fields at some points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fields {
    /// Potentials, V.
    pub potentials: Vec<f64>,
    /// Electric fields (world), V/m; a charge q there feels the force q E.
    pub fields: Vec<Vector3<f64>>,
}

impl Fields {
    /// Fields at `count` targets from their `sums` of `q/r` and its gradient, in units of the
    /// charge `unit` (C).
    pub(crate) fn new(unit: f64, count: usize, sums: impl Fn(usize) -> [f64; 4] + Sync) -> Self {
        let factor = COULOMB_CONSTANT * unit;
        let field = |i| {
            let [potential, x, y, z] = sums(i);
            (factor * potential, -factor * Vector3::new(x, y, z))
        };
        let (potentials, fields) = (0..count).into_par_iter().map(field).unzip();
        Self { potentials, fields }
    }
}

/// Method to sum the Coulomb fields of point charges.
///
/// Implementations: [`Direct`], [`BarnesHut`](crate::BarnesHut), [`Multipole`](crate::Multipole). A
/// target that coincides with a charge does not feel it, so the charges may be targets too.
pub trait Method {
    /// Potentials and fields at `targets` (world, m) of `charges` (C) at `sources` (world, m); the
    /// same for any number of threads. No charges make no field.
    ///
    /// # Errors
    /// Positions or charges that are not finite, arrays of different lengths, and a
    /// tolerance out of reach.
    fn fields(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        targets: &[Point3<f64>],
    ) -> Result<Fields, ElectrostaticsError>;
}

/// Direct sum over all pairs, the reference for every other method.
///
/// Exact to a relative 2e-12 of the sum of magnitudes, three times the 6e-13 by which inverse roots
/// may err. Cost: 0.4 ns a pair with AVX-512.
#[derive(Debug, Clone, Copy, Default)]
pub struct Direct;

impl Method for Direct {
    fn fields(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        targets: &[Point3<f64>],
    ) -> Result<Fields, ElectrostaticsError> {
        check_positions("source", sources)?;
        check_positions("target", targets)?;
        check_charges(charges, sources.len())?;
        let cloud = Cloud::new(places(sources.par_iter().copied()), charges.to_vec());
        let sums = direct_sums(&cloud, 0.0, &places(targets.par_iter().copied()));
        Ok(Fields::new(1.0, sums.len(), |i| sums[i]))
    }
}
