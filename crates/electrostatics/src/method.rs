//! The potential and the field of point charges, and ways to sum them.

use crate::error::{check_charges, check_positions};
use crate::multipole::near::{Cloud, add_pairs};
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
    /// From the sums of `q/r` at `count` targets and their gradients, in units of the charge `unit`.
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

/// A way to sum the Coulomb fields of point charges.
///
/// Implementations: [`Direct`], [`BarnesHut`](crate::BarnesHut), [`Multipole`](crate::Multipole).
/// A target that coincides with a charge does not feel it, so the charges may be targets too.
pub trait Method {
    /// The potentials and fields at `targets` (world, m) of `charges` (C) at `sources` (world, m);
    /// the same for any number of threads. No charges make no field.
    ///
    /// # Errors
    /// Positions or charges that are not finite, arrays of different lengths, and a tolerance out of
    /// reach.
    fn fields(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        targets: &[Point3<f64>],
    ) -> Result<Fields, ElectrostaticsError>;
}

/// The direct sum over all pairs, the reference for every other method.
///
/// Exact to a relative 1e-13 of the sum of magnitudes. Cost: 0.4 ns a pair with AVX-512.
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

/// Coordinate by coordinate.
pub(crate) fn places(points: impl IndexedParallelIterator<Item = Point3<f64>>) -> [Vec<f64>; 3] {
    // Points may stand anywhere in memory: they are fetched once.
    let points: Vec<_> = points.collect();
    [0, 1, 2].map(|d| points.par_iter().map(|x| x[d]).collect())
}

/// Sums of `q/sqrt(r^2 + softening)` and their gradients at `targets`.
pub(crate) fn direct_sums(cloud: &Cloud, softening: f64, targets: &[Vec<f64>; 3]) -> Vec<[f64; 4]> {
    // Sources are taken a level-2 cache at a time.
    const TILE: usize = 16_384;
    const TARGETS: usize = 64;
    let tiles = cloud.len().div_ceil(TILE);
    let mut sums = vec![[0.0; 4]; targets[0].len()];
    sums.par_chunks_mut(TARGETS).enumerate().for_each(|(k, out)| {
        let range = k * TARGETS..k * TARGETS + out.len();
        let part = |k: usize| {
            let (tile, mut part) = (k * TILE..cloud.len().min((k + 1) * TILE), [[0.0; 4]; TARGETS]);
            let part = &mut part[..out.len()];
            add_pairs(cloud, &[tile], softening, targets, range.clone(), part);
            part.to_vec()
        };
        let parts: Vec<_> = (0..tiles).into_par_iter().map(part).collect();
        for part in parts {
            let sums = out.as_flattened_mut().iter_mut();
            sums.zip(part.as_flattened()).for_each(|(sum, part)| *sum += part);
        }
    });
    sums
}
