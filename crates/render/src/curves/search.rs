use super::capsules::{CapsuleBlock, MovingEnds};
use super::store::CurveStore;
use super::tube::{CurveHit, enter};
use crate::Ray;
use crate::tree::{Leaves, SignBits, TreeRay, WIDTH, single};
use pulp::Simd;

/// The tubes in the leaves of a tree, for one ray.
pub(super) struct CurveSearch<'a> {
    pub(super) store: &'a CurveStore,
    pub(super) blocks: &'a [CapsuleBlock],
    /// Where something moves.
    pub(super) moving: &'a [MovingEnds],
    pub(super) ray: &'a Ray,
    /// Where the ray begins and ends, m.
    pub(super) range: [f64; 2],
    /// Two directions across the ray.
    pub(super) across: [[f32; 3]; 2],
}

impl Leaves for CurveSearch<'_> {
    type Found = CurveHit;

    #[inline(always)]
    fn meet<S: Simd, B: SignBits>(
        &mut self,
        registers: (S, B),
        leaf: usize,
        ray: &mut TreeRay,
    ) -> Option<CurveHit> {
        let mut at = [0.0; WIDTH];
        let block = &self.blocks[leaf];
        let moving = match self.moving.get(leaf) {
            Some(ways) => Some((ways, single(&[self.ray.time])[0])),
            None => None,
        };
        let mut met = block.meet(registers, ray, &self.across, moving, &mut at);
        let mut found = None;
        while met != 0 {
            let lane = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            let part = block.part(lane);
            let [start, length] = part.range();
            let tube = self.store.tube(part.piece() as usize, self.ray.time, &self.ray.origin);
            let guess = start + f64::from(at[lane]) * length;
            if let Some([distance, parameter]) = enter(&tube, &self.ray.direction, guess) {
                let [first, last] = self.range;
                if distance > first && distance < last {
                    self.range[1] = distance;
                    ray.shorten(distance);
                    found = Some(CurveHit { distance, piece: part.piece(), parameter });
                }
            }
        }
        found
    }
}
