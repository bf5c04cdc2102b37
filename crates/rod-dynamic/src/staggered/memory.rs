//! Saving and restoring the state of a batch, whole or of one lane.

use super::array::{at, set, zeros};
use super::chain::RotationChain;
use super::ends::Ends;
use super::history::KinematicHistory;
use super::simd_batch::SimdBatch;
use pulp::Simd;
use rapunzel_lanes::LANES;

/// Saving and restoring of a batch: the numbers of its state, and the start of the step under way.
pub(super) trait BatchMemory {
    /// Number of scalars in the state of the lane.
    fn numbers(&self, lane: usize) -> usize;
    /// Appends all numbers of the lane's state.
    fn save(&self, lane: usize, numbers: &mut Vec<f64>);
    /// Restores the lane's state from the front of `numbers`, and returns the rest.
    fn restore<'a>(&mut self, lane: usize, numbers: &'a [f64]) -> &'a [f64];
    /// Saves the state that attempts change, for [`BatchMemory::undo`] and
    /// [`BatchMemory::undo_all`], and clears impulses.
    fn remember(&mut self);
    /// Restores only the rotations and the tip reaction of one lane.
    fn undo(&mut self, lane: usize);
    /// Restores the saved state of all lanes, as long as no step has been committed, and removes
    /// the accelerations of lanes that were `fresh`.
    fn undo_all(&mut self, fresh: &[bool; LANES]);
    /// Sets all velocities and accelerations of the lane to zero.
    fn stop(&mut self, lane: usize);
}

impl<S: Simd> BatchMemory for SimdBatch<S> {
    fn numbers(&self, lane: usize) -> usize {
        let own: usize = self.arrays().iter().map(|a| a.len()).sum();
        own + self.chain.laws.as_ref().map_or(0, |laws| laws.numbers(lane))
    }

    fn save(&self, lane: usize, numbers: &mut Vec<f64>) {
        for array in self.arrays() {
            numbers.extend((0..array.len()).map(|i| at(array, i, lane)));
        }
        self.chain.laws.iter().for_each(|laws| laws.save(lane, numbers));
    }

    fn restore<'a>(&mut self, lane: usize, mut numbers: &'a [f64]) -> &'a [f64] {
        for array in self.arrays_mut() {
            let (head, tail) = numbers.split_at(array.len());
            for (i, x) in head.iter().enumerate() {
                set(array, i, lane, *x);
            }
            numbers = tail;
        }
        self.set_nozzle(lane, self.inside(lane));
        // Where it bore, nobody may have needed them.
        self.knows_accelerations = false;
        self.chain.laws.iter_mut().fold(numbers, |numbers, laws| laws.restore(lane, numbers))
    }

    fn remember(&mut self) {
        self.before.q.copy_from_slice(&self.chain.q);
        self.before.force.copy_from_slice(&self.chain.force);
        self.before.phi = zeros::<S>(0);
        self.before.ends = self.chain.ends;
        self.chain.laws.iter_mut().for_each(|laws| laws.remember());
        self.clear_impulses();
        self.weighted.take_if(|weighted| !std::mem::take(&mut weighted.used));
    }

    fn undo(&mut self, lane: usize) {
        for i in 0..self.before.q.len() {
            set(&mut self.chain.q, i, lane, at(&self.before.q, i, lane));
        }
        for i in 0..3 {
            let reaction = at(&self.before.ends.tip_reaction, i, lane);
            set(&mut self.chain.ends.tip_reaction, i, lane, reaction);
        }
    }

    fn undo_all(&mut self, fresh: &[bool; LANES]) {
        self.chain.q.copy_from_slice(&self.before.q);
        self.chain.force.copy_from_slice(&self.before.force);
        self.chain.ends.put_back(&self.before.ends);
        for lane in 0..S::F64_LANES {
            self.set_nozzle(lane, self.inside(lane));
        }
        if !self.before.phi.is_empty() {
            self.phi.copy_from_slice(&self.before.phi);
        }
        for lane in (0..S::F64_LANES).filter(|&lane| fresh[lane]) {
            let tracks = [&mut self.nodes, &mut self.directors, &mut self.joints];
            tracks.into_iter().for_each(|track| track.forget(lane));
        }
        self.chain.laws.iter_mut().for_each(|laws| laws.undo_all());
    }

    fn stop(&mut self, lane: usize) {
        let tracks = [&mut self.nodes, &mut self.directors, &mut self.joints];
        for array in tracks.into_iter().flat_map(KinematicHistory::arrays_mut) {
            for i in 0..array.len() {
                set(array, i, lane, 0.0);
            }
        }
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Every array that a lane's future depends on, except the memory of section laws.
    pub(super) fn arrays(&self) -> [&[S::f64s]; 19] {
        let [a, b, c] = self.nodes.arrays();
        let [d, e, f] = self.directors.arrays();
        let [g, h, i] = self.joints.arrays();
        let RotationChain { start, q, force, ends, .. } = &self.chain;
        let flags =
            [&ends.root_free, &ends.root_joint, &ends.tip_held, &ends.tip_joint, &ends.inside];
        let [j, k, l, m, x] = flags.map(std::slice::from_ref);
        let phi = &self.phi;
        [a, b, c, d, e, f, g, h, i, j, k, l, m, x, start, phi, q, force, &ends.tip_reaction]
    }

    /// Every array that a lane's future depends on, mutable, in the order of [`Self::arrays`].
    pub(super) fn arrays_mut(&mut self) -> [&mut [S::f64s]; 19] {
        let [a, b, c] = self.nodes.arrays_mut();
        let [d, e, f] = self.directors.arrays_mut();
        let [g, h, i] = self.joints.arrays_mut();
        let RotationChain { start, q, force, ends, .. } = &mut self.chain;
        let Ends { root_free, root_joint, tip_held, tip_joint, tip_reaction, inside, .. } = ends;
        let flags = [root_free, root_joint, tip_held, tip_joint, inside];
        let [j, k, l, m, x] = flags.map(std::slice::from_mut);
        let phi = &mut self.phi;
        [a, b, c, d, e, f, g, h, i, j, k, l, m, x, start, phi, q, force, tip_reaction]
    }
}
