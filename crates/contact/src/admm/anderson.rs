//! Anderson's acceleration of a fixed-point iteration, with a memory of a few steps.
//!
//! Type II (Walker and Ni 2011): of the last steps it finds the combination whose residual is
//! least, and steps to the same combination of their images. A step that raises the residual is
//! taken back. A step may be some plain iterations, one after another: between extrapolations
//! they smooth what these roughen, at a part of the cost (Pratapa, Suryanarayana and Pask 2016).
//!
//! Differences of steps are remembered in single precision, which is half of what has to be read:
//! they only choose the next state, and their roundings shrink with them.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, NullaryFnOnce};

/// Partial sums that a product runs side by side.
const SUMS: usize = 32;
/// Added to the diagonal of the Gram matrix to keep it regular, relative to its largest entry.
const RIDGE: f64 = 1e-10;
/// Growth of the norm of the residual from which on a step is taken back.
const LARGEST_GROWTH: f64 = 1.0;

/// Small system of the last steps of an iteration as a whole, over all parts.
#[derive(Debug, Clone, Default)]
pub(crate) struct Anderson {
    /// Most differences of steps that are remembered.
    depth: usize,
    /// Iterations that make a step.
    period: usize,
    /// Iterations done of the step at hand.
    iterations: usize,
    /// Differences of steps that have been remembered, overwritten ones included.
    steps: usize,
    /// Norm of the residual of the step before; `None` if there is none.
    norm: Option<f64>,
    /// Gram matrix of the differences of residuals.
    gram: DMatrix<f64>,
}

/// Residuals and images of the last steps, of one part of the vectors.
#[derive(Debug, Clone, Default)]
pub(crate) struct AndersonHistory {
    /// Differences of residuals and of images, the oldest overwritten first.
    differences: Vec<[Vec<f32>; 2]>,
    /// Residual of the last step, times the roots of the weights.
    residual: Vec<f64>,
    /// Images of the step before and of the last.
    images: [Vec<f64>; 2],
}

/// Role of an iteration in a step of the acceleration.
#[derive(Debug, Clone, Copy)]
pub(crate) enum IterationKind {
    /// A plain iteration: its image is the next state.
    Plain,
    /// The last iteration of a step: its image goes into the history, where there is a slot for the
    /// difference from the step before.
    EndOfStep(Option<HistorySlot>),
}

/// Next state after a step.
#[derive(Debug, Clone)]
pub(crate) enum AndersonUpdate {
    /// The image of the step before, from which the acceleration starts anew.
    Revert,
    /// The image less these shares of the differences of images.
    Mix(Vec<f64>),
}

/// Place of the newest difference in the history.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HistorySlot {
    newest: usize,
    /// Number of differences with the newest.
    count: usize,
}

impl Anderson {
    /// An acceleration that remembers nothing yet, and `depth` steps of `period` iterations from
    /// now on.
    pub(crate) fn new(depth: usize, period: usize) -> Self {
        Self { depth, period, gram: DMatrix::zeros(depth, depth), ..Self::default() }
    }

    /// Whether the next iteration begins a step: its state is to be kept.
    pub(crate) fn starts_step(&self) -> bool {
        self.iterations == 0 && self.depth > 0
    }

    /// Role of the next iteration, which is counted.
    pub(crate) fn next_iteration(&mut self) -> IterationKind {
        if self.depth == 0 {
            return IterationKind::Plain;
        }
        self.iterations += 1;
        if self.iterations < self.period {
            return IterationKind::Plain;
        }
        self.iterations = 0;
        IterationKind::EndOfStep(self.next_slot())
    }

    /// Slot of the difference that the next step makes; none before the second step.
    pub(crate) fn next_slot(&self) -> Option<HistorySlot> {
        self.norm.map(|_| HistorySlot {
            newest: self.steps % self.depth,
            count: (self.steps + 1).min(self.depth),
        })
    }

    /// Next state, by the products of all parts at the end of a step.
    pub(crate) fn update(&mut self, products: &ResidualProducts) -> AndersonUpdate {
        let norm = products.norm.sqrt();
        if let Some(before) = self.norm
            && (norm > LARGEST_GROWTH * before || norm.is_nan())
        {
            // The residual grew: forget all steps and take the last one back.
            *self = Self::new(self.depth, self.period);
            return AndersonUpdate::Revert;
        }
        if let Some(HistorySlot { newest, .. }) = self.next_slot() {
            self.steps += 1;
            for (i, &[_, entry]) in products.with.iter().enumerate() {
                (self.gram[(newest, i)], self.gram[(i, newest)]) = (entry, entry);
            }
        }
        self.norm = Some(norm);
        AndersonUpdate::Mix(self.shares(products))
    }

    /// Shares of the differences that leave the least residual; none where they cannot be told.
    fn shares(&self, products: &ResidualProducts) -> Vec<f64> {
        // Normal equations of type II (Walker and Ni 2011), with a ridge.
        let count = products.with.len();
        let mut gram = self.gram.view((0, 0), (count, count)).into_owned();
        let ridge = RIDGE * gram.amax();
        for i in 0..count {
            gram[(i, i)] += ridge;
        }
        let right = DVector::from_iterator(count, products.with.iter().map(|[right, _]| *right));
        let shares = gram.cholesky().map(|cholesky| cholesky.solve(&right));
        let shares = shares.filter(|shares| shares.iter().all(|x| x.is_finite()));
        shares.map_or_else(Vec::new, |shares| shares.as_slice().to_vec())
    }
}

