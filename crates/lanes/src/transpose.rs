//! Rows of numbers to columns.

use crate::{LANES_F32, Portable, Real};
use pulp::Simd;

/// The exchange of rows and columns as the machine makes it best.
pub trait Transpose<S: Simd, E: Real>: Copy {
    /// Number `k` of row `i` becomes lane `i` of register `c` of `columns[k]`; there are as many
    /// rows and columns as lanes, and at least as many numbers in each row.
    fn transpose<const C: usize>(
        self,
        simd: S,
        rows: &[&[E]; LANES_F32],
        c: usize,
        columns: &mut [[E::Register<S>; C]],
    );
}

impl<S: Simd, E: Real> Transpose<S, E> for Portable {
    #[inline(always)]
    fn transpose<const C: usize>(
        self,
        _: S,
        rows: &[&[E]; LANES_F32],
        c: usize,
        columns: &mut [[E::Register<S>; C]],
    ) {
        for (k, column) in columns.iter_mut().enumerate() {
            let lanes: &mut [E] =
                pulp::bytemuck::cast_slice_mut(std::slice::from_mut(&mut column[c]));
            for (lane, row) in lanes.iter_mut().zip(rows) {
                *lane = row[k];
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod widest {
    use super::Transpose;
    use crate::roots::Estimate;
    use crate::{LANES_F32, Real};
    use pulp::cast;
    use pulp::x86::V4;
    use std::arch::x86_64::__m512d;

    /// Quarters of registers: number k of register i becomes number i of register k.
    #[inline(always)]
    fn quarters(simd: V4, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
        const LOW: i32 = 0b01_00_01_00;
        const HIGH: i32 = 0b11_10_11_10;
        const EVEN: i32 = 0b10_00_10_00;
        const ODD: i32 = 0b11_01_11_01;
        let avx = simd.avx512f;
        let low = [avx._mm512_shuffle_f64x2::<LOW>(a, b), avx._mm512_shuffle_f64x2::<LOW>(c, d)];
        let high = [avx._mm512_shuffle_f64x2::<HIGH>(a, b), avx._mm512_shuffle_f64x2::<HIGH>(c, d)];
        [
            avx._mm512_shuffle_f64x2::<EVEN>(low[0], low[1]),
            avx._mm512_shuffle_f64x2::<ODD>(low[0], low[1]),
            avx._mm512_shuffle_f64x2::<EVEN>(high[0], high[1]),
            avx._mm512_shuffle_f64x2::<ODD>(high[0], high[1]),
        ]
    }

    impl Transpose<V4, f64> for Estimate {
        #[inline(always)]
        fn transpose<const C: usize>(
            self,
            simd: V4,
            rows: &[&[f64]; LANES_F32],
            c: usize,
            columns: &mut [[pulp::f64x8; C]],
        ) {
            let avx = simd.avx512f;
            let mut even = [cast(pulp::f64x8(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)); 4];
            let mut odd = even;
            for k in 0..4 {
                let a = cast(f64::registers::<V4>(rows[2 * k])[0]);
                let b = cast(f64::registers::<V4>(rows[2 * k + 1])[0]);
                even[k] = avx._mm512_unpacklo_pd(a, b);
                odd[k] = avx._mm512_unpackhi_pd(a, b);
            }
            (even, odd) = (quarters(simd, even), quarters(simd, odd));
            for k in 0..4 {
                columns[2 * k][c] = cast(even[k]);
                columns[2 * k + 1][c] = cast(odd[k]);
            }
        }
    }

    impl Transpose<V4, f32> for Estimate {
        #[inline(always)]
        fn transpose<const C: usize>(
            self,
            simd: V4,
            rows: &[&[f32]; LANES_F32],
            c: usize,
            columns: &mut [[pulp::f32x16; C]],
        ) {
            let avx = simd.avx512f;
            let zero = cast(pulp::f64x8(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
            let mut fours = [[zero; 4]; 4];
            for k in 0..4 {
                let row0 = cast(f32::registers::<V4>(rows[4 * k])[0]);
                let row1 = cast(f32::registers::<V4>(rows[4 * k + 1])[0]);
                let row2 = cast(f32::registers::<V4>(rows[4 * k + 2])[0]);
                let row3 = cast(f32::registers::<V4>(rows[4 * k + 3])[0]);
                let low0 = cast(avx._mm512_unpacklo_ps(row0, row1));
                let low2 = cast(avx._mm512_unpacklo_ps(row2, row3));
                let high0 = cast(avx._mm512_unpackhi_ps(row0, row1));
                let high2 = cast(avx._mm512_unpackhi_ps(row2, row3));
                fours[0][k] = avx._mm512_unpacklo_pd(low0, low2);
                fours[1][k] = avx._mm512_unpackhi_pd(low0, low2);
                fours[2][k] = avx._mm512_unpacklo_pd(high0, high2);
                fours[3][k] = avx._mm512_unpackhi_pd(high0, high2);
            }
            for k in 0..4 {
                let four = quarters(simd, fours[k]);
                for quarter in 0..4 {
                    columns[4 * quarter + k][c] = cast(four[quarter]);
                }
            }
        }
    }
}
