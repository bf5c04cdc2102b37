//! An adaptive octree over bodies in Morton order, with tight boxes.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Number of halvings of the root's cube: the bits of a Morton code for each axis.
const DEPTH: u32 = 21;

/// Least length that expansions are scaled with, over the radius of the root.
const LEAST_SCALE: f64 = 1e-20;

/// Number of bodies whose bounds are found by one thread at once.
const PART: usize = 4096;

/// Share of the most bodies of a leaf that it holds at best, from measured rates.
const FILLING: f64 = 0.35;

/// Cell of the octree: a set of bodies that are close together.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    /// Range of the bodies, in the order of the tree.
    pub(crate) bodies: Range<usize>,
    /// Range of the indices of the children; empty for a leaf.
    pub(crate) children: Range<usize>,
    /// Center (world, m) of the tight box of the bodies.
    pub(crate) center: Point3<f64>,
    /// Radius (m) of a sphere about the center that holds all bodies.
    pub(crate) radius: f64,
    /// Length (m) that expansions about the center are scaled with: the radius, if it is not zero.
    pub(crate) scale: f64,
    /// Half of the sides of the tight box, m.
    half: Vector3<f64>,
}

impl Cell {
    /// Whether the cell has no children.
    pub(crate) fn is_leaf(&self) -> bool {
        self.children.is_empty()
    }
}

/// Octree over bodies. Cells stand level by level, so the children of a level are the next one.
#[derive(Debug)]
pub(crate) struct Octree {
    /// Cells, the root first.
    pub(crate) cells: Vec<Cell>,
    /// Index of the first cell of each level, and the number of cells.
    pub(crate) levels: Vec<usize>,
    /// Index that each body was given, in the order of the tree.
    pub(crate) order: Vec<u32>,
}

impl Octree {
    /// Octree over `count` bodies (at most 2^32), each what lies between its `ends(i)` (world, m);
    /// leaves hold at most `capacity` bodies, unless those coincide. The cube of the root is larger
    /// than it must be where this fills leaves better: those of evenly spread bodies are all filled
    /// alike, by chance.
    pub(crate) fn new<const N: usize>(
        count: usize,
        capacity: usize,
        ends: impl Fn(usize) -> [Point3<f64>; N] + Sync,
    ) -> Self {
        // The box of the middles of all bodies, and from it the cube of the root.
        let middle =
            |i: usize| ends(i).iter().map(|end| end.coords).sum::<Vector3<f64>>() / N as f64;
        let bounds =
            |[low, high]: [Vector3<f64>; 2], [a, b]: [Vector3<f64>; 2]| [low.inf(&a), high.sup(&b)];
        let none = [f64::MAX, f64::MIN].map(Vector3::repeat);
        let part = |first: usize| {
            let part = first..count.min(first + PART);
            part.map(|i| [middle(i); 2]).fold(none, bounds)
        };
        let parts: Vec<_> = (0..count).into_par_iter().step_by(PART).map(part).collect();
        let [low, high] = parts.into_iter().fold(none, bounds);
        let edge = (high - low).max().max(f64::MIN_POSITIVE) * (1.0 + 1e-12);
        // Bodies in the order of the Morton codes of their middles: a cell holds those whose codes
        // have the same leading bits.
        let grow = |edge: f64| {
            let code = |i: usize| {
                let place = (middle(i) - low) / edge * (1_u64 << DEPTH) as f64;
                place.iter().rev().fold(0, |code, &x| (code << 1) | spread(x))
            };
            let mut keys: Vec<(u64, u32)> =
                (0..count).into_par_iter().map(|i| (code(i), number(i))).collect();
            keys.par_sort_unstable();
            let (cells, levels) = split(&keys, capacity.max(1));
            Self { cells, levels, order: keys.par_iter().map(|(_, i)| *i).collect() }
        };
        // The cube is made larger once, if leaves would be too empty; then spheres are fitted to
        // the bodies.
        let mut tree = grow(edge);
        let stretch = tree.stretch(capacity);
        if stretch > 1.0 {
            tree = grow(stretch * edge);
        }
        tree.fit(ends);
        tree
    }

    /// Place of each body in the order of the tree, by the index that it was given.
    pub(crate) fn places(&self) -> Vec<u32> {
        let places: Vec<_> = self.order.par_iter().map(|_| AtomicU32::new(0)).collect();
        let put = |(k, &i): (usize, &u32)| places[i as usize].store(number(k), Ordering::Relaxed);
        self.order.par_iter().enumerate().for_each(put);
        places.into_iter().map(AtomicU32::into_inner).collect()
    }

    /// Factor by which the cube of the root should be larger, if bodies are spread evenly, for
    /// leaves as large as is best; one where they are about that large or larger, as leaves of
    /// other bodies are on average.
    fn stretch(&self, capacity: usize) -> f64 {
        let sizes = self.cells.iter().filter(|cell| cell.is_leaf()).map(|cell| cell.bodies.len());
        let squares: f64 = sizes.map(|size| (size * size) as f64).sum();
        let growth = FILLING * (capacity * self.order.len()) as f64 / squares;
        if growth > 1.5 { growth.cbrt().min(2.0) } else { 1.0 }
    }

