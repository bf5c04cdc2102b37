//! Pairs of close segments in closed form, a source in each lane.

use super::lines::{Loads, SegmentLines};
use super::parallel::Parallel;
use super::skew::{LineMeans, skew};
use crate::multipole::downward::Task;
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES, Lane, Machine, dispatch};

/// Adds to the loads of `task` the actions of the `pairs` of its bodies with others; pairs of one
/// body stand after each other. Of a pair within a complete task, which stands in `pairs` once, it
/// adds both.
///
/// Pairs that are nearly `parallel` are taken as such.
pub(super) fn add_close(
    lines: &SegmentLines,
    pairs: &[[usize; 2]],
    parallel: &Parallel,
    task: Task<Loads>,
) {
    dispatch(ClosePairs { lines, pairs, parallel, task });
}

/// Arguments of [`add_close`].
struct ClosePairs<'a> {
    lines: &'a SegmentLines,
    pairs: &'a [[usize; 2]],
    parallel: &'a Parallel,
    task: Task<'a, Loads>,
}

impl Kernel for ClosePairs<'_> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { lines, pairs, parallel, mut task } = self;
        let sine2 = parallel.sine() * parallel.sine();
        let (mut askew, mut aligned) = (Vec::new(), Vec::new());
        for pairs in pairs.chunk_by(|a, b| a[0] == b[0]) {
            let i = pairs[0][0];
            let first = lines.gather(simd, &[i; LANES]);
            askew.clear();
            for &[i, j] in pairs {
                let list = if lines.sine2(i, j) < sine2 { &mut aligned } else { &mut askew };
                list.push([i, j]);
            }
            let mut loads = [Lane::splat(simd, 0.0); 7];
            for pairs in askew.chunks(S::F64_LANES) {
                let batch = NearBatch::new(lines, pairs, &task);
                let second = lines.gather(simd, &batch.indices[1]);
                let means = skew(machine, &first, &second, Lane::load(simd, &batch.softening, 0));
                for (sum, load) in loads.iter_mut().zip(batch.add(pairs, &means, &mut task)) {
                    *sum = *sum + load;
                }
            }
            for (sum, load) in task.of_body(i).iter_mut().zip(loads) {
                *sum += load.reduce_sum();
            }
        }
        for pairs in aligned.chunks(S::F64_LANES) {
            let batch = NearBatch::new(lines, pairs, &task);
            let [first, second] = batch.indices.map(|k| lines.gather(simd, &k));
            let softening = Lane::load(simd, &batch.softening, 0);
            let means = parallel.means(machine, &first, &second, softening);
            let loads = batch.add(pairs, &means, &mut task);
            for (k, [i, _]) in pairs.iter().enumerate() {
                for (sum, load) in task.of_body(*i).iter_mut().zip(&loads) {
                    *sum += load.numbers()[k];
                }
            }
        }
    }
}

/// Pairs of close segments, one in each lane; lanes without one repeat the first, without charge.
struct NearBatch {
    /// Indices of the first and of the second of each pair.
    indices: [[usize; LANES]; 2],
    /// Product of the charges of each pair.
    charges: [f64; LANES],
    /// Square of the length that the distance of each pair is softened with, m^2.
    softening: [f64; LANES],
    /// Share of the energy of each pair that is added to the first.
    shares: [f64; LANES],
}

impl NearBatch {
    /// Batch of the `pairs`, at most one for each lane.
    fn new(lines: &SegmentLines, pairs: &[[usize; 2]], task: &Task<Loads>) -> Self {
        let pair = |k: usize| pairs.get(k).copied().unwrap_or(pairs[0]);
        let charge =
            |k: usize| pairs.get(k).map_or(0.0, |[i, j]| lines.charge(*i) * lines.charge(*j));
        Self {
            indices: [0, 1].map(|side| std::array::from_fn(|k| pair(k)[side])),
            charges: std::array::from_fn(charge),
            softening: std::array::from_fn(|k| lines.softening(pair(k)[0], pair(k)[1])),
            shares: std::array::from_fn(|k| if task.both(pair(k)[1]) { 1.0 } else { 0.5 }),
        }
    }

    /// Loads of the first of each pair; adds those of the second to `task` where they are found
    /// here as well.
    #[inline(always)]
    fn add<S: Simd>(
        &self,
        pairs: &[[usize; 2]],
        means: &LineMeans<S>,
        task: &mut Task<Loads>,
    ) -> [Lane<S>; 7] {
        let charges = Lane::load(means.energy.simd(), &self.charges, 0);
        let mut loads = [means.energy * charges * Lane::load(charges.simd(), &self.shares, 0); 7];
        let mut felt = [[0.0; LANES]; 6];
        for c in 0..3 {
            let (force, end) = (means.force[c] * charges, means.first_end[c] * charges);
            let other_end = means.second_end[c] * charges;
            loads[1 + c] = force - end;
            loads[4 + c] = end;
            (force - other_end).store(&mut felt[c], 0);
            other_end.store(&mut felt[3 + c], 0);
        }
        for (k, &[_, j]) in pairs.iter().enumerate() {
            if task.both(j) {
                for (load, felt) in task.of_body(j)[1..].iter_mut().zip(&felt) {
                    *load -= felt[k];
                }
            }
        }
        loads
    }
}
