//! Boxes fitted to where the segments are now.

use super::block::Block;
use super::bounds::{Bounds, above, below};
use super::{Diagonals, NONE, TreeLevel};
use crate::Capsules;
use pulp::{Arch, NullaryFnOnce};
use rapunzel_lanes::LANES_F32;
use rayon::prelude::*;

/// Blocks that one thread fits at a time.
const REFIT_CHUNK: usize = 64;

impl TreeLevel {
    /// Fits the boxes of those blocks of the lowest level that are `wanted` to the segments of all
    /// `frames`, grown by `margin`, m; `nodes` are the first nodes of the segments in the lanes.
    pub(super) fn fit_segments<const N: usize>(
        &mut self,
        diagonals: Option<&mut Diagonals>,
        nodes: &[[u32; LANES_F32]],
        frames: [&Capsules; N],
        margin: f64,
        wanted: &[bool],
    ) {
        let boxes =
            self.blocks.par_chunks_mut(REFIT_CHUNK).zip(self.hulls.par_chunks_mut(REFIT_CHUNK));
        let lanes = self.children.par_chunks(REFIT_CHUNK).zip(nodes.par_chunks(REFIT_CHUNK));
        let lanes = lanes.zip(wanted.par_chunks(REFIT_CHUNK));
        let Some(Diagonals { blocks, hulls }) = diagonals else {
            return boxes.zip(lanes).for_each(|(along, (lanes, wanted))| {
                let oblique = None;
                Arch::new().dispatch(Fit { along, oblique, lanes, wanted, frames, margin });
            });
        };
        let oblique = blocks.par_chunks_mut(REFIT_CHUNK).zip(hulls.par_chunks_mut(REFIT_CHUNK));
        boxes.zip(oblique).zip(lanes).for_each(|((along, oblique), (lanes, wanted))| {
            let oblique = Some(oblique);
            Arch::new().dispatch(Fit { along, oblique, lanes, wanted, frames, margin });
        });
    }

    /// Fits the boxes of a higher level to the hulls of the blocks below.
    pub(super) fn fit_hulls(&mut self, below: &[Bounds]) {
        let blocks =
            self.blocks.par_chunks_mut(REFIT_CHUNK).zip(self.hulls.par_chunks_mut(REFIT_CHUNK));
        blocks.zip(self.children.par_chunks(REFIT_CHUNK)).for_each(
            |((blocks, hulls), children)| {
                for ((block, hull), children) in blocks.iter_mut().zip(hulls).zip(children) {
                    *hull = Bounds::EMPTY;
                    for (lane, &child) in
                        children.iter().enumerate().take_while(|(_, c)| **c != NONE)
                    {
                        block.set(lane, &below[child as usize]);
                        hull.hold(&below[child as usize]);
                    }
                }
            },
        );
    }
}

struct Fit<'a, const N: usize> {
    along: (&'a mut [Block], &'a mut [Bounds]),
    oblique: Option<(&'a mut [Block<6>], &'a mut [Bounds<6>])>,
    /// Segments and their first nodes.
    lanes: (&'a [[u32; LANES_F32]], &'a [[u32; LANES_F32]]),
    wanted: &'a [bool],
    frames: [&'a Capsules<'a>; N],
    margin: f64,
}

impl<const N: usize> NullaryFnOnce for Fit<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { along, mut oblique, .. } = self;
        for (b, (segments, nodes)) in self.lanes.0.iter().zip(self.lanes.1).enumerate() {
            if !self.wanted[b] {
                continue;
            }
            let ends = LaneEnds::gather(segments, nodes, self.frames, self.margin);
            ends.fit(segments, &mut along.0[b], &mut along.1[b]);
            if let Some((blocks, hulls)) = &mut oblique {
                ends.along_diagonals().fit(segments, &mut blocks[b], &mut hulls[b]);
            }
        }
    }
}

/// Ends of the segments in the lanes of a block in every frame, and by how much boxes are larger
/// than axes, m.
struct LaneEnds<const N: usize, const D: usize = 3> {
    start: [LaneCoordinates<D>; N],
    end: [LaneCoordinates<D>; N],
    grow: [f64; LANES_F32],
}

