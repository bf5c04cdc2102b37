//! Where the axes of many pairs are close to each other, several at a time.

use crate::{Capsules, Pair};

/// Pairs whose ends are gathered at a time: few enough to stay close to the processor.
pub(super) const BATCH: usize = 64;
/// Axes that enclose less than this angle count as nearly parallel; its squared sine.
const PARALLEL_AXES: f64 = 1e-6;
/// Axes that enclose less than 15 degrees may touch in several points; the squared sine of that.
const SIDE_BY_SIDE: f64 = 0.067;
/// Squared lengths below this are those of points, m²: their products stay normal numbers.
const POINT: f64 = 1e-70;

type BatchScalars = [f64; BATCH];

/// The axes of a batch of pairs: from the start of the first to its end, from the start of the
/// second to its end, and from start to start.
pub(super) struct PairBatch {
    first: [BatchScalars; 3],
    second: [BatchScalars; 3],
    between: [BatchScalars; 3],
    /// Squared sines of the angles between the axes.
    sines: BatchScalars,
    pub(super) closest: BatchPlaces,
    /// Where axes that are nearly parallel begin and stop to lie side by side; infinitely far apart
    /// for others, and where that is no other place than the closest.
    pub(super) ends: [BatchPlaces; 2],
}

/// A place along both axes of each pair.
pub(super) struct BatchPlaces {
    pub(super) fractions: [BatchScalars; 2],
    /// Distances there, squared, m².
    pub(super) squared: BatchScalars,
}

impl BatchPlaces {
    fn none() -> Self {
        Self { fractions: [[0.0; BATCH]; 2], squared: [f64::INFINITY; BATCH] }
    }

    #[inline(always)]
    fn set(&mut self, k: usize, [s, t]: [f64; 2], squared: f64) {
        (self.fractions[0][k], self.fractions[1][k], self.squared[k]) = (s, t, squared);
    }
}

impl Default for PairBatch {
    fn default() -> Self {
        let zero = [[0.0; BATCH]; 3];
        let (closest, ends) = (BatchPlaces::none(), [BatchPlaces::none(), BatchPlaces::none()]);
        Self { first: zero, second: zero, between: zero, sines: [0.0; BATCH], closest, ends }
    }
}

impl PairBatch {
    /// Takes at most [`BATCH`] pairs.
    #[inline(always)]
    pub(super) fn gather(&mut self, capsules: &Capsules, pairs: &[Pair]) {
        let (layout, positions) = (capsules.layout(), capsules.positions());
        for (k, &[i, j]) in pairs.iter().enumerate() {
            let [a, b] = layout.segment_nodes(i as usize);
            let [c, d] = layout.segment_nodes(j as usize);
            for axis in 0..3 {
                let (p, q) = (positions[a][axis], positions[c][axis]);
                self.first[axis][k] = positions[b][axis] - p;
                self.second[axis][k] = positions[d][axis] - q;
                self.between[axis][k] = q - p;
            }
        }
    }

    #[inline(always)]
    pub(super) fn axes(&self, k: usize) -> Axes {
        let first = [self.first[0][k], self.first[1][k], self.first[2][k]];
        let second = [self.second[0][k], self.second[1][k], self.second[2][k]];
        let between = [self.between[0][k], self.between[1][k], self.between[2][k]];
        Axes {
            a: positive(dot(&first, &first)),
            b: dot(&first, &second),
            c: dot(&first, &between),
            e: positive(dot(&second, &second)),
            f: dot(&second, &between),
            first,
            second,
            between,
        }
    }

    /// Finds where all axes are closest.
    #[inline(always)]
    pub(super) fn measure(&mut self) {
        if !self.measure_oblique() {
            self.measure_parallel();
        }
    }

