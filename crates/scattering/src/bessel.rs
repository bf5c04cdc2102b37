use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Modified Bessel function of the first kind over the exponential, `exp(-x) I_n(x)`, for `n` 0 or
/// 1 and `x >= 0`, to some 1e-15 of its value: by the power series, whose terms are positive, or
/// beyond 30 by the asymptotic one, whose smallest term is below `exp(-2 x)`.
pub(crate) fn scaled_bessel(n: u32, x: f64) -> f64 {
    let n = f64::from(n);
    let mut k = 0.0;
    if x <= 30.0 {
        let mut term = (-x).exp() * (0.5 * x).powf(n);
        let mut sum = term;
        while term > 1e-17 * sum {
            k += 1.0;
            term *= 0.25 * x * x / (k * (k + n));
            sum += term;
        }
        return sum;
    }
    let (mut term, mut sum) = (1.0, 1.0);
    while f64::abs(term) > 1e-17 {
        k += 1.0;
        let odd = 2.0 * k - 1.0;
        term *= (odd * odd - 4.0 * n * n) / (8.0 * k * x);
        sum += term;
    }
    sum / (TAU * x).sqrt()
}

/// `exp(-x) I0(x)` for `x >= 0`, as [`scaled_bessel`] has it, but by a table, without a division.
pub(crate) fn scaled_bessel_0(x: f64) -> f64 {
    /// Cells of a half each, with the polynomial around their middles.
    static CELLS: LazyLock<[[f64; 14]; 60]> =
        LazyLock::new(|| std::array::from_fn(|k| taylor(0.25 + 0.5 * k as f64)));
    if x < 30.0 {
        #[expect(clippy::cast_possible_truncation, reason = "in [0, 60)")]
        let cell = (2.0 * x) as usize;
        let s = x - 0.25 - 0.5 * cell as f64;
        return CELLS[cell.min(59)].iter().rev().fold(0.0, |sum, a| sum * s + a);
    }
    // The asymptotic series, of which 14 terms are left at 30.
    let y = 0.125 / x;
    let term = |sum: f64, k: u32| {
        let odd = f64::from(2 * k - 1);
        1.0 + sum * y * (odd * odd / f64::from(k))
    };
    (1..15).rev().fold(1.0, term) / (TAU * x).sqrt()
}

/// Taylor's series of `y = exp(-x) I0(x)` around `c`, by `x y'' + (1 + 2 x) y' + y = 0`.
fn taylor(c: f64) -> [f64; 14] {
    let mut a = [0.0; 14];
    a[0] = scaled_bessel(0, c);
    a[1] = scaled_bessel(1, c) - a[0];
    for k in 0..12_u32 {
        let (n, at) = (f64::from(k), k as usize);
        let sum = (n + 1.0) * (n + 1.0 + 2.0 * c) * a[at + 1] + (2.0 * n + 1.0) * a[at];
        a[at + 2] = -sum / (c * (n + 2.0) * (n + 1.0));
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn it_is_the_integral_on_both_sides_of_the_seam() {
        for (n, x) in
            [0, 1].into_iter().flat_map(|n| [1e-3, 1.0, 29.99, 30.01, 400.0].map(|x| (n, x)))
        {
            // The trapezoidal rule of a periodic analytic function: its error falls like I_N(x).
            let nodes = 2048;
            let at = |k: u32| f64::from(k) / f64::from(nodes) * PI;
            let of = |psi: f64| (x * (psi.cos() - 1.0)).exp() * (f64::from(n) * psi).cos();
            let inner: f64 = (1..nodes).map(|k| of(at(k))).sum();
            let integral = (inner + 0.5 * (of(0.0) + of(PI))) / f64::from(nodes);
            assert!((scaled_bessel(n, x) / integral - 1.0).abs() < 1e-12, "I_{n}({x})");
        }
    }

    #[test]
    fn the_table_has_the_same_values() {
        for k in 0..100_000 {
            let x = f64::from(k) * 5e-4;
            let whole = scaled_bessel(0, x);
            assert!(
                (scaled_bessel_0(x) / whole - 1.0).abs() < 4e-15,
                "{x} {}",
                scaled_bessel_0(x) / whole - 1.0
            );
        }
        assert_eq!(scaled_bessel_0(1e300), scaled_bessel(0, 1e300));
        assert!(scaled_bessel_0(f64::NAN).is_nan());
    }
}
