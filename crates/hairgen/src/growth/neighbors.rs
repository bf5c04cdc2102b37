//! Which points lie near each other.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Cells along an axis at most: keys of cells fit into 64 bits.
const MOST_CELLS: f64 = 1e6;

/// Points whose neighbors are searched for together.
const SEARCH_CHUNK: usize = 4096;

/// For every point those within a distance.
pub(super) struct Neighbors {
    /// Place of every point in the order of the cells.
    ranks: Vec<u32>,
    /// Where the list of each begins, in that order.
    starts: Vec<usize>,
    lists: Vec<u32>,
}

impl Neighbors {
    /// Points no farther apart than `distance`, which is positive. Cells of that width are sorted,
    /// row by row, so that the neighbors of consecutive points lie in nine stretches that move on
    /// with them. Cost: `n log n` and the number of pairs.
    pub(super) fn within(points: &[Point3<f64>], distance: f64) -> Self {
        let cells = Cells::new(points, distance);
        let mut sorted: Vec<(u64, u32)> = points.iter().map(|p| cells.key(p)).zip(0..).collect();
        sorted.par_sort_unstable();
        let mut ranks = vec![0; points.len()];
        for (rank, &(_, point)) in (0..).zip(&sorted) {
            ranks[point as usize] = rank;
        }
        let chunks = sorted.par_chunks(SEARCH_CHUNK);
        let found: Vec<_> =
            chunks.map(|chunk| cells.search(points, distance, &sorted, chunk)).collect();
        let (mut starts, mut lists) = (vec![0], Vec::new());
        for (ends, neighbors) in found {
            let before = lists.len();
            starts.extend(ends.into_iter().map(|end| before + end));
            lists.extend(neighbors);
        }
        Self { ranks, starts, lists }
    }

    /// The neighbors of a point, without itself.
    pub(super) fn of(&self, point: u32) -> &[u32] {
        let rank = self.ranks[point as usize] as usize;
        &self.lists[self.starts[rank]..self.starts[rank + 1]]
    }
}

/// A lattice of cubes, with a layer around it.
struct Cells {
    low: Vector3<f64>,
    width: f64,
    /// From a row to the next and from a layer to the next.
    strides: [u64; 2],
}

impl Cells {
    fn new(points: &[Point3<f64>], width: f64) -> Self {
        let far = Vector3::repeat(f64::INFINITY);
        let (low, high) = points
            .iter()
            .fold((far, -far), |(low, high), p| (low.inf(&p.coords), high.sup(&p.coords)));
        let size = high - low;
        let width = width.max(size.amax() / MOST_CELLS);
        let count = size.map(|x| whole(x / width) + 3);
        Self { low, width, strides: [count.x, count.x * count.y] }
    }

    fn key(&self, point: &Point3<f64>) -> u64 {
        let cell = ((point.coords - self.low) / self.width).map(|x| whole(x) + 1);
        cell.x + self.strides[0] * cell.y + self.strides[1] * cell.z
    }

    /// The neighbors of a chunk of the sorted points, and where the list of each ends.
    fn search(
        &self,
        points: &[Point3<f64>],
        distance: f64,
        sorted: &[(u64, u32)],
        chunk: &[(u64, u32)],
    ) -> (Vec<usize>, Vec<u32>) {
        let [row, layer] = self.strides;
        // The first cells of the nine stretches of three, from the key of a point; there is a layer
        // around all, so that no key is less.
        let first = |key: u64, k: u64| key + row * (k % 3) + layer * (k / 3) - row - layer - 1;
        let mut at = [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|k| {
            let target = first(chunk[0].0, k);
            sorted.partition_point(|(key, _)| *key < target)
        });
        let (mut ends, mut lists) = (Vec::with_capacity(chunk.len()), Vec::new());
        for &(key, point) in chunk {
            let place = points[point as usize];
            for (k, at) in (0..).zip(&mut at) {
                let target = first(key, k);
                while sorted.get(*at).is_some_and(|(key, _)| *key < target) {
                    *at += 1;
                }
                let stretch = sorted[*at..].iter().take_while(|(key, _)| *key <= target + 2);
                let near = stretch.map(|(_, other)| *other).filter(|&other| {
                    let squared = (points[other as usize] - place).norm_squared();
                    squared <= distance * distance && other != point
                });
                lists.extend(near);
            }
            ends.push(lists.len());
        }
        (ends, lists)
    }
}

/// The integer part of a number from 0 to a million.
fn whole(x: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = x as u64;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_pairs_within_the_distance_are_found(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..200),
            flat: bool,
            distance in 0.01..3.0_f64,
        ) {
            let flatten = |p: [f64; 3]| Point3::new(p[0], p[1], if flat { 0.0 } else { p[2] });
            let points: Vec<_> = points.into_iter().map(flatten).collect();
            let neighbors = Neighbors::within(&points, distance);
            for (i, p) in (0..).zip(&points) {
                let mut found = neighbors.of(i).to_vec();
                found.sort_unstable();
                let near = |(j, q): &(u32, &Point3<f64>)| {
                    *j != i && (*q - p).norm_squared() <= distance * distance
                };
                let expected: Vec<u32> = (0..).zip(&points).filter(near).map(|(j, _)| j).collect();
                prop_assert_eq!(found, expected);
            }
        }
    }
}
