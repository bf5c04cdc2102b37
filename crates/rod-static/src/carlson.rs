//! Carlson's symmetric elliptic integrals by duplication (Carlson 1995, DLMF 19.16, 19.36).
//!
//! Each step brings the arguments together by a factor of four; a series of the seventh order then
//! ends it. Arguments down to `1e-200` of each other lose no digits. Cost: some six steps of three
//! square roots. Arguments are not checked: outside of their ranges the values have no meaning.

/// Spread, relative to the mean, below which the series ends the duplication.
const SPREAD: f64 = 4e-3;

/// `R_F(x, y, z)`, the integral of the first kind; arguments at least zero, at most one of them
/// zero.
#[must_use]
pub fn rf(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    loop {
        let mean = (x + y + z) / 3.0;
        let (dx, dy) = (1.0 - x / mean, 1.0 - y / mean);
        let dz = -dx - dy;
        if dx.abs().max(dy.abs()).max(dz.abs()) < SPREAD || !mean.is_normal() {
            let (e2, e3) = (dx * dy - dz * dz, dx * dy * dz);
            let series = 1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0;
            return (series - 5.0 * e2.powi(3) / 208.0 + 3.0 * e3 * e3 / 104.0) / mean.sqrt();
        }
        let lambda = duplication(x, y, z);
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
}

/// `R_C(x, y) = R_F(x, y, y)`; `x >= 0`, `y != 0`. The Cauchy principal value for `y < 0`.
#[must_use]
pub fn rc(x: f64, y: f64) -> f64 {
    if y < 0.0 { (x / (x - y)).sqrt() * rf(x - y, -y, -y) } else { rf(x, y, y) }
}

/// `R_D(x, y, z) = R_J(x, y, z, z)`, the integral of the second kind; `x, y >= 0`, not both zero,
/// `z > 0`.
#[must_use]
pub fn rd(x: f64, y: f64, z: f64) -> f64 {
    rj(x, y, z, z)
}

/// `R_J(x, y, z, p)`, the integral of the third kind; `x, y, z` at least zero, at most one of them
/// zero, `p != 0`. The Cauchy principal value for `p < 0` (DLMF 19.20.14).
#[must_use]
pub fn rj(x: f64, y: f64, z: f64, p: f64) -> f64 {
    if p < 0.0 {
        return principal_value(x, y, z, -p);
    }
    let (mut x, mut y, mut z, mut p) = (x, y, z, p);
    let (mut sum, mut scale) = (0.0, 1.0);
    loop {
        let mean = (x + y + z + 2.0 * p) / 5.0;
        let (dx, dy, dz) = (1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean);
        let dp = -0.5 * (dx + dy + dz);
        let spread = dx.abs().max(dy.abs()).max(dz.abs()).max(dp.abs());
        if spread < SPREAD || !mean.is_normal() {
            return 6.0 * sum + scale * series_rj(dx, dy, dz, dp) / (mean * mean.sqrt());
        }
        let (rx, ry, rz, rp) = (x.sqrt(), y.sqrt(), z.sqrt(), p.sqrt());
        let d = (rp + rx) * (rp + ry) * (rp + rz);
        // Carlson's 1 + e as a sum of positive terms: no cancellation for small p.
        let one_and_e = 2.0 * rp * (p + rx * ry + rx * rz + ry * rz) / d;
        sum += scale / d * rc(1.0, one_and_e);
        scale *= 0.25;
        let lambda = rx * ry + rx * rz + ry * rz;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
        p = 0.25 * (p + lambda);
    }
}

/// The series of `R_J` (DLMF 19.36.2) in the relative deviations from the mean.
fn series_rj(x: f64, y: f64, z: f64, p: f64) -> f64 {
    let xyz = x * y * z;
    let e2 = x * y + x * z + y * z - 3.0 * p * p;
    let e3 = xyz + 2.0 * e2 * p + 4.0 * p.powi(3);
    let e4 = (2.0 * xyz + e2 * p + 3.0 * p.powi(3)) * p;
    let e5 = xyz * p * p;
    let low = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0;
    let middle = -9.0 * e2 * e3 / 52.0 + 3.0 * e5 / 26.0 - e2.powi(3) / 16.0 + 3.0 * e3 * e3 / 40.0;
    let high = 3.0 * e2 * e4 / 20.0 + 45.0 * e2 * e2 * e3 / 272.0;
    low + middle + high - 9.0 * (e3 * e4 + e2 * e5) / 68.0
}

/// `R_J(x, y, z, -q)` as a principal value.
fn principal_value(x: f64, y: f64, z: f64, q: f64) -> f64 {
    let mut sorted = [x, y, z];
    sorted.sort_by(f64::total_cmp);
    let [x, y, z] = sorted;
    let p = (z * (x + y + q) - x * y) / (z + q);
    let sum = (p - z) * rj(x, y, z, p) - 3.0 * rf(x, y, z);
    let tail = if x > 0.0 {
        3.0 * (x * y * z / (x * y + p * q)).sqrt() * rc(x * y + p * q, p * q)
    } else {
        0.0
    };
    (sum + tail) / (q + z)
}

/// Increment of every argument in a duplication step.
fn duplication(x: f64, y: f64, z: f64) -> f64 {
    let (rx, ry, rz) = (x.sqrt(), y.sqrt(), z.sqrt());
    rx * ry + rx * rz + ry * rz
}
