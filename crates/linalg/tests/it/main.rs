//! Pairs of eigenvalues and vectors against their equations, closed forms and nalgebra.

use nalgebra::{Complex, DMatrix, DVector, Schur, SymmetricEigen};
use proptest::prelude::*;
use rapunzel_linalg::{
    LinalgError, SparseSystem, characteristic_exponents, eigen, largest_eigenvalue, modes,
    smallest_eigenvalue,
};
use std::f64::consts::PI;

/// Rounding of `n` operations with numbers of a size.
fn rounding(n: usize, size: f64) -> f64 {
    20.0 * n as f64 * f64::EPSILON * size
}

fn matrix() -> impl Strategy<Value = DMatrix<f64>> {
    (1_usize..40).prop_flat_map(|n| {
        prop::collection::vec(-1.0..1.0, n * n).prop_map(move |x| DMatrix::from_vec(n, n, x))
    })
}

/// A matrix and another of its size.
fn two() -> impl Strategy<Value = [DMatrix<f64>; 2]> {
    (1_usize..40).prop_flat_map(|n| {
        let entries = || prop::collection::vec(-1.0..1.0, n * n);
        (entries(), entries()).prop_map(move |(a, b)| [a, b].map(|x| DMatrix::from_vec(n, n, x)))
    })
}

/// A symmetric matrix whose eigenvalues are at least `least`.
fn definite(root: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    root * root.transpose() + DMatrix::identity(root.nrows(), root.nrows()) * least
}

/// Equal springs and masses 1 between two walls: `omega = 2 sin(k pi / (2 (n + 1)))`.
fn chain(n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    })
}

proptest! {
    #[test]
    fn modes_solve_their_equation_and_are_orthonormal([a, b] in two(), shift in -2.0..2.0) {
        let n = a.nrows();
        // Of either kind: a negative shift makes it indefinite.
        let k = definite(&a, shift);
        let m = definite(&b, 1.0);
        let found = modes(&k, &m, n).expect("modes");
        prop_assert!(found.squares.is_sorted());
        let size = k.norm() + m.norm() * found.squares.iter().fold(1.0, |s: f64, x| s.max(x.abs()));
        let norm = found.shapes.norm();
        for (square, shape) in found.squares.iter().zip(found.shapes.column_iter()) {
            // Taken by the inverse, an error is one of the inverse square.
            let spread = (square / found.squares[0]).abs().max(1.0);
            let residual = &k * shape - *square * (&m * shape);
            let allowed = rounding(n, size * norm) * spread;
            prop_assert!(residual.amax() < allowed, "{} at {square}", residual.amax());
        }
        let gram = found.shapes.transpose() * &m * &found.shapes;
        let spread = found.squares.last().expect("one") / found.squares[0];
        let wrong = (gram - DMatrix::identity(n, n)).amax();
        let allowed = rounding(n, m.norm() * norm) * norm * spread.abs().max(1.0);
        prop_assert!(wrong < allowed, "{wrong}");
        // The same by another way.
        let lower = m.clone().cholesky().expect("definite").unpack();
        let half = lower.solve_lower_triangular(&k).expect("regular");
        let c = lower.solve_lower_triangular(&half.transpose()).expect("regular");
        let mut expected: Vec<f64> = c.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(f64::total_cmp);
        for (x, y) in found.squares.iter().zip(&expected) {
            let spread = (x / found.squares[0]).abs().max(1.0);
            prop_assert!((x - y).abs() < rounding(n, size) * spread, "{x}, not {y}");
        }
        let few = modes(&k, &m, 2).expect("modes");
        prop_assert_eq!(&few.squares[..], &found.squares[..n.min(2)]);
        prop_assert_eq!(few.shapes, found.shapes.columns(0, n.min(2)));
    }

    #[test]
    fn eigenvalues_are_those_of_nalgebra(a in matrix()) {
        let n = a.nrows();
        let symmetric = &a + a.transpose();
        let found = eigen(&symmetric).expect("eigenvalues");
        let expected = SymmetricEigen::new(symmetric.clone());
        let mut values: Vec<f64> = expected.eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        let allowed = rounding(n, symmetric.norm());
        for (x, y) in found.squares.iter().zip(&values) {
            prop_assert!((x - y).abs() < allowed, "{x}, not {y}");
        }
        let product = &found.shapes * DMatrix::from_diagonal(&found.squares.clone().into());
        prop_assert!((&symmetric * &found.shapes - product).amax() < allowed);
        let gram = found.shapes.transpose() * &found.shapes - DMatrix::identity(n, n);
        prop_assert!(gram.amax() < rounding(n, 1.0));
        let smallest = smallest_eigenvalue(&symmetric).expect("one");
        prop_assert!((smallest - values[0]).abs() < allowed);
        let start = DVector::from_fn(n, |i, _| 1.0 + (i as f64 * 0.618).fract());
        let largest = largest_eigenvalue(start, |z, y| *y = &symmetric * z).expect("one");
        let last = values.last().expect("one");
        prop_assert!(largest < last + allowed && largest > last - 1e-6 * last.abs() - allowed);
    }

    #[test]
    fn exponents_are_roots([a, b] in two()) {
        let n = a.nrows();
        let m = definite(&b, 1.0);
        // Far from singular, and not symmetric.
        let k = &a + DMatrix::identity(n, n) * (1.0 + n as f64);
        let found = characteristic_exponents(&k, &m).expect("exponents");
        prop_assert_eq!(found.len(), n);
        prop_assert!(found.is_sorted_by(|x, y| x.norm_sqr() <= y.norm_sqr()));
        let inverse = k.clone().lu().solve(&m).expect("regular");
        let schur = Schur::try_new(inverse, f64::EPSILON, 10_000).expect("converged");
        let mut expected: Vec<_> = schur.complex_eigenvalues().iter().map(|x| -x.inv()).collect();
        expected.sort_by(|x, y| x.norm_sqr().total_cmp(&y.norm_sqr()));
        for s in found {
            let square = s * s;
            let near = expected.iter().map(|x| {
                // Of a pair of exponents that are conjugate, the first is given twice.
                let conjugate = Complex::new(x.re, -x.im);
                (x - square).norm().min((conjugate - square).norm())
            });
            let nearest = near.fold(f64::INFINITY, f64::min);
            prop_assert!(nearest < 1e-7 * square.norm(), "{s}: off by {nearest}");
        }
    }
}

