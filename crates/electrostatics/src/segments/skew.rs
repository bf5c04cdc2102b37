//! Two straight charged lines in closed form, a pair in each lane.

use crate::vectors::{LaneVector, along, cross, dot, log, minus, scaled};
use pulp::Simd;
use rapunzel_lanes::{Lane, Roots, angle};

/// Rounding error of [`skew`], relative, times the cube of the sine.
pub(super) const ROUNDINGS: f64 = 10.0 * f64::EPSILON;

/// Lines from `start` along the unit vector `tangent`, one in each lane.
#[derive(Clone, Copy)]
pub(super) struct ChargedLine<S: Simd> {
    /// Start (world), m.
    pub(super) start: LaneVector<S>,
    /// Unit tangent (world).
    pub(super) tangent: LaneVector<S>,
    /// Length, m.
    pub(super) length: Lane<S>,
}

/// Means over two lines of the actions of unit charges, with the kernel `1/sqrt(r^2 + softening)`,
/// r from the second to the first; the shares u and v of the first and the second run from 0 at the
/// start to 1 at the end.
#[derive(Clone, Copy)]
pub(super) struct LineMeans<S: Simd> {
    /// Mean of `1/r`, 1/m: the energy.
    pub(super) energy: Lane<S>,
    /// Mean of `r/r^3` (world), 1/m^2: the force on the first.
    pub(super) force: LaneVector<S>,
    /// Mean of `u r/r^3` (world), 1/m^2: the part of the force that the end of the first takes.
    pub(super) first_end: LaneVector<S>,
    /// Mean of `v r/r^3` (world), 1/m^2: the negative force on the end of the second.
    pub(super) second_end: LaneVector<S>,
}

/// Product of complex numbers.
#[inline(always)]
fn product<S: Simd>(a: [Lane<S>; 2], b: [Lane<S>; 2]) -> [Lane<S>; 2] {
    [a[1].negate_mul_add(b[1], a[0] * b[0]), a[0].mul_add(b[1], a[1] * b[0])]
}

/// Combination `n a + s y + t z` of the axes n, s and t.
#[inline(always)]
fn combined<S: Simd>(axes: &[LaneVector<S>; 3], [a, y, z]: [Lane<S>; 3]) -> LaneVector<S> {
    along(&along(&scaled(&axes[0], a), &axes[1], y), &axes[2], z)
}

