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
        let norm = dot(weights, residual, residual).sqrt();
        if let Some(before) = self.norm
            && (norm > GROWTH * before || norm.is_nan())
        {
            // Back to where plain steps lead.
            state.copy_from_slice(&self.image);
            self.forget();
            return;
        }
        if self.norm.is_some() {
            let slot = self.steps % self.depth;
            if self.residuals.len() <= slot {
                self.residuals.push(Vec::new());
                self.images.push(Vec::new());
            }
            let old = (&self.residual, &self.image);
            difference(&mut self.residuals[slot], residual, old.0, None);
            difference(&mut self.images[slot], residual, old.1, Some(state));
            self.steps += 1;
            let count = self.steps.min(self.depth);
            for i in 0..count {
                let entry = dot(weights, &self.residuals[slot], &self.residuals[i]);
                (self.gram[(slot, i)], self.gram[(i, slot)]) = (entry, entry);
            }
        }
        self.norm = Some(norm);
        self.residual.clear();
        self.residual.extend_from_slice(residual);
        self.image.clear();
        self.image.extend(state.iter().zip(residual).map(|(h, f)| h + f));
        let count = self.steps.min(self.depth);
        let right = DVector::from_iterator(
            count,
            (0..count).map(|i| dot(weights, &self.residuals[i], residual)),
        );
        let mut gram = self.gram.view((0, 0), (count, count)).into_owned();
        let ridge = RIDGE * gram.amax();
        for i in 0..count {
            gram[(i, i)] += ridge;
        }
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

/// The weighted product, summed in a fixed order.
fn dot(weights: &[f64], a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let parts: Vec<f64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .zip(weights.par_chunks(CHUNK))
        .map(|((a, b), w)| a.iter().zip(b).zip(w).map(|((a, b), w)| w * a.dot(b)).sum())
        .collect();
    parts.iter().sum()
}