impl AndersonHistory {
    /// Buffer for the image at the end of a step.
    pub(crate) fn image_mut(&mut self) -> &mut Vec<f64> {
        &mut self.images[1]
    }

    /// Records the step that led to the image, with its residual times the roots of the weights of
    /// the norm, and returns the products of this part.
    pub(crate) fn record(
        &mut self,
        residual: &[f64],
        slot: Option<HistorySlot>,
    ) -> ResidualProducts {
        Arch::new().dispatch(RecordStep { history: self, residual, slot })
    }

    /// Next state of this part; `buffer` holds it where it is mixed.
    pub(crate) fn apply<'a>(
        &'a mut self,
        update: &AndersonUpdate,
        buffer: &'a mut Vec<f64>,
    ) -> &'a [f64] {
        match update {
            AndersonUpdate::Revert => &self.images[0],
            AndersonUpdate::Mix(shares) => {
                Arch::new().dispatch(MixImages { history: self, shares, buffer });
                self.images.swap(0, 1);
                buffer
            }
        }
    }
}

/// Scalar products of the residuals that are remembered.
#[derive(Debug, Clone, Default)]
pub(crate) struct ResidualProducts {
    /// Square of the norm of the residual.
    norm: f64,
    /// Products of every difference of residuals with the residual and with the newest
    /// difference.
    with: Vec<[f64; 2]>,
}

impl ResidualProducts {
    /// Adds the products of another part.
    pub(crate) fn add(&mut self, other: &Self) {
        self.norm += other.norm;
        self.with.resize(other.with.len(), [0.0; 2]);
        for (sum, other) in self.with.iter_mut().zip(&other.with) {
            *sum = [sum[0] + other[0], sum[1] + other[1]];
        }
    }
}

/// Records a step and finds its products, for any kind of machine.
struct RecordStep<'a> {
    history: &'a mut AndersonHistory,
    residual: &'a [f64],
    slot: Option<HistorySlot>,
}

impl NullaryFnOnce for RecordStep<'_> {
    type Output = ResidualProducts;

    #[inline(always)]
    fn call(self) -> ResidualProducts {
        let Self { history, residual, slot } = self;
        let AndersonHistory { differences, residual: last, images: [before, image] } = history;
        let mut products = ResidualProducts { norm: sum_of_squares(residual), with: Vec::new() };
        if let Some(HistorySlot { newest, count }) = slot {
            differences.resize_with(differences.len().max(count), Default::default);
            // Differences of residuals and of images from the step before.
            let steps = [(residual, &**last), (&**image, &**before)];
            for (difference, (now, before)) in differences[newest].iter_mut().zip(steps) {
                difference.resize(now.len(), 0.0);
                let both = now.iter().zip(before);
                difference.iter_mut().zip(both).for_each(|(d, (a, b))| *d = to_single(a - b));
            }
            let [newest, _] = &differences[newest];
            // No closure: the sums must be inlined into what is dispatched.
            for [other, _] in &differences[..count] {
                products.with.push(dots(other, residual, newest));
            }
        }
        residual.clone_into(last);
        products
    }
}

#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
fn to_single(x: f64) -> f32 {
    x as f32
}

/// Sum of the squares of numbers.
#[inline(always)]
fn sum_of_squares(a: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (whole, rest) = a.as_chunks::<SUMS>();
    for a in whole {
        for i in 0..SUMS {
            sums[i] += a[i] * a[i];
        }
    }
    total(sums) + rest.iter().map(|a| a * a).sum::<f64>()
}

/// Products of a difference with a residual and with another difference.
#[inline(always)]
fn dots(difference: &[f32], residual: &[f64], other: &[f32]) -> [f64; 2] {
    let mut sums = [[0.0; SUMS]; 2];
    let (d, rest) = difference.as_chunks::<SUMS>();
    let (r, rest_r) = residual.as_chunks::<SUMS>();
    let (o, rest_o) = other.as_chunks::<SUMS>();
    for ((d, r), o) in d.iter().zip(r).zip(o) {
        for i in 0..SUMS {
            sums[0][i] += f64::from(d[i]) * r[i];
            sums[1][i] += f64::from(d[i]) * f64::from(o[i]);
        }
    }
    let rest = rest.iter().zip(rest_r).zip(rest_o).fold([0.0; 2], |[a, b], ((d, r), o)| {
        [a + f64::from(*d) * r, b + f64::from(*d) * f64::from(*o)]
    });
    [0, 1].map(|k| total(sums[k]) + rest[k])
}

/// Sum of the partial sums, by halves.
#[inline(always)]
fn total(mut sums: [f64; SUMS]) -> f64 {
    let mut half = SUMS / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] += sums[i + half];
        }
        half /= 2;
    }
    sums[0]
}

/// Writes the last image less shares of the differences of images, for any kind of machine.
struct MixImages<'a> {
    history: &'a AndersonHistory,
    shares: &'a [f64],
    buffer: &'a mut Vec<f64>,
}

impl NullaryFnOnce for MixImages<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { history, shares, buffer } = self;
        buffer.clone_from(&history.images[1]);
        for (share, [_, image]) in shares.iter().zip(&history.differences) {
            buffer.iter_mut().zip(image).for_each(|(h, d)| *h -= f64::from(*d) * share);
        }
    }
}