/// Means over two lines that are not parallel. Relative error: [`ROUNDINGS`] over the cube of the
/// sine of their angle. Cost: some 350 operations.
///
/// With the second line reversed, `r = h n + y s + z t`: n is the common normal, s and t are the
/// tangents with the product c, and `R^2 = d^2 + y^2 + z^2 + 2 c y z` with `d^2 = h^2 + softening`.
/// Of `1/R^3` the integral is an angle, `A = atan((y z q^2 - c d^2)/(d q R))/(d q)` with
/// `q^2 = 1 - c^2`; all others follow from it and from the logarithms `M = ln(R + z + c y)` and
/// `N = ln(R + y + c z)` by integration by parts: the derivatives of `1/R`, `y/R` and `z/R` by y
/// and z give `Y + c Z = -M` and so on. All are differences over the four corners.
#[inline(always)]
pub(super) fn skew<S: Simd, R: Roots<S>>(
    roots: R,
    first: &ChargedLine<S>,
    second: &ChargedLine<S>,
    softening: Lane<S>,
) -> LineMeans<S> {
    // The frame of both lines: the feet of the common normal, and their square distance d2.
    let s = first.tangent;
    let t = scaled(&second.tangent, softening.lift(-1.0));
    let r = minus(&first.start, &second.start);
    let (c, normal) = (dot(&s, &t), cross(&s, &t));
    let q2 = dot(&normal, &normal);
    let inverse = roots.recip(q2);
    let (rs, rt) = (dot(&r, &s), dot(&r, &t));
    let y0 = c.negate_mul_add(rt, rs) * inverse;
    let z0 = c.negate_mul_add(rs, rt) * inverse;
    // Times q, the distance of the lines.
    let height = dot(&r, &normal);
    let d2 = (height * height).mul_add(inverse, softening);
    let (y, z) = ([y0, y0 + first.length], [z0, z0 + second.length]);
    let dq = roots.sqrt(d2 * q2);

    // The angle A, from the product of the four complex numbers of the corners.
    let mut radius = [[y0; 2]; 2];
    // The cosine and sine of the four angles, not normalized; their product has the sum of them.
    let mut turn = [y0.lift(1.0), y0.lift(0.0)];
    let cd2 = c * d2;
    for i in 0..2 {
        for j in 0..2 {
            let square = y[i].mul_add(y[i], z[j].mul_add(z[j], d2));
            radius[i][j] = roots.sqrt((c * y[i]).mul_add(z[j] + z[j], square));
            let sine = (y[i] * z[j]).mul_add(q2, -cd2);
            turn = product(turn, [dq * radius[i][j], if i == j { sine } else { -sine }]);
        }
    }
    let a = angle(roots, turn[0], turn[1]) * roots.recip(dq);
    // The logarithms M and N at the corners of the other line.
    let (mut m, mut n) = ([y0; 2], [y0; 2]);
    for k in 0..2 {
        let w = [c.mul_add(y[k], z[0]), c.mul_add(y[k], z[1])];
        m[k] = log(roots, w, radius[k]);
        let w = [c.mul_add(z[k], y[0]), c.mul_add(z[k], y[1])];
        n[k] = log(roots, w, [radius[0][k], radius[1][k]]);
    }

    // Integration by parts: energy, first moments iy and iz, and second moments yy, zz and yz.
    let (dm, dn) = (m[1] - m[0], n[1] - n[0]);
    let ym = y[1].mul_add(m[1], -(y0 * m[0]));
    let zn = z[1].mul_add(n[1], -(z0 * n[0]));
    let dr = (radius[1][1] - radius[0][1]) - (radius[1][0] - radius[0][0]);
    let energy = d2.negate_mul_add(a, ym + zn);
    let iy = c.negate_mul_add(dn, dm) * -inverse;
    let iz = c.negate_mul_add(dm, dn) * -inverse;
    let (ey, ez) = (energy - ym, energy - zn);
    let (gy, gz) = (c.negate_mul_add(ym, dr), c.negate_mul_add(zn, dr));
    let yy = c.mul_add(gz, ey) * inverse;
    let zz = c.mul_add(gy, ez) * inverse;
    let yz = c.mul_add(ey, gz) * -inverse;

    let over = roots.recip(first.length * second.length);
    let over_first = second.length * over * over;
    let over_second = first.length * over * over;
    let axes = [scaled(&normal, height * inverse), s, t];
    let first_end =
        [y0.negate_mul_add(a, iy), y0.negate_mul_add(iy, yy), y0.negate_mul_add(iz, yz)];
    let second_end =
        [z0.negate_mul_add(a, iz), z0.negate_mul_add(iy, yz), z0.negate_mul_add(iz, zz)];
    LineMeans {
        energy: energy * over,
        force: scaled(&combined(&axes, [a, iy, iz]), over),
        first_end: scaled(&combined(&axes, first_end), over_first),
        second_end: scaled(&combined(&axes, second_end), over_second),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rapunzel_fiber::quadrature::gauss_legendre;
    use rapunzel_lanes::{Kernel, dispatch};

    type Ends = [Vector3<f64>; 2];

    struct Check {
        lines: [Ends; 2],
        softening: f64,
        tolerance: f64,
    }

    impl Kernel for Check {
        fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
            let of = |value: f64| Lane::splat(simd, value);
            let line = |[a, b]: Ends| {
                let tangent = (b - a).normalize();
                let lanes = |v: Vector3<f64>| [of(v.x), of(v.y), of(v.z)];
                ChargedLine { start: lanes(a), tangent: lanes(tangent), length: of((b - a).norm()) }
            };
            let [first, second] = self.lines.map(line);
            let means = skew(roots, &first, &second, of(self.softening));
            let vectors = [means.force, means.first_end, means.second_end].concat();
            let exact = self.quadrature();
            let size = exact[1..].iter().map(|x| x.abs()).fold(0.0, f64::max);
            assert!((means.energy.numbers()[0] - exact[0]).abs() < self.tolerance * exact[0]);
            for (k, found) in vectors.iter().enumerate() {
                let error = (found.numbers()[0] - exact[1 + k]).abs() / size;
                assert!(error < self.tolerance, "{:?}: {k}: {error:e}", self.lines);
            }
        }
    }

    impl Check {
        /// Gauss's rule of 6 points in intervals that are finer toward all ends.
        fn quadrature(&self) -> [f64; 10] {
            let mut points = Vec::new();
            for k in 0..120 {
                let at = |k: i32| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(k) / 120.0).cos();
                let (low, high) = (at(k), at(k + 1));
                for [x, w] in gauss_legendre(6) {
                    let half = 0.5 * (high - low);
                    points.push((0.5 * (low + high) + half * x, half * w));
                }
            }
            let [[a, b], [c, d]] = self.lines;
            let mut sums = [0.0; 10];
            for (u, w) in &points {
                for (v, x) in &points {
                    let r = a + (b - a) * *u - c - (d - c) * *v;
                    let inverse = 1.0 / (r.norm_squared() + self.softening).sqrt();
                    let share = w * x * inverse;
                    sums[0] += share;
                    for k in 0..3 {
                        let force = share * inverse * inverse * r[k];
                        sums[1 + k] += force;
                        sums[4 + k] += u * force;
                        sums[7 + k] += v * force;
                    }
                }
            }
            sums
        }
    }

    fn check(first: [[f64; 3]; 2], second: [[f64; 3]; 2], softening: f64, tolerance: f64) {
        let lines = [first, second].map(|ends| ends.map(Vector3::from));
        dispatch(Check { lines, softening, tolerance });
    }

    #[test]
    fn skew_lines_are_the_integrals() {
        let first = [[0.0, 0.0, 0.0], [0.2, -0.1, 1.0]];
        check(first, [[0.5, 0.3, 0.2], [-0.4, 0.8, 0.9]], 1e-6, 1e-11);
        check(first, [[0.9, 0.3, 2.2], [-0.4, 1.8, 0.1]], 1e-2, 1e-11);
        // At a right angle, from an end, and against the first.
        check([[0.0; 3], [1.0, 0.0, 0.0]], [[0.3, 0.1, 0.2], [0.3, 1.4, 0.2]], 1e-9, 1e-11);
        check([[0.0; 3], [1.0, 0.0, 0.0]], [[1.0, 0.0, 0.0], [1.5, 0.8, 0.2]], 1e-2, 1e-10);
        check(first, [[0.3, 0.0, 0.9], [0.1, 0.2, -0.3]], 1e-6, 1e-9);
    }
}