#[test]
fn frequencies_of_a_chain_are_those_of_the_closed_form() {
    for n in [1, 2, 5, 150] {
        let identity = DMatrix::identity(n, n);
        let found = modes(&chain(n), &identity, n).expect("modes").angular_frequencies();
        let dense = eigen(&chain(n)).expect("modes").angular_frequencies();
        let rates = characteristic_exponents(&chain(n), &identity).expect("exponents");
        for k in 1..=n {
            let expected = 2.0 * (0.5 * PI * k as f64 / (n + 1) as f64).sin();
            for omega in [found[k - 1], dense[k - 1], rates[k - 1].im] {
                assert!((omega - expected).abs() < 1e-11, "{n}: {omega}, not {expected}");
            }
            // The lowest to a few last bits.
            if k == 1 {
                assert!((found[0] / expected - 1.0).abs() < 1e-14 * n as f64, "{n}");
            }
        }
    }
    // Near the top of a long chain frequencies are close together.
    let n = 3000;
    let start = DVector::from_fn(n, |i, _| (1.618_034 * i as f64).fract() - 0.5);
    let largest = largest_eigenvalue(start, |z, y| {
        for i in 0..n {
            let beside = |j: Option<usize>| j.and_then(|j| z.get(j)).copied().unwrap_or(0.0);
            y[i] = 2.0 * z[i] - beside(i.checked_sub(1)) - beside(Some(i + 1));
        }
    });
    assert!((largest.expect("finite") / 4.0 - 1.0).abs() < 1e-4);
}

/// `(2 - x)(2 - 1e-14 x) = 1` for two masses of which one is nearly none.
#[test]
fn low_frequencies_do_not_suffer_from_high_ones() {
    let k = chain(2);
    let m = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1e-14]));
    let found = modes(&k, &m, 2).expect("modes").squares;
    assert!((found[0] / (1.5 - 0.375e-14) - 1.0).abs() < 1e-15, "{}", found[0]);
    let rates = characteristic_exponents(&k, &m).expect("exponents");
    assert!((rates[0].im / 1.5_f64.sqrt() - 1.0).abs() < 1e-14);
    // One that is none: it follows, as fast as numbers tell.
    let m = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 0.0]));
    let found = modes(&k, &m, 2).expect("modes").squares;
    assert!((found[0] / 1.5 - 1.0).abs() < 1e-15 && found[1] > 1e15, "{found:?}");
}

#[test]
fn what_floats_and_what_falls_over_is_told() {
    // Two masses and one spring, which may fly away together.
    let free = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
    let identity = DMatrix::identity(2, 2);
    let found = modes(&free, &identity, 2).expect("modes");
    assert!(found.squares[0].abs() < 1e-15 && (found.squares[1] - 2.0).abs() < 1e-15);
    let rates = characteristic_exponents(&free, &identity).expect("exponents");
    assert!(rates[0].norm() < 1e-7 && (rates[1].im - 2.0_f64.sqrt()).abs() < 1e-15);
    let falling = -chain(2);
    assert_eq!(modes(&falling, &identity, 9).expect("modes").angular_frequencies(), [0.0; 2]);
    let rates = characteristic_exponents(&falling, &identity).expect("exponents");
    assert!((rates[0].re - 1.0).abs() < 1e-15 && rates[0].im == 0.0);
}

