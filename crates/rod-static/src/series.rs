//! Entire functions of the squared angle that the geometry of a segment is made of, by their power
//! series: no sine, no square root, and no special case at zero.

/// Number of terms for squared angles up to [`SMALL_ARGUMENT`].
const FEW_TERMS: usize = 10;
/// Number of terms for angles up to half a turn.
const MANY: usize = 20;
/// Squared angle up to which few terms are enough: the next one is `1 / 22!` of the first.
const SMALL_ARGUMENT: f64 = 1.0;

/// Coefficients of `(1 - cos a) / a^2` in powers of `a^2`.
const C2: [f64; MANY] = coefficients(2);
/// Coefficients of `(a - sin a) / a^3` in powers of `a^2`.
const C3: [f64; MANY] = coefficients(3);
/// Coefficients of `(2 (1 - cos a) - a sin a) / a^4` in powers of `a^2`.
const E: [f64; MANY] = {
    let (c3, mut c4) = (coefficients(3), coefficients(4));
    let mut k = 0;
    while k < MANY {
        c4[k] = c3[k] - 2.0 * c4[k];
        k += 1;
    }
    c4
};

/// Coefficients `(-1)^k / (2 k + first)!` of a power series.
const fn coefficients(first: usize) -> [f64; MANY] {
    let mut terms = [0.0; MANY];
    let mut term = 1.0;
    let mut i = 2;
    while i <= first {
        term /= i as f64;
        i += 1;
    }
    let mut k = 0;
    while k < MANY {
        terms[k] = term;
        term /= -(((2 * k + first + 1) * (2 * k + first + 2)) as f64);
        k += 1;
    }
    terms
}

/// Value, first derivative and half the second derivative of a function.
pub(crate) type Jet = [f64; 3];

fn jet(terms: &[f64]) -> impl Fn(f64) -> Jet {
    move |x| {
        let [mut value, mut first, mut second] = [0.0; 3];
        for term in terms.iter().rev() {
            second = second * x + first;
            first = first * x + value;
            value = value * x + term;
        }
        [value, first, second]
    }
}

/// `c2 = (1 - cos a) / a^2` and `c3 = (a - sin a) / a^3` of the squared angle `x = a^2`.
pub(crate) fn curve(x: f64) -> [Jet; 2] {
    let count = if x < SMALL_ARGUMENT { FEW_TERMS } else { MANY };
    [jet(&C2[..count])(x), jet(&C3[..count])(x)]
}

/// The values of [`curve`] alone.
pub(crate) fn curve_values(x: f64) -> [f64; 2] {
    let count = if x < SMALL_ARGUMENT { FEW_TERMS } else { MANY };
    let value = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * x + term);
    [value(&C2[..count]), value(&C3[..count])]
}

/// `d = (1 - (a / 2) cot(a / 2)) / a^2` and its derivative by `x = a^2`, from the jet of `c2`.
pub(crate) fn logarithm(x: f64, c2: &Jet) -> [f64; 2] {
    let count = if x < SMALL_ARGUMENT { FEW_TERMS } else { MANY };
    let e = jet(&E[..count])(x);
    let d = 0.5 * e[0] / c2[0];
    [d, (0.5 * e[1] - d * c2[1]) / c2[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn series_are_the_closed_forms() {
        for a in [0.3_f64, 0.9, 0.999, 1.001, 2.0, 3.0, 3.1] {
            let x = a * a;
            let [c2, c3] = curve(x);
            assert_relative_eq!(c2[0], (1.0 - a.cos()) / x, max_relative = 1e-14);
            assert_relative_eq!(c3[0], (a - a.sin()) / (x * a), max_relative = 1e-13);
            assert_eq!(curve_values(x), [c2[0], c3[0]]);
            let [d, _] = logarithm(x, &c2);
            assert_relative_eq!(d, (1.0 - 0.5 * a / (0.5 * a).tan()) / x, max_relative = 1e-13);
        }
    }

    #[test]
    fn derivatives_are_those_of_the_values() {
        for x in [0.0, 0.2, 0.7, 1.5, 6.0, 9.8] {
            let h = 1e-4;
            let [low, middle, high] = [x - h, x, x + h].map(curve);
            let d = [x - h, x, x + h].map(|x| logarithm(x, &curve(x)[0]));
            for i in 0..2 {
                let first = (high[i][0] - low[i][0]) / (2.0 * h);
                let second = (high[i][1] - low[i][1]) / (4.0 * h);
                assert_relative_eq!(middle[i][1], first, max_relative = 1e-8);
                assert_relative_eq!(middle[i][2], second, max_relative = 1e-8);
            }
            assert_relative_eq!(d[1][1], (d[2][0] - d[0][0]) / (2.0 * h), max_relative = 1e-7);
        }
    }
}