    /// Finds the tight spheres of all cells, leaves first.
    fn fit<const N: usize>(&mut self, ends: impl Fn(usize) -> [Point3<f64>; N] + Sync) {
        let order = &self.order;
        self.cells.par_iter_mut().filter(|cell| cell.is_leaf()).for_each(|cell| {
            let bodies = &order[cell.bodies.clone()];
            let points = || bodies.iter().flat_map(|&i| ends(i as usize));
            cell.enclose(points().map(|x| (x, Vector3::zeros())));
            let center = cell.center;
            cell.radius = points().map(|x| (x - center).norm()).fold(0.0, f64::max);
        });
        // A sphere about the spheres of the children or about the box, whichever is smaller.
        for k in (0..self.cells.len()).rev() {
            let (above, below) = self.cells.split_at_mut(k + 1);
            let cell = &mut above[k];
            if cell.is_leaf() {
                continue;
            }
            let children = &below[cell.children.start - k - 1..cell.children.end - k - 1];
            cell.enclose(children.iter().map(|child| (child.center, child.half)));
            let reach = |child: &Cell| (child.center - cell.center).norm() + child.radius;
            cell.radius = children.iter().map(reach).fold(0.0, f64::max).min(cell.half.norm());
        }
        let least = self.cells.first().map_or(0.0, |root| LEAST_SCALE * root.radius).max(1e-150);
        self.cells.iter_mut().for_each(|cell| cell.scale = cell.radius.max(least));
    }
}

impl Cell {
    /// Sets center and half sides to the box that holds `boxes`, given as centers (world, m) and
    /// half sides (m).
    fn enclose(&mut self, boxes: impl Iterator<Item = (Point3<f64>, Vector3<f64>)>) {
        let [mut low, mut high] = [f64::MAX, f64::MIN].map(Vector3::repeat);
        for (center, half) in boxes {
            low = low.inf(&(center.coords - half));
            high = high.sup(&(center.coords + half));
        }
        self.center = ((low + high) * 0.5).into();
        self.half = (high - low) * 0.5;
    }
}

/// Cells, level by level, and the beginnings of the levels, for sorted `keys` (Morton code and
/// index): a cell with more than `capacity` bodies is split by the next three bits of the code.
fn split(keys: &[(u64, u32)], capacity: usize) -> (Vec<Cell>, Vec<usize>) {
    let cell = |bodies: Range<usize>| Cell {
        bodies,
        children: 0..0,
        center: Point3::origin(),
        radius: 0.0,
        scale: 0.0,
        half: Vector3::zeros(),
    };
    let mut levels = vec![0];
    if keys.is_empty() {
        return (Vec::new(), levels);
    }
    let mut cells = vec![cell(0..keys.len())];
    for level in (0..DEPTH).rev() {
        let first = levels[levels.len() - 1];
        levels.push(cells.len());
        let octants = |bodies: &Range<usize>| {
            let mut start = bodies.start;
            [0, 1, 2, 3, 4, 5, 6, 7].map(|octant| {
                let rest = &keys[start..bodies.end];
                let end = start + rest.partition_point(|key| (key.0 >> (3 * level)) & 7 <= octant);
                std::mem::replace(&mut start, end)..end
            })
        };
        let split = |cell: &Cell| (cell.bodies.len() > capacity).then(|| octants(&cell.bodies));
        let parts: Vec<_> = cells[first..].par_iter().map(split).collect();
        for (k, parts) in (first..).zip(parts) {
            let Some(parts) = parts else { continue };
            let begin = cells.len();
            cells.extend(parts.into_iter().filter(|part| !part.is_empty()).map(cell));
            cells[k].children = begin..cells.len();
        }
        if cells.len() == levels[levels.len() - 1] {
            return (cells, levels);
        }
    }
    levels.push(cells.len());
    (cells, levels)
}

/// Index of a body in 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "solvers refuse more than 2^32 bodies")]
fn number(i: usize) -> u32 {
    i as u32
}

/// Low 21 bits of the integer part of `x`, with two zeros between each two (the part of one axis in
/// a Morton code).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 <= x < 2^21")]
fn spread(x: f64) -> u64 {
    let mut x = (x as u64).min((1 << DEPTH) - 1);
    x = (x | (x << 32)) & 0x001f_0000_0000_ffff;
    x = (x | (x << 16)) & 0x001f_0000_ff00_00ff;
    x = (x | (x << 8)) & 0x100f_00f0_0f00_f00f;
    x = (x | (x << 4)) & 0x10c3_0c30_c30c_30c3;
    (x | (x << 2)) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However many they are. Leaves are let be from 2/3 of the best filling on; a layer of cells
    /// at three faces of the cube is cut off by it.
    #[test]
    fn leaves_of_evenly_spread_bodies_are_well_filled() {
        let golden = [0.819_172_513, 0.671_043_607, 0.549_700_478];
        for count in [3000, 6000, 12_000, 24_000, 48_000] {
            let point = |i: usize| Point3::from(golden.map(|g| (i as f64 * g).fract()));
            let tree = Octree::new(count, 100, |i| [point(i)]);
            let leaves: Vec<_> = tree.cells.iter().filter(|cell| cell.is_leaf()).collect();
            let squares: usize = leaves.iter().map(|leaf| leaf.bodies.len().pow(2)).sum();
            let mean = squares as f64 / count as f64;
            assert!(mean > 0.6 * 100.0 * FILLING, "{count}: {mean}");
            let held: usize = leaves.iter().map(|leaf| leaf.bodies.len()).sum();
            assert!(held == count && leaves.iter().all(|leaf| leaf.bodies.len() <= 100));
        }
    }
}
