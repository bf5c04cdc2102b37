//! The ways of a machine with numbers of either precision.

use crate::{LANES_F32, Lane, Machine, Real, Roots, Transpose};
use pulp::Simd;

/// A type of numbers that every [`Machine`] has its ways with, for functions over both types.
pub trait Ways: Real {
    /// Twice the inverse square roots by [`Roots::double_rsqrt`].
    fn double_rsqrt<S: Simd, M: Machine<S>>(machine: M, x: Lane<S, Self>) -> Lane<S, Self>;
    /// The exchange of rows and columns by [`Transpose::transpose`].
    fn transpose<S: Simd, M: Machine<S>, const C: usize>(
        simd: S,
        machine: M,
        rows: &[&[Self]; LANES_F32],
        c: usize,
        columns: &mut [[Self::Register<S>; C]],
    );
}

macro_rules! ways {
    ($real:ident) => {
        impl Ways for $real {
            #[inline(always)]
            fn double_rsqrt<S: Simd, M: Machine<S>>(machine: M, x: Lane<S, Self>) -> Lane<S, Self> {
                Roots::<S, Self>::double_rsqrt(machine, x)
            }

            #[inline(always)]
            fn transpose<S: Simd, M: Machine<S>, const C: usize>(
                simd: S,
                machine: M,
                rows: &[&[Self]; LANES_F32],
                c: usize,
                columns: &mut [[Self::Register<S>; C]],
            ) {
                Transpose::<S, Self>::transpose(machine, simd, rows, c, columns);
            }
        }
    };
}

ways!(f32);
ways!(f64);
