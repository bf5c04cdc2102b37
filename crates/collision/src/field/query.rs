//! Values and gradients of a grid, many at a time.
//!
//! Points are taken in chunks, in three passes: where each one is, the eight corners of its cell,
//! and the interpolation. The first and the last are loops over arrays without branches, for the
//! widest vectors that the processor has; only the second one jumps about in memory, and one cell
//! is four pairs of neighbors in one block.

use super::grid::{CELLS, Grid, GridFrame, SIDE};
use super::{DistanceField, Sample};
use nalgebra::{Point3, Vector3};
use pulp::{Arch, Simd, WithSimd};

/// Points per chunk.
const QUERY_CHUNK: usize = 64;

/// Adding this to a double rounds it to an integer, found in its low bits.
const INTEGER: f64 = 6_755_399_441_055_744.0;

/// Cells and nodes along a side of a block.
#[expect(clippy::cast_possible_truncation, reason = "they are 8 and 9")]
const SIZES: [u32; 2] = [CELLS as u32, SIDE as u32];

/// From the low corner of a cell to the end of its corners.
const CORNERS: usize = SIDE * SIDE + SIDE + 2;

impl DistanceField for Grid {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let (place, inside) = locate(&self.frame, point);
        let corners = self.corners(place.address);
        let mut out = sample(interpolate(corners, place.fractions), self.frame.inverse);
        if !inside {
            self.leave_the_box(point, &mut out);
        }
        out
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        self.least_on(start, end)
    }

    fn lipschitz(&self) -> f64 {
        self.lipschitz
    }

    fn error(&self) -> f64 {
        self.error
    }

    /// The stored band less the diagonal of a cell: up to there no corner is clipped.
    fn band(&self) -> f64 {
        self.band - 3.0_f64.sqrt() * self.frame.spacing
    }
}

impl Grid {
    /// Values and gradients at all `points` (world): what [`sample`](DistanceField::sample) returns
    /// for each, several times as fast.
    ///
    /// # Panics
    /// If there are not as many `samples` as points.
    pub fn samples(&self, points: &[Point3<f64>], samples: &mut [Sample]) {
        assert_eq!(points.len(), samples.len(), "one sample per point");
        Arch::new().dispatch(QueryBatch { grid: self, points, samples });
    }

    /// The eight corners of a cell, given its block and its place in that.
    #[inline(always)]
    fn corners(&self, [block, place]: [u32; 2]) -> [f32; 8] {
        self.corners_at((self.starts[block as usize] + place) as usize)
    }

    /// The eight corners of the cell whose first node is number `start`.
    #[inline(always)]
    pub(super) fn corners_at(&self, start: usize) -> [f32; 8] {
        let nodes = &self.nodes[start..start + CORNERS];
        let [j, k] = [SIDE, SIDE * SIDE];
        [
            nodes[0],
            nodes[1],
            nodes[j],
            nodes[j + 1],
            nodes[k],
            nodes[k + 1],
            nodes[k + j],
            nodes[k + j + 1],
        ]
    }

    /// Corrects a sample outside of the box, where all is far: the distance to the box is added.
    fn leave_the_box(&self, point: &Point3<f64>, sample: &mut Sample) {
        let size = Vector3::from(self.frame.cells) * self.frame.spacing;
        let p = point - self.frame.origin;
        let beyond = p - p.sup(&Vector3::zeros()).inf(&size);
        let distance = beyond.norm();
        if distance > 0.0 {
            let gradient = if distance.is_finite() { beyond / distance } else { Vector3::zeros() };
            *sample = Sample { value: self.band + distance, gradient };
        }
    }
}

struct QueryBatch<'a> {
    grid: &'a Grid,
    points: &'a [Point3<f64>],
    samples: &'a mut [Sample],
}

impl WithSimd for QueryBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { grid, points, samples } = self;
        let mut chunk = Chunk {
            fractions: [[0.0; QUERY_CHUNK]; 3],
            addresses: [[0; QUERY_CHUNK]; 2],
            corners: [[0.0; QUERY_CHUNK]; 8],
            results: [[0.0; QUERY_CHUNK]; 4],
        };
        let (full, rest) = points.as_chunks();
        let (full_samples, rest_samples) = samples.as_chunks_mut();
        for (points, samples) in full.iter().zip(full_samples) {
            chunk.query(grid, points, samples);
        }
        if !rest.is_empty() {
            let mut padded = [rest[0]; QUERY_CHUNK];
            padded[..rest.len()].copy_from_slice(rest);
            let mut padded_samples =
                [Sample { value: 0.0, gradient: Vector3::zeros() }; QUERY_CHUNK];
            chunk.query(grid, &padded, &mut padded_samples);
            rest_samples.copy_from_slice(&padded_samples[..rest.len()]);
        }
    }
}

/// What is known of the points of a chunk, each quantity in an array.
struct Chunk {
    fractions: [[f32; QUERY_CHUNK]; 3],
    addresses: [[u32; QUERY_CHUNK]; 2],
    corners: [[f32; QUERY_CHUNK]; 8],
    results: [[f32; QUERY_CHUNK]; 4],
}

