//! Even grids on `[0, 1]`, over which tables are interpolated.

/// Where a value lies between the nodes of an even grid on `[0, 1]` with `cells` cells: the index
/// of the node below, and the part of the cell, in `[0, 1]`.
pub(crate) fn cell(x: f64, cells: usize) -> (usize, f64) {
    let at = x.clamp(0.0, 1.0) * cells as f64;
    #[expect(clippy::cast_possible_truncation, reason = "in [0, cells]")]
    let below = (at as usize).min(cells - 1);
    let part = at - below as f64;
    (below, part)
}

/// A number of cells, at least `wanted`, but in `[least, most]`.
pub(crate) fn count(wanted: f64, least: f64, most: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "most is far less than 2^32")]
    let count = wanted.ceil().clamp(least, most) as u32;
    count
}

/// The places of the nodes of an even grid on `[0, 1]` with `cells` cells.
pub(crate) fn nodes(cells: u32) -> impl ExactSizeIterator<Item = f64> + Clone {
    (0..cells + 1).map(move |k| f64::from(k) / f64::from(cells))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_in_their_cells() {
        assert_eq!([0.0, 0.3, 1.0, 2.0].map(|x| cell(x, 4).0), [0, 1, 3, 3]);
        assert_eq!([0.0, 0.375, 1.0, 2.0].map(|x| cell(x, 4).1), [0.0, 0.5, 1.0, 1.0]);
    }
}
