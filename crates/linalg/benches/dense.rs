//! Eigenvalues of dense matrices, and nalgebra's on the same: one thread.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::{DMatrix, Schur};
use rapunzel_linalg::{characteristic_exponents, eigen, modes};
use std::f64::consts::PI;
use std::hint::black_box;
use std::time::Duration;

/// A stiffness and a mass without pattern: `K = S diag(1, 2, ...) S` and `M = 2 - S / 2`, with the
/// sines `S`, whose square is 1.
fn matrices(n: usize) -> [DMatrix<f64>; 2] {
    let part = PI / (n + 1) as f64;
    let scale = (2.0 / (n + 1) as f64).sqrt();
    let s = DMatrix::from_fn(n, n, |i, j| scale * (part * ((i + 1) * (j + 1)) as f64).sin());
    let weighted = DMatrix::from_fn(n, n, |i, j| s[(i, j)] * (j + 1) as f64);
    [weighted * &s, DMatrix::identity(n, n) * 2.0 - 0.5 * s]
}

fn nalgebra_modes(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let lower = k.clone().cholesky()?.unpack();
    let half = lower.solve_lower_triangular(m)?;
    let eigen = lower.solve_lower_triangular(&half.transpose())?.symmetric_eigen();
    lower.tr_solve_lower_triangular(&eigen.eigenvectors)
}

fn dense(c: &mut Criterion) {
    let mut group = c.benchmark_group("vibration");
    group.sample_size(10).warm_up_time(Duration::from_millis(500));
    for n in [30, 150, 300, 600] {
        let [k, m] = matrices(n);
        let mut case = |name: &str, run: &dyn Fn() -> bool| {
            group.bench_function(BenchmarkId::new(name, n), |b| b.iter(|| black_box(run())));
        };
        case("modes", &|| modes(&k, &m, n).is_ok());
        case("modes by nalgebra", &|| nalgebra_modes(&k, &m).is_some());
        case("eigen", &|| eigen(&k).is_ok());
        case("eigen by nalgebra", &|| k.clone().symmetric_eigen().eigenvalues[0].is_finite());
        if n <= 300 {
            case("exponents", &|| characteristic_exponents(&k, &m).is_ok());
            case("exponents by nalgebra", &|| {
                let inverse = k.clone().lu().solve(&m);
                inverse.is_some_and(|x| Schur::try_new(x, f64::EPSILON, 100 * n).is_some())
            });
        }
    }
}

criterion_group!(benches, dense);
criterion_main!(benches);
