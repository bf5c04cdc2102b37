//! Sixteen boxes side by side, and which of them meet another.

use super::bounds::Bounds;
use pulp::Simd;
use rapunzel_lanes::LANES_F32;

/// Sixteen boxes. A lane that holds none is NaN, which no comparison accepts.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Block<const D: usize = 3> {
    pub(super) low: [[f32; LANES_F32]; D],
    pub(super) high: [[f32; LANES_F32]; D],
}

impl<const D: usize> Block<D> {
    /// No box at all.
    pub(super) const EMPTY: Self =
        Self { low: [[f32::NAN; LANES_F32]; D], high: [[f32::NAN; LANES_F32]; D] };

    pub(super) fn set(&mut self, lane: usize, bounds: &Bounds<D>) {
        for d in 0..D {
            self.low[d][lane] = bounds.low[d];
            self.high[d][lane] = bounds.high[d];
        }
    }

    pub(super) fn clear(&mut self, lane: usize) {
        for d in 0..D {
            self.low[d][lane] = f32::NAN;
            self.high[d][lane] = f32::NAN;
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Bounds<D> {
        let mut bounds = Bounds::EMPTY;
        for d in 0..D {
            bounds.low[d] = self.low[d][lane];
            bounds.high[d] = self.high[d][lane];
        }
        bounds
    }
}

/// How sixteen boxes are compared at once.
pub(super) trait Compare: Copy {
    /// The lanes of `block` whose boxes meet `bounds`, as bits; touching is meeting.
    fn meet<const D: usize>(self, block: &Block<D>, bounds: &Bounds<D>) -> u16;

    /// The lanes of `nodes` that differ from `node` by at most one, as bits; also those that do
    /// so across the end of the range, where lanes are empty.
    fn adjacent(self, nodes: &[u32; LANES_F32], node: u32) -> u16;
}

/// Comparison that compilers turn into what the machine has.
#[derive(Clone, Copy)]
pub(super) struct PortableCompare;

impl Compare for PortableCompare {
    #[inline(always)]
    fn meet<const D: usize>(self, block: &Block<D>, bounds: &Bounds<D>) -> u16 {
        let mut meet = [true; LANES_F32];
        for d in 0..D {
            for lane in 0..LANES_F32 {
                meet[lane] &= block.low[d][lane] <= bounds.high[d];
                meet[lane] &= block.high[d][lane] >= bounds.low[d];
            }
        }
        bits(&meet)
    }

    #[inline(always)]
    fn adjacent(self, nodes: &[u32; LANES_F32], node: u32) -> u16 {
        let mut adjacent = [false; LANES_F32];
        for lane in 0..LANES_F32 {
            adjacent[lane] = nodes[lane].wrapping_sub(node).wrapping_add(1) <= 2;
        }
        bits(&adjacent)
    }
}

#[inline(always)]
fn bits(lanes: &[bool; LANES_F32]) -> u16 {
    let mut bits = 0;
    for lane in 0..LANES_F32 {
        bits |= u16::from(lanes[lane]) << lane;
    }
    bits
}

/// Comparison with mask registers. What is wanted is the mask as bits, and of integers too, at one
/// width only: none of this is arithmetic by lanes of any width.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(super) struct Masks(pub(super) pulp::x86::V4);

#[cfg(target_arch = "x86_64")]
impl Compare for Masks {
    #[inline(always)]
    fn meet<const D: usize>(self, block: &Block<D>, bounds: &Bounds<D>) -> u16 {
        let Self(simd) = self;
        let mut meet = u16::MAX;
        for d in 0..D {
            let (low, high) = (pulp::cast(block.low[d]), pulp::cast(block.high[d]));
            meet &= simd.cmp_le_f32x16(low, simd.splat_f32s(bounds.high[d])).0;
            meet &= simd.cmp_ge_f32x16(high, simd.splat_f32s(bounds.low[d])).0;
        }
        meet
    }
    #[inline(always)]
    fn adjacent(self, nodes: &[u32; LANES_F32], node: u32) -> u16 {
        let Self(simd) = self;
        let before = simd.splat_u32s(node.wrapping_sub(1));
        let ahead = simd.wrapping_sub_u32x16(pulp::cast(*nodes), before);
        simd.cmp_le_u32x16(ahead, simd.splat_u32s(2)).0
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn corner() -> impl Strategy<Value = [f32; 3]> {
        prop::array::uniform3(prop_oneof![(-2..=2_i8).prop_map(f32::from), -2.0..2.0_f32])
    }

    proptest! {
        /// Mask registers give what the portable comparison gives, and both what it means.
        #[test]
        fn comparisons_agree(
            boxes in prop::collection::vec((corner(), corner()), 1..=LANES_F32),
            low in corner(), high in corner(),
            nodes in prop::array::uniform16(1..9_u32),
            node in 1..9_u32,
        ) {
            let bounds = Bounds { low, high };
            let mut block = Block::EMPTY;
            let (mut meet, mut adjacent) = (0, 0);
            for (lane, &(low, high)) in boxes.iter().enumerate() {
                block.set(lane, &Bounds { low, high });
                let meets = (0..3).all(|d| low[d] <= bounds.high[d] && high[d] >= bounds.low[d]);
                meet |= u16::from(meets) << lane;
            }
            for (lane, other) in nodes.iter().enumerate() {
                adjacent |= u16::from(other.abs_diff(node) <= 1) << lane;
            }
            prop_assert_eq!(PortableCompare.meet(&block, &bounds), meet);
            prop_assert_eq!(PortableCompare.adjacent(&nodes, node), adjacent);
            if let Some(simd) = pulp::x86::V4::try_new() {
                prop_assert_eq!(Masks(simd).meet(&block, &bounds), meet);
                prop_assert_eq!(Masks(simd).adjacent(&nodes, node), adjacent);
            }
        }
    }
}
