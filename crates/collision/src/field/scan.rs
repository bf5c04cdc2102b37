//! Scan conversion of a mesh (thesis 7.2.2): every feature writes the distances of the lattice
//! points in its region, and the least one counts.

use super::Mesh;
use super::feature::{Feature, features};
use super::grid::{CELLS, Grid, GridBlock, GridFrame, NODES, SIDE, single};
use super::mesh::index;
use crate::CollisionError;
use nalgebra::{Point3, Vector3};
use std::array;

/// Regions are widened by this part of the spacing.
const SCAN_SLACK: f64 = 1e-10;

impl Grid {
    /// Distances of a mesh at the nodes closer than `band`, m, on the smallest box that holds them.
    ///
    /// Cost: every face, edge and vertex visits the nodes in the box of its region, which has at
    /// least `(2 band / spacing)³` of them; blocks are worked on in parallel, with the same result
    /// for any number of threads.
    ///
    /// # Errors
    /// As [`Grid::scan_in`].
    pub fn scan(mesh: &Mesh, spacing: f64, band: f64) -> Result<Self, CollisionError> {
        let [low, high] = mesh.bounds();
        let margin = Vector3::repeat(band + spacing);
        Self::scan_in(mesh, GridFrame::new(low - margin, high + margin, spacing)?, band)
    }

    /// An estimate of the memory that [`Grid::scan`] takes while it works, bytes: that of all
    /// blocks of the lattice, of those near the surface, and of what may reach into which. Cost: a
    /// pass over the triangles.
    #[must_use]
    pub fn memory(mesh: &Mesh, spacing: f64, band: f64) -> f64 {
        let side = CELLS as f64 * spacing;
        let [low, high] = mesh.bounds();
        let around = |size: Vector3<f64>| size.map(|x| (x + 2.0 * band) / side + 2.0).product();
        let all = around(high - low);
        let (mut area, mut reached) = (0.0, 0.0);
        for face in 0..index(mesh.triangles().len()) {
            let [a, b, c] = mesh.corners(face).map(|p| p.coords);
            area += 0.5 * (b - a).cross(&(c - a)).norm();
            reached += around(a.sup(&b).sup(&c) - a.inf(&b).inf(&c));
        }
        // Blocks within the band of the surface, and as many again at its edges; each is held twice
        // while all are put together.
        let near = all.min(4.0 * area * (2.0 * band + 2.0 * side) / side.powi(3));
        // A triangle counts for its own, its edges and its corners.
        32.0 * all
            + 12.0 * NODES as f64 * near
            + 16.0 * all.min(reached)
            + 1000.0 * mesh.triangles().len() as f64
    }

    /// Distances of a mesh at the nodes of a given lattice that are closer than `band`, m.
    ///
    /// # Errors
    /// [`CollisionError::Grid`] if the band is less than two spacings, or the box does not hold the
    /// mesh with a margin of the band.
    pub fn scan_in(mesh: &Mesh, frame: GridFrame, band: f64) -> Result<Self, CollisionError> {
        let [low, high] = mesh.bounds();
        let top = frame.node(frame.blocks.map(|n| n * CELLS));
        let margin = (low - frame.origin).inf(&(top - high)).min();
        if margin < band {
            let problem = "the box does not hold the mesh with a margin of the band";
            return Err(CollisionError::Grid { problem });
        }
        let features = features(mesh, band);
        let bins = FeatureBins::new(&frame, &features);
        Self::assemble(frame, band, |block| {
            let scan = Scan { frame: &frame, first: frame.corner(block), band };
            scan.block(bins.of(block).iter().map(|&f| &features[f as usize]))
        })
    }
}

/// Which features may reach into which block.
struct FeatureBins {
    starts: Vec<usize>,
    features: Vec<u32>,
}

