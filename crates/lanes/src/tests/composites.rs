//! Vectors, matrices and rotations at every width of registers, against those of `nalgebra`.

use super::widths::by_all_widths;
use crate::{LANES, Lane, M3, Quat, Real, Sym, V3};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;
use pulp::{Simd, WithSimd};

/// Numbers in each lane: three vectors, two matrices, a symmetric one, two quaternions, a factor.
const INPUTS: usize = 9 + 18 + 6 + 8 + 1;

/// Rounding: numbers are at most 5, no result is the sum of more than nine products of three of
/// them, and nothing is divided by less than 1.
const BOUND: f64 = 9.0 * 125.0 * f64::EPSILON;

/// Factor, rad, to angles of many turns.
const TURNS: f64 = 40.0;

/// All operations on some things in each lane.
struct AllComposites<'a>(&'a [[f64; LANES]]);

impl WithSimd for AllComposites<'_> {
    type Output = Vec<Vec<f64>>;

    /// What each operation gives, number by number, for each lane.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<Vec<f64>> {
        let lanes = S::F64_LANES;
        let mut found = vec![Vec::new(); LANES];
        for register in 0..LANES / lanes {
            let mut numbers = Vec::new();
            for all in self.0 {
                numbers.extend_from_slice(&all[register * lanes..][..lanes]);
            }
            let mut results = Vec::new();
            all(simd, f64::registers::<S>(&numbers), &mut results);
            for result in results {
                for (lane, x) in result.numbers().iter().enumerate() {
                    found[register * lanes + lane].push(*x);
                }
            }
        }
        found
    }
}

#[inline(always)]
fn all<S: Simd>(simd: S, numbers: &[S::f64s], out: &mut Vec<Lane<S>>) {
    let mut v = [V3::splat(simd, 0.0); 9];
    for (i, v) in v.iter_mut().enumerate() {
        *v = V3::load(simd, numbers, i);
    }
    let [a, b, c, ..] = v;
    let (m, n) = (M3([v[3], v[4], v[5]]), M3([v[6], v[7], v[8]]));
    let y = Sym::load(simd, &numbers[27..], 0);
    let (p, q) = (Quat::load(simd, &numbers[33..], 0), Quat::load(simd, &numbers[33..], 1));
    let s = Lane::new(simd, numbers[41]);
    let mask = s.positive();

    let (mut sum, mut difference) = (a, a);
    sum += b;
    difference -= b;
    for v in [
        a + b,
        a - b,
        sum,
        difference,
        a.cross(b),
        a.scale(s),
        a.mul_add(s, b),
        a.times(c),
        mask.select(a, b),
        m.apply(a),
        m.apply_transposed(a),
        m.solve(a),
        y.apply(a),
        p.log().0,
    ] {
        out.extend(v.0);
    }
    let d = M3(p.directors());
    for m in [
        M3::splat(simd, 3.0),
        m.transposed(),
        m.times(n),
        m.scale(s),
        m + n,
        m - n,
        y.full(),
        y.times(m),
        d.transposed(),
        M3(p.spun_by(s * s.lift(TURNS)).directors()).transposed(),
    ] {
        m.0.into_iter().for_each(|row| out.extend(row.0));
    }
    let (inverse, signature) = y.inverse();
    for y in [
        Sym::diagonal(s),
        Sym::transposed_product(m, m),
        Sym::product_transposed(m, m),
        Sym::outer(a),
        Sym::symmetric_outer(a, b),
        Sym::symmetric_part(m),
        Sym::twice_symmetric_part(m),
        y.scale(s),
        y + Sym::outer(a),
        y - Sym::outer(a),
        inverse,
    ] {
        out.extend(y.0);
    }
    for q in [p.inverse_times(q), p.turned_by(a), mask.select(p, q)] {
        out.extend(q.v.0);
        out.push(q.w);
    }
    out.extend([a.dot(b), a.max_abs(), signature, p.log().1]);
}

