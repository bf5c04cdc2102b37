//! A narrow band of distances on a lattice, in blocks.

use super::DistanceField;
use crate::CollisionError;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::array;

/// Cells along a side of a block.
pub(super) const CELLS: usize = 8;
/// Nodes along a side of a block: neighbors share the nodes between them, so that all corners of a
/// cell are in one block.
pub(super) const SIDE: usize = CELLS + 1;
/// Nodes of a block.
pub(super) const NODES: usize = SIDE * SIDE * SIDE;

/// Where a lattice stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridFrame {
    pub(super) origin: Point3<f64>,
    pub(super) spacing: f64,
    /// Blocks along x, y, z.
    pub(super) blocks: [usize; 3],
    /// The same in the width of the addresses, the number of cells, and one over the spacing: what
    /// every query needs.
    pub(super) counts: [u32; 3],
    pub(super) cells: [f64; 3],
    pub(super) inverse: f64,
}

impl GridFrame {
    /// A lattice with nodes at distances of `spacing`, m, that begins at `low` and reaches at least
    /// up to `high` (world), m.
    ///
    /// # Errors
    /// [`CollisionError::Grid`] if a number is not finite, the spacing not positive, the box empty,
    /// or so large that its nodes cannot be counted.
    pub fn new(low: Point3<f64>, high: Point3<f64>, spacing: f64) -> Result<Self, CollisionError> {
        let refuse = |problem| Err(CollisionError::Grid { problem });
        let size = high - low;
        if !(spacing > 0.0 && spacing.is_finite()) {
            return refuse("the spacing must be positive and finite");
        }
        if !(size.min() > 0.0 && size.iter().chain(&low.coords).all(|x| x.is_finite())) {
            return refuse("the box must be finite, and its high corner above its low one");
        }
        let counts = (size / (spacing * CELLS as f64)).map(f64::ceil);
        if counts.product() * NODES as f64 > f64::from(i32::MAX) {
            return refuse("there are more than 2^31 nodes; take a larger spacing");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "just checked")]
        let counts = array::from_fn(|k| counts[k] as u32);
        let blocks = counts.map(|n| n as usize);
        let cells = blocks.map(|n| (n * CELLS) as f64);
        Ok(Self { origin: low, spacing, blocks, counts, cells, inverse: 1.0 / spacing })
    }

    /// Position of a node (world), m.
    pub(super) fn node(&self, index: [usize; 3]) -> Point3<f64> {
        self.origin + self.spacing * Vector3::from(index.map(|i| i as f64))
    }

    /// The first node of a block, by the index of the block.
    pub(super) fn corner(&self, block: usize) -> [usize; 3] {
        let [nx, ny, _] = self.blocks;
        [block % nx, block / nx % ny, block / (nx * ny)].map(|i| i * CELLS)
    }
}

/// Distances of the nodes of one block, x running fastest.
pub(super) type GridBlock = [f32; NODES];

/// A signed field of distance on a lattice, with trilinear values between the nodes (thesis 7.2.1).
///
/// Only nodes closer to the surface than the band are stored, in blocks of 8³ cells; elsewhere the
/// value is the band with the right sign, and outside of the lattice it grows with the distance
/// from that. Gradients are those of the interpolant itself, not differences as in the thesis.
/// Values are stored in single precision: they are off by no more than 2⁻²⁴ of the band, far less
/// than the interpolation, and take half the memory traffic.
///
/// With spacing `h`, the interpolant is within `h² / (4 R)` of the distance where the level
/// surfaces of that are smooth with radii of curvature of at least `R`, since then its second
/// derivatives sum up to at most `2 / R`; see [`Grid::smooth`]. At any surface it is within
/// `h sqrt(3) / 2`, since the distance is 1-Lipschitz.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    pub(super) frame: GridFrame,
    pub(super) band: f64,
    /// For each block, where its nodes begin in `nodes`.
    pub(super) starts: Vec<u32>,
    /// The first two blocks are those of no detail, outside and inside.
    pub(super) nodes: Vec<f32>,
    pub(super) lipschitz: f64,
    pub(super) error: f64,
}

impl Grid {
    /// Samples another field at the nodes closer than `band`, m. Cost: a sample for each of these
    /// and for some farther ones of the blocks that the band reaches, and one for each other block.
    ///
    /// # Errors
    /// [`CollisionError::Grid`] if the band is not at least two spacings and at most that of the
    /// field, or the surface is not held by the box with a margin of the band.
    pub fn sample(
        field: &impl DistanceField,
        frame: GridFrame,
        band: f64,
    ) -> Result<Self, CollisionError> {
        if band > field.band() {
            let problem = "the band must not be wider than that of the sampled field";
            return Err(CollisionError::Grid { problem });
        }
        let side = CELLS as f64 * frame.spacing;
        let reach = field.lipschitz() * 0.5 * 3.0_f64.sqrt() * side;
        let mut grid = Self::assemble(frame, band, |block| {
            let [i, j, k] = frame.corner(block);
            // From a center so far away the field reaches the band at no node.
            let center = frame.node([i, j, k]) + Vector3::repeat(0.5 * side);
            let middle = (center, field.value(&center));
            if middle.1.abs() > band + reach {
                return None;
            }
            // Values that tell of others that they are beyond the band: those of the center, of the
            // first node of the row, and of the last that was not known to be so.
            let mut known = [middle; 3];
            let values: [f64; NODES] = array::from_fn(|n| {
                let [x, y, z] = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
                let node = frame.node([i + x, j + y, k + z]);
                let is_far = |(at, value): &&(Point3<f64>, f64)| {
                    value.abs() > band + field.lipschitz() * (node - at).norm()
                };
                if let Some((_, value)) = known.iter().find(is_far) {
                    return band.copysign(*value);
                }
                let value = field.value(&node);
                known[2] = (node, value);
                if x == 0 {
                    known[1] = known[2];
                }
                value.clamp(-band, band)
            });
            values.iter().any(|v| v.abs() < band).then(|| Box::new(single(&values)))
        })?;
        grid.error += field.error();
        Ok(grid)
    }