#[test]
fn wrong_matrices_are_refused() {
    let (k, m) = (chain(3), DMatrix::identity(3, 3));
    let size = Err(LinalgError::Size { what: "mass", rows: 2, columns: 2, expected: 3 });
    assert_eq!(modes(&k, &DMatrix::identity(2, 2), 1), size);
    assert!(matches!(eigen(&DMatrix::zeros(2, 3)), Err(LinalgError::Size { .. })));
    let infinite = k.map(|x| if x == 2.0 { f64::INFINITY } else { x });
    let not_finite = |what| LinalgError::NotFinite { what };
    assert_eq!(modes(&infinite, &m, 1), Err(not_finite("stiffness")));
    assert_eq!(modes(&k, &infinite, 1), Err(not_finite("mass")));
    assert_eq!(smallest_eigenvalue(&infinite), Err(not_finite("matrix")));
    assert_eq!(
        largest_eigenvalue(DVector::repeat(3, 1.0), |z, y| *y = z * f64::NAN),
        Err(not_finite("product"))
    );
    for k in [k, DMatrix::zeros(3, 3)] {
        assert_eq!(modes(&k, &-&m, 1), Err(LinalgError::Mass));
    }
    let nothing = DMatrix::zeros(3, 3);
    assert_eq!(characteristic_exponents(&nothing, &nothing), Err(LinalgError::Mass));
    assert_eq!(characteristic_exponents(&chain(3), &nothing), Err(LinalgError::Mass));
    let none = DMatrix::zeros(0, 0);
    assert!(modes(&none, &none, 3).expect("no modes").squares.is_empty());
    assert!(eigen(&none).expect("no modes").squares.is_empty());
    assert!(characteristic_exponents(&none, &none).expect("no exponents").is_empty());
    assert_eq!(largest_eigenvalue(DVector::zeros(3), |_, _| ()), Ok(0.0));
}

/// A chain of springs on an unsymmetric band: the solution of two columns against the dense one.
#[test]
fn a_sparse_system_is_solved_as_the_dense_one() {
    let n = 60;
    let entries: Vec<_> = (0..n)
        .flat_map(|i| [(i, i, 4.0), (i, (i + 1) % n, -1.5), (i, (i + 7) % n, -0.5), (i, i, 1.0)])
        .collect();
    let dense = entries.iter().fold(DMatrix::zeros(n, n), |mut m: DMatrix<f64>, &(i, j, x)| {
        m[(i, j)] += x;
        m
    });
    let right = DMatrix::from_fn(n, 2, |i, j| (i as f64 * 0.3 + j as f64).sin());
    let found = SparseSystem::new(n, &entries).expect("regular").solve(&right).expect("solved");
    assert!((&dense * found - &right).amax() < rounding(n, 5.0));
    // The symmetric part is diagonally dominant.
    let both: Vec<_> = entries.iter().flat_map(|&(i, j, x)| [(i, j, x), (j, i, x)]).collect();
    let found = SparseSystem::positive_definite(n, &both).expect("definite");
    let found = found.solve(&right).expect("solved");
    assert!(((&dense + dense.transpose()) * found - &right).amax() < rounding(n, 10.0));
}

#[test]
fn what_is_not_positive_definite_is_refused() {
    let right = DMatrix::from_element(2, 1, 1.0);
    for entries in [
        // Indefinite, of rank one, and not symmetric.
        [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 2.0), (1, 0, 2.0)],
        [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 1.0), (1, 0, 1.0)],
        [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 0.5), (1, 0, 0.0)],
    ] {
        let system = SparseSystem::positive_definite(2, &entries);
        let refused = system.and_then(|system| system.solve(&right)).expect_err("refused");
        assert_eq!(refused, LinalgError::Singular, "{entries:?}");
    }
}

#[test]
fn what_is_no_sparse_system_is_refused() {
    let refused = |entries: &[(usize, usize, f64)]| {
        SparseSystem::new(2, entries)
            .and_then(|system| system.solve(&DMatrix::from_element(2, 1, 1.0)))
            .expect_err("refused")
    };
    assert_eq!(refused(&[(0, 2, 1.0)]), LinalgError::Entry { row: 0, column: 2, size: 2 });
    assert_eq!(refused(&[(0, 0, f64::NAN)]), LinalgError::NotFinite { what: "sparse matrix" });
    assert_eq!(refused(&[(0, 0, 1.0)]), LinalgError::Singular);
    assert_eq!(
        refused(&[(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0)]),
        LinalgError::Singular
    );
}
