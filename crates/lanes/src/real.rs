//! Numbers of single and double precision, a register of them at a time.

use pulp::Simd;
use pulp::bytemuck::Pod;

/// Most lanes of any register of doubles.
pub const LANES: usize = 8;

/// Most lanes of any register of numbers of single precision.
pub const LANES_F32: usize = 2 * LANES;

/// A type of floating-point numbers, `f32` or `f64`, with the arithmetic of its registers.
pub trait Real: Pod + Send + Sync + PartialOrd {
    /// A register of numbers.
    type Register<S: Simd>: Pod + Send + Sync;
    /// A truth value for each number of a register.
    type Mask<S: Simd>: Copy;

    /// The nearest number to `value`.
    fn from_f64(value: f64) -> Self;
    /// The number in double precision.
    fn to_f64(self) -> f64;
    /// The full registers of a slice; numbers that do not fill a register are left out.
    fn registers<S: Simd>(values: &[Self]) -> &[Self::Register<S>];
    /// The full registers of a slice, to be changed.
    fn registers_mut<S: Simd>(values: &mut [Self]) -> &mut [Self::Register<S>];
    /// `value` in all lanes.
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Register<S>;
    /// `a + b`.
    fn add<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a - b`.
    fn sub<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a * b`.
    fn mul<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a / b`.
    fn div<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// The larger of `a` and `b`. Of a number and a NaN either.
    fn max<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// The smaller of `a` and `b`. Of a number and a NaN either.
    fn min<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `-a`.
    fn neg<S: Simd>(simd: S, a: Self::Register<S>) -> Self::Register<S>;
    /// The absolute value of `a`.
    fn abs<S: Simd>(simd: S, a: Self::Register<S>) -> Self::Register<S>;
    /// The square root of `a`.
    fn sqrt<S: Simd>(simd: S, a: Self::Register<S>) -> Self::Register<S>;
    /// `a * b + c` with one rounding where the machine has it.
    fn mul_add<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
        c: Self::Register<S>,
    ) -> Self::Register<S>;
    /// `c - a * b` with one rounding where the machine has it.
    fn negate_mul_add<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
        c: Self::Register<S>,
    ) -> Self::Register<S>;
    /// Whether `a < b`, false for NaN.
    fn less_than<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Mask<S>;
    /// Whether `a <= b`, false for NaN.
    fn less_or_equal<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>)
    -> Self::Mask<S>;
    /// `yes` in the lanes where `mask` is true, `no` in the others.
    fn select<S: Simd>(
        simd: S,
        mask: Self::Mask<S>,
        yes: Self::Register<S>,
        no: Self::Register<S>,
    ) -> Self::Register<S>;
    /// Whether `mask` is true in any lane.
    fn any<S: Simd>(simd: S, mask: Self::Mask<S>) -> bool;
    /// The sum of all lanes.
    fn reduce_sum<S: Simd>(simd: S, a: Self::Register<S>) -> Self;
    /// The largest of all lanes.
    fn reduce_max<S: Simd>(simd: S, a: Self::Register<S>) -> Self;

    /// Number of lanes of a register.
    #[inline(always)]
    fn lanes<S: Simd>() -> usize {
        size_of::<Self::Register<S>>() / size_of::<Self>()
    }
}

macro_rules! real {
    ($real:ident, $register:ident, $mask:ident, {
        registers $as:ident $as_mut:ident
        splat $splat:ident
        unary $([$unary:ident $of_one:ident])*
        binary $([$binary:ident $of_two:ident])*
        ternary $([$ternary:ident $of_three:ident])*
        compare $([$compare:ident $of_sides:ident])*
        masks $select:ident $first_true:ident
        reduce $([$reduce:ident $of_lanes:ident])*
    }) => {
        impl Real for $real {
            type Register<S: Simd> = S::$register;
            type Mask<S: Simd> = S::$mask;

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, reason = "rounding is meant")]
            fn from_f64(value: f64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn registers<S: Simd>(values: &[Self]) -> &[S::$register] {
                S::$as(values).0
            }

            #[inline(always)]
            fn registers_mut<S: Simd>(values: &mut [Self]) -> &mut [S::$register] {
                S::$as_mut(values).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$register {
                simd.$splat(value)
            }

            $(#[inline(always)]
            fn $unary<S: Simd>(simd: S, a: S::$register) -> S::$register {
                simd.$of_one(a)
            })*

            $(#[inline(always)]
            fn $binary<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$of_two(a, b)
            })*

            $(#[inline(always)]
            fn $ternary<S: Simd>(
                simd: S,
                a: S::$register,
                b: S::$register,
                c: S::$register,
            ) -> S::$register {
                simd.$of_three(a, b, c)
            })*

            $(#[inline(always)]
            fn $compare<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$mask {
                simd.$of_sides(a, b)
            })*

            #[inline(always)]
            fn select<S: Simd>(
                simd: S,
                mask: S::$mask,
                yes: S::$register,
                no: S::$register,
            ) -> S::$register {
                simd.$select(mask, yes, no)
            }

            #[inline(always)]
            fn any<S: Simd>(simd: S, mask: S::$mask) -> bool {
                simd.$first_true(mask) < Self::lanes::<S>()
            }

            $(#[inline(always)]
            fn $reduce<S: Simd>(simd: S, a: S::$register) -> Self {
                simd.$of_lanes(a)
            })*
        }
    };
}

real!(f64, f64s, m64s, {
    registers as_simd_f64s as_mut_simd_f64s
    splat splat_f64s
    unary [neg neg_f64s] [abs abs_f64s] [sqrt sqrt_f64s]
    binary [add add_f64s] [sub sub_f64s] [mul mul_f64s] [div div_f64s] [max max_f64s] [min min_f64s]
    ternary [mul_add mul_add_e_f64s] [negate_mul_add negate_mul_add_e_f64s]
    compare [less_than less_than_f64s] [less_or_equal less_than_or_equal_f64s]
    masks select_f64s first_true_m64s
    reduce [reduce_sum reduce_sum_f64s] [reduce_max reduce_max_f64s]
});
real!(f32, f32s, m32s, {
    registers as_simd_f32s as_mut_simd_f32s
    splat splat_f32s
    unary [neg neg_f32s] [abs abs_f32s] [sqrt sqrt_f32s]
    binary [add add_f32s] [sub sub_f32s] [mul mul_f32s] [div div_f32s] [max max_f32s] [min min_f32s]
    ternary [mul_add mul_add_e_f32s] [negate_mul_add negate_mul_add_e_f32s]
    compare [less_than less_than_f32s] [less_or_equal less_than_or_equal_f32s]
    masks select_f32s first_true_m32s
    reduce [reduce_sum reduce_sum_f32s] [reduce_max reduce_max_f32s]
});