    /// The same; whether it is good for all, as no axes are nearly parallel (or so large that their
    /// squares overflow).
    #[inline(always)]
    fn measure_oblique(&mut self) -> bool {
        let mut oblique = true;
        for k in 0..BATCH {
            let pair = self.axes(k);
            let Axes { a, b, c, e, f, .. } = pair;
            // One division for all three fractions.
            let determinant = a * e - b * b;
            let parallel = PARALLEL_AXES * a * e;
            let safe = if determinant > parallel { determinant } else { parallel };
            let inverse = 1.0 / (a * e * safe);
            let per_a = inverse * e * safe;
            let per_e = inverse * a * safe;
            let s = clamped((c * e - b * f) * (inverse * a * e));
            let t = clamped((s * b - f) * per_e);
            let s = clamped((c + t * b) * per_a);
            self.closest.set(k, [s, t], pair.squared([s, t]));
            let sine = determinant * inverse * safe;
            self.sines[k] = sine;
            oblique &= sine >= PARALLEL_AXES;
        }
        oblique
    }

    /// Measures those again for which the fast way is not good: the squared distance is convex in
    /// the two fractions, so its least value lies where the lines come closest or on a side of
    /// their square.
    #[inline(always)]
    fn measure_parallel(&mut self) {
        for k in 0..BATCH {
            let pair = self.axes(k);
            let Axes { a, b, c, e, f, .. } = pair;
            let (per_a, per_e) = (1.0 / a, 1.0 / e);
            let t = clamped((clamped((c * e - b * f) / (a * e - b * b)) * b - f) * per_e);
            let mut best = [clamped((c + t * b) * per_a), t];
            let mut least = pair.squared(best);
            for other in [
                [0.0, clamped(-f * per_e)],
                [1.0, clamped((b - f) * per_e)],
                [clamped(c * per_a), 0.0],
                [clamped((c + b) * per_a), 1.0],
            ] {
                let squared = pair.squared(other);
                best = if squared < least { other } else { best };
                least = if squared < least { squared } else { least };
            }
            let oblique = self.sines[k] >= PARALLEL_AXES;
            let [s, t] =
                [0, 1].map(|i| if oblique { self.closest.fractions[i][k] } else { best[i] });
            self.closest.set(k, [s, t], if oblique { self.closest.squared[k] } else { least });
        }
    }

    /// Finds the ends of axes that lie side by side, if they are more than a `radius` of the first,
    /// m, along it from where these are closest.
    #[inline(always)]
    pub(super) fn find_ends(&mut self, radius: &BatchScalars) {
        for k in 0..BATCH {
            let pair = self.axes(k);
            let Axes { a, b, c, e, f, .. } = pair;
            let (per_a, per_e) = (1.0 / a, 1.0 / e);
            let side_by_side = a * e - b * b < SIDE_BY_SIDE * a * e;
            for (along, ends) in [c, c + b].into_iter().zip(&mut self.ends) {
                let s = clamped(along * per_a);
                let t = clamped((s * b - f) * per_e);
                let way = s - self.closest.fractions[0][k];
                let other = side_by_side & (way * way * a > radius[k] * radius[k]);
                ends.set(k, [s, t], if other { pair.squared([s, t]) } else { f64::INFINITY });
            }
        }
    }
}

/// The axes of one pair with their products, named as in [`crate::Capsule::closest`].
pub(super) struct Axes {
    pub(super) first: [f64; 3],
    pub(super) second: [f64; 3],
    between: [f64; 3],
    a: f64,
    b: f64,
    c: f64,
    e: f64,
    f: f64,
}

impl Axes {
    /// From the point of the first at a fraction to that of the second, m.
    #[inline(always)]
    pub(super) fn offset(&self, [s, t]: [f64; 2]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.between[i] + t * self.second[i] - s * self.first[i])
    }

    /// Squared length of that, m².
    #[inline(always)]
    fn squared(&self, fractions: [f64; 2]) -> f64 {
        let offset = self.offset(fractions);
        dot(&offset, &offset)
    }
}

#[inline(always)]
fn dot(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline(always)]
fn positive(squared: f64) -> f64 {
    if squared > POINT { squared } else { POINT }
}

/// `x` moved into 0..=1.
#[inline(always)]
fn clamped(x: f64) -> f64 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}
