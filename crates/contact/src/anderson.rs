//! Anderson's acceleration of a fixed-point iteration, with a memory of a few steps.
//!
//! Type II (Walker and Ni 2011): of the last steps it finds the combination whose residual is
//! least, and steps to the same combination of their images. A step that raises the residual is
//! taken back. A step is some plain iterations, one after another: between extrapolations they
//! smooth what these roughen, at a part of the cost (Pratapa, Suryanarayana and Pask 2016).
//!
//! Differences of steps are remembered in single precision, which is half of what has to be read:
//! they only choose the next state, and their roundings shrink with them.

use nalgebra::{DMatrix, DVector, Vector3};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Vectors that one task takes.
const CHUNK: usize = 256;
/// Sums that a product runs side by side.
const LANES: usize = 32;
/// Part of the largest entry that keeps the small system regular.
const RIDGE: f64 = 1e-10;
/// Iterations that make a step; one of up to so many vectors, of which the memory spans much.
const ITERATIONS: usize = 3;
const FEW: usize = 64;
/// A step is taken back if the residual grows by more than this factor.
const GROWTH: f64 = 1.0;

/// The last steps of an iteration on many vectors. Residuals are by the roots of their weights.
#[derive(Debug, Clone, Default)]
pub(crate) struct Anderson {
    depth: usize,
    parts: Vec<Part>,
    /// Iterations of the step at hand, and steps that are remembered or were.
    iterations: usize,
    steps: usize,
    /// Norm of the residual of the step before; `None` if there is none.
    norm: Option<f64>,
    gram: DMatrix<f64>,
}

/// The last steps of some of the vectors.
#[derive(Debug, Clone, Default)]
struct Part {
    /// Differences of residuals and of images, the oldest overwritten first.
    differences: Vec<[Vec<f32>; 2]>,
    /// State at the start of the step.
    start: Vec<f64>,
    /// Residual and image of the step before, and of the next.
    last: [Vec<f64>; 2],
    next: [Vec<f64>; 2],
}

/// Where the newest difference goes, and how many are then remembered.
#[derive(Debug, Clone, Copy)]
struct Place {
    newest: usize,
    count: usize,
}

impl Part {
    fn set_out(&mut self, state: &[Vector3<f64>]) {
        self.start.clear();
        self.start.extend(state.iter().flatten());
    }
}

impl Anderson {
    /// Forgets everything; remembers `depth` steps from now on.
    pub(crate) fn reset(&mut self, depth: usize) {
        self.depth = depth;
        self.iterations = 0;
        self.forget();
    }

    fn forget(&mut self) {
        self.steps = 0;
        self.norm = None;
        self.gram = DMatrix::zeros(self.depth, self.depth);
    }

    /// Replaces `state` by the next one, where `residual` is what an iteration adds to it; `roots`
    /// are those of the weights of the norm of what a step adds.
    pub(crate) fn next(
        &mut self,
        roots: &[f64],
        residual: &[Vector3<f64>],
        state: &mut [Vector3<f64>],
    ) {
        self.parts.resize_with(state.len().div_ceil(CHUNK), Part::default);
        if self.iterations == 0 {
            let parts = self.parts.par_iter_mut().zip(state.par_chunks(CHUNK));
            parts.for_each(|(part, state)| part.set_out(state));
        }
        self.iterations += 1;
        if self.iterations < ITERATIONS && state.len() > FEW {
            let both = state.par_chunks_mut(CHUNK).zip(residual.par_chunks(CHUNK));
            both.for_each(|(h, step)| h.iter_mut().zip(step).for_each(|(h, step)| *h += step));
            return;
        }
        self.iterations = 0;
        let place = self.norm.map(|_| Place {
            newest: self.steps % self.depth,
            count: (self.steps + 1).min(self.depth),
        });
        let given = residual.par_chunks(CHUNK).zip(roots.par_chunks(CHUNK));
        let parts = self.parts.par_iter_mut().zip(state.par_chunks(CHUNK).zip(given));
        let products: Vec<Products> = parts
            .map(|(part, (state, (residual, roots)))| {
                let vectors = Vectors { state, residual, roots };
                Arch::new().dispatch(Look { part, place, vectors })
            })
            .collect();
        let products = Products::sum(&products);
        let norm = products.norm.sqrt();
        if let Some(before) = self.norm
            && (norm > GROWTH * before || norm.is_nan())
        {
            // Back to where plain steps lead.
            let parts = self.parts.par_iter().zip(state.par_chunks_mut(CHUNK));
            parts.for_each(|(part, state)| set(state, &part.last[1]));
            self.forget();
            return;
        }
        if let Some(Place { newest, .. }) = place {
            self.steps += 1;
            for (i, &[_, entry]) in products.with.iter().enumerate() {
                (self.gram[(newest, i)], self.gram[(i, newest)]) = (entry, entry);
            }
        }
        self.norm = Some(norm);
        let shares = self.shares(&products);
        let parts = self.parts.par_iter_mut().zip(state.par_chunks_mut(CHUNK));
        parts.for_each(|(part, state)| {
            Arch::new().dispatch(Mix { part, shares: &shares, state });
        });
    }