    /// Puts blocks together; those without any node in the band are none, and on the same side as
    /// the node that they share with the block before.
    pub(super) fn assemble(
        frame: GridFrame,
        band: f64,
        block: impl Fn(usize) -> Option<Box<GridBlock>> + Sync,
    ) -> Result<Self, CollisionError> {
        let refuse = |problem| Err(CollisionError::Grid { problem });
        if !(band >= 2.0 * frame.spacing && band.is_finite()) {
            return refuse("the band must be finite and at least two spacings");
        }
        let count = frame.blocks.iter().product::<usize>();
        let blocks: Vec<_> = (0..count).into_par_iter().map(&block).collect();
        // Rounded down, so that no value is larger than the band.
        let far = single(&[band])[0];
        let mut nodes = vec![far; NODES];
        nodes.resize(2 * NODES, -far);
        let mut starts = Vec::with_capacity(count);
        let mut inside = false;
        for block in &blocks {
            let start = if block.is_some() { nodes.len() } else { usize::from(inside) * NODES };
            starts.push(u32::try_from(start).unwrap_or(u32::MAX));
            if let Some(block) = block {
                inside = block[CELLS] < 0.0;
                nodes.extend_from_slice(&block[..]);
            }
        }
        if u32::try_from(nodes.len()).is_err() {
            return refuse("the surface passes through too many blocks; take a larger spacing");
        }
        let lipschitz = blocks.iter().flatten().map(|block| steepest(block)).fold(0.0, f64::max);
        let grid = Self {
            lipschitz: (lipschitz / frame.spacing).max(1.0),
            error: 0.5 * 3.0_f64.sqrt() * frame.spacing,
            band: f64::from(far),
            frame,
            starts,
            nodes,
        };
        if !grid.rim_is_outside() {
            return refuse("the box does not hold the surface with a margin of the band");
        }
        Ok(grid)
    }

    /// Whether all nodes of the faces of the box are far outside.
    fn rim_is_outside(&self) -> bool {
        let far = self.nodes[0];
        (0..self.starts.len()).all(|block| {
            let corner = self.frame.corner(block);
            let start = self.starts[block] as usize;
            (0..3).all(|axis| {
                let stride = SIDE.pow(axis);
                let axis = axis as usize;
                let rim = |side: usize| {
                    (0..NODES)
                        .filter(move |n| n / stride % SIDE == side)
                        .all(|n| self.nodes[start + n] == far)
                };
                (corner[axis] > 0 || rim(0))
                    && (corner[axis] + CELLS < self.frame.blocks[axis] * CELLS || rim(CELLS))
            })
        })
    }

    /// States that the level surfaces in the band are smooth, with radii of curvature of at least
    /// `radius`, m: then the error is at most `spacing² / (4 radius)`. For a ball of radius `R` and
    /// the band `b` the least radius is `R - b`.
    #[must_use]
    pub fn smooth(mut self, radius: f64) -> Self {
        let bound = self.frame.spacing * self.frame.spacing / (4.0 * radius);
        // The rounding of the stored values comes on top.
        self.error = self.error.min(bound + 1e-7 * self.band);
        self
    }

    /// Number of blocks that are stored, of all.
    #[must_use]
    pub fn blocks(&self) -> [usize; 2] {
        [self.nodes.len() / NODES - 2, self.starts.len()]
    }

    /// Memory of the field, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.nodes[..])
    }
}

/// In single precision, rounded toward zero: Lipschitz bounds and clipping stay right.
pub(super) fn single<const N: usize>(values: &[f64; N]) -> [f32; N] {
    values.map(|value| {
        #[expect(clippy::cast_possible_truncation, reason = "rounding is what is wanted")]
        let near = value as f32;
        if f64::from(near).abs() > value.abs() { f32::from_bits(near.to_bits() - 1) } else { near }
    })
}

/// Bound of the slope of the interpolant in a block, per spacing: the derivative along an axis is
/// between the differences along the four edges of a cell.
fn steepest(block: &GridBlock) -> f64 {
    let mut steepest: f32 = 0.0;
    let edge = |n: usize, step: usize| (block[n + step] - block[n]).abs();
    for cell in 0..CELLS * CELLS * CELLS {
        let [x, y, z] = [cell % CELLS, cell / CELLS % CELLS, cell / (CELLS * CELLS)];
        let n = (z * SIDE + y) * SIDE + x;
        let slope = |step: usize, a: usize, b: usize| {
            edge(n, step).max(edge(n + a, step)).max(edge(n + b, step)).max(edge(n + a + b, step))
        };
        let (i, j, k) = (1, SIDE, SIDE * SIDE);
        let [u, v, w] = [slope(i, j, k), slope(j, i, k), slope(k, i, j)];
        steepest = steepest.max(u * u + v * v + w * w);
    }
    // Of single precision, with its rounding.
    f64::from(steepest).sqrt() * (1.0 + 1e-6)
}
