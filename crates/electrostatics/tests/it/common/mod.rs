//! Sets of points to test with.
use nalgebra::{Point3, Vector3};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// Uniform in `[0, 1)`.
pub(crate) fn unit(random: &mut Pcg64Mcg) -> f64 {
    (random.next_u64() >> 11) as f64 * (-53f64).exp2()
}

/// Roughly normal, of unit variance.
pub(crate) fn normal(random: &mut Pcg64Mcg) -> f64 {
    (0..12).map(|_| unit(random)).sum::<f64>() - 6.0
}

/// A generator from a seed.
pub(crate) fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::new(u128::from(seed) * 2 + 1)
}

/// `count` points uniform in the unit cube.
pub(crate) fn cube(count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut r = random(seed);
    (0..count).map(|_| Point3::new(unit(&mut r), unit(&mut r), unit(&mut r))).collect()
}

/// `count` points uniform on the unit sphere.
pub(crate) fn sphere(count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut r = random(seed);
    let mut point = || Vector3::from_fn(|_, _| normal(&mut r)).normalize().into();
    (0..count).map(|_| point()).collect()
}

/// The tress of the research notes: `fibers` curved, nearly parallel fibres of 30 cm in an elliptic
/// bundle of 200 a square centimeter, each with `nodes` equidistant nodes, m.
pub(crate) fn hair(fibers: usize, nodes: usize, seed: u64) -> Vec<Vec<Point3<f64>>> {
    let mut r = random(seed);
    let minor = (fibers as f64 / 200.0 / std::f64::consts::TAU).sqrt();
    let fiber = |k: usize| {
        let (radius, angle) =
            (((k as f64 + 0.5) / fibers as f64).sqrt(), (k as f64 + 0.5) * 2.399_963);
        let x0 = 2.0 * minor * radius * angle.cos() + 0.01 * normal(&mut r);
        let y0 = minor * radius * angle.sin() + 0.01 * normal(&mut r);
        let phase = unit(&mut r) * std::f64::consts::TAU;
        let node = |i: usize| {
            let s = i as f64 / (nodes - 1) as f64 * 30.0;
            let wave = |length: f64| std::f64::consts::TAU * s / length;
            let x = x0 * (1.0 + 0.01 * s)
                + 25.0 * (1.0 - (s / 25.0).cos())
                + 0.03 * wave(6.0).sin()
                + 0.01 * (wave(5.0) + phase).sin();
            let y =
                y0 * (1.0 + 0.01 * s) + 0.05 * wave(8.0).sin() + 0.01 * (wave(5.0) + phase).cos();
            Point3::new(x, y, -25.0 * (s / 25.0).sin()) * 0.01
        };
        (0..nodes).map(node).collect()
    };
    (0..fibers).map(fiber).collect()
}

/// Charges of both signs, or all equal.
pub(crate) fn charges(count: usize, mixed: bool, seed: u64) -> Vec<f64> {
    let mut r = random(seed);
    (0..count).map(|_| if mixed { (unit(&mut r) - 0.5) * 1e-12 } else { 1e-12 }).collect()
}

/// Root of the sum of squared differences over that of squares.
pub(crate) fn relative(actual: &[Vector3<f64>], exact: &[Vector3<f64>]) -> f64 {
    let errors: f64 = actual.iter().zip(exact).map(|(a, e)| (a - e).norm_squared()).sum();
    (errors / exact.iter().map(Vector3::norm_squared).sum::<f64>()).sqrt()
}
