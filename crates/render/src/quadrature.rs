use std::f64::consts::PI;

/// The nodes of Gauss and Legendre in `[-1, 1]` with their weights, exact for polynomials of the
/// degree `2 count - 1`: by Newton's method from their asymptotic places.
pub(crate) fn gauss_legendre(count: u32) -> Vec<[f64; 2]> {
    let n = f64::from(count);
    let node = |k: u32| {
        let mut x = -(PI * (f64::from(k) + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p, mut before) = (1.0, 0.0);
            for j in 1..=count {
                let j = f64::from(j);
                (p, before) = (((2.0 * j - 1.0) * x * p - (j - 1.0) * before) / j, p);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..count).map(node).collect()
}

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

/// The places of the nodes of such a grid.
pub(crate) fn nodes(cells: u32) -> impl ExactSizeIterator<Item = f64> + Clone {
    (0..cells + 1).map(move |k| f64::from(k) / f64::from(cells))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_exact() {
        for (count, degree) in [(1, 1), (5, 9), (24, 47)] {
            let rule = gauss_legendre(count);
            let even: f64 = rule.iter().map(|[x, w]| w * x.powi(degree - 1)).sum();
            assert!((even - 2.0 / f64::from(degree)).abs() < 1e-14, "{count}");
        }
    }

    #[test]
    fn values_lie_in_their_cells() {
        assert_eq!([0.0, 0.3, 1.0, 2.0].map(|x| cell(x, 4).0), [0, 1, 3, 3]);
        assert_eq!([0.0, 0.375, 1.0, 2.0].map(|x| cell(x, 4).1), [0.0, 0.5, 1.0, 1.0]);
    }
}
