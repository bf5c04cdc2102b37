#![doc = include_str!("../README.md")]

use pulp::Simd;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number for each of as many things as a register holds.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Lane<S: Simd> {
    simd: S,
    /// The register.
    pub value: S::f64s,
}

impl<S: Simd> Lane<S> {
    /// The numbers of a register.
    #[inline(always)]
    pub fn new(simd: S, value: S::f64s) -> Self {
        Self { simd, value }
    }

    /// The constant `x` in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self { simd, value: simd.splat_f64s(x) }
    }

    /// Those of an array that this register of several holds. Loads of a part of a register are not
    /// offered: where two registers stand for a wide one, those of `pulp` 0.22 leave half of it unset.
    ///
    /// # Panics
    /// If the array is shorter.
    #[inline(always)]
    pub fn load(simd: S, all: &[f64], register: usize) -> Self {
        Self { simd, value: S::as_simd_f64s(all).0[register] }
    }

    /// Puts the numbers where [`Lane::load`] finds them.
    ///
    /// # Panics
    /// If the array is shorter.
    #[inline(always)]
    pub fn store(self, all: &mut [f64], register: usize) {
        S::as_mut_simd_f64s(all).0[register] = self.value;
    }

    /// The token that the operations take.
    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }

    /// The constant `x` in all lanes.
    #[inline(always)]
    #[must_use]
    pub fn lift(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    /// `self * b + c` with one rounding where the machine has it.
    #[inline(always)]
    #[must_use]
    pub fn fma(self, b: Self, c: Self) -> Self {
        Self::new(self.simd, self.simd.mul_add_e_f64s(self.value, b.value, c.value))
    }

    /// `c - self * b`.
    #[inline(always)]
    #[must_use]
    pub fn nma(self, b: Self, c: Self) -> Self {
        (-self).fma(b, c)
    }

    /// The square root.
    #[inline(always)]
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self::new(self.simd, self.simd.sqrt_f64s(self.value))
    }

    /// `1 / self`.
    #[inline(always)]
    #[must_use]
    pub fn recip(self) -> Self {
        self.lift(1.0) / self
    }

    /// The absolute value.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        Self::new(self.simd, self.simd.abs_f64s(self.value))
    }

    /// The larger of two. Of a number and a NaN either.
    #[inline(always)]
    #[must_use]
    pub fn max(self, b: Self) -> Self {
        Self::new(self.simd, self.simd.max_f64s(self.value, b.value))
    }

    /// The smaller of two. Of a number and a NaN either.
    #[inline(always)]
    #[must_use]
    pub fn min(self, b: Self) -> Self {
        Self::new(self.simd, self.simd.min_f64s(self.value, b.value))
    }

    /// 1 where `self > 0`, else -1 (also for NaN).
    #[inline(always)]
    #[must_use]
    pub fn sign(self) -> Self {
        self.positive_or(self.lift(1.0), self.lift(-1.0))
    }

    /// `yes` where `self > 0`, else `no` (also for NaN).
    #[inline(always)]
    #[must_use]
    pub fn positive_or(self, yes: Self, no: Self) -> Self {
        let mask = self.simd.greater_than_f64s(self.value, self.simd.splat_f64s(0.0));
        Self::new(self.simd, self.simd.select_f64s(mask, yes.value, no.value))
    }

    /// `yes` where `self <= bound`, else `no` (also for NaN).
    #[inline(always)]
    #[must_use]
    pub fn at_most(self, bound: Self, yes: Self, no: Self) -> Self {
        let mask = self.simd.less_than_or_equal_f64s(self.value, bound.value);
        Self::new(self.simd, self.simd.select_f64s(mask, yes.value, no.value))
    }

    /// The sum of all lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.value)
    }

    /// The largest of all lanes.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.simd.reduce_max_f64s(self.value)
    }
}

