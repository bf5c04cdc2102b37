//! The way up the tree of the sources: the multipoles of all cells.

use super::points;
use super::tree::{Cell, Octree};
use crate::direct_sum::Cloud;
use crate::harmonics::{Coefficient, Shift, TranslationKind, Translator, count};
use rayon::prelude::*;
use std::ops::Range;

/// Multipoles of all cells of a tree.
pub(crate) struct Multipoles<'a, E> {
    pub(crate) tree: &'a Octree,
    /// Degree of the multipoles.
    pub(super) order: usize,
    /// Coefficients of all cells, `(order + 1)^2` each, in the order of the cells.
    moments: Vec<E>,
    /// Coefficients in single precision, where expansions are partly moved so.
    pub(super) rounded: Option<Rounded>,
}

/// Moments in single precision, for what degrees from `low` on take part in.
pub(super) struct Rounded {
    /// Degree from which on single precision is enough.
    pub(super) low: usize,
    /// Coefficients of all cells, in the order of the cells.
    pub(super) moments: Vec<f32>,
}

impl<'a, E: Coefficient> Multipoles<'a, E> {
    /// Multipoles of degree up to `order` of all cells of `tree`; `cloud` holds `per_body` points
    /// for each body of the tree, in its order.
    pub(crate) fn new(tree: &'a Octree, cloud: &Cloud, per_body: usize, order: usize) -> Self {
        let size = count(order);
        let mut moments = vec![E::from_f64(0.0); size * tree.cells.len()];
        let mut below = 0..0;
        // From the deepest level up: leaves from their points (P2M), other cells from their
        // children (M2M).
        for level in tree.levels.windows(2).rev() {
            let (above, deeper) =
                moments[size * level[0]..].split_at_mut(size * (level[1] - level[0]));
            let deeper = &deeper[..size * below.len()];
            let cells = &tree.cells[level[0]..level[1]];
            let scratch = || (points::work(order), vec![0.0; size], Translator::<E>::new(order));
            // Those with many points or children may stand together.
            let cells = cells.par_iter().zip(above.par_chunks_exact_mut(size));
            let cells = cells.with_min_len(16).with_max_len(512);
            cells.for_each_init(scratch, |(work, leaf, translator), (cell, moments)| {
                if cell.is_leaf() {
                    let range = scaled(&cell.bodies, per_body);
                    points::multipole(order, cell, cloud, range, work, leaf);
                    moments.iter_mut().zip(leaf).for_each(|(m, leaf)| *m = E::from_f64(*leaf));
                    return;
                }
                let shift = |child: usize| {
                    let coefficients = &deeper[size * (child - below.start)..][..size];
                    shift(&tree.cells[child], cell, coefficients, order)
                };
                let shifts: Vec<_> = cell.children.clone().map(shift).collect();
                translator.sum(TranslationKind::Multipole, &shifts, moments);
            });
            below = level[0]..level[1];
        }
        Self { tree, order, moments, rounded: None }
    }

    /// Multipoles that are moved far in single precision but for what degrees below `low` do to
    /// each other: the others are small.
    pub(crate) fn rounded(mut self, low: usize) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
        let moments = self.moments.par_iter().map(|moment| moment.to_f64() as f32).collect();
        self.rounded = Some(Rounded { low, moments });
        self
    }

    /// Coefficients of the cell with this index.
    pub(crate) fn moments(&self, cell: usize) -> &[E] {
        &self.moments[count(self.order) * cell..][..count(self.order)]
    }
}

/// Array of zeros with `N` numbers for each of `bodies`. All threads write it, as memory that is
/// read before it is written takes twice as long, and more where other threads run.
pub(crate) fn nothing<const N: usize>(bodies: usize) -> Vec<[f64; N]> {
    (0..bodies).into_par_iter().map(|_| [0.0; N]).collect()
}

/// Parts of `all` for these ascending `ranges`.
pub(crate) fn parts<T>(
    mut all: &mut [T],
    ranges: impl Iterator<Item = Range<usize>>,
) -> Vec<(Range<usize>, &mut [T])> {
    let mut first = 0;
    let part = |range: Range<usize>| {
        let (_, rest) = std::mem::take(&mut all).split_at_mut(range.start - first);
        let (part, rest) = rest.split_at_mut(range.len());
        (all, first) = (rest, range.end);
        (range, part)
    };
    ranges.map(part).collect()
}

/// Range of the points of `bodies`, with `per_body` points for each.
pub(crate) fn scaled(bodies: &Range<usize>, per_body: usize) -> Range<usize> {
    bodies.start * per_body..bodies.end * per_body
}

/// Move of the expansion `coefficients` of the cell `from` to the cell `to`, both of this degree.
pub(super) fn shift<'a, E>(
    from: &Cell,
    to: &Cell,
    coefficients: &'a [E],
    degree: usize,
) -> Shift<'a, E> {
    let (offset, scales) = (to.center - from.center, [from.scale, to.scale]);
    Shift { coefficients, degrees: [degree; 2], offset, scales }
}
