//! Pairs of close segments in closed form.

use super::lines::{Lines, Loads};
use super::skew::{Means, parallel, skew};
use crate::lanes::{LANES, Lanes};
use crate::machine::{Kernel, Roots, dispatch};
use crate::multipole::engine::Task;
use nalgebra::Vector3;
use pulp::Simd;

/// Adds to the loads of `task` those of the `pairs` of its bodies with others. Of a pair within a
/// complete task, which stands in `pairs` once, it adds both.
///
/// Pairs whose angle has a smaller sine than `sine` are taken as [`parallel`].
pub(super) fn add_close(lines: &Lines, pairs: &[[usize; 2]], sine: f64, task: Task<Loads>) {
    let tangent = |k: usize| Vector3::from_fn(|c, _| lines.tangent[c][k]);
    let askew = |[i, j]: &[usize; 2]| tangent(*i).cross(&tangent(*j)).norm_squared() >= sine * sine;
    let (askew, parallel): (Vec<_>, Vec<_>) = pairs.iter().copied().partition(askew);
    dispatch(Close { lines, askew, parallel, sine, task });
}

struct Close<'a> {
    lines: &'a Lines,
    askew: Vec<[usize; 2]>,
    parallel: Vec<[usize; 2]>,
    sine: f64,
    task: Task<'a, Loads>,
}

impl Kernel for Close<'_> {
    #[inline(always)]
    fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
        let Self { lines, askew, parallel: aligned, sine, mut task } = self;
        for pairs in askew.chunks(S::F64_LANES) {
            let batch = Batch::new(lines, pairs);
            let [first, second] = batch.indices.map(|k| lines.gather(simd, &k));
            let means = skew(roots, &first, &second, Lanes::load(simd, &batch.softening));
            batch.add(pairs, &means, &mut task);
        }
        for pairs in aligned.chunks(S::F64_LANES) {
            let batch = Batch::new(lines, pairs);
            let [first, second] = batch.indices.map(|k| lines.gather(simd, &k));
            let softening = Lanes::load(simd, &batch.softening);
            let means = parallel(roots, &first, &second, softening, softening.of(sine));
            batch.add(pairs, &means, &mut task);
        }
    }
}

/// A pair in each lane; those without one repeat the first.
struct Batch {
    indices: [[usize; LANES]; 2],
    charges: [f64; LANES],
    softening: [f64; LANES],
}

impl Batch {
    fn new(lines: &Lines, pairs: &[[usize; 2]]) -> Self {
        let pair = |k: usize| pairs.get(k).copied().unwrap_or(pairs[0]);
        Self {
            indices: [0, 1].map(|side| std::array::from_fn(|k| pair(k)[side])),
            charges: std::array::from_fn(|k| pair(k).iter().map(|i| lines.charge[*i]).product()),
            softening: std::array::from_fn(|k| lines.softening(pair(k)[0], pair(k)[1])),
        }
    }

    #[inline(always)]
    fn add<S: Simd>(&self, pairs: &[[usize; 2]], means: &Means<S>, task: &mut Task<Loads>) {
        let charges = Lanes::load(means.energy.simd, &self.charges);
        let energy = (means.energy * charges).store();
        let mut forces = [[0.0; LANES]; 9];
        for c in 0..3 {
            forces[c] = (means.force[c] * charges).store();
            forces[3 + c] = (means.first_end[c] * charges).store();
            forces[6 + c] = (means.second_end[c] * charges).store();
        }
        for (k, &[i, j]) in pairs.iter().enumerate() {
            let own = task.of_body(i);
            own[0] += 0.5 * energy[k];
            for c in 0..3 {
                own[1 + c] += forces[c][k] - forces[3 + c][k];
                own[4 + c] += forces[3 + c][k];
            }
            if task.both(j) {
                let other = task.of_body(j);
                other[0] += 0.5 * energy[k];
                for c in 0..3 {
                    other[1 + c] -= forces[c][k] - forces[6 + c][k];
                    other[4 + c] -= forces[6 + c][k];
                }
            }
        }
    }
}
