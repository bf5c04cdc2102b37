use std::f64::consts::TAU;

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
}
