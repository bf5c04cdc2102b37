//! Functions of a number in each lane, in double precision.

use crate::{LANES, Lane, Roots};
use pulp::Simd;

/// Natural logarithms of positive normal numbers, to some units in the last place.
#[inline(always)]
pub fn ln<S: Simd, R: Roots<S>>(roots: R, x: Lane<S>) -> Lane<S> {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    const ROOT: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    // 2^52 as bits: adding a small integer to these bits adds it to the number.
    const SHIFTED: u64 = 0x4330_0000_0000_0000;
    let [mut exponent, mut mantissa] = [[0.0; LANES]; 2];
    for ((x, exponent), mantissa) in x.numbers().iter().zip(&mut exponent).zip(&mut mantissa) {
        // Mantissas run from sqrt(1/2) to sqrt(2).
        let bits = x.to_bits().wrapping_add(ONE - ROOT);
        *exponent = f64::from_bits((bits >> 52) | SHIFTED);
        *mantissa = f64::from_bits((bits & MANTISSA) + ROOT);
    }
    let (m, one) = (Lane::load(x.simd(), &mantissa, 0), x.lift(1.0));
    let exponent = Lane::load(x.simd(), &exponent, 0) - x.lift(4_503_599_627_370_496.0 + 1023.0);
    let f = (m - one) * roots.recip(m + one);
    let w = f * f;
    let mut sum = x.lift(1.0 / 21.0);
    for n in (0..=9).rev() {
        sum = sum.mul_add(w, x.lift(1.0 / (2 * n + 1) as f64));
    }
    exponent.mul_add(x.lift(std::f64::consts::LN_2), (f + f) * sum)
}

/// Angles of the points `(x, y)` between 0 and `2 pi`; those that are below zero by rounding stay
/// so.
#[inline(always)]
pub fn angle<S: Simd, R: Roots<S>>(roots: R, x: Lane<S>, y: Lane<S>) -> Lane<S> {
    use std::f64::consts::{FRAC_PI_4, FRAC_PI_8, PI};
    const ROUNDING: f64 = -1e-10;
    let (width, height) = (x.abs(), y.abs());
    // Seen from the nearest of 0, 45 and 90 degrees the angle is at most 22.5 degrees.
    let (steep, flat) = (width * x.lift(FRAC_PI_8.tan()), height * x.lift(FRAC_PI_8.tan()));
    let middle = [x.lift(1.0), height - width, height + width];
    let mut pick = [x.lift(0.0); 3];
    for (k, [low, high]) in
        [[x.lift(0.0), x.lift(2.0)], [height, -width], [width, height]].into_iter().enumerate()
    {
        pick[k] =
            height.less_than(steep).select(low, width.less_than(flat).select(high, middle[k]));
    }
    let [base, opposite, adjacent] = pick;
    let t = opposite * roots.recip(adjacent);
    let w = t * t;
    let mut sum = x.lift(1.0 / 41.0);
    for n in (0..20).rev() {
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        sum = sum.mul_add(w, x.lift(sign / (2 * n + 1) as f64));
    }
    let acute = base.mul_add(x.lift(FRAC_PI_4), t * sum);
    let half = x.less_than(x.lift(0.0)).select(x.lift(PI) - acute, acute);
    let signed = y.less_than(x.lift(0.0)).select(-half, half);
    signed.less_than(x.lift(ROUNDING)).select(signed + x.lift(2.0 * PI), signed)
}