    /// The shares of the differences that leave the least residual; none where they cannot be told.
    fn shares(&self, products: &Products) -> Vec<f64> {
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

/// Products of what is remembered.
#[derive(Debug, Clone, Default)]
struct Products {
    /// Of the residual with itself.
    norm: f64,
    /// Of every difference of residuals with the residual and with the newest difference.
    with: Vec<[f64; 2]>,
}

impl Products {
    /// Those of all parts, in their order.
    fn sum(parts: &[Self]) -> Self {
        let count = parts.first().map_or(0, |part| part.with.len());
        let sum = |i: usize| [0, 1].map(|k| parts.iter().map(|part| part.with[i][k]).sum());
        Self { norm: parts.iter().map(|part| part.norm).sum(), with: (0..count).map(sum).collect() }
    }
}

/// Some of the vectors of a step.
struct Vectors<'a> {
    state: &'a [Vector3<f64>],
    residual: &'a [Vector3<f64>],
    roots: &'a [f64],
}

/// Remembers a step and finds its products.
struct Look<'a> {
    part: &'a mut Part,
    place: Option<Place>,
    vectors: Vectors<'a>,
}

impl NullaryFnOnce for Look<'_> {
    type Output = Products;

    #[inline(always)]
    fn call(self) -> Products {
        let Self { part, place, vectors: Vectors { state, residual, roots } } = self;
        let [weighted, image] = &mut part.next;
        weighted.resize(3 * state.len(), 0.0);
        image.resize(3 * state.len(), 0.0);
        let rooms = weighted.as_chunks_mut::<3>().0.iter_mut().zip(image.as_chunks_mut::<3>().0);
        let rooms = rooms.zip(part.start.as_chunks::<3>().0);
        let given = state.iter().zip(residual).zip(roots);
        for (((weighted, image), start), ((h, f), w)) in rooms.zip(given) {
            let next = h + f;
            *weighted = ((next - Vector3::from(*start)) * *w).into();
            *image = next.into();
        }
        let mut products = Products { norm: product(weighted), with: Vec::new() };
        let Some(Place { newest, count }) = place else { return products };
        part.differences.resize_with(part.differences.len().max(count), Default::default);
        let steps = part.next.iter().zip(&part.last);
        for (difference, (next, last)) in part.differences[newest].iter_mut().zip(steps) {
            difference.resize(next.len(), 0.0);
            let both = next.iter().zip(last);
            difference.iter_mut().zip(both).for_each(|(d, (a, b))| *d = single(a - b));
        }
        let [newest, _] = &part.differences[newest];
        // No closure: the sums must be inlined into what is dispatched.
        for [other, _] in &part.differences[..count] {
            products.with.push(dots(other, &part.next[0], newest));
        }
        products
    }
}

#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
fn single(x: f64) -> f32 {
    x as f32
}

/// The product of numbers with themselves.
#[inline(always)]
fn product(a: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (whole, rest) = a.as_chunks::<LANES>();
    for a in whole {
        for i in 0..LANES {
            sums[i] += a[i] * a[i];
        }
    }
    total(sums) + rest.iter().map(|a| a * a).sum::<f64>()
}

/// The products of a difference with a residual and with another difference.
#[inline(always)]
fn dots(difference: &[f32], residual: &[f64], other: &[f32]) -> [f64; 2] {
    let mut sums = [[0.0; LANES]; 2];
    let (d, rest) = difference.as_chunks::<LANES>();
    let (r, rest_r) = residual.as_chunks::<LANES>();
    let (o, rest_o) = other.as_chunks::<LANES>();
    for ((d, r), o) in d.iter().zip(r).zip(o) {
        for i in 0..LANES {
            sums[0][i] += f64::from(d[i]) * r[i];
            sums[1][i] += f64::from(d[i]) * f64::from(o[i]);
        }
    }
    let rest = rest.iter().zip(rest_r).zip(rest_o).fold([0.0; 2], |[a, b], ((d, r), o)| {
        [a + f64::from(*d) * r, b + f64::from(*d) * f64::from(*o)]
    });
    [0, 1].map(|k| total(sums[k]) + rest[k])
}

/// By halves.
#[inline(always)]
fn total(mut sums: [f64; LANES]) -> f64 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] += sums[i + half];
        }
        half /= 2;
    }
    sums[0]
}

/// Takes shares of the differences of images from the next one, and makes that the last.
struct Mix<'a> {
    part: &'a mut Part,
    shares: &'a [f64],
    state: &'a mut [Vector3<f64>],
}

impl NullaryFnOnce for Mix<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Part { differences, last, next, .. } = self.part;
        std::mem::swap(last, next);
        // The room of the next step serves for the sum.
        let mixed = &mut next[1];
        mixed.clone_from(&last[1]);
        for (share, [_, image]) in self.shares.iter().zip(differences) {
            mixed.iter_mut().zip(&*image).for_each(|(h, d)| *h -= f64::from(*d) * share);
        }
        set(self.state, mixed);
    }
}

fn set(state: &mut [Vector3<f64>], numbers: &[f64]) {
    let vectors = numbers.as_chunks::<3>().0;
    state.iter_mut().zip(vectors).for_each(|(h, &numbers)| *h = numbers.into());
}
