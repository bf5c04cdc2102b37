//! Anderson's acceleration of a fixed-point iteration, with a memory of a few steps.
//!
//! Type II (Walker and Ni 2011): of the last steps it finds the combination whose residual is
//! least, and steps to the same combination of their images. A step that raises the residual is
//! taken back.

use nalgebra::{DMatrix, DVector, Vector3};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use std::ops::Range;

/// Vectors that one task takes.
const CHUNK: usize = 512;
/// Sums that a product runs side by side.
const LANES: usize = 32;
/// Part of the largest entry that keeps the small system regular.
const RIDGE: f64 = 1e-10;
/// A step is taken back if the residual grows by more than this factor.
const GROWTH: f64 = 1.0;

/// The last steps of an iteration on many vectors. Residuals are by the roots of their weights.
#[derive(Debug, Clone, Default)]
pub(crate) struct Anderson {
    depth: usize,
    /// Differences of residuals and of images, the oldest overwritten first.
    residuals: Vec<Vec<[f64; 3]>>,
    images: Vec<Vec<[f64; 3]>>,
    steps: usize,
    /// Residual and image of the step before, and of the next.
    last: [Vec<[f64; 3]>; 2],
    next: [Vec<[f64; 3]>; 2],
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

    /// Replaces `state` by the next one, where `residual` is what the iteration adds to it; `roots`
    /// are those of the weights of its norm.
    pub(crate) fn next(
        &mut self,
        roots: &[f64],
        residual: &[Vector3<f64>],
        state: &mut [Vector3<f64>],
    ) {
        let [weighted, image] = &mut self.next;
        weighted.clear();
        weighted.extend(residual.iter().zip(roots).map(|(f, w)| <[f64; 3]>::from(f * *w)));
        image.clear();
        image.extend(state.iter().zip(residual).map(|(h, f)| <[f64; 3]>::from(h + f)));
        let remembers = self.norm.is_some();
        let slot = self.steps % self.depth;
        if remembers {
            if self.residuals.len() <= slot {
                self.residuals.push(Vec::new());
                self.images.push(Vec::new());
            }
            difference(&mut self.residuals[slot], weighted, &self.last[0]);
            difference(&mut self.images[slot], image, &self.last[1]);
        }
        let count = (self.steps + usize::from(remembers)).min(self.depth);
        let newest = remembers.then_some(slot);
        let products = products(&self.residuals[..count], newest, weighted);
        let norm = products.norm.sqrt();
        if let Some(before) = self.norm
            && (norm > GROWTH * before || norm.is_nan())
        {
            // Back to where plain steps lead.
            state.iter_mut().zip(&self.last[1]).for_each(|(h, image)| *h = (*image).into());
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
        std::mem::swap(&mut self.last, &mut self.next);
        let mut gram = self.gram.view((0, 0), (count, count)).into_owned();
        let ridge = RIDGE * gram.amax();
        for i in 0..count {
            gram[(i, i)] += ridge;
        }
        let right = DVector::from_vec(products.with_residual);
        let shares = gram.cholesky().map(|cholesky| cholesky.solve(&right));
        let shares = shares.filter(|shares| shares.iter().all(|x| x.is_finite()));
        let shares = shares.as_ref().map_or(&[][..], |shares| shares.as_slice());
        let (image, images) = (&self.last[1], &self.images);
        state.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, state)| {
            let range = chunk * CHUNK..chunk * CHUNK + state.len();
            let mut mixed = image[range.clone()].to_vec();
            Arch::new().dispatch(Mix { mixed: &mut mixed, shares, images, range });
            state.iter_mut().zip(mixed).for_each(|(h, mixed)| *h = mixed.into());
        });
    }
}

/// Takes shares of differences of images from some vectors.
struct Mix<'a> {
    mixed: &'a mut [[f64; 3]],
    shares: &'a [f64],
    images: &'a [Vec<[f64; 3]>],
    range: Range<usize>,
}

impl NullaryFnOnce for Mix<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mixed = self.mixed.as_flattened_mut();
        for (share, image) in self.shares.iter().zip(self.images) {
            let image = image[self.range.clone()].as_flattened();
            mixed.iter_mut().zip(image).for_each(|(h, d)| *h -= d * share);
        }
    }
}

/// Products of what is remembered.
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
    differences: &[Vec<[f64; 3]>],
    newest: Option<usize>,
    residual: &[[f64; 3]],
) -> Products {
    let part = |start: usize| {
        let range = start..residual.len().min(start + CHUNK);
        let residual = residual[range.clone()].as_flattened();
        let newest = newest.map(|slot| differences[slot][range.clone()].as_flattened());
        let others = differences.iter().map(|d| d[range.clone()].as_flattened()).collect();
        Arch::new().dispatch(Dots { residual, newest, others })
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

/// The products of a residual with itself and with others, and of those with the newest of them.
struct Dots<'a> {
    residual: &'a [f64],
    newest: Option<&'a [f64]>,
    others: Vec<&'a [f64]>,
}

impl NullaryFnOnce for Dots<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let mut dots = vec![dot(self.residual, self.residual)];
        dots.extend(self.others.iter().map(|other| dot(other, self.residual)));
        if let Some(newest) = self.newest {
            dots.extend(self.others.iter().map(|other| dot(other, newest)));
        }
        dots
    }
}

/// Sums that run side by side, then one after another.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

fn difference(out: &mut Vec<[f64; 3]>, new: &[[f64; 3]], old: &[[f64; 3]]) {
    out.clear();
    out.extend(new.iter().zip(old).map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]]));
}