impl<const N: usize> LaneEnds<N> {
    /// Gathers segment by segment; lanes without one repeat the first.
    #[inline(always)]
    fn gather(
        segments: &[u32; LANES_F32],
        nodes: &[u32; LANES_F32],
        frames: [&Capsules; N],
        margin: f64,
    ) -> Self {
        let zero = [[[0.0; LANES_F32]; 3]; N];
        let mut ends = Self { start: zero, end: zero, grow: [0.0; LANES_F32] };
        for lane in 0..LANES_F32 {
            let used = if segments[lane] == NONE { 0 } else { lane };
            let node = nodes[used] as usize;
            for k in 0..N {
                let positions = frames[k].positions();
                for d in 0..3 {
                    ends.start[k][d][lane] = positions[node][d];
                    ends.end[k][d][lane] = positions[node + 1][d];
                }
            }
            ends.grow[lane] = frames[0].radii()[segments[used] as usize] + margin;
        }
        ends
    }

    /// The same along the diagonals of the axes' planes, as sums and differences of coordinates.
    #[inline(always)]
    fn along_diagonals(&self) -> LaneEnds<N, 6> {
        let zero = [[[0.0; LANES_F32]; 6]; N];
        let mut along = LaneEnds { start: zero, end: zero, grow: self.grow };
        for k in 0..N {
            along.start[k] = diagonals(&self.start[k]);
            along.end[k] = diagonals(&self.end[k]);
        }
        for lane in 0..LANES_F32 {
            along.grow[lane] *= DIAGONAL;
        }
        along
    }
}

/// Coordinates in all lanes.
type LaneCoordinates<const D: usize> = [[f64; LANES_F32]; D];

/// The length of `(1, 1, 0)`, rounded up.
const DIAGONAL: f64 = std::f64::consts::SQRT_2 * (1.0 + f64::EPSILON);

#[inline(always)]
fn diagonals([x, y, z]: &LaneCoordinates<3>) -> LaneCoordinates<6> {
    let mut along = [[0.0; LANES_F32]; 6];
    for lane in 0..LANES_F32 {
        along[0][lane] = x[lane] + y[lane];
        along[1][lane] = x[lane] - y[lane];
        along[2][lane] = y[lane] + z[lane];
        along[3][lane] = y[lane] - z[lane];
        along[4][lane] = z[lane] + x[lane];
        along[5][lane] = z[lane] - x[lane];
    }
    along
}

impl<const N: usize, const D: usize> LaneEnds<N, D> {
    /// Encloses and rounds in all lanes at once.
    #[inline(always)]
    fn fit(&self, segments: &[u32; LANES_F32], block: &mut Block<D>, hull: &mut Bounds<D>) {
        for d in 0..D {
            let mut negative = [0.0; LANES_F32];
            for lane in 0..LANES_F32 {
                let (p, q) = (self.start[0][d][lane], self.end[0][d][lane]);
                let (mut low, mut high) = (if p < q { p } else { q }, if p > q { p } else { q });
                for k in 1..N {
                    for x in [self.start[k][d][lane], self.end[k][d][lane]] {
                        low = if x < low { x } else { low };
                        high = if x > high { x } else { high };
                    }
                }
                block.low[d][lane] = below(low - self.grow[lane]);
                block.high[d][lane] = above(high + self.grow[lane]);
                negative[lane] = -block.high[d][lane];
            }
            hull.low[d] = least(&block.low[d]);
            hull.high[d] = -least(&negative);
        }
        for lane in 0..LANES_F32 {
            if segments[lane] == NONE {
                block.clear(lane);
            }
        }
    }
}

/// The least of sixteen numbers, by halves.
#[inline(always)]
fn least(x: &[f32; LANES_F32]) -> f32 {
    let mut x = *x;
    let mut half = LANES_F32 / 2;
    while half > 0 {
        for lane in 0..half {
            let other = x[lane + half];
            x[lane] = if other < x[lane] { other } else { x[lane] };
        }
        half /= 2;
    }
    x[0]
}