macro_rules! operator {
    ($operator:ident, $function:ident, $of_registers:ident) => {
        impl<S: Simd> $operator for Lane<S> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, b: Self) -> Self {
                Self::new(self.simd, self.simd.$of_registers(self.value, b.value))
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Lane<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, self.simd.neg_f64s(self.value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use pulp::{Arch, NullaryFnOnce, Scalar, Scalar128b, Scalar512b, WithSimd};

    /// All operations on three numbers in each lane.
    struct All<'a>([&'a [f64; 8]; 3]);

    /// What they give, by lane, and over all lanes of every register.
    type Found = ([[f64; 8]; 16], [f64; 2]);

    impl WithSimd for All<'_> {
        type Output = Found;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Found {
            let (mut found, mut over) = ([[0.0; 8]; 16], [0.0, f64::NEG_INFINITY]);
            for register in 0..8 / S::F64_LANES {
                let [a, b, c] = self.0.map(|all| Lane::load(simd, all, register));
                let all = [
                    a + b,
                    a - b,
                    a * b,
                    a / b,
                    -a,
                    a.fma(b, c),
                    a.nma(b, c),
                    a.abs().sqrt(),
                    a.recip(),
                    a.abs(),
                    a.max(b),
                    a.min(b),
                    a.sign(),
                    a.positive_or(b, c),
                    a.at_most(b, c, a),
                    a.lift(3.0),
                ];
                for (found, lane) in found.iter_mut().zip(all) {
                    lane.store(found, register);
                }
                over = [over[0] + a.sum(), over[1].max(a.largest())];
            }
            (found, over)
        }
    }

    /// By registers of one width, with the instructions that they need.
    struct At<'a, S>(S, All<'a>);

    impl<S: Simd> NullaryFnOnce for At<'_, S> {
        type Output = Found;

        #[inline(always)]
        fn call(self) -> Found {
            self.1.with_simd(self.0)
        }
    }

    /// By registers of every width that this machine can have.
    fn by_all_widths(all: [&[f64; 8]; 3]) -> Vec<Found> {
        fn at<S: Simd>(simd: S, all: [&[f64; 8]; 3]) -> Found {
            simd.vectorize(At(simd, All(all)))
        }
        let mut found = vec![
            Arch::new().dispatch(All(all)),
            at(Scalar::new(), all),
            at(Scalar128b, all),
            at(Scalar512b, all),
        ];
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            found.push(at(pulp::x86::V3_128b(simd), all));
            found.push(at(pulp::x86::V3_512b(simd), all));
        }
        found
    }

    /// The same, number by number, without rounding twice.
    fn expected([a, b, c]: [f64; 3]) -> [f64; 16] {
        [
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.mul_add(b, c),
            (-a).mul_add(b, c),
            a.abs().sqrt(),
            1.0 / a,
            a.abs(),
            a.max(b),
            a.min(b),
            if a > 0.0 { 1.0 } else { -1.0 },
            if a > 0.0 { b } else { c },
            if a <= b { c } else { a },
            3.0,
        ]
    }

    fn numbers() -> impl Strategy<Value = [f64; 8]> {
        let special = prop::sample::select(vec![1.0, -1.0, 0.5, 2.0]);
        prop::array::uniform8(prop_oneof![4 => -1e3..1e3, 1 => special])
    }

    proptest! {
        /// One by one and by as many as a register has: only a machine that rounds twice differs, where a
        /// product and a sum are one.
        #[test]
        fn lanes_do_what_numbers_do(a in numbers(), b in numbers(), c in numbers()) {
            let all = [&a, &b, &c];
            for (found, over) in by_all_widths(all) {
                for i in 0..8 {
                    for (k, expected) in expected([a[i], b[i], c[i]]).into_iter().enumerate() {
                        let rounding = if k == 5 || k == 6 { 1e-15 * (a[i] * b[i]).abs().max(c[i].abs()) } else { 0.0 };
                        let error = (found[k][i] - expected).abs();
                        prop_assert!(error <= 2.0 * rounding, "operation {}: {} for {}", k, found[k][i], expected);
                    }
                }
                prop_assert!((over[0] - a.iter().sum::<f64>()).abs() <= 1e-11);
                prop_assert_eq!(over[1], a.iter().copied().fold(f64::NEG_INFINITY, f64::max));
            }
        }
    }
}
