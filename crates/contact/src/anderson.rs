//! Anderson's acceleration of a fixed-point iteration, with a memory of a few steps.
//!
//! Type II (Walker and Ni 2011): of the last steps it finds the combination whose residual is
//! least, and steps to the same combination of their images. A step that raises the residual is
//! taken back.

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

/// Vectors that one task takes.
const CHUNK: usize = 2048;
/// Part of the largest entry that keeps the small system regular.
const RIDGE: f64 = 1e-10;
/// A step is taken back if the residual grows by more than this factor.
const GROWTH: f64 = 1.0;

/// The last steps of an iteration on many vectors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Anderson {
    depth: usize,
    /// Differences of residuals and of images, the oldest overwritten first.
    residuals: Vec<Vec<Vector3<f64>>>,
    images: Vec<Vec<Vector3<f64>>>,
    steps: usize,
    /// Residual and image of the step before.
    residual: Vec<Vector3<f64>>,
    image: Vec<Vector3<f64>>,
    /// Norm of the residual of the step before; `None` if there is none.
    norm: Option<f64>,
    gram: DMatrix<f64>,
}

impl Anderson {
    /// Forgets everything; remembers `depth` steps from now on.
    pub(crate) fn reset(&mut self, depth: usize) {
        self.depth = depth;
        self.forget();
    }

    fn forget(&mut self) {
        self.steps = 0;
        self.norm = None;
        self.gram = DMatrix::zeros(self.depth, self.depth);
    }

    /// Replaces `state` by the next one, where `residual` is what the iteration adds to it;
    /// `weights` are those of the norm.
    pub(crate) fn next(
        &mut self,
        weights: &[f64],
        residual: &[Vector3<f64>],
        state: &mut [Vector3<f64>],
    ) {
        let remembers = self.norm.is_some();
        let slot = self.steps % self.depth;
        if remembers {
            if self.residuals.len() <= slot {
                self.residuals.push(Vec::new());
                self.images.push(Vec::new());
            }
            let old = (&self.residual, &self.image);
            difference(&mut self.residuals[slot], residual, old.0, None);
            difference(&mut self.images[slot], residual, old.1, Some(state));
        }
        let count = (self.steps + usize::from(remembers)).min(self.depth);
        let newest = remembers.then_some(slot);
        let products = products(weights, &self.residuals[..count], newest, residual);
        let norm = products.norm.sqrt();
        if let Some(before) = self.norm
            && (norm > GROWTH * before || norm.is_nan())
        {
            // Back to where plain steps lead.
            state.copy_from_slice(&self.image);
            self.forget();
            return;
        }
        if remembers {
            self.steps += 1;
            for (i, &entry) in products.with_newest.iter().enumerate() {
                (self.gram[(slot, i)], self.gram[(i, slot)]) = (entry, entry);
            }
        }
        self.norm = Some(norm);
        self.residual.clear();
        self.residual.extend_from_slice(residual);
        self.image.clear();
        self.image.extend(state.iter().zip(residual).map(|(h, f)| h + f));
        let mut gram = self.gram.view((0, 0), (count, count)).into_owned();
        let ridge = RIDGE * gram.amax();
        for i in 0..count {
            gram[(i, i)] += ridge;
        }
        let right = DVector::from_vec(products.with_residual);
        let shares = gram.cholesky().map(|cholesky| cholesky.solve(&right));
        state.copy_from_slice(&self.image);
        if let Some(shares) = shares.filter(|shares| shares.iter().all(|x| x.is_finite())) {
            let images = &self.images;
            state.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, state)| {
                let start = chunk * CHUNK;
                for (share, image) in shares.iter().zip(images) {
                    for (h, d) in state.iter_mut().zip(&image[start..]) {
                        *h -= d * *share;
                    }
                }
            });
        }
    }
}

/// Weighted products of what is remembered.
struct Products {
    /// Of the residual with itself.
    norm: f64,
    /// Of every difference of residuals with the newest one, if there is one.
    with_newest: Vec<f64>,
    /// Of every difference with the residual.
    with_residual: Vec<f64>,
}

/// All products in one pass, summed in a fixed order.
fn products(
    weights: &[f64],
    differences: &[Vec<Vector3<f64>>],
    newest: Option<usize>,
    residual: &[Vector3<f64>],
) -> Products {
    let part = |start: usize| {
        let range = start..residual.len().min(start + CHUNK);
        let (weights, residual) = (&weights[range.clone()], &residual[range.clone()]);
        let newest = newest.map(|slot| &differences[slot][range.clone()]);
        let mut sums = vec![dot(weights, residual, residual)];
        sums.extend(differences.iter().map(|d| dot(weights, &d[range.clone()], residual)));
        let with = |newest| differences.iter().map(move |d| (d, newest));
        let pairs = newest.into_iter().flat_map(with);
        sums.extend(pairs.map(|(d, newest)| dot(weights, &d[range.clone()], newest)));
        sums
    };
    let starts: Vec<usize> = (0..residual.len()).step_by(CHUNK).collect();
    let parts: Vec<Vec<f64>> = starts.into_par_iter().map(part).collect();
    let sum = |i: usize| parts.iter().map(|sums| sums[i]).sum::<f64>();
    let count = differences.len();
    let newest = if newest.is_some() { count } else { 0 };
    Products {
        norm: sum(0),
        with_residual: (1..=count).map(sum).collect(),
        with_newest: (count + 1..=count + newest).map(sum).collect(),
    }
}

/// `out = new - old`, of images `new = base + new`.
fn difference(
    out: &mut Vec<Vector3<f64>>,
    new: &[Vector3<f64>],
    old: &[Vector3<f64>],
    base: Option<&[Vector3<f64>]>,
) {
    out.clear();
    match base {
        None => out.extend(new.iter().zip(old).map(|(a, b)| a - b)),
        Some(base) => {
            out.extend(new.iter().zip(base).zip(old).map(|((a, h), b)| a + h - b));
        }
    }
}

/// The weighted product.
fn dot(weights: &[f64], a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).zip(weights).map(|((a, b), w)| w * a.dot(b)).sum()
}