/// What the operations give for the things of one lane.
fn expected(x: &[f64]) -> Vec<f64> {
    let v = |i: usize| Vector3::from_column_slice(&x[3 * i..3 * i + 3]);
    let [a, b, c] = [0, 1, 2].map(v);
    let [m, n] = [9, 18].map(|first| Matrix3::from_row_slice(&x[first..first + 9]));
    let y = &x[27..33];
    let y = Matrix3::new(y[0], y[3], y[4], y[3], y[1], y[5], y[4], y[5], y[2]);
    let quaternion = |x: &[f64]| Quaternion::new(x[3], x[0], x[1], x[2]);
    let [p, q] = [33, 37].map(|first| UnitQuaternion::new_unchecked(quaternion(&x[first..])));
    let (s, positive) = (x[41], x[41] > 0.0);

    let mut out = Vec::new();
    for v in [
        a + b,
        a - b,
        a + b,
        a - b,
        a.cross(&b),
        a * s,
        a * s + b,
        a.component_mul(&c),
        if positive { a } else { b },
        m * a,
        m.tr_mul(&a),
        m.try_inverse().expect("strictly dominant") * a,
        y * a,
        p.scaled_axis(),
    ] {
        out.extend(v.iter());
    }
    for m in [
        Matrix3::repeat(3.0),
        m.transpose(),
        m * n,
        m * s,
        m + n,
        m - n,
        y,
        y * m,
        p.to_rotation_matrix().into_inner(),
        (p * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), TURNS * s))
            .to_rotation_matrix()
            .into_inner(),
    ] {
        out.extend(m.transpose().iter());
    }
    for y in [
        Matrix3::from_diagonal_element(s),
        m.tr_mul(&m),
        m * m.transpose(),
        a * a.transpose(),
        (a * b.transpose() + b * a.transpose()) / 2.0,
        (m + m.transpose()) / 2.0,
        m + m.transpose(),
        y * s,
        y + a * a.transpose(),
        y - a * a.transpose(),
        y.try_inverse().expect("strictly dominant"),
    ] {
        out.extend([y.m11, y.m22, y.m33, y.m12, y.m13, y.m23]);
    }
    let turn = UnitQuaternion::new_normalize(Quaternion::from_parts(1.0, a / 2.0));
    for q in [p.inverse() * q, turn * p, if positive { p } else { q }] {
        out.extend([q.i, q.j, q.k, q.w]);
    }
    let signature = y.symmetric_eigenvalues().map(f64::signum).sum();
    let cotangent = p.w.abs() * p.angle() / p.imag().norm();
    out.extend([a.dot(&b), a.amax(), signature, cotangent]);
    out
}

/// Makes diagonals larger than the rest of their rows, with signs as they are, and quaternions
/// unit ones with a turn.
fn prepared(mut x: Vec<f64>) -> Vec<f64> {
    for i in [9, 13, 17, 18, 22, 26, 27, 28, 29] {
        x[i] += 4_f64.copysign(x[i]);
    }
    for first in [33, 37] {
        x[first] += 0.1_f64.copysign(x[first]);
        let norm = x[first..first + 4].iter().map(|x| x * x).sum::<f64>().sqrt();
        x[first..first + 4].iter_mut().for_each(|x| *x /= norm);
    }
    x
}

proptest! {
    #[test]
    fn composites_do_what_those_of_nalgebra_do(
        things in prop::collection::vec(
            prop::collection::vec(-1.0..1.0_f64, INPUTS).prop_map(prepared), LANES),
    ) {
        let numbers: Vec<_> =
            (0..INPUTS).map(|k| std::array::from_fn(|lane| things[lane][k])).collect();
        for found in by_all_widths(|| AllComposites(&numbers)) {
            for (found, x) in found.iter().zip(&things) {
                let expected = expected(x);
                prop_assert_eq!(found.len(), expected.len());
                for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
                    let error = (found - expected).abs();
                    prop_assert!(error <= BOUND, "number {k}: {found}, not {expected}");
                }
            }
        }
    }
}
