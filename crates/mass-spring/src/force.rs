//! Spring forces over runs of springs: loops without branches over arrays, for the widest vectors
//! that the processor has.

use crate::NodeVectors;
use crate::spring::{SpringRun, Springs};
use nalgebra::SVector;

/// Number of springs taken at a time; their data stay in the first cache.
const CHUNK: usize = 128;
/// Runs of fewer springs than this are computed spring by spring.
const SHORT: usize = 4;
/// Added to a squared length, so that the force of a spring of zero length is zero instead of
/// undefined.
pub(crate) const TINY: f64 = 1e-200;

/// Adds the forces of the springs of a run to the forces on their nodes.
#[inline(always)]
pub(crate) fn add_run<const D: usize>(
    springs: &Springs,
    run: &SpringRun,
    x: &NodeVectors<D>,
    v: &NodeVectors<D>,
    forces: &mut NodeVectors<D>,
) {
    if run.count < SHORT {
        for s in run.first..run.first + run.count {
            let [i, j] = springs.nodes[s];
            let force = force(springs, s, &(x.get(j) - x.get(i)), &(v.get(j) - v.get(i)));
            forces.add(i, &force);
            forces.add(j, &-force);
        }
        return;
    }
    for done in (0..run.count).step_by(CHUNK) {
        let count = CHUNK.min(run.count - done);
        let part =
            SpringRun { first: run.first + done, count, i: run.i + done, j: run.j + done, ..*run };
        match (springs.damped, run.uniform) {
            (false, true) => add_chunk::<D, false, true>(springs, &part, x, v, forces),
            (false, false) => add_chunk::<D, false, false>(springs, &part, x, v, forces),
            (true, true) => add_chunk::<D, true, true>(springs, &part, x, v, forces),
            (true, false) => add_chunk::<D, true, false>(springs, &part, x, v, forces),
        }
    }
}

/// The force of a spring on its first node, from the differences of the positions and velocities of
/// its nodes.
#[inline(always)]
pub(crate) fn force<const D: usize>(
    springs: &Springs,
    s: usize,
    apart: &SVector<f64, D>,
    parting: &SVector<f64, D>,
) -> SVector<f64, D> {
    let squared = apart.norm_squared() + TINY;
    let elastic = springs.stiffness[s] * (1.0 - springs.rest_length[s] / squared.sqrt());
    apart * (elastic + springs.damping[s] * parting.dot(apart) / squared)
}

#[inline(always)]
fn add_chunk<const D: usize, const DAMPED: bool, const UNIFORM: bool>(
    springs: &Springs,
    &SpringRun { first, count, i, j, .. }: &SpringRun,
    x: &NodeVectors<D>,
    v: &NodeVectors<D>,
    forces: &mut NodeVectors<D>,
) {
    let count = count.min(CHUNK);
    let [a, b] = [i, j].map(|node| std::array::from_fn::<_, D, _>(|k| &x.0[k][node..node + count]));
    let [va, vb] =
        [i, j].map(|node| std::array::from_fn::<_, D, _>(|k| &v.0[k][node..node + count]));
    let stiffness = &springs.stiffness[first..first + count];
    let rest_length = &springs.rest_length[first..first + count];
    let damping = &springs.damping[first..first + count];
    let mut pulls = [[0.0; CHUNK]; D];
    for s in 0..count {
        let of = if UNIFORM { 0 } else { s };
        let apart: [f64; D] = std::array::from_fn(|k| b[k][s] - a[k][s]);
        let squared = apart.iter().fold(TINY, |sum, d| sum + d * d);
        let mut factor = stiffness[of] * (1.0 - rest_length[of] / squared.sqrt());
        if DAMPED {
            let parting: f64 = (0..D).map(|k| apart[k] * (vb[k][s] - va[k][s])).sum();
            factor += damping[of] * parting / squared;
        }
        for k in 0..D {
            pulls[k][s] = factor * apart[k];
        }
    }
    for (pulls, forces) in pulls.iter().zip(&mut forces.0) {
        let to = &mut forces[i..i + count];
        for s in 0..count {
            to[s] += pulls[s];
        }
        let to = &mut forces[j..j + count];
        for s in 0..count {
            to[s] -= pulls[s];
        }
    }
}
