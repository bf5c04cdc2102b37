//! Distances of many pairs of axes, several at a time.

use crate::{Capsules, Pair};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Pairs whose ends are gathered at a time: few enough to stay close to the processor.
const BATCH: usize = 64;
/// Batches that one thread takes at a time.
const CHUNK: usize = 32 * BATCH;
/// Axes that enclose less than this angle count as nearly parallel; its squared sine.
const PARALLEL: f64 = 1e-6;
/// Squared lengths below this are those of points, m²: their products stay normal numbers.
const POINT: f64 = 1e-70;

/// Squared distances of the axes of all `pairs`, m², as [`crate::Capsule::closest`] finds them.
///
/// `distances` is overwritten. The results differ from those of `closest` by roundings alone: a
/// distance `d` of segments of length `L` by `1e-13 L` at most. Cost: 10 ns a pair.
///
/// # Panics
/// If a pair names a segment that does not exist, as indexing does.
pub fn squared_distances(capsules: &Capsules, pairs: &[Pair], distances: &mut Vec<f64>) {
    distances.resize(pairs.len(), 0.0);
    let chunks = pairs.par_chunks(CHUNK).zip(distances.par_chunks_mut(CHUNK));
    chunks.for_each(|(pairs, distances)| {
        Arch::new().dispatch(Measure { capsules, pairs, distances });
    });
}

struct Measure<'a> {
    capsules: &'a Capsules<'a>,
    pairs: &'a [Pair],
    distances: &'a mut [f64],
}

impl NullaryFnOnce for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut batch = Batch::default();
        for (pairs, distances) in self.pairs.chunks(BATCH).zip(self.distances.chunks_mut(BATCH)) {
            batch.gather(self.capsules, pairs);
            if !batch.measure() {
                batch.measure_parallel();
            }
            distances.copy_from_slice(&batch.squared[..pairs.len()]);
        }
    }
}

/// The axes of a batch of pairs: from the start of the first to its end, from the start of the
/// second to its end, and from start to start.
struct Batch {
    first: [[f64; BATCH]; 3],
    second: [[f64; BATCH]; 3],
    between: [[f64; BATCH]; 3],
    squared: [f64; BATCH],
    /// Squared sines of the angles between the axes.
    sines: [f64; BATCH],
}

impl Default for Batch {
    fn default() -> Self {
        let zero = [[0.0; BATCH]; 3];
        let (squared, sines) = ([0.0; BATCH], [0.0; BATCH]);
        Self { first: zero, second: zero, between: zero, squared, sines }
    }
}

impl Batch {
    #[inline(always)]
    fn gather(&mut self, capsules: &Capsules, pairs: &[Pair]) {
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
    fn axes(&self, k: usize) -> Axes {
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

    /// Sets all squared distances; whether these are good for all, as no axes are nearly parallel
    /// (or so large that their squares overflow).
    #[inline(always)]
    fn measure(&mut self) -> bool {
        let mut oblique = true;
        for k in 0..BATCH {
            let pair = self.axes(k);
            let Axes { a, b, c, e, f, .. } = pair;
            // One division for all three fractions.
            let determinant = a * e - b * b;
            let parallel = PARALLEL * a * e;
            let safe = if determinant > parallel { determinant } else { parallel };
            let inverse = 1.0 / (a * e * safe);
            let per_a = inverse * e * safe;
            let per_e = inverse * a * safe;
            let s = clamped((c * e - b * f) * (inverse * a * e));
            let t = clamped((s * b - f) * per_e);
            let s = clamped((c + t * b) * per_a);
            self.squared[k] = pair.squared(s, t);
            let sine = determinant * inverse * safe;
            self.sines[k] = sine;
            oblique &= sine >= PARALLEL;
        }
        oblique
    }

    /// Measures those again for which the fast way is not good: the squared distance is convex in
    /// the two fractions, so its least value lies where the lines come closest or on a side of their
    /// square.
    #[inline(always)]
    fn measure_parallel(&mut self) {
        for k in 0..BATCH {
            let pair = self.axes(k);
            let Axes { a, b, c, e, f, .. } = pair;
            let (per_a, per_e) = (1.0 / a, 1.0 / e);
            let t = clamped((clamped((c * e - b * f) / (a * e - b * b)) * b - f) * per_e);
            let mut least = pair.squared(clamped((c + t * b) * per_a), t);
            for other in [
                pair.squared(0.0, clamped(-f * per_e)),
                pair.squared(1.0, clamped((b - f) * per_e)),
                pair.squared(clamped(c * per_a), 0.0),
                pair.squared(clamped((c + b) * per_a), 1.0),
            ] {
                least = if other < least { other } else { least };
            }
            let oblique = self.sines[k] >= PARALLEL;
            self.squared[k] = if oblique { self.squared[k] } else { least };
        }
    }
}

/// The axes of one pair with their products, named as in [`crate::Capsule::closest`].
struct Axes {
    first: [f64; 3],
    second: [f64; 3],
    between: [f64; 3],
    a: f64,
    b: f64,
    c: f64,
    e: f64,
    f: f64,
}

impl Axes {
    /// Squared distance of the points at fractions `s` and `t`.
    #[inline(always)]
    fn squared(&self, s: f64, t: f64) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|i| self.between[i] + t * self.second[i] - s * self.first[i]);
        x * x + y * y + z * z
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

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use proptest::prelude::*;
    use rapunzel_fiber::Layout;

    /// Coordinates that often coincide, so that segments are parallel, collinear, or points.
    fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
        let x = prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64, -1e-7..1e-7_f64];
        prop::collection::vec(prop::array::uniform3(x).prop_map(Point3::from), 2..40)
    }

    proptest! {
        #[test]
        fn many_distances_are_those_of_single_pairs(points in points()) {
            let count = points.len() / 2;
            let layout = Layout::new(std::iter::repeat_n(1, count));
            let radii = vec![1.0; count];
            let capsules = Capsules::new(&layout, &points[..2 * count], &radii).expect("valid");
            let pairs: Vec<Pair> = (0..u32::try_from(count).expect("few"))
                .flat_map(|j| (0..=j).map(move |i| [i, j]))
                .collect();
            let mut squared = Vec::new();
            squared_distances(&capsules, &pairs, &mut squared);
            for (&[i, j], squared) in pairs.iter().zip(squared) {
                let expected = capsules.get(i as usize).closest(&capsules.get(j as usize)).distance();
                // Segments are shorter than 7.
                prop_assert!((squared.sqrt() - expected).abs() < 1e-12, "{i} {j}");
            }
        }
    }

    #[test]
    fn what_is_too_large_to_square_is_far_apart() {
        let layout = Layout::new([1, 1]);
        let far = [[0.0; 3], [1e200, 0.0, 0.0], [0.0, 1e200, 0.0], [1.0, 1e200, 1e200]];
        let points = far.map(Point3::from);
        let capsules = Capsules::new(&layout, &points, &[1.0; 2]).expect("valid");
        let mut squared = Vec::new();
        squared_distances(&capsules, &[[0, 1]], &mut squared);
        assert_eq!(squared, [f64::INFINITY]);
    }
}
