//! A number for each of several things at once, in the notation of scalars.

use crate::Real;
use pulp::Simd;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number for each of as many things as a register holds.
#[derive(Clone, Copy)]
pub struct Lane<S: Simd, E: Real = f64> {
    simd: S,
    /// The register.
    pub value: E::Register<S>,
}

/// A truth value for each of as many things as a register holds.
#[derive(Clone, Copy)]
pub struct Mask<S: Simd, E: Real = f64> {
    simd: S,
    value: E::Mask<S>,
}

/// What can be chosen in each lane by a mask.
pub trait Select<S: Simd, E: Real = f64> {
    /// `yes` in the lanes where `mask` is true, `no` in the others.
    fn select(mask: Mask<S, E>, yes: Self, no: Self) -> Self;
}

impl<S: Simd, E: Real> Select<S, E> for Lane<S, E> {
    #[inline(always)]
    fn select(mask: Mask<S, E>, yes: Self, no: Self) -> Self {
        Self::new(mask.simd, E::select(mask.simd, mask.value, yes.value, no.value))
    }
}

impl<S: Simd, E: Real> Mask<S, E> {
    /// `yes` in the lanes where the mask is true, `no` in the others.
    #[inline(always)]
    pub fn select<T: Select<S, E>>(self, yes: T, no: T) -> T {
        T::select(self, yes, no)
    }

    /// Whether the mask is true in any lane.
    #[inline(always)]
    pub fn any(self) -> bool {
        E::any(self.simd, self.value)
    }
}

impl<S: Simd, E: Real> Lane<S, E> {
    /// The numbers of a register.
    #[inline(always)]
    pub fn new(simd: S, value: E::Register<S>) -> Self {
        Self { simd, value }
    }

    /// The constant `x` in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: E) -> Self {
        Self::new(simd, E::splat(simd, x))
    }

    /// The numbers of an array from `register` times the number of lanes on. Loads of a part of
    /// a register are not offered: where two registers stand for a wide one, those of `pulp` 0.22
    /// leave half of it unset.
    ///
    /// # Panics
    /// If the array is shorter.
    #[inline(always)]
    pub fn load(simd: S, all: &[E], register: usize) -> Self {
        Self::new(simd, E::registers::<S>(all)[register])
    }

    /// Puts the numbers where [`Lane::load`] finds them.
    ///
    /// # Panics
    /// If the array is shorter.
    #[inline(always)]
    pub fn store(self, all: &mut [E], register: usize) {
        E::registers_mut::<S>(all)[register] = self.value;
    }

    /// The numbers one after another, as many as a register has lanes.
    #[inline(always)]
    pub fn numbers(&self) -> &[E] {
        pulp::bytemuck::cast_slice(std::slice::from_ref(&self.value))
    }

    /// The token that the operations take.
    #[inline(always)]
    pub fn simd(self) -> S {
        self.simd
    }

    /// The constant `x`, rounded to the type of the numbers, in all lanes.
    #[inline(always)]
    #[must_use]
    pub fn lift(self, x: f64) -> Self {
        Self::splat(self.simd, E::from_f64(x))
    }

    /// `self * b + c` with one rounding where the machine has it.
    #[inline(always)]
    #[must_use]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        Self::new(self.simd, E::mul_add(self.simd, self.value, b.value, c.value))
    }

    /// `c - self * b` with one rounding where the machine has it.
    #[inline(always)]
    #[must_use]
    pub fn negate_mul_add(self, b: Self, c: Self) -> Self {
        Self::new(self.simd, E::negate_mul_add(self.simd, self.value, b.value, c.value))
    }

    /// The square root.
    #[inline(always)]
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self::new(self.simd, E::sqrt(self.simd, self.value))
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
        Self::new(self.simd, E::abs(self.simd, self.value))
    }

    /// The larger of two. Of a number and a NaN either.
    #[inline(always)]
    #[must_use]
    pub fn max(self, b: Self) -> Self {
        Self::new(self.simd, E::max(self.simd, self.value, b.value))
    }

    /// The smaller of two. Of a number and a NaN either.
    #[inline(always)]
    #[must_use]
    pub fn min(self, b: Self) -> Self {
        Self::new(self.simd, E::min(self.simd, self.value, b.value))
    }

    /// 1 where `self > 0`, else -1 (also for NaN).
    #[inline(always)]
    #[must_use]
    pub fn sign(self) -> Self {
        self.positive().select(self.lift(1.0), self.lift(-1.0))
    }

    /// The nearest integer, of two the even one, for doubles of up to 2^51 in size.
    #[inline(always)]
    #[must_use]
    pub fn round(self) -> Self {
        // In numbers of this size the last digit stands for one.
        let large = self.lift(6_755_399_441_055_744.0);
        self + large - large
    }

    /// Whether `self > 0`, false for NaN.
    #[inline(always)]
    pub fn positive(self) -> Mask<S, E> {
        self.lift(0.0).less_than(self)
    }

    /// Whether `self < b`, false for NaN.
    #[inline(always)]
    pub fn less_than(self, b: Self) -> Mask<S, E> {
        Mask { simd: self.simd, value: E::less_than(self.simd, self.value, b.value) }
    }

    /// Whether `self <= b`, false for NaN.
    #[inline(always)]
    pub fn less_or_equal(self, b: Self) -> Mask<S, E> {
        Mask { simd: self.simd, value: E::less_or_equal(self.simd, self.value, b.value) }
    }

    /// The sum of all lanes.
    #[inline(always)]
    pub fn reduce_sum(self) -> E {
        E::reduce_sum(self.simd, self.value)
    }

    /// The largest of all lanes.
    #[inline(always)]
    pub fn reduce_max(self) -> E {
        E::reduce_max(self.simd, self.value)
    }
}

macro_rules! operator {
    ($operator:ident, $function:ident) => {
        impl<S: Simd, E: Real> $operator for Lane<S, E> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, b: Self) -> Self {
                Self::new(self.simd, E::$function(self.simd, self.value, b.value))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<S: Simd, E: Real> Neg for Lane<S, E> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, E::neg(self.simd, self.value))
    }
}
