//! Arithmetic with a number in each SIMD lane, in the notation of scalars.

use crate::machine::Roots;
use crate::real::Real;
use pulp::Simd;
use std::ops::{Add, Mul, Neg, Sub};

/// Most lanes of any register of doubles.
pub(crate) const LANES: usize = 8;

/// A number in each lane.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd, E: Real = f64> {
    pub(crate) simd: S,
    pub(crate) values: E::Lanes<S>,
}

/// A vector in each lane.
pub(crate) type Vectors<S, E = f64> = [Lanes<S, E>; 3];

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<S: Simd, E: Real> $trait for Lanes<S, E> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { values: E::$method(self.simd, self.values, other.values), ..self }
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);

impl<S: Simd, E: Real> Neg for Lanes<S, E> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { values: E::neg(self.simd, self.values), ..self }
    }
}

impl<S: Simd, E: Real> Lanes<S, E> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self { simd, values: E::splat(simd, E::of(value)) }
    }

    /// Another number in all lanes. Kernels name their steps by functions that are always inlined, as
    /// closures are not compiled for the kernel's machine.
    #[inline(always)]
    pub(crate) fn of(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// A number that is of the kind already in all lanes.
    #[inline(always)]
    pub(crate) fn all(simd: S, value: E) -> Self {
        Self { simd, values: E::splat(simd, value) }
    }

    /// The first lanes of an array, which has as many as a register.
    #[inline(always)]
    pub(crate) fn load(simd: S, values: &[E]) -> Self {
        Self { simd, values: E::registers::<S>(values)[0] }
    }

    /// `self * factor + summand`, rounded once where the machine can.
    #[inline(always)]
    pub(crate) fn times_plus(self, factor: Self, summand: Self) -> Self {
        let values = E::mul_add(self.simd, self.values, factor.values, summand.values);
        Self { values, ..self }
    }

    /// `summand - self * factor`.
    #[inline(always)]
    pub(crate) fn times_from(self, factor: Self, summand: Self) -> Self {
        let values = E::mul_from(self.simd, self.values, factor.values, summand.values);
        Self { values, ..self }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { values: E::abs(self.simd, self.values), ..self }
    }

    #[inline(always)]
    pub(crate) fn square_root(self) -> Self {
        Self { values: E::sqrt(self.simd, self.values), ..self }
    }

    #[inline(always)]
    pub(crate) fn over(self, other: Self) -> Self {
        Self { values: E::div(self.simd, self.values, other.values), ..self }
    }

    /// Whether this is below `limit` in any lane.
    #[inline(always)]
    pub(crate) fn any_below(self, limit: Self) -> bool {
        E::any_below(self.simd, [self.values, limit.values])
    }

    /// `yes` in the lanes where this is below `limit`, `no` in the others.
    #[inline(always)]
    pub(crate) fn below(self, limit: Self, yes: Self, no: Self) -> Self {
        let sides = [self.values, limit.values];
        Self { values: E::below(self.simd, sides, yes.values, no.values), ..self }
    }
}

impl<S: Simd> Lanes<S> {
    /// The lanes one after another; those beyond the register are zero.
    #[inline(always)]
    pub(crate) fn store(self) -> [f64; LANES] {
        let mut out = [0.0; LANES];
        f64::registers_mut::<S>(&mut out)[0] = self.values;
        out
    }
}

impl<S: Simd, E: Real> Lanes<S, E> {
    /// The sum of all lanes.
    #[inline(always)]
    pub(crate) fn sum(self) -> E {
        E::sum(self.simd, self.values)
    }

    /// The lanes one after another, as many as a register has.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> &[E] {
        pulp::bytemuck::cast_slice(std::slice::from_ref(&self.values))
    }
}

#[inline(always)]
pub(crate) fn dot<S: Simd, E: Real>(a: &Vectors<S, E>, b: &Vectors<S, E>) -> Lanes<S, E> {
    a[2].times_plus(b[2], a[1].times_plus(b[1], a[0] * b[0]))
}

#[inline(always)]
pub(crate) fn cross<S: Simd, E: Real>(a: &Vectors<S, E>, b: &Vectors<S, E>) -> Vectors<S, E> {
    [
        a[2].times_from(b[1], a[1] * b[2]),
        a[0].times_from(b[2], a[2] * b[0]),
        a[1].times_from(b[0], a[0] * b[1]),
    ]
}

