//! Distances of many pairs of axes, several at a time.

use super::batch::{BATCH, PairBatch};
use crate::{Capsules, Pair};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Batches that one thread takes at a time.
const DISTANCE_CHUNK: usize = 32 * BATCH;

/// Squared distances of the axes of all `pairs`, m², as [`crate::Capsule::closest`] finds them.
///
/// `distances` is overwritten. The results differ from those of `closest` by roundings alone: a
/// distance `d` of segments of length `L` by `1e-13 L` at most. Cost: 10 ns a pair.
///
/// # Panics
/// If a pair names a segment that does not exist, as indexing does.
pub fn squared_distances(capsules: &Capsules, pairs: &[Pair], distances: &mut Vec<f64>) {
    distances.resize(pairs.len(), 0.0);
    let chunks = pairs.par_chunks(DISTANCE_CHUNK).zip(distances.par_chunks_mut(DISTANCE_CHUNK));
    chunks.for_each(|(pairs, distances)| {
        Arch::new().dispatch(DistanceQuery { capsules, pairs, distances });
    });
}

struct DistanceQuery<'a> {
    capsules: &'a Capsules<'a>,
    pairs: &'a [Pair],
    distances: &'a mut [f64],
}

impl NullaryFnOnce for DistanceQuery<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut batch = PairBatch::default();
        for (pairs, distances) in self.pairs.chunks(BATCH).zip(self.distances.chunks_mut(BATCH)) {
            batch.gather(self.capsules, pairs);
            batch.measure();
            distances.copy_from_slice(&batch.closest.squared[..pairs.len()]);
        }
    }
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