impl FeatureBins {
    fn new(frame: &GridFrame, features: &[Feature]) -> Self {
        let count = frame.blocks.iter().product::<usize>();
        let mut starts = vec![0; count + 1];
        for feature in features {
            each_block(frame, feature, |block| starts[block + 1] += 1);
        }
        for block in 0..count {
            starts[block + 1] += starts[block];
        }
        let mut next = starts.clone();
        let mut list = vec![0; starts[count]];
        for (index, feature) in (0_u32..).zip(features) {
            each_block(frame, feature, |block| {
                list[next[block]] = index;
                next[block] += 1;
            });
        }
        Self { starts, features: list }
    }

    fn of(&self, block: usize) -> &[u32] {
        &self.features[self.starts[block]..self.starts[block + 1]]
    }
}

/// Calls `act` with all blocks that have a node in the box of a feature.
fn each_block(frame: &GridFrame, feature: &Feature, mut act: impl FnMut(usize)) {
    let [low, high] = nodes(frame, feature);
    let [nx, ny, _] = frame.blocks;
    // A node between two blocks is in both.
    let first = low.map(|i| i.saturating_sub(1) / CELLS);
    let last = array::from_fn::<_, 3, _>(|k| (high[k] / CELLS).min(frame.blocks[k] - 1));
    for k in first[2]..=last[2] {
        for j in first[1]..=last[1] {
            for i in first[0]..=last[0] {
                act((k * ny + j) * nx + i);
            }
        }
    }
}

/// First and last node along each axis in the box of a feature, which is within the lattice.
fn nodes(frame: &GridFrame, feature: &Feature) -> [[usize; 3]; 2] {
    let index = |p: &Point3<f64>, k: usize| (p[k] - frame.origin[k]) / frame.spacing;
    let [low, high] = &feature.bounds;
    // One more on each side for the slack and the rounding.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let at = |x: f64, k: usize| x.clamp(0.0, (frame.blocks[k] * CELLS) as f64) as usize;
    [
        array::from_fn(|k| at((index(low, k) - SCAN_SLACK).ceil(), k)),
        array::from_fn(|k| at((index(high, k) + SCAN_SLACK).floor(), k)),
    ]
}

/// The work on one block.
struct Scan<'a> {
    frame: &'a GridFrame,
    /// Index of its first node.
    first: [usize; 3],
    band: f64,
}

impl Scan<'_> {
    /// Signed distances of the nodes; none if all are farther than the band.
    fn block<'a>(&self, features: impl Iterator<Item = &'a Feature>) -> Option<Box<GridBlock>> {
        // Where nothing is found the distance is at least the band, of a side not yet known.
        let mut distances = [f64::NAN; NODES];
        let mut found = false;
        for feature in features {
            let [low, high] = nodes(self.frame, feature);
            let range = |k: usize| {
                let first = low[k].saturating_sub(self.first[k]);
                first..(high[k] + 1).saturating_sub(self.first[k]).min(SIDE)
            };
            for (k, j) in range(2).flat_map(|k| range(1).map(move |j| (k, j))) {
                for i in range(0) {
                    let [x, y, z] = self.first;
                    let node = self.frame.node([x + i, y + j, z + k]);
                    let known = &mut distances[(k * SIDE + j) * SIDE + i];
                    let limit = if known.is_nan() { self.band } else { known.abs() };
                    if let Some(distance) =
                        feature.distance(&node, limit, SCAN_SLACK * self.frame.spacing)
                    {
                        *known = distance;
                        found = true;
                    }
                }
            }
        }
        found.then(|| {
            fill(&mut distances, self.band);
            Box::new(single(&distances))
        })
    }
}

/// Gives the nodes beyond the band the side of a neighbor: between the two the surface does not
/// pass, since it would be closer than the band.
fn fill(distances: &mut [f64; NODES], band: f64) {
    let mut front: Vec<usize> = (0..NODES).filter(|&n| !distances[n].is_nan()).collect();
    while let Some(n) = front.pop() {
        for stride in [1, SIDE, SIDE * SIDE] {
            let place = n / stride % SIDE;
            for (there, inside) in
                [(n.wrapping_sub(stride), place > 0), (n + stride, place < CELLS)]
            {
                if inside && distances[there].is_nan() {
                    distances[there] = band.copysign(distances[n]);
                    front.push(there);
                }
            }
        }
    }
}