#[inline(always)]
pub(crate) fn minus<S: Simd, E: Real>(a: &Vectors<S, E>, b: &Vectors<S, E>) -> Vectors<S, E> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scaled<S: Simd, E: Real>(a: &Vectors<S, E>, factor: Lanes<S, E>) -> Vectors<S, E> {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// `a + b * factor`.
#[inline(always)]
pub(crate) fn along<S: Simd, E: Real>(
    a: &Vectors<S, E>,
    b: &Vectors<S, E>,
    factor: Lanes<S, E>,
) -> Vectors<S, E> {
    [b[0].times_plus(factor, a[0]), b[1].times_plus(factor, a[1]), b[2].times_plus(factor, a[2])]
}

/// Natural logarithms of positive normal numbers, to some units in the last place.
#[inline(always)]
pub(crate) fn ln<S: Simd, R: Roots<S>>(roots: R, x: Lanes<S>) -> Lanes<S> {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    const ROOT: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    // 2^52 as bits: adding a small integer to these bits adds it to the number.
    const SHIFTED: u64 = 0x4330_0000_0000_0000;
    let [mut exponent, mut mantissa] = [[0.0; LANES]; 2];
    for ((x, exponent), mantissa) in x.store().iter().zip(&mut exponent).zip(&mut mantissa) {
        // Mantissas run from sqrt(1/2) to sqrt(2).
        let bits = x.to_bits().wrapping_add(ONE - ROOT);
        *exponent = f64::from_bits((bits >> 52) | SHIFTED);
        *mantissa = f64::from_bits((bits & MANTISSA) + ROOT);
    }
    let (m, one) = (Lanes::load(x.simd, &mantissa), x.of(1.0));
    let exponent = Lanes::load(x.simd, &exponent) - x.of(4_503_599_627_370_496.0 + 1023.0);
    let f = (m - one) * roots.reciprocal(m + one);
    let w = f * f;
    let mut sum = x.of(1.0 / 21.0);
    for n in (0..=9).rev() {
        sum = sum.times_plus(w, x.of(1.0 / (2 * n + 1) as f64));
    }
    exponent.times_plus(x.of(std::f64::consts::LN_2), (f + f) * sum)
}

/// `ln((R1 + w1)/(R0 + w0))` in the form that does not cancel, where `R^2 - w^2` is the same for both.
#[inline(always)]
pub(crate) fn log<S: Simd, R: Roots<S>>(roots: R, w: [Lanes<S>; 2], r: [Lanes<S>; 2]) -> Lanes<S> {
    let sign = (w[0] + w[1]).below(w[0].of(0.0), w[0].of(-1.0), w[0].of(1.0));
    let (a, b) = (sign.times_plus(w[0], r[0]), sign.times_plus(w[1], r[1]));
    sign * ln(roots, b * roots.reciprocal(a))
}

/// Angles of the points `(x, y)` between 0 and `2 pi`; those that are below zero by rounding stay so.
#[inline(always)]
pub(crate) fn angle<S: Simd, R: Roots<S>>(roots: R, x: Lanes<S>, y: Lanes<S>) -> Lanes<S> {
    use std::f64::consts::{FRAC_PI_4, FRAC_PI_8, PI};
    const ROUNDING: f64 = -1e-10;
    let (width, height) = (x.abs(), y.abs());
    // Seen from the nearest of 0, 45 and 90 degrees the angle is at most 22.5 degrees.
    let (steep, flat) = (width * x.of(FRAC_PI_8.tan()), height * x.of(FRAC_PI_8.tan()));
    let middle = [x.of(1.0), height - width, height + width];
    let mut pick = [x.of(0.0); 3];
    for (k, [low, high]) in
        [[x.of(0.0), x.of(2.0)], [height, -width], [width, height]].into_iter().enumerate()
    {
        pick[k] = height.below(steep, low, width.below(flat, high, middle[k]));
    }
    let [base, opposite, adjacent] = pick;
    let t = opposite * roots.reciprocal(adjacent);
    let w = t * t;
    let mut sum = x.of(1.0 / 41.0);
    for n in (0..20).rev() {
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        sum = sum.times_plus(w, x.of(sign / (2 * n + 1) as f64));
    }
    let acute = base.times_plus(x.of(FRAC_PI_4), t * sum);
    let half = x.below(x.of(0.0), x.of(PI) - acute, acute);
    let signed = y.below(x.of(0.0), -half, half);
    signed.below(x.of(ROUNDING), signed + x.of(2.0 * PI), signed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Kernel, Usual, dispatch};
    use pulp::Arch;

    struct Check;

    impl Kernel for Check {
        fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
            let splat = |value: f64| Lanes::splat(simd, value);
            for x in [1.0, 1.0 + 1e-9, 0.7, 1.414, 2.0, 1e-200, 3e17, 12.5] {
                let [log, root, inverse] = [
                    ln(roots, splat(x)).store()[0],
                    roots.root(splat(x)).store()[0],
                    roots.inverse_root(splat(x)).store()[0],
                ];
                assert!((log - x.ln()).abs() <= 5e-16 * x.ln().abs().max(0.3), "ln {x} = {log}");
                assert!((root / x.sqrt() - 1.0).abs() < 4e-16, "sqrt {x} = {root}");
                assert!((inverse * x.sqrt() - 1.0).abs() < 6e-13, "{x}: {inverse}");
                let reciprocal = roots.reciprocal(splat(x)).store()[0];
                assert!((reciprocal * x - 1.0).abs() < 4e-16, "1/{x} = {reciprocal}");
            }
            assert!(roots.inverse_root(splat(0.0)).store()[0] == 0.0);
            for k in 0..200 {
                let exact = 0.0314 * f64::from(k);
                let found = angle(roots, splat(3.0 * exact.cos()), splat(3.0 * exact.sin()));
                assert!((found.store()[0] - exact).abs() < 1e-15 * exact.max(1.0), "{exact}");
            }
            let rounded = angle(roots, splat(1.0), splat(-1e-15)).store()[0];
            assert!((rounded + 1e-15).abs() < 1e-20, "{rounded}");
        }
    }

    #[test]
    fn functions_are_exact() {
        dispatch(Check);
        Arch::new().dispatch(Usual(Check));
    }
}
