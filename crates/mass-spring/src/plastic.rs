use crate::System;

impl<const D: usize> System<D> {
    /// Lets springs beyond their yield strain give way for good: the rest length follows until the
    /// elastic strain is at the limit. Returns how many did; to be called after every step.
    ///
    /// In the third text pins deform plastically; this is perfect plasticity, for every spring by
    /// itself.
    pub fn give_way(&mut self) -> usize {
        let mut lengths = Vec::new();
        for (s, &[i, j]) in self.springs.nodes.iter().enumerate() {
            let limit = self.springs.yield_strain[s];
            if limit == f64::INFINITY {
                continue;
            }
            let length = (self.positions.get(j) - self.positions.get(i)).norm();
            let strain = length / self.springs.rest_length[s] - 1.0;
            // In compression by more than all there is no length to go to.
            if strain > limit || (strain < -limit && length > 0.0) {
                lengths.push((s, length / (1.0 + limit.copysign(strain))));
            }
        }
        let count = lengths.len();
        for (s, length) in lengths {
            self.springs.rest_length[s] = length;
        }
        if count > 0 {
            self.springs.refresh();
        }
        count
    }
}
