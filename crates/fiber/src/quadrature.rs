//! Integrals by sums.

use std::f64::consts::PI;

/// The nodes of Gauss and Legendre with their weights, `count` of them on `[-1, 1]`, rising: exact
/// for polynomials up to the degree `2 count - 1`. Newton's method on the Legendre polynomial; cost
/// O(count^2).
#[must_use]
pub fn gauss_legendre(count: usize) -> Vec<[f64; 2]> {
    let n = count as f64;
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let [mut last, mut p] = [0.0, 1.0];
            for k in 0..count {
                let k = k as f64;
                [last, p] = [p, ((2.0 * k + 1.0) * x * p - k * last) / (k + 1.0)];
            }
            slope = n * (last - x * p) / (1.0 - x * x);
            x -= p / slope;
        }
        [-x, 2.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for count in 1..=42 {
            let rule = gauss_legendre(count);
            for degree in 0..2 * count {
                let sum: f64 = rule.iter().map(|[x, w]| w * x.powf(degree as f64)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "{count} points, degree {degree}");
            }
        }
    }
}
