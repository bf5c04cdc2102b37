//! Numbers of single and double precision, a register of them at a time.

use crate::harmonics::Moves;
use crate::lanes::Lanes;
use crate::machine::{Machine, Roots};
use crate::transpose::{ROWS, Transpose};
use pulp::Simd;
use pulp::bytemuck::Pod;
use std::sync::OnceLock;

/// `f32` or `f64`.
pub(crate) trait Real: Pod + Send + Sync + PartialOrd {
    /// A register of such numbers.
    type Lanes<S: Simd>: Pod + Send + Sync;

    fn of(value: f64) -> Self;
    fn double(self) -> f64;
    /// The registers in a slice; what does not fill one is left out.
    fn registers<S: Simd>(values: &[Self]) -> &[Self::Lanes<S>];
    fn registers_mut<S: Simd>(values: &mut [Self]) -> &mut [Self::Lanes<S>];
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Lanes<S>;
    fn add<S: Simd>(simd: S, a: Self::Lanes<S>, b: Self::Lanes<S>) -> Self::Lanes<S>;
    fn sub<S: Simd>(simd: S, a: Self::Lanes<S>, b: Self::Lanes<S>) -> Self::Lanes<S>;
    fn mul<S: Simd>(simd: S, a: Self::Lanes<S>, b: Self::Lanes<S>) -> Self::Lanes<S>;
    fn div<S: Simd>(simd: S, a: Self::Lanes<S>, b: Self::Lanes<S>) -> Self::Lanes<S>;
    fn sqrt<S: Simd>(simd: S, a: Self::Lanes<S>) -> Self::Lanes<S>;
    fn neg<S: Simd>(simd: S, a: Self::Lanes<S>) -> Self::Lanes<S>;
    fn abs<S: Simd>(simd: S, a: Self::Lanes<S>) -> Self::Lanes<S>;
    /// `a b + c`, rounded once where the machine can.
    fn mul_add<S: Simd>(
        simd: S,
        a: Self::Lanes<S>,
        b: Self::Lanes<S>,
        c: Self::Lanes<S>,
    ) -> Self::Lanes<S>;
    /// `c - a b`.
    fn mul_from<S: Simd>(
        simd: S,
        a: Self::Lanes<S>,
        b: Self::Lanes<S>,
        c: Self::Lanes<S>,
    ) -> Self::Lanes<S>;
    /// `yes` in the lanes where the first of `sides` is the smaller, `no` in the others.
    fn below<S: Simd>(
        simd: S,
        sides: [Self::Lanes<S>; 2],
        yes: Self::Lanes<S>,
        no: Self::Lanes<S>,
    ) -> Self::Lanes<S>;
    /// Whether the first of `sides` is the smaller in any lane.
    fn any_below<S: Simd>(simd: S, sides: [Self::Lanes<S>; 2]) -> bool;
    /// As [`Roots::double_inverse_root`].
    fn double_inverse_root<S: Simd, R: Roots<S> + Roots<S, f32>>(
        roots: R,
        x: Lanes<S, Self>,
    ) -> Lanes<S, Self>;
    /// As [`Transpose::transpose`].
    fn transpose<S: Simd, M: Machine<S>, const C: usize>(
        simd: S,
        machine: M,
        rows: &[&[Self]; ROWS],
        c: usize,
        columns: &mut [[Self::Lanes<S>; C]],
    );
    /// The sum of all lanes.
    fn sum<S: Simd>(simd: S, a: Self::Lanes<S>) -> Self;
    /// The constants that move expansions.
    fn moves() -> &'static Moves<Self>;

    /// How many lanes a register has.
    fn lanes<S: Simd>() -> usize {
        size_of::<Self::Lanes<S>>() / size_of::<Self>()
    }
}

macro_rules! real {
    ($real:ident, $lanes:ident, {
        $as:ident $as_mut:ident $splat:ident $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident
        $neg:ident $abs:ident $mul_add:ident $mul_from:ident $less:ident $first:ident $select:ident $sum:ident
    }) => {
        impl Real for $real {
            type Lanes<S: Simd> = S::$lanes;

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, reason = "rounding is meant")]
            fn of(value: f64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn double(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn registers<S: Simd>(values: &[Self]) -> &[S::$lanes] {
                S::$as(values).0
            }

            #[inline(always)]
            fn registers_mut<S: Simd>(values: &mut [Self]) -> &mut [S::$lanes] {
                S::$as_mut(values).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$lanes {
                simd.$splat(value)
            }

            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes) -> S::$lanes {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn sub<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes) -> S::$lanes {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes) -> S::$lanes {
                simd.$mul(a, b)
            }

            #[inline(always)]
            fn div<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes) -> S::$lanes {
                simd.$div(a, b)
            }

            #[inline(always)]
            fn sqrt<S: Simd>(simd: S, a: S::$lanes) -> S::$lanes {
                simd.$sqrt(a)
            }

            #[inline(always)]
            fn neg<S: Simd>(simd: S, a: S::$lanes) -> S::$lanes {
                simd.$neg(a)
            }

            #[inline(always)]
            fn abs<S: Simd>(simd: S, a: S::$lanes) -> S::$lanes {
                simd.$abs(a)
            }

            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes, c: S::$lanes) -> S::$lanes {
                simd.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn mul_from<S: Simd>(simd: S, a: S::$lanes, b: S::$lanes, c: S::$lanes) -> S::$lanes {
                simd.$mul_from(a, b, c)
            }

            #[inline(always)]
            fn below<S: Simd>(
                simd: S,
                [a, b]: [S::$lanes; 2],
                yes: S::$lanes,
                no: S::$lanes,
            ) -> S::$lanes {
                simd.$select(simd.$less(a, b), yes, no)
            }

            #[inline(always)]
            fn any_below<S: Simd>(simd: S, [a, b]: [S::$lanes; 2]) -> bool {
                simd.$first(simd.$less(a, b)) < Self::lanes::<S>()
            }

            #[inline(always)]
            fn double_inverse_root<S: Simd, R: Roots<S> + Roots<S, f32>>(
                roots: R,
                x: Lanes<S, Self>,
            ) -> Lanes<S, Self> {
                roots.double_inverse_root(x)
            }

            #[inline(always)]
            fn transpose<S: Simd, M: Machine<S>, const C: usize>(
                simd: S,
                machine: M,
                rows: &[&[Self]; ROWS],
                c: usize,
                columns: &mut [[S::$lanes; C]],
            ) {
                Transpose::<S, Self>::transpose(machine, simd, rows, c, columns);
            }

            #[inline(always)]
            fn sum<S: Simd>(simd: S, a: S::$lanes) -> Self {
                simd.$sum(a)
            }

            fn moves() -> &'static Moves<Self> {
                static MOVES: OnceLock<Moves<$real>> = OnceLock::new();
                MOVES.get_or_init(Moves::new)
            }
        }
    };
}

real!(f64, f64s, {
    as_simd_f64s as_mut_simd_f64s splat_f64s add_f64s sub_f64s mul_f64s div_f64s sqrt_f64s
    neg_f64s abs_f64s mul_add_e_f64s negate_mul_add_e_f64s less_than_f64s first_true_m64s select_f64s reduce_sum_f64s
});
real!(f32, f32s, {
    as_simd_f32s as_mut_simd_f32s splat_f32s add_f32s sub_f32s mul_f32s div_f32s sqrt_f32s
    neg_f32s abs_f32s mul_add_e_f32s negate_mul_add_e_f32s less_than_f32s first_true_m32s select_f32s reduce_sum_f32s
});