impl Chunk {
    #[inline(always)]
    fn query(
        &mut self,
        grid: &Grid,
        points: &[Point3<f64>; QUERY_CHUNK],
        samples: &mut [Sample; QUERY_CHUNK],
    ) {
        let outside = self.locate(grid, points);
        self.fetch(grid);
        self.interpolate();
        self.write(grid.frame.inverse, samples);
        if outside {
            for (point, sample) in points.iter().zip(samples) {
                grid.leave_the_box(point, sample);
            }
        }
    }

    /// Finds the cells, and whether any point is outside of the box.
    #[inline(always)]
    fn locate(&mut self, grid: &Grid, points: &[Point3<f64>; QUERY_CHUNK]) -> bool {
        let frame = grid.frame;
        let mut outside = false;
        for lane in 0..QUERY_CHUNK {
            let (GridPlace { address: [block, node], fractions: [x, y, z] }, inside) =
                locate(&frame, &points[lane]);
            outside |= !inside;
            (self.addresses[0][lane], self.addresses[1][lane]) = (block, node);
            (self.fractions[0][lane], self.fractions[1][lane]) = (x, y);
            self.fractions[2][lane] = z;
        }
        outside
    }

    /// Brings in the corners.
    #[inline(always)]
    fn fetch(&mut self, grid: &Grid) {
        for lane in 0..QUERY_CHUNK {
            let corners = grid.corners([self.addresses[0][lane], self.addresses[1][lane]]);
            for k in 0..8 {
                self.corners[k][lane] = corners[k];
            }
        }
    }

    #[inline(always)]
    fn interpolate(&mut self) {
        let [c0, c1, c2, c3, c4, c5, c6, c7] = &self.corners;
        let [x, y, z] = &self.fractions;
        let [value, dx, dy, dz] = &mut self.results;
        for i in 0..QUERY_CHUNK {
            let corners = [c0[i], c1[i], c2[i], c3[i], c4[i], c5[i], c6[i], c7[i]];
            [value[i], dx[i], dy[i], dz[i]] = interpolate(corners, [x[i], y[i], z[i]]);
        }
    }

    #[inline(always)]
    fn write(&self, inverse: f64, samples: &mut [Sample; QUERY_CHUNK]) {
        let [value, x, y, z] = &self.results;
        for lane in 0..QUERY_CHUNK {
            samples[lane] = sample([value[lane], x[lane], y[lane], z[lane]], inverse);
        }
    }
}

/// Where a point is.
struct GridPlace {
    /// The block of its cell, and the first node of that in the block.
    address: [u32; 2],
    /// Where it is in the cell, each in 0..=1.
    fractions: [f32; 3],
}

/// The place of a point, or of the point of the box nearest to it, and whether it is in the box.
#[inline(always)]
fn locate(frame: &GridFrame, point: &Point3<f64>) -> (GridPlace, bool) {
    let [nx, ny, nz] = frame.cells;
    let [[x, y, z]] = ((point - frame.origin) * frame.inverse).data.0;
    let inside = (0.0 <= x) & (x <= nx) & (0.0 <= y) & (y <= ny) & (0.0 <= z) & (z <= nz);
    let ((i, x), (j, y), (k, z)) = (split(x, nx), split(y, ny), split(z, nz));
    let ([cells, side], [bx, by, _]) = (SIZES, frame.counts);
    let block = i / cells + bx * (j / cells + by * (k / cells));
    let node = i % cells + side * (j % cells + side * (k % cells));
    (GridPlace { address: [block, node], fractions: [x, y, z] }, inside)
}

/// A place on an axis of `count` cells as the index of its cell and the fraction in it.
#[inline(always)]
fn split(t: f64, count: f64) -> (u32, f32) {
    // What is not a number becomes zero.
    let t = if t > 0.0 { t } else { 0.0 };
    let t = if t < count { t } else { count };
    let (rounded, last) = (t - 0.5 + INTEGER, INTEGER + (count - 1.0));
    let integer = if rounded < last { rounded } else { last };
    #[expect(clippy::cast_possible_truncation, reason = "the low bits are the integer")]
    let split = (integer.to_bits() as u32, (t - (integer - INTEGER)) as f32);
    split
}

/// The trilinear interpolant and its derivatives along the axes, per cell.
#[inline(always)]
fn interpolate(c: [f32; 8], [x, y, z]: [f32; 3]) -> [f32; 4] {
    // Along x on the four edges, then along y on two faces, then along z.
    let (d0, d1, d2, d3) = (c[1] - c[0], c[3] - c[2], c[5] - c[4], c[7] - c[6]);
    let (e0, e1, e2, e3) = (c[0] + x * d0, c[2] + x * d1, c[4] + x * d2, c[6] + x * d3);
    let (low, high) = (e0 + y * (e1 - e0), e2 + y * (e3 - e2));
    let (dx_low, dx_high) = (d0 + y * (d1 - d0), d2 + y * (d3 - d2));
    let (dy_low, dy_high) = (e1 - e0, e3 - e2);
    [
        low + z * (high - low),
        dx_low + z * (dx_high - dx_low),
        dy_low + z * (dy_high - dy_low),
        high - low,
    ]
}

#[inline(always)]
fn sample([value, x, y, z]: [f32; 4], inverse: f64) -> Sample {
    let gradient = inverse * Vector3::new(f64::from(x), f64::from(y), f64::from(z));
    Sample { value: f64::from(value), gradient }
}
