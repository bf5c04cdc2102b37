//! The operators, for every pair of degrees.

use super::*;
use nalgebra::Vector3;

/// Multipole (`outside` false) or local expansion of unit charges, scaled with `scale`.
fn expansion(order: usize, points: &[Vector3<f64>], scale: f64, outside: bool) -> Vec<f64> {
    let mut sum = vec![0.0; count(order)];
    for point in points {
        let mut values = vec![0.0; count(order)];
        let x = (if outside { point / point.norm_squared() } else { point / scale }).into();
        regular_at(HarmonicTables::get(), order, x, &mut values);
        for n in 0..=order {
            let factor = if outside { scale.powf(n as f64) / point.norm() } else { 1.0 };
            for k in n * n..count(n) {
                sum[k] += factor * values[k];
            }
        }
    }
    sum
}

fn cloud(seed: u32) -> Vec<Vector3<f64>> {
    let angle = |k: u32| f64::from(k * 7 + seed * 13).sin();
    (0..12).map(|k| 0.3 * Vector3::new(angle(k), angle(k + 50), angle(k + 90))).collect()
}

fn directions() -> Vec<Vector3<f64>> {
    let mut all: Vec<_> = (0..6)
        .map(|k| {
            let k = f64::from(k);
            Vector3::new((3.0 * k).sin(), (5.0 * k).cos(), (7.0 * k + 1.0).sin()).normalize()
        })
        .collect();
    all.extend([Vector3::x(), -Vector3::y(), Vector3::z(), -Vector3::z()]);
    all
}

fn assert_close(actual: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    for (k, (a, e)) in actual.iter().zip(expected).enumerate() {
        assert!((a - e).abs() <= tolerance, "{what}: coefficient {k} is {a}, not {e}");
    }
}

/// A shifted multipole is exactly the multipole about the other center, as far as the orders
/// reach: also through a zero offset, and for all pairs of orders.
#[test]
fn multipoles_shift_exactly_for_every_pair_of_orders() {
    let (cloud, mut translator) = (cloud(1), Translator::new(30));
    for (k, direction) in directions().into_iter().enumerate() {
        let offset = direction * [0.4, 0.0][usize::from(k == 3)];
        let moved: Vec<_> = cloud.iter().map(|x| x - offset).collect();
        let [before, after] =
            [expansion(30, &cloud, 0.5, false), expansion(30, &moved, 0.9, false)];
        for (p, q) in (0..=30).flat_map(|p| (0..=30).map(move |q| (p, q))) {
            let mut out = vec![0.0; count(q)];
            let shift =
                Shift { coefficients: &before, degrees: [p, q], offset, scales: [0.5, 0.9] };
            translator.sum(TranslationKind::Multipole, &[shift], &mut out);
            let exact = count(p.min(q));
            assert_close(&out[..exact], &after[..exact], 1e-11, &format!("{p} to {q}"));
        }
    }
}

/// A local expansion cut off at p is a polynomial, which moves exactly if q is no less; for
/// smaller q the coefficients that remain are the same.
#[test]
fn local_expansions_shift_exactly_for_every_pair_of_orders() {
    let mut translator = Translator::new(30);
    for direction in directions() {
        let local = expansion(30, &[Vector3::new(2.0, 1.0, -1.5)], 0.8, true);
        let offset = direction * 0.3;
        for p in 0..=30 {
            let shift = |q: usize| Shift {
                coefficients: &local,
                degrees: [p, q],
                offset,
                scales: [0.8, 0.4],
            };
            let mut full = vec![0.0; count(30)];
            translator.sum(TranslationKind::Local, &[shift(30)], &mut full);
            assert!(full[count(p)..].iter().all(|c| c.abs() < 1e-13), "{p}: no new degrees");
            let at = |x: Vector3<f64>, scale: f64, c: &[f64]| -> f64 {
                let values = expansion(30, &[x], scale, false);
                values.iter().zip(c).map(|(a, b)| a * b).sum()
            };
            for x in cloud(4) {
                let [old, new] = [at(x, 0.8, &local[..count(p)]), at(x - offset, 0.4, &full)];
                assert!((old - new).abs() < 1e-12, "order {p}: {old} against {new}");
            }
            for q in 0..=30 {
                let mut out = vec![0.0; count(q)];
                translator.sum(TranslationKind::Local, &[shift(q)], &mut out);
                assert_close(&out, &full[..count(q)], 1e-13, &format!("{p} to {q}"));
            }
        }
    }
}

/// A far multipole becomes the local expansion of the same charges; the error falls as the
/// ratio of radius to distance to the power of the order of the multipole.
#[test]
fn far_multipoles_become_local_for_every_pair_of_orders() {
    let (cloud, mut translator) = (cloud(2), Translator::new(30));
    let bound = |p: usize, n: usize| -> f64 {
        // |R_l(x)| <= 0.52^l, and the coefficient (n+l)!/(n! l!) bounds the matrix.
        let term = |l: usize| {
            let binomial: f64 = (1..=n).map(|k| (l + k) as f64 / k as f64).product();
            binomial * 0.26f64.powf(l as f64) * 0.2f64.powf(n as f64)
        };
        0.5 * 12.0 * (p + 1..p + 200).map(term).sum::<f64>()
    };
    let bounds: Vec<Vec<_>> = (0..=30).map(|p| (0..=30).map(|n| bound(p, n)).collect()).collect();
    for direction in directions() {
        let offset = direction * 2.0;
        let from_there: Vec<_> = cloud.iter().map(|x| x - offset).collect();
        let multipole = expansion(40, &cloud, 0.5, false);
        let exact = expansion(30, &from_there, 0.4, true);
        for (p, q) in (0..=30).flat_map(|p| (0..=30).map(move |q| (p, q))) {
            let mut out = vec![0.0; count(q)];
            let shift =
                Shift { coefficients: &multipole, degrees: [p, q], offset, scales: [0.5, 0.4] };
            translator.sum(TranslationKind::Far(0), &[shift], &mut out);
            for n in 0..=q {
                let bound = bounds[p][n];
                for k in n * n..count(n) {
                    let error = (out[k] - exact[k]).abs();
                    assert!(error <= bound + 1e-12, "{p} to {q}, {k}: {error} > {bound}");
                }
            }
        }
    }
}

/// What is moved with and without low degrees adds up to all.
#[test]
fn low_and_higher_degrees_are_moved_apart() {
    let (p, cloud) = (9, cloud(3));
    let multipole = expansion(p, &cloud, 0.5, false);
    for direction in directions() {
        let moved = |kind: TranslationKind, degree: usize| {
            let (degrees, offset, scales) = ([degree; 2], direction * 2.0, [0.5, 0.4]);
            let shift = Shift { coefficients: &multipole, degrees, offset, scales };
            let mut out = vec![0.0; count(p)];
            Translator::new(p).sum(kind, &[shift], &mut out);
            out
        };
        let all = moved(TranslationKind::Far(0), p);
        for low in 1..=p {
            let sum = moved(TranslationKind::Far(low), p)
                .into_iter()
                .zip(moved(TranslationKind::Far(0), low - 1));
            let sum: Vec<_> = sum.map(|(higher, lower)| higher + lower).collect();
            assert_close(&sum, &all, 1e-13, &format!("below {low}"));
        }
    }
}
