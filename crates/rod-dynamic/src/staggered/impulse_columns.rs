use super::array::{Array, fit, zeros};
use pulp::Simd;

/// Three sets of impulses on all nodes and segments, which are replaced by mean velocities and
/// angular velocities: `3 a + k` is the vector of node or segment `a` in set `k`.
pub(super) struct ImpulseColumns<S: Simd> {
    pub(super) values: Array<S>,
    pub(super) turns: Array<S>,
    pub(super) loads: Array<S>,
    pub(super) solution: Array<S>,
}

impl<S: Simd> ImpulseColumns<S> {
    pub(super) fn empty() -> Self {
        let none = || zeros::<S>(0);
        Self { values: none(), turns: none(), loads: none(), solution: none() }
    }

    /// Resizes all arrays to rods of `n` segments.
    pub(super) fn fit(&mut self, n: usize) {
        fit::<S>(&mut self.values, 9 * (n + 1));
        fit::<S>(&mut self.turns, 9 * n);
        fit::<S>(&mut self.loads, 18 * n);
        fit::<S>(&mut self.solution, 18 * n);
    }
}
