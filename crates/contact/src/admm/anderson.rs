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

/// Sums that a product runs side by side.
const SUMS: usize = 32;
/// Part of the largest entry that keeps the small system regular.
const RIDGE: f64 = 1e-10;
/// A step is taken back if the residual grows by more than this factor.
const GROWTH: f64 = 1.0;

/// What is remembered of the last steps of an iteration as a whole.
#[derive(Debug, Clone, Default)]
pub(crate) struct Anderson {
    depth: usize,
    /// Iterations that make a step.
    period: usize,
    /// Iterations of the step at hand, and steps that are remembered or were.
    iterations: usize,
    steps: usize,
    /// Norm of the residual of the step before; `None` if there is none.
    norm: Option<f64>,
    gram: DMatrix<f64>,
}

/// What is remembered of some of the vectors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Part {
    /// Differences of residuals and of images, the oldest overwritten first.
    differences: Vec<[Vec<f32>; 2]>,
    /// The residual of the last step, times the roots of the weights.
    residual: Vec<f64>,
    /// Images of the step before and of the last.
    images: [Vec<f64>; 2],
}

/// What an iteration is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Turn {
    /// A plain one: its image is the next state.
    Plain,
    /// The last one of a step: what comes of it is to be looked at.
    Look(Option<Place>),
}

/// How the state goes on after a step.
#[derive(Debug, Clone)]
pub(crate) enum Onward {
    /// Where plain iterations led the step before.
    Back,
    /// To the image less such shares of the differences of images.
    Mix(Vec<f64>),
}

/// Where the newest difference goes, and how many are then remembered.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    newest: usize,
    count: usize,
}

impl Anderson {
    /// Remembers nothing yet, and `depth` steps of `period` iterations from now on.
    pub(crate) fn new(depth: usize, period: usize) -> Self {
        Self { depth, period, gram: DMatrix::zeros(depth, depth), ..Self::default() }
    }

    /// Whether the next iteration begins a step: its state is to be noted.
    pub(crate) fn sets_out(&self) -> bool {
        self.iterations == 0 && self.depth > 0
    }

    /// What the next iteration is for.
    pub(crate) fn turn(&mut self) -> Turn {
        if self.depth == 0 {
            return Turn::Plain;
        }
        self.iterations += 1;
        if self.iterations < self.period {
            return Turn::Plain;
        }
        self.iterations = 0;
        Turn::Look(self.place())
    }

    /// Where the difference of the next step goes; none before the second step.
    pub(crate) fn place(&self) -> Option<Place> {
        self.norm.map(|_| Place {
            newest: self.steps % self.depth,
            count: (self.steps + 1).min(self.depth),
        })
    }

    /// How the state goes on, by the products of all vectors at the end of a step.
    pub(crate) fn onward(&mut self, products: &Products) -> Onward {
        let norm = products.norm.sqrt();
        if let Some(before) = self.norm
            && (norm > GROWTH * before || norm.is_nan())
        {
            *self = Self::new(self.depth, self.period);
            return Onward::Back;
        }
        if let Some(Place { newest, .. }) = self.place() {
            self.steps += 1;
            for (i, &[_, entry]) in products.with.iter().enumerate() {
                (self.gram[(newest, i)], self.gram[(i, newest)]) = (entry, entry);
            }
        }
        self.norm = Some(norm);
        Onward::Mix(self.shares(products))
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

impl Part {
    /// Room for the image at the end of a step.
    pub(crate) fn image(&mut self) -> &mut Vec<f64> {
        &mut self.images[1]
    }

    /// Remembers the step that led to the image, with a residual times the roots of the weights of the norm, and
    /// finds its products.
    pub(crate) fn look(&mut self, residual: &[f64], place: Option<Place>) -> Products {
        Arch::new().dispatch(Look { part: self, residual, place })
    }

    /// The next state, or where that is mixed, room for it.
    pub(crate) fn onward<'a>(&'a mut self, onward: &Onward, room: &'a mut Vec<f64>) -> &'a [f64] {
        match onward {
            Onward::Back => &self.images[0],
            Onward::Mix(shares) => {
                Arch::new().dispatch(Mix { part: self, shares, room });
                self.images.swap(0, 1);
                room
            }
        }
    }
}

/// Products of what is remembered.
#[derive(Debug, Clone, Default)]
pub(crate) struct Products {
    /// Of the residual with itself.
    norm: f64,
    /// Of every difference of residuals with the residual and with the newest difference.
    with: Vec<[f64; 2]>,
}

impl Products {
    /// Adds those of other vectors.
    pub(crate) fn add(&mut self, other: &Self) {
        self.norm += other.norm;
        self.with.resize(other.with.len(), [0.0; 2]);
        for (sum, other) in self.with.iter_mut().zip(&other.with) {
            *sum = [sum[0] + other[0], sum[1] + other[1]];
        }
    }
}

/// Remembers a step and finds its products.
struct Look<'a> {
    part: &'a mut Part,
    residual: &'a [f64],
    place: Option<Place>,
}

impl NullaryFnOnce for Look<'_> {
    type Output = Products;

    #[inline(always)]
    fn call(self) -> Products {
        let Self { part, residual, place } = self;
        let Part { differences, residual: last, images: [before, image] } = part;
        let mut products = Products { norm: product(residual), with: Vec::new() };
        if let Some(Place { newest, count }) = place {
            differences.resize_with(differences.len().max(count), Default::default);
            let steps = [(residual, &**last), (&**image, &**before)];
            for (difference, (now, before)) in differences[newest].iter_mut().zip(steps) {
                difference.resize(now.len(), 0.0);
                let both = now.iter().zip(before);
                difference.iter_mut().zip(both).for_each(|(d, (a, b))| *d = single(a - b));
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
fn single(x: f64) -> f32 {
    x as f32
}

/// The product of numbers with themselves.
#[inline(always)]
fn product(a: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (whole, rest) = a.as_chunks::<SUMS>();
    for a in whole {
        for i in 0..SUMS {
            sums[i] += a[i] * a[i];
        }
    }
    total(sums) + rest.iter().map(|a| a * a).sum::<f64>()
}

/// The products of a difference with a residual and with another difference.
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

/// By halves.
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

/// Takes shares of the differences of images from the last one.
struct Mix<'a> {
    part: &'a Part,
    shares: &'a [f64],
    room: &'a mut Vec<f64>,
}

impl NullaryFnOnce for Mix<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { part, shares, room } = self;
        room.clone_from(&part.images[1]);
        for (share, [_, image]) in shares.iter().zip(&part.differences) {
            room.iter_mut().zip(image).for_each(|(h, d)| *h -= f64::from(*d) * share);
        }
    }
}
