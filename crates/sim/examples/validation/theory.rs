//! What theory says, computed here: closed forms, and quadratures of ordinary differential
//! equations that no integrator of the house has a part in.

use crate::greenhill::clamps;
use rapunzel_rod_static::elliptic::{first_kind, second_kind};
use std::f64::consts::FRAC_PI_2;

/// Steps of the quadratures; the error of Runge and Kutta's method is a rounding then.
const QUADRATURE_STEPS: u32 = 4000;

/// Halves the interval in which a function changes its sign until it is a rounding.
pub(crate) fn zero(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rises = f(high) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        *(if (f(middle) > 0.0) == rises { &mut high } else { &mut low }) = middle;
    }
    0.5 * (low + high)
}

/// Runge and Kutta's method of fourth order from 0 to 1.
fn integrate<const N: usize>(
    mut y: [f64; N],
    slope: impl Fn(f64, &[f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = 1.0 / f64::from(QUADRATURE_STEPS);
    let plus = |y: &[f64; N], k: &[f64; N], c: f64| -> [f64; N] {
        std::array::from_fn(|i| y[i] + c * k[i])
    };
    for step in 0..QUADRATURE_STEPS {
        let s = f64::from(step) * h;
        let a = slope(s, &y);
        let b = slope(s + 0.5 * h, &plus(&y, &a, 0.5 * h));
        let c = slope(s + 0.5 * h, &plus(&y, &b, 0.5 * h));
        let d = slope(s + h, &plus(&y, &c, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    y
}

/// Place of the end of a cantilever of length 1 that is clamped level and bends under its weight:
/// along and down. The weight is `gamma` in the unit of bending, `w L^3 / B`. The heavy elastica,
/// `theta'' = -gamma (1 - s) cos(theta)` with `theta'(1) = 0`.
pub(crate) fn heavy_cantilever(gamma: f64) -> [f64; 2] {
    let bent = |curvature: f64| {
        integrate([0.0, curvature, 0.0, 0.0], |s, y| {
            [y[1], -gamma * (1.0 - s) * y[0].cos(), y[0].cos(), y[0].sin()]
        })
    };
    // Straight, the weight would ask for `gamma / 2`; the first root is the stable one.
    let root = zero(0.0, 0.5 * gamma, |curvature| bent(curvature)[1]);
    let [_, _, along, down] = bent(root);
    [along, down]
}

/// Place of the end of a level cantilever of length 1 under a force `a` down on it, in the unit of
/// bending `P L^2 / B`: along and down (Bisshopp and Drucker 1945, Mattiasson 1981). With the angle
/// at the end, `k^2 = (1 + sin) / 2` and `sin(phi) = 1 / (k sqrt 2)`, it is the one for which
/// `K - F(phi)` is the root of `a`.
pub(crate) fn tip_load(a: f64) -> [f64; 2] {
    let integrals = |angle: f64| {
        let m = 0.5 * (1.0 + angle.sin());
        let phi = (1.0 / (2.0 * m).sqrt()).min(1.0).asin();
        let of = |f: fn(f64, f64) -> Option<f64>| {
            f(FRAC_PI_2, m).unwrap_or(f64::NAN) - f(phi, m).unwrap_or(f64::NAN)
        };
        [of(first_kind), of(second_kind)]
    };
    let angle = zero(1e-9, FRAC_PI_2 - 1e-6, |angle| integrals(angle)[0] - a.sqrt());
    let [_, second] = integrals(angle);
    [(2.0 * angle.sin() / a).sqrt(), 1.0 - 2.0 * second / a.sqrt()]
}

/// Angle at the arc length `s` of a cone of length 1 under the couple `m` on its end, whose
/// stiffness is 1 at the root and whose radius falls to the part `tip`.
pub(crate) fn cone_under_couple(tip: f64, m: f64, s: f64) -> f64 {
    let c = 1.0 - tip;
    m / (3.0 * c) * ((1.0 - c * s).powi(-3) - 1.0)
}

/// The first zero beyond 1 of the Bessel function of an order between -1 and 0.
fn bessel_zero(order: f64) -> f64 {
    // Of the series the sign alone counts, and so the power before it does not.
    let bessel = |x: f64| {
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..60 {
            let k = f64::from(k);
            term *= -0.25 * x * x / (k * (k + order));
            sum += term;
        }
        sum
    };
    zero(1.0, 3.0, bessel)
}

/// The force, in units of `sqrt(B C) / L^2`, under which the end of a cantilever goes aside that is
/// stiff in the plane of the force: `4.0126`, twice the first zero of the Bessel function of order
/// `-1/4` (Prandtl 1899, Michell 1899).
pub(crate) fn lateral_buckling() -> f64 {
    2.0 * bessel_zero(-0.25)
}

/// The weight, in units of `B / L^2`, under which an upright rod buckles: `7.8373`, with the first
/// zero of the Bessel function of order `-1/3` (Greenhill 1881).
pub(crate) fn upright_buckling() -> f64 {
    (1.5 * bessel_zero(-1.0 / 3.0)).powi(2)
}

/// The loads, in units of `B / L^2`, of Euler's columns: free above a clamp, between joints, in a
/// joint above a clamp (`tan x = x`), and between clamps.
pub(crate) fn columns() -> [f64; 4] {
    let x = zero(4.4, 4.6, |x| x.sin() - x * x.cos());
    [FRAC_PI_2.powi(2), (2.0 * FRAC_PI_2).powi(2), x * x, (4.0 * FRAC_PI_2).powi(2)]
}

/// The twist, rad, at which a ring leaves its plane whose torsion stiffness is so many times that
/// against bending (Michell 1889, Zajac 1962).
pub(crate) fn ring_twist(torsion: f64) -> f64 {
    4.0 * FRAC_PI_2 * 3.0_f64.sqrt() / torsion
}

/// The least thrust, in units of `B / L^2`, of a cantilever clamped at the angle `lean` to it that
/// leans to the other side: with the modulus `k` it carries `(K(k) + F(phi, k))^2`,
/// `sin(phi) = sin(lean / 2) / k`.
pub(crate) fn snap_thrust(lean: f64) -> f64 {
    let least = (0.5 * lean).sin();
    let integral = |phi: f64, k: f64| first_kind(phi, k * k).unwrap_or(f64::NAN);
    let root = |k: f64| integral(FRAC_PI_2, k) + integral((least / k).min(1.0).asin(), k);
    // By thirds: the least value is known to the square of the bracket.
    let (mut low, mut high) = (least, 0.9);
    for _ in 0..100 {
        let third = (high - low) / 3.0;
        if root(low + third) < root(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    root(low).powi(2)
}

/// The tension at which a clamped rod writhes under the twisting moment `moment`, with `B = L = 1`
/// ([`clamps`]).
pub(crate) fn writhing_tension(moment: f64) -> f64 {
    let a = 0.5 * moment;
    let clamps = |b: f64| clamps(a, b);
    let mut b = 1e-3;
    while clamps(b + 0.01) * clamps(b) > 0.0 {
        b += 0.01;
    }
    let b = zero(b, b + 0.01, clamps);
    a * a - b * b
}

/// The natural curvature at which a hanging rod of length 1 leaves its plane, whose stiffness is 1
/// against bending and `torsion` against torsion. Its clamp points down, its weight is `weight`.
///
/// In the plane it is the heavy elastica: with the angle from the vertical, `k = theta'` and the
/// moment `m = k - natural`, it is `m' = w (1 - s) sin(theta)`, `m(1) = 0`. Each curvature at the
/// clamp is that of one natural curvature. Rotations `b` about the normal in the plane and `c`
/// about the tangent change the energy by the sum of `(b' - k c)^2 + C (c' + k b)^2`, of
/// `-m k (b^2 + c^2) - m (b c' - c b')`, and of `w (1 - s) (cos(theta) b^2 - sin(theta) b c)`,
/// which can fall from where a field of extremals that starts at the clamp has a free end (Jacobi
/// 1837).
pub(crate) fn hanging_curl(weight: f64, torsion: f64) -> f64 {
    // The natural curvature, and the determinant of the moments of two extremals at the end.
    let natural = |k: f64| {
        let slope = |s: f64, y: &[f64; 2]| [y[1], weight * (1.0 - s) * y[0].sin()];
        integrate([0.0, k], slope)[1]
    };
    let fields = |k: f64| {
        let own = natural(k);
        let slope = |s: f64, y: &[f64; 10]| {
            let (k, m) = (y[1], y[1] - own);
            let [along, across] = [y[0].cos(), y[0].sin()].map(|part| weight * (1.0 - s) * part);
            let mut rates = [k, across, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            for field in [2, 6] {
                let [b, c, p, q] = [0, 1, 2, 3].map(|i| y[field + i]);
                let bent = p + (k - 0.5 * m) * c;
                let twisted = (q + 0.5 * m * b) / torsion - k * b;
                let moment = torsion * (twisted + k * b);
                rates[field] = bent;
                rates[field + 1] = twisted;
                rates[field + 2] =
                    (moment - m * b) * k - 0.5 * (m * twisted + across * c) + along * b;
                rates[field + 3] = 0.5 * (m * bent - across * b) - k * (bent - k * c) - m * k * c;
            }
            rates
        };
        let end = integrate([0.0, k, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0], slope);
        end[4] * end[9] - end[5] * end[8]
    };
    // From a curl that is far too small.
    let mut k = 1e-9 / natural(1e-9);
    while fields(1.1 * k) > 0.0 {
        k *= 1.1;
    }
    natural(zero(k, 1.1 * k, fields))
}

/// A localised helix of a rod with `B = C = 1` under the tension 1 and the twisting moment `m`,
/// below 2: `1 - cos(theta) = (2 - m^2 / 2) sech^2(sqrt(1 - m^2 / 4) s)` (Coyne 1990; van der
/// Heijden and Thompson 2000).
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalisedHelix {
    pub(crate) moment: f64,
}

/// A point of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HelixPoint {
    /// The tangent's angle to the axis, and its azimuth; the angle of the material frame about the
    /// tangent; rad.
    pub(crate) angles: [f64; 3],
    pub(crate) position: [f64; 3],
}

impl LocalisedHelix {
    /// Cosine of the tangent's angle to the axis at the arc length `s` from the middle.
    pub(crate) fn cosine(&self, s: f64) -> f64 {
        let m = 0.25 * self.moment * self.moment;
        1.0 - 2.0 * (1.0 - m) * ((1.0 - m).sqrt() * s).cosh().powi(-2)
    }

    /// Points at `2 n + 1` arc lengths, evenly from `-half` to `half`: nodes and middles of `n`
    /// segments. The azimuth turns by `m / (1 + cos)`, the material frame with it by `m` in all.
    pub(crate) fn points(&self, half: f64, n: u32) -> Vec<HelixPoint> {
        const FINE: u32 = 40;
        let h = half / f64::from(n * FINE);
        let azimuth = |s: f64| self.moment / (1.0 + self.cosine(s));
        let tangent = |s: f64, psi: f64| {
            let c = self.cosine(s);
            let t = (1.0 - c * c).max(0.0).sqrt();
            [t * psi.cos(), t * psi.sin(), c]
        };
        let (mut psi, mut roll, mut position) = (0.0, 0.0, [0.0; 3]);
        let mut points = Vec::new();
        for step in 0..=2 * n * FINE {
            let s = -half + f64::from(step) * h;
            if step.is_multiple_of(FINE) {
                points.push(HelixPoint { angles: [self.cosine(s).acos(), psi, roll], position });
            }
            // Simpson's rule, for what turns and then for what that leads along.
            let [a, b, c] = [0.0, 0.5, 1.0].map(|part| s + part * h);
            let quarter = azimuth(a) + 4.0 * azimuth(a + 0.25 * h) + azimuth(b);
            let middle = psi + h / 12.0 * quarter;
            let rolling = |s: f64| self.moment - azimuth(s) * self.cosine(s);
            let simpson = |f: &dyn Fn(f64) -> f64| h / 6.0 * (f(a) + 4.0 * f(b) + f(c));
            let end = psi + simpson(&azimuth);
            roll += simpson(&rolling);
            let ways = [tangent(a, psi), tangent(b, middle), tangent(c, end)];
            for (i, x) in position.iter_mut().enumerate() {
                *x += h / 6.0 * (ways[0][i] + 4.0 * ways[1][i] + ways[2][i]);
            }
            psi = end;
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What was published, to the digits that it has.
    #[test]
    fn theory_has_its_published_values() {
        for (a, [shortening, drop]) in
            [(1.0, [0.056_433_24, 0.301_720_77]), (10.0, [0.554_995_60, 0.810_609_02])]
        {
            let [along, down] = tip_load(a);
            assert!((1.0 - along - shortening).abs() < 1e-8, "{along}");
            assert!((down - drop).abs() < 1e-8, "{down}");
        }
        for (gamma, [x, z]) in
            [(1.0, [0.991_246_395, 0.123_471_402]), (10.0, [0.656_353_761, 0.700_199_716])]
        {
            let [along, down] = heavy_cantilever(gamma);
            assert!((along - x).abs() < 1e-9 && (down - z).abs() < 1e-9, "{along} {down}");
        }
        assert!((lateral_buckling() - 4.012_599_344).abs() < 1e-9);
        assert!((upright_buckling() - 7.837_347_439).abs() < 1e-8);
        // Clamped ends without tension, and without a moment.
        assert!(
            writhing_tension(8.986_818_916).abs() < 1e-7,
            "{}",
            writhing_tension(8.986_818_916)
        );
        // Of long rods the weight per length is 0.2387 times the cube of the curvature.
        let long = 1000.0 / hanging_curl(1000.0, 2.0 / 3.0).powi(3);
        assert!((long - 0.2387).abs() < 2e-3, "{long}");
        let euler = -4.0 * std::f64::consts::PI.powi(2);
        assert!((writhing_tension(1e-6) - euler).abs() < 1e-6, "{}", writhing_tension(1e-6));
    }

    /// The twist is the moment over the stiffness, and the ends come together by
    /// `4 sqrt(1 - m^2 / 4)`.
    #[test]
    fn a_localised_helix_is_as_short_as_its_formula() {
        let helix = LocalisedHelix { moment: 1.6 };
        let points = helix.points(20.0, 400);
        let [first, last] = [points[0], points[800]];
        assert_eq!(points.len(), 801);
        let shortening = 40.0 - (last.position[2] - first.position[2]);
        assert!((shortening - 2.4).abs() < 1e-8, "{shortening}");
    }
}
