//! Every operation at every width of registers that the machine has.

use super::widths::{by_all_machines, by_all_widths};
use crate::*;
use proptest::prelude::*;
use pulp::{Simd, WithSimd};

/// All operations on three numbers in each lane.
struct AllOperations<'a, E>([&'a [E; LANES_F32]; 3]);

/// Results of the operations, by lane, of comparisons in any lane of every register, sum and
/// largest.
type Found<E> = ([[E; LANES_F32]; 20], [bool; 2], [f64; 2]);

impl<E: Ways> WithSimd for AllOperations<'_, E> {
    type Output = Found<E>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Found<E> {
        let mut found = [[E::from_f64(0.0); LANES_F32]; 20];
        let (mut any, mut over) = ([false; 2], [0.0, f64::NEG_INFINITY]);
        let lanes = E::lanes::<S>();
        for register in 0..LANES_F32 / lanes {
            let [a, b, c] = self.0.map(|all| Lane::load(simd, all, register));
            let all = [
                a + b,
                a - b,
                a * b,
                a / b,
                -a,
                a.mul_add(b, c),
                a.negate_mul_add(b, c),
                a.abs().sqrt(),
                a.recip(),
                a.abs(),
                a.max(b),
                a.min(b),
                a.sign(),
                a.positive().select(b, c),
                a.less_or_equal(b).select(c, a),
                a.less_than(b).select(c, a),
                a.lift(3.0),
                Roots::<S, E>::sqrt(Portable, a.abs()),
                Roots::<S, E>::rsqrt(Portable, a.abs()),
                E::double_rsqrt(Portable, a.abs()),
            ];
            for (found, lane) in found.iter_mut().zip(all) {
                lane.store(found, register);
                assert!(lane.numbers() == &found[register * lanes..][..lanes]);
            }
            any = [any[0] || a.less_than(b).any(), any[1] || a.less_or_equal(b).any()];
            let largest = a.reduce_max().to_f64();
            over = [over[0] + a.reduce_sum().to_f64(), over[1].max(largest)];
        }
        (found, any, over)
    }
}

/// Expected results of all operations, number by number, without rounding twice.
fn expected([a, b, c]: [f64; 3]) -> [f64; 20] {
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
        if a < b { c } else { a },
        3.0,
        a.abs().sqrt(),
        1.0 / a.abs().sqrt(),
        2.0 / a.abs().sqrt(),
    ]
}

fn numbers() -> impl Strategy<Value = [f64; LANES_F32]> {
    let special = prop::sample::select(vec![1.0, -1.0, 0.5, 2.0]);
    prop::array::uniform16(prop_oneof![4 => -1e3..1e3, 1 => special])
}

/// Results one by one and by as many as a register has: all are rounded once, by half of `unit`,
/// but those that a machine composes.
fn check<E: Ways>(all: [[f64; LANES_F32]; 3], unit: f64) {
    let rounded = all.map(|all| all.map(E::from_f64));
    let exact = rounded.map(|all| all.map(E::to_f64));
    let [first, second, _] = &exact;
    let pairs = || first.iter().zip(second);
    for (found, any, over) in
        by_all_widths(|| AllOperations([&rounded[0], &rounded[1], &rounded[2]]))
    {
        for i in 0..LANES_F32 {
            let [a, b, c] = [0, 1, 2].map(|k| exact[k][i]);
            for (k, expected) in expected([a, b, c]).into_iter().enumerate() {
                // A machine may round a product before a sum; an inverse root is of a rounded root.
                let scale = match k {
                    5 | 6 => (a * b).abs() + c.abs(),
                    18 | 19 => expected.abs(),
                    _ => 0.0,
                };
                let expected = E::from_f64(expected).to_f64();
                let found = found[k][i].to_f64();
                let error = if found == expected { 0.0 } else { (found - expected).abs() };
                assert!(error <= 2.0 * unit * scale, "operation {k} of {a}, {b}, {c}: {error:e}");
            }
        }
        assert_eq!(any, [pairs().any(|(a, b)| a < b), pairs().any(|(a, b)| a <= b)]);
        let size: f64 = first.iter().map(|a| a.abs()).sum();
        assert!((over[0] - first.iter().sum::<f64>()).abs() <= LANES_F32 as f64 * unit * size);
        assert_eq!(over[1], first.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    }
}

proptest! {
    #[test]
    fn lanes_do_what_numbers_do(a in numbers(), b in numbers(), c in numbers()) {
        check::<f64>([a, b, c], f64::EPSILON);
        check::<f32>([a, b, c], f64::from(f32::EPSILON));
    }
}

#[derive(Clone, Copy)]
struct Functions;

impl Kernel for Functions {
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let splat = |value: f64| Lane::splat(simd, value);
        for x in [1.0, 1.0 + 1e-9, 0.7, 1.414, 2.0, 1e-200, 3e17, 12.5] {
            let log = ln(machine, splat(x)).numbers()[0];
            assert!((log - x.ln()).abs() <= 5e-16 * x.ln().abs().max(0.3), "ln {x} = {log}");
            let root = machine.sqrt(splat(x)).numbers()[0];
            assert!((root / x.sqrt() - 1.0).abs() < 4e-16, "sqrt {x} = {root}");
            let inverse = machine.rsqrt(splat(x)).numbers()[0];
            assert!((inverse * x.sqrt() - 1.0).abs() < 6e-13, "{x}: {inverse}");
            let reciprocal = machine.recip(splat(x)).numbers()[0];
            assert!((reciprocal * x - 1.0).abs() < 4e-16, "1/{x} = {reciprocal}");
        }
        assert!(machine.rsqrt(splat(0.0)).numbers()[0] == 0.0);
        for k in 0..200 {
            let exact = 0.0314 * f64::from(k);
            let found = angle(machine, splat(3.0 * exact.cos()), splat(3.0 * exact.sin()));
            let error = (found.numbers()[0] - exact).abs();
            assert!(error < 1e-15 * exact.max(1.0), "{exact}: {error:e}");
        }
        let rounded = angle(machine, splat(1.0), splat(-1e-15)).numbers()[0];
        assert!((rounded + 1e-15).abs() < 1e-20, "{rounded}");
    }
}

#[test]
fn functions_are_exact() {
    by_all_machines(Functions);
}

#[derive(Clone, Copy)]
struct Rows;

impl Kernel for Rows {
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        transposed::<S, f32, M>(simd, machine);
        transposed::<S, f64, M>(simd, machine);
    }
}

fn transposed<S: Simd, E: Ways, M: Machine<S>>(simd: S, machine: M) {
    let lanes = E::lanes::<S>();
    let numbers: Vec<_> = (0..LANES_F32 * LANES_F32).map(|k| E::from_f64(k as f64)).collect();
    let rows = std::array::from_fn(|i| &numbers[LANES_F32 * i..][..LANES_F32]);
    let mut columns = vec![[E::splat(simd, E::from_f64(0.0)); 2]; lanes];
    E::transpose(simd, machine, &rows, 1, &mut columns);
    for (k, [untouched, column]) in columns.into_iter().enumerate() {
        let zero = E::from_f64(0.0);
        assert!(Lane::<S, E>::new(simd, untouched).numbers().iter().all(|x| *x == zero));
        for (i, x) in Lane::<S, E>::new(simd, column).numbers().iter().enumerate() {
            assert!(*x == numbers[LANES_F32 * i + k], "{i}, {k}");
        }
    }
}

#[test]
fn rows_become_columns() {
    by_all_machines(Rows);
}
